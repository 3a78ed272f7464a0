"""Training, validation and test assets of the policy experiment: whole families, balanced lists."""

from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from roomkin.stages.contracts import TaskAssets
from roomkin.stages.contracts.policies import TaskAsset
from roomkin.stages.contracts.policy_config import DRAW
from roomkin.stages.experiment.splits import by_chance, cover, order_by_family, split_by_family, with_lists
from tests.refusals import refused
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
    splits = split_by_family(library(), np.random.default_rng(0))
    sizes = [len(families(split)) for split in splits]
    assert sizes == [8, 16, 32] and sum(map(len, splits)) == len(library())
    assert len(set.union(*map(families, splits))) == sum(sizes), "no family is on two sides"
    for split, share in zip(splits, (1 / 7, 2 / 7, 4 / 7), strict=True):
        for kind, count in KINDS.items():
            assert kinds(split)[kind] / 3 == pytest.approx(share * count, abs=1)


def test_the_deal_follows_the_seed_and_not_the_order_of_the_library() -> None:
    first, again, other = (split_by_family(assets, np.random.default_rng(seed)) for assets, seed in (
        (library(), 0), (library()[::-1], 0), (library(), 1)))  # fmt: skip
    assert first == again and families(first.test) != families(other.test)


def test_every_beginning_of_a_list_is_balanced() -> None:
    assets = library()
    ordered = order_by_family(assets, np.random.default_rng(0))
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


def a_pool(families: int = 16, members: int = 2) -> list[TaskAsset]:
    """Families whose fronts and handles are anywhere, members alike."""
    rng = np.random.default_rng(3)
    places = [(rng.uniform(0.2, 1.2), rng.uniform(0, 1)) for _ in range(families)]
    return [
        an_asset(f"f{number:02d}_{member}", panel_size=(width, 0.5), handle_height=height)
        for number, (width, height) in enumerate(places)
        for member in range(members)
    ]


@pytest.mark.parametrize("seed", range(5))
def test_assets_that_cover_lie_one_in_each_cell_of_width_and_height(seed: int) -> None:
    pool = a_pool()
    drawn = cover(pool, DRAW, np.random.default_rng(seed))
    assert len(families(drawn)) == 16 and drawn == cover(pool[::-1], DRAW, np.random.default_rng(seed))
    by_width = sorted(pool, key=lambda asset: asset.panel_size[0])
    halves = [by_width[:16], by_width[16:]]
    quarters = [part for half in halves for part in cut(sorted(half, key=lambda asset: asset.handle_height))]
    eighths = [part for quarter in quarters for part in cut(sorted(quarter, key=lambda asset: asset.panel_size[0]))]
    for cells in (halves, quarters, eighths):
        for cell in cells:
            assert len(families(cell) & families(drawn[: len(cells)])) == 1, len(cells)
    for count in range(2, 16):
        lower = len(families(halves[0]) & families(drawn[:count]))
        assert abs(2 * lower - count) <= 1, "for any n"


def cut(assets: list[TaskAsset]) -> list[list[TaskAsset]]:
    return [assets[: len(assets) // 2], assets[len(assets) // 2 :]]


def test_every_asset_is_as_likely_to_cover() -> None:
    """Also of an odd number of families, and the extremes no more than the others."""
    pool = a_pool(families=7, members=1)
    rng = np.random.default_rng(0)
    found = Counter(asset.asset for _ in range(700) for asset in cover(pool, 2, rng))
    assert set(found) == {asset.asset for asset in pool}
    assert min(found.values()) > 140 and max(found.values()) < 270, found


def test_a_family_covers_once_as_long_as_there_are_others() -> None:
    few = a_pool(families=5, members=4)
    drawn = cover(few, DRAW, np.random.default_rng(0))
    assert len(families(drawn[:5])) == 5 and len({asset.asset for asset in drawn}) == 16
    assert len(cover(few[:3], DRAW, np.random.default_rng(0))) == 3 and not cover([], DRAW, np.random.default_rng(0))


def test_every_draw_is_another_and_the_other_lists_stay() -> None:
    assets = library()
    twin = assets[0].model_copy(update={"role": "twin"})
    plan = TaskAssets(task="door", scene="room_1", object="cabinet_1", encoder="hog", assets=[twin])
    once, thrice = (with_lists(plan, assets, [], 10, 0, draws) for draws in (1, 3))
    assert (once.draws, thrice.draws, thrice.length("random"), thrice.length("cover")) == (1, 3, DRAW, DRAW)
    assert once.random_assets == thrice.random_assets[:DRAW] and once.test_assets == thrice.test_assets
    assert once.validation_assets == thrice.validation_assets
    for rule in ("random", "cover"):
        draws = [thrice.list_drawn(rule)[start : start + DRAW] for start in (0, DRAW, 2 * DRAW)]
        firsts = {tuple(asset.asset for asset in draw[:8]) for draw in draws}
        assert len(firsts) == 3 and all(len(families(draw[:8])) == 8 for draw in draws), "of 8 families that are left"
        assert {asset.role for draw in draws for asset in draw} == {rule}
    assert with_lists(plan, assets[::-1], [], 10, 0, 3) == thrice
    elsewhere = with_lists(plan.model_copy(update={"object": "cabinet_2"}), assets, [], 10, 0, 3)
    assert elsewhere.cover_assets != thrice.cover_assets and elsewhere.random_assets != thrice.random_assets
    third = thrice.assets_of(f"random_{DRAW + 3}_randomised", Path("assets.json"))
    assert third == [thrice.random_assets[DRAW + 2]]


def test_draws_are_of_one_length_and_name_an_asset_once_each() -> None:
    twin, others = an_asset("twin_1", role="twin"), [an_asset(f"a_{number}") for number in range(2)]
    about = {"task": "door", "scene": "room_1", "object": "cabinet_1", "encoder": "hog", "assets": [twin], "draws": 2}
    plan = TaskAssets(**about, random_assets=[*others, *others[::-1]])
    assert plan.assets_of("random_18", Path("assets.json")) == [others[0]], "second of the second draw"
    for role in ("random_3", "random_33", "cover_1"):
        with refused("E-ROLE-MISSING", f"has no '{role}'"):
            plan.assets_of(role, Path("assets.json"))
    with pytest.raises(ValueError, match="random_assets: 3 are not 2 draws of one length"):
        TaskAssets(**about, random_assets=[*others, others[0]])
    with pytest.raises(ValueError, match="cover_assets of one draw: 'a_0' occurs twice"):
        TaskAssets(**about, cover_assets=[others[0], others[0], *others])


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
    assert families(full.random_assets) == families(full.cover_assets) <= families(full.all_assets)
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


def test_the_only_one_of_its_kind_stands_in_the_middle() -> None:
    """One knob among eight bars: neither the first test asset nor the last."""
    assets = [an_asset(f"bar{number}_0") for number in range(8)] + [an_asset("knob0_0", handle="knob")]
    ordered = order_by_family(assets, np.random.default_rng(0))
    assert [asset.handle for asset in ordered].index("knob") == 4
