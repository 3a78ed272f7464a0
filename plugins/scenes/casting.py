"""Choose a model for every item of the rooms by seed; no model stands in two rooms (paper B.1)."""

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from roomkin.plugins.scenes.layout import Layout, arrange
from roomkin.plugins.scenes.recipe import Room
from roomkin.stages.contracts import Asset, InputError

ATTEMPTS = 400  # draws of a room before it is refused as one that does not fit; chosen for time
SALT = 0x5CE7E  # keeps this draw apart from others with the same seed


@dataclass(frozen=True)
class CastRoom:
    """A room with its models (by item name) and their places."""

    room: Room
    layout: Layout
    assets: dict[str, Asset]


def templates(models: dict[str, Asset]) -> set[str]:
    """Ids of the models that may furnish rooms; near relatives of another model are left out."""
    return {name for name, asset in models.items() if asset.recipe is None or asset.recipe.variation_of is None}


def choose_models(
    room: Room, models: dict[str, Asset], free: set[str], rng: np.random.Generator, library: Path
) -> dict[str, Asset]:
    """One model per item, all different, by the item's name.

    Raises:
        InputError: no unused model is left for an item.
    """
    chosen: dict[str, Asset] = {}
    left = {name: asset for name, asset in models.items() if name in free}
    for item in room.items:
        able = [name for name, one in left.items() if one.category == item.category and item.model.accepts(one)]
        if not able:
            fault = (
                f"has no model left for '{item.name}' of {room.name}: category {item.category}, {item.model.text()}."
            )
            fix = f"raise assets.counts.{item.category} (no model stands in two rooms)"
            raise InputError(library, fault, fix, code="E-MODELS-SHORT")
        chosen[item.name] = left.pop(able[int(rng.integers(len(able)))])
    return chosen


def cast(rooms: Sequence[Room], models: dict[str, Asset], seed: int, library: Path) -> dict[str, CastRoom]:
    """Models and layout of every room, by the room's name.

    A room's cast depends on the rooms before it, never on those after it: jobs for single rooms agree. Near relatives
    of other models play no part: a larger library has the same rooms. If no remaining models fit a room (one seed of
    twenty has such a room), it takes some of other rooms, and a line on stderr says so.

    Raises:
        InputError: a category is short, or its models are too large for the room.
    """
    rng = np.random.default_rng(np.random.SeedSequence((seed, SALT)))
    able = templates(models)
    free = set(able)
    result = {}
    for room in rooms:
        found = cast_room(room, models, free, rng, library)
        if found is None:
            found = cast_room(room, models, able, rng, library)
            print(f"{room.name}: no models that are left fit its layout: some are of other rooms", file=sys.stderr)
        if found is None:
            fault = f"{room.name}: no choice of models fits its layout."
            raise InputError(library, fault, "raise assets.counts", code="E-MODELS-SHORT")
        result[room.name] = found
        free -= {asset.id for asset in found.assets.values()}
    return result


def cast_room(
    room: Room, models: dict[str, Asset], able: set[str], rng: np.random.Generator, library: Path
) -> CastRoom | None:
    """The room with models of those `able` to play, by chance; None if no choice of many fits its layout."""
    for _ in range(ATTEMPTS):
        assets = choose_models(room, models, able, rng, library)
        layout = arrange(room, {name: asset.size for name, asset in assets.items()})
        if layout is not None:
            return CastRoom(room, layout, assets)
    return None
