"""Training, validation and test assets: whole families, and lists of which every beginning is balanced."""

import sys
from collections import Counter
from collections.abc import Collection, Iterable, Mapping, Sequence
from itertools import zip_longest
from statistics import median
from typing import NamedTuple, TypeVar, get_args

import numpy as np

from roomkin.stages.contracts.policies import TaskAsset, TaskAssets
from roomkin.stages.contracts.policy_config import DRAW

T = TypeVar("T")
Handle = tuple[str, float, float]  # kind, length in metres, height on the front
Stratum = tuple[str, bool, bool]  # kind, longer and higher than most of this kind
# To whom families go in turns. Four in seven to test: of the default library's doors that makes 20 families.
SPLIT_TURNS = ("test", "validation", "test", "train", "test", "validation", "test")


class Splits(NamedTuple):
    """Assets of the families in each split."""

    train: list[TaskAsset]
    validation: list[TaskAsset]
    test: list[TaskAsset]


def with_lists(
    plan: TaskAssets, usable: Collection[TaskAsset], nearest: Collection[str], count: int, seed: int, draws: int = 1
) -> TaskAssets:
    """The plan, which has its roles alone, with the lists of training, validation and test assets.

    Args:
        usable: the assets that the task can open; of those that do not open to the twin's side, only some of the
            training set `all` are used.
        nearest: categories that the training set `all` is of.
        count: at most so many assets in the lists of validation and of test each.
        seed: of the split and of the assets drawn by chance.
        draws: how often assets are drawn for the training sets `random_n` and `cover_n`.
    """
    rng = np.random.default_rng(seed)
    hidden = {asset.family for asset in plan.assets if asset.role in plan.hidden_roles}
    trained = {asset.family for asset in plan.assets} - hidden
    twins = {asset.family for asset in plan.assets if asset.role in ("twin", "matched")}
    same = [asset for asset in usable if asset.hinge == plan.assets[0].hinge]
    splits = split_by_family((asset for asset in same if asset.family not in trained | hidden), rng)
    trained |= {asset.family for asset in splits.train}
    train = [asset for asset in same if asset.family in trained]
    apart = hidden | {asset.family for asset in [*splits.validation, *splits.test]}
    everything = (asset for asset in usable if asset.category in nearest and asset.family not in apart)
    for name, assets in {"train": train, "validation": splits.validation, "test": splits.test}.items():
        print(census(name, assets), file=sys.stderr)
    pool = [asset for asset in train if asset.family not in twins]
    first = by_chance(pool, rng)  # of the same generator and in its turn, as published assets were drawn
    validation, test = order_by_family(splits.validation, rng), order_by_family(splits.test, rng)
    own = np.random.default_rng((seed, *f"{plan.scene} {plan.object} {plan.task}".encode()))  # other draws per object
    by_draw = [first, *(by_chance(pool, own) for _ in range(draws - 1))]
    covering = [cover(pool, DRAW, own) for _ in range(draws)]
    return plan.model_copy(
        update={
            "all_assets": _as("all", sorted(everything, key=lambda asset: (asset.distance, asset.asset))),
            "draws": draws,
            "random_assets": _as("random", [asset for draw in by_draw for asset in draw[:DRAW]]),
            "cover_assets": _as("cover", [asset for draw in covering for asset in draw]),
            "validation_assets": _as("validation", validation[:count]),
            "test_assets": _as("test", test[:count]),
        }
    )


def split_by_family(assets: Iterable[TaskAsset], rng: np.random.Generator) -> Splits:
    """Assign whole families to splits: about half of them to test, a quarter to validation, the rest to training.

    Families with the same kind of handle, about as long and as high on the front, are assigned one after another, in an
    order by chance, so that every split gets its share of them.
    """
    families: dict[str, list[TaskAsset]] = {}
    for asset in sorted(assets, key=lambda asset: asset.asset):
        families.setdefault(asset.family, []).append(asset)
    strata = _strata({name: _pick_typical(members) for name, members in families.items()})
    splits = Splits([], [], [])
    for turn, name in enumerate(sorted(_shuffle_items(families, rng), key=lambda name: strata[name])):
        getattr(splits, SPLIT_TURNS[turn % len(SPLIT_TURNS)]).extend(families[name])
    return splits


def order_by_family(assets: Iterable[TaskAsset], rng: np.random.Generator) -> list[TaskAsset]:
    """The assets in an order whose first n, for any n, are of as many families as can be, and like all of them in
    kinds, lengths and heights of handles."""
    turns = _turns(assets, rng)
    strata = _strata({asset.asset: _handle(asset) for turn in turns for asset in turn})
    return [asset for turn in turns for asset in _spread(turn, strata)]


