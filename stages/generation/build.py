"""One scene: every object's cousin placed, resized, stacked and freed from collisions."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from stages.config.generation import GenerationConfig
from stages.contracts import Asset, InputError, read_json
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
from stages.procedural.resize import resized


@dataclass(frozen=True)
class Built:
    """`items` with `folders` of assets at their sizes; `failed`: id -> reason; `left`: pairs that still overlap."""

    items: list[Placed]
    folders: dict[str, Path]
    failed: dict[str, str]
    left: list[tuple[str, str]]


def placed_cousins(item: SceneObject, inputs: Inputs, options: GenerationConfig) -> Iterator[Placed]:
    """An object's cousins at their places, best first.

    Raises:
        InputError: the object has no cousin, or the library lacks it.
    """
    ranked = inputs.ranked(item)
    if isinstance(ranked, str):
        raise InputError(item.id, ranked)
    for cousin in ranked:
        if cousin.asset not in inputs.folders:
            raise InputError(item.id, f"asset '{cousin.asset}' is not in the library")
        asset = read_json(Asset, inputs.folders[cousin.asset] / "asset.json")
        beyond = beyond_front(visual_meshes(inputs.folders[cousin.asset])) if options.aspect_prior == "native" else 0.0
        seen = inputs.bearings.get(item.id)
        yield place(item, cousin, asset, inputs.clouds[item.id], inputs.objects, options, beyond, seen)


def chosen(placed: Iterable[Placed], rank: int, limit: float | None) -> Placed:
    """The cousin that stands in the scene of a rank: of those that fit, best first, the one of that rank.

    Where fewer fit, the last of them; where none does, the one that is stretched least. It says so.

    Args:
        placed: the cousins at their places, best first.
        limit: how far they may be stretched; None: they all fit.
    """
    fitting: list[Placed] = []
    passed: list[tuple[float, Placed]] = []
    for one in placed:
        times = stretch(one.asset.size, one.box)
        if limit is None or times <= limit:
            fitting.append(one)
        else:
            passed.append((times, one))
        if len(fitting) == rank:
            break
    over = ", ".join(f"{one.cousin} ({times:.1f})" for times, one in passed)
    steps = (f"passed over, for so many times they would be stretched: cousins {over}",) if over else ()
    if not fitting:
        times, least = min(passed, key=lambda one: one[0])
        return replace(least, doubts=(f"no cousin has its size: this one is stretched {times:.1f} times",))
    if len(fitting) < rank:
        doubt = f"only {len(fitting)} of its cousins have its size: the last of them stands here again"
        return replace(fitting[-1], steps=(*steps, *fitting[-1].steps), doubts=(doubt,))
    return replace(fitting[-1], steps=(*steps, *fitting[-1].steps))


def build(inputs: Inputs, rank: int, options: GenerationConfig, cache: Path) -> Built:
    """The scene of the cousins of one rank. An object that fails is left out, with its reason.

    Args:
        cache: folder for resized assets.
    """
    items, folders, failed = [], {}, {}
    for item in inputs.objects.objects:
        try:
            placed = chosen(placed_cousins(item, inputs, options), rank, options.max_stretch)
            folders[item.id] = resized(inputs.folders[placed.asset.id], placed.size.tolist(), cache)
            items.append(replace(placed, asset=read_json(Asset, folders[item.id] / "asset.json")))
        except InputError as error:
            failed[item.id] = error.what
    prisms = {item.id: asset_prisms(folders[item.id]) for item in items}
    stood = stacked(items, prisms, options)
    result = resolve(stood, prisms, inputs.objects.walls, options)
    apart = told("out of collisions", stood, result.items)
    doubted = [replace(item, doubts=(*item.doubts, *doubts(item, inputs.objects.walls))) for item in apart]
    return Built(doubted, folders, failed, result.left)
