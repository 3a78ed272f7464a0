"""One scene: every object's cousin placed, resized, stacked and freed from collisions."""

from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from stages.config.generation import GenerationConfig
from stages.contracts import Asset, InputError, read_json
from stages.contracts.cousins import Cousin
from stages.contracts.objects import SceneObject
from stages.generation.collisions import resolve
from stages.generation.doubts import doubts
from stages.generation.extents import beyond_front
from stages.generation.inputs import Inputs
from stages.generation.meshes import visual_meshes
from stages.generation.placed import Placed
from stages.generation.placement import place, stacked
from stages.generation.prisms import asset_prisms
from stages.generation.sizing import stretch
from stages.generation.steps import told
from stages.generation.told import as_cousin, leaders_first, left, nudged, stated
from stages.procedural.resize import resized


@dataclass(frozen=True)
class Built:
    """`items` with `folders` of assets at their sizes; `failed`: id -> reason; `left`: pairs that still overlap."""

    items: list[Placed]
    folders: dict[str, Path]
    failed: dict[str, str]
    left: list[tuple[str, str]]


def placed_cousins(
    item: SceneObject, cousins: Iterable[Cousin], inputs: Inputs, options: GenerationConfig
) -> Iterator[Placed]:
    """Some cousins of an object at their places, in order.

    Raises:
        InputError: the library lacks one.
    """
    for cousin in cousins:
        asset = read_json(Asset, _folder(item, cousin.asset, inputs) / "asset.json")
        beyond = beyond_front(visual_meshes(inputs.folders[cousin.asset])) if options.aspect_prior == "native" else 0.0
        seen = inputs.bearings.get(item.id)
        yield place(item, cousin, asset, inputs.clouds[item.id], inputs.objects, options, beyond, seen)


def _folder(item: SceneObject, asset: str, inputs: Inputs) -> Path:
    if asset not in inputs.folders:
        raise InputError(item.id, f"asset '{asset}' is not in the library")
    return inputs.folders[asset]


def standing(item: SceneObject, rank: int, inputs: Inputs, options: GenerationConfig, models: dict[int, str]) -> Placed:
    """What stands for an object in the scene of a rank: what a person says, else the cousin of that rank that fits.

    Args:
        models: asset by mask value, of what stands in this scene already.

    Raises:
        InputError: the object has no cousin left, or the library lacks it.
    """
    ranked = inputs.ranked(item)
    if isinstance(ranked, str):
        raise InputError(item.id, ranked)
    said = inputs.said(item)
    if by_hand := stated(item, rank, inputs, models):
        asset, why = by_hand
        category = read_json(Asset, _folder(item, asset, inputs) / "asset.json").category
        (one,) = placed_cousins(item, [as_cousin(asset, category, ranked)], inputs, options)
        known = one.cousin if asset in {cousin.asset for cousin in ranked} else None
        return replace(one, cousin=known, chosen=True, steps=(why, *one.steps))
    cousins = left(ranked, said)
    if not cousins:
        raise InputError(item.id, "all of its cousins are banned")
    rank -= said.model is not None and rank > 1
    called = inputs.called(item, cousins[0].category)
    return chosen(placed_cousins(item, cousins, inputs, options), rank, options.max_stretch, called)


def chosen(placed: Iterable[Placed], rank: int, limit: float | None, called: Collection[str]) -> Placed:
    """The cousin that stands in the scene of a rank: of those that fit, best first, the one of that rank.

    Those come first that are what the object is called and have the doors and drawers of the nearest: that was stated,
    a size is but measured. Then those with others; what is called otherwise never stands for it. Where fewer fit, the
    last of them stands again; where none of the first does, the one that is stretched least. It says so.

    Args:
        placed: the cousins at their places, best first.
        limit: how far they may be stretched; None: they all fit.
        called: categories that the object's label means, that of the nearest among them.
    """
    alike: list[Placed] = []
    akin: list[Placed] = []
    passed: list[tuple[float, Placed]] = []
    nearest: Asset | None = None
    for one in placed:
        nearest, times = nearest or one.asset, stretch(one.asset.size, one.box)
        if one.asset.category not in called:
            continue
        same = (one.asset.doors, one.asset.drawers) == (nearest.doors, nearest.drawers)
        if limit is None or times <= limit:
            (alike if same else akin).append(one)
        elif same:
            passed.append((times, one))
        if len(alike) == rank:
            break
    if not alike:
        least = min(passed, key=lambda one: one[0])
        passed.remove(least)
        alike = [replace(least[1], doubts=(f"no cousin has its size: this one is stretched {least[0]:.1f} times",))]
    fitting = alike + akin
    one = fitting[min(rank, len(fitting)) - 1]
    if len(fitting) < rank and not one.doubts:
        doubt = f"only {len(fitting)} of its cousins have its size: the last of them stands here again"
        one = replace(one, doubts=(doubt,))
    over = ", ".join(f"{each.cousin} ({times:.1f})" for times, each in passed)
    steps = (f"passed over, for so many times they would be stretched: cousins {over}",) if over else ()
    return replace(one, steps=(*steps, *one.steps))


def build(inputs: Inputs, rank: int, options: GenerationConfig, cache: Path) -> Built:
    """The scene of the cousins of one rank. An object that fails is left out, with its reason.

    Args:
        cache: folder for resized assets.
    """
    items, folders, failed = [], {}, {}
    models: dict[int, str] = {}
    for item in leaders_first(inputs):
        try:
            placed = standing(item, rank, inputs, options, models)
            models[item.mask] = placed.asset.id
            folders[item.id] = resized(inputs.folders[placed.asset.id], placed.size.tolist(), cache)
            items.append(replace(placed, asset=read_json(Asset, folders[item.id] / "asset.json")))
        except InputError as error:
            failed[item.id] = error.what
    prisms = {item.id: asset_prisms(folders[item.id]) for item in items}
    supports = {item.id: item.support for item in inputs.objects.objects if item.support}
    stood = nudged(stacked(items, prisms, options, supports), inputs)
    result = resolve(stood, prisms, inputs.objects.walls, options)
    apart = told("out of collisions", stood, result.items)
    sized = {item.id for item in inputs.objects.objects if "size" in item.told}
    doubted = [
        replace(item, doubts=(*item.doubts, *doubts(item, inputs.objects.walls, item.id in sized))) for item in apart
    ]
    return Built(doubted, folders, failed, result.left)