def by_chance(assets: Iterable[TaskAsset], rng: np.random.Generator) -> list[TaskAsset]:
    """The assets in an order by chance, families different from one another first."""
    return [asset for turn in _turns(assets, rng) for asset in turn]


def cover(pool: Iterable[TaskAsset], count: int, rng: np.random.Generator) -> list[TaskAsset]:
    """So many assets in an order by chance whose first n, for any n, are spread over widths of fronts and heights of
    handles on them; families different from one another first.

    A family is there by one asset, by chance. Of n = 2, 4, 8, ... assets each lies in a cell of its own, which holds
    the n-th part of the families: halves by width, of those halves by height, of those by width again.
    """
    return [asset for turn in _turns(pool, rng) for asset in _alternate_halves(turn, rng)][:count]


def census(name: str, assets: Sequence[TaskAsset]) -> str:
    """Size of a split by kind of handle, e.g. `test: 53 of 20 families (bar 31, knob 9)`."""
    kinds = ", ".join(f"{kind} {count}" for kind, count in sorted(Counter(asset.handle for asset in assets).items()))
    families = len({asset.family for asset in assets})
    return f"{name}: {len(assets)} of {families} families" + f" ({kinds})" * bool(kinds)


def _as(role: str, assets: Iterable[TaskAsset]) -> list[TaskAsset]:
    return [asset.model_copy(update={"role": role}) for asset in assets]


def _shuffle_items(items: Iterable[T], rng: np.random.Generator) -> list[T]:
    given = list(items)
    return [given[number] for number in rng.permutation(len(given))]


def _turns(assets: Iterable[TaskAsset], rng: np.random.Generator) -> list[list[TaskAsset]]:
    """Rounds in which every family gives one of its assets, as long as it has any left."""
    turns: list[list[TaskAsset]] = []
    given: Counter[str] = Counter()
    for asset in _shuffle_items(sorted(assets, key=lambda asset: asset.asset), rng):
        if given[asset.family] == len(turns):
            turns.append([])
        turns[given[asset.family]].append(asset)
        given[asset.family] += 1
    return turns


def _handle(asset: TaskAsset) -> Handle:
    return asset.handle, asset.handle_length, asset.handle_height


def _pick_typical(members: Sequence[TaskAsset]) -> Handle:
    kind = Counter(asset.handle for asset in members).most_common(1)[0][0]
    return kind, median(a.handle_length for a in members), median(a.handle_height for a in members)


def _strata(handles: Mapping[str, Handle]) -> dict[str, Stratum]:
    """What each handle is like among those of its kind."""
    kinds: dict[str, list[Handle]] = {}
    for handle in handles.values():
        kinds.setdefault(handle[0], []).append(handle)
    long = {kind: median(each[1] for each in same) for kind, same in kinds.items()}
    high = {kind: median(each[2] for each in same) for kind, same in kinds.items()}
    return {name: (kind, length > long[kind], up > high[kind]) for name, (kind, length, up) in handles.items()}


def _alternate_halves(assets: list[TaskAsset], rng: np.random.Generator, axis: int = 0) -> list[TaskAsset]:
    """The assets in an order that takes turns between the lower and the upper half of them along an axis of `_place`,
    within each between its halves along the other axis, and so on; which half begins is by chance."""
    if len(assets) < 2:
        return assets
    ordered = sorted(assets, key=lambda asset: _place(asset)[axis])
    middle = (len(ordered) + int(rng.integers(2))) // 2  # of an odd number either half may be the larger
    lower, upper = (_alternate_halves(half, rng, 1 - axis) for half in (ordered[:middle], ordered[middle:]))
    turns = zip_longest(*((lower, upper) if rng.integers(2) else (upper, lower)))
    return [asset for turn in turns for asset in turn if asset]


def _place(asset: TaskAsset) -> tuple[float, float]:
    return asset.panel_size[0], asset.handle_height


def _spread(assets: list[TaskAsset], strata: Mapping[str, Stratum], level: int = 0) -> list[TaskAsset]:
    """The assets in an order in which those of every stratum come at equal distances."""
    if level == len(get_args(Stratum)):
        return assets
    groups: dict[str | bool, list[TaskAsset]] = {}
    for asset in assets:
        groups.setdefault(strata[asset.asset][level], []).append(asset)
    placed = []
    for key, group in groups.items():
        placed += [((k + 0.5) / len(group), key, one) for k, one in enumerate(_spread(group, strata, level + 1))]
    return [asset for _, _, asset in sorted(placed, key=lambda place: place[:2])]
