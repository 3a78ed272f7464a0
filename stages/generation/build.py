"""One scene: every object's cousin placed, resized, stacked and freed from collisions."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path

from stages.config.generation import GenerationConfig
from stages.contracts import Asset, InputError, read_json
from stages.contracts.objects import SceneObject
from stages.generation.collisions import resolve
from stages.generation.extents import beyond_front
from stages.generation.inputs import Inputs
from stages.generation.meshes import visual_meshes
from stages.generation.placed import Placed
from stages.generation.placement import place, stacked
from stages.generation.prisms import asset_prisms
from stages.generation.sizing import fits
from stages.procedural.resize import resized


@dataclass(frozen=True)
class Built:
    """`items` with `folders` of assets at their sizes; `failed`: id -> reason; `left`: pairs that still overlap."""

    items: list[Placed]
    folders: dict[str, Path]
    failed: dict[str, str]
    left: list[tuple[str, str]]


def placed_cousins(item: SceneObject, inputs: Inputs, options: GenerationConfig) -> Iterator[Placed]:
    """An object's cousins at their places and sizes, best first: the first, and of the others those that fit.

    Raises:
        InputError: the object has no cousin, or the library lacks it.
    """
    ranked = inputs.ranked(item)
    if isinstance(ranked, str):
        raise InputError(item.id, ranked)
    for index, cousin in enumerate(ranked):
        if cousin.asset not in inputs.folders:
            raise InputError(item.id, f"asset '{cousin.asset}' is not in the library")
        asset = read_json(Asset, inputs.folders[cousin.asset] / "asset.json")
        beyond = beyond_front(visual_meshes(inputs.folders[cousin.asset])) if options.aspect_prior == "native" else 0.0
        seen = inputs.bearings.get(item.id)
        placed = place(item, cousin, asset, inputs.clouds[item.id], inputs.objects, options, beyond, seen)
        if index == 0 or fits(asset.size, placed.box, options.max_stretch):
            yield placed


def placed_and_resized(
    item: SceneObject, rank: int, inputs: Inputs, options: GenerationConfig, cache: Path
) -> tuple[Placed, Path]:
    """An object's cousin of a rank, the last one if fewer fit, and the folder of the asset at its size.

    Raises:
        InputError: the object has no cousin, or the asset is missing or cannot be resized.
    """
    *_, placed = islice(placed_cousins(item, inputs, options), rank)
    folder = resized(inputs.folders[placed.asset.id], placed.size.tolist(), cache)
    return replace(placed, asset=read_json(Asset, folder / "asset.json")), folder


def build(inputs: Inputs, rank: int, options: GenerationConfig, cache: Path) -> Built:
    """The scene of the cousins of one rank. An object that fails is left out, with its reason.

    Args:
        cache: folder for resized assets.
    """
    items, folders, failed = [], {}, {}
    for item in inputs.objects.objects:
        try:
            placed, folders[item.id] = placed_and_resized(item, rank, inputs, options, cache)
            items.append(placed)
        except InputError as error:
            failed[item.id] = error.what
    prisms = {item.id: asset_prisms(folders[item.id]) for item in items}
    result = resolve(stacked(items, prisms, options), prisms, inputs.objects.walls, options)
    return Built(result.items, folders, failed, result.left)
