"""Training, validation and test assets of the policy experiment: whole families, balanced lists."""

from collections import Counter

import numpy as np
import pytest

from stages.contracts import TaskAssets
from stages.contracts.policies import TaskAsset
from stages.experiment.splits import balanced, by_chance, census, deal, with_lists
from tests.unit.demo_assets import an_asset

KINDS = {"bar": 28, "knob": 14, "arch": 7, "edge": 7}  # families


def library() -> list[TaskAsset]:
    """56 families of three, of all kinds of handles at lengths and heights drawn by chance."""
    rng = np.random.default_rng(5)
    return [
        an_asset(
            f"{kind}{number:02d}_{member}",
            float(rng.uniform(0.5, 1)),
            handle=kind,
            handle_length=float(rng.uniform(0.1, 0.5)),
            handle_height=float(rng.uniform(0, 1)),
        )
        for kind, count in KINDS.items()
        for number in range(count)
        for member in range(3)
    ]


def families(assets: list[TaskAsset]) -> set[str]:
    return {asset.family for asset in assets}


def kinds(assets: list[TaskAsset]) -> Counter[str]:
    return Counter(asset.handle for asset in assets)


def test_families_are_dealt_whole_and_every_split_gets_its_share_of_every_kind() -> None:
    splits = deal(library(), np.random.default_rng(0))
    sizes = [len(families(split)) for split in splits]
    assert sizes == [8, 16, 32] and sum(map(len, splits)) == len(library())
    assert len(set.union(*map(families, splits))) == sum(sizes), "no family is on two sides"
    for split, share in zip(splits, (1 / 7, 2 / 7, 4 / 7), strict=True):
        for kind, count in KINDS.items():
            assert kinds(split)[kind] / 3 == pytest.approx(share * count, abs=1)


def test_the_deal_follows_the_seed_and_not_the_order_of_the_library() -> None:
    first, again, other = (deal(assets, np.random.default_rng(seed)) for assets, seed in (
        (library(), 0), (library()[::-1], 0), (library(), 1)))  # fmt: skip
    assert first == again and families(first.test) != families(other.test)


def test_every_beginning_of_a_list_is_balanced() -> None:
    assets = library()
    ordered = balanced(assets, np.random.default_rng(0))
    assert sorted(asset.asset for asset in ordered) == sorted(asset.asset for asset in assets)
    for count in range(1, len(assets) + 1):
        found = Counter(asset.family for asset in ordered[:count])
        assert max(found.values()) - min((found[family] for family in families(assets)), default=0) <= 1
    for count in (12, 24, 36, 56):
        shares = {kind: kinds(ordered[:count])[kind] for kind in KINDS}
        assert shares == pytest.approx({kind: count * all / 56 for kind, all in KINDS.items()}, abs=1)
        bars = [asset.handle_length for asset in ordered[:count] if asset.handle == "bar"]
        middle = np.median([asset.handle_length for asset in assets if asset.handle == "bar"])
        assert np.mean([length > middle for length in bars]) == pytest.approx(0.5, abs=0.2)


def test_assets_by_chance_are_of_different_families_first() -> None:
    drawn = by_chance(library(), np.random.default_rng(0))
    assert len(families(drawn[:56])) == 56 and drawn != by_chance(library(), np.random.default_rng(1))


def test_lists_hold_no_relatives_of_the_other_sides() -> None:
    usable = [*library(), an_asset("mirror_1", hinge="right"), an_asset("bar00_9", hinge="right")]
    named = {asset.asset: asset for asset in usable}
    roles = {"twin": "bar00_0", "cousin_1": "knob00_0", "cousin_2": "arch00_0", "dissimilar": "edge00_0"}
    chosen = [named[asset].model_copy(update={"role": role, "distance": 1.0}) for role, asset in roles.items()]
    plan = TaskAssets(task="door", scene="room_1", object="cabinet_1", encoder="hog", assets=chosen, held_out=[2])
    full = with_lists(plan, usable, ["cabinet"], 10, 0)
    TaskAssets.model_validate(full.model_dump())
    assert len(full.test_assets) == len(full.validation_assets) == 10 and len(full.random_assets) == 16
    assert {asset.role for asset in full.test_assets} == {"test"}
    everything = {asset.asset for asset in full.all_assets}
    assert {"bar00_0", "bar00_1", "bar00_9", "knob00_2", "mirror_1"} <= everything, "relatives, whatever their hinge"
    assert not families(full.all_assets) & {"arch00", "edge00"}
    assert "bar00" not in families(full.random_assets) and {a.hinge for a in full.random_assets} == {"left"}
    assert families(full.random_assets) <= families(full.all_assets)
    assert {asset.hinge for asset in [*full.test_assets, *full.validation_assets]} == {"left"}
    assert with_lists(plan, usable[::-1], [], 10, 0).test_assets == full.test_assets
    assert with_lists(plan, usable, [], 10, 1).test_assets != full.test_assets


def test_a_family_on_two_sides_breaks_the_contract() -> None:
    twin = an_asset("bar_1", role="twin")
    about = {"task": "door", "scene": "room_1", "object": "cabinet_1", "encoder": "hog", "assets": [twin]}
    for name in ("validation_assets", "test_assets"):
        with pytest.raises(ValueError, match=rf"bar_2: its family 'bar' is in training and in {name}"):
            TaskAssets(**about | {name: [an_asset("bar_2")]})
    with pytest.raises(ValueError, match="'edge' is in validation_assets and in test_assets"):
        TaskAssets(**about | {"validation_assets": [an_asset("edge_1")], "test_assets": [an_asset("edge_2")]})
    cousin = an_asset("bar_2", role="cousin_1")
    assert TaskAssets(**about | {"assets": [twin, cousin]})
    with pytest.raises(ValueError, match="bar_2: its family 'bar' is in training and in the held-out"):
        TaskAssets(**about | {"assets": [twin, cousin], "held_out": [1]})


def test_the_census_counts_kinds() -> None:
    assert census("test", [an_asset("a_1"), an_asset("a_2", handle="knob")]) == "test: 2 of 1 families (bar 1, knob 1)"
    assert census("train", []) == "train: 0 of 0 families"


def test_the_only_one_of_its_kind_stands_in_the_middle() -> None:
    """One knob among eight bars: neither the first test asset nor the last."""
    assets = [an_asset(f"bar{number}_0") for number in range(8)] + [an_asset("knob0_0", handle="knob")]
    ordered = balanced(assets, np.random.default_rng(0))
    assert [asset.handle for asset in ordered].index("knob") == 4
