"""Robustness variant of a room: other colors, light and model sizes (perturbation `recoloured`)."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from roomkin.plugins.scenes.casting import ATTEMPTS, CastRoom
from roomkin.plugins.scenes.chance import colors
from roomkin.plugins.scenes.layout import arrange
from roomkin.stages.articulated.asset_folder import write_asset
from roomkin.stages.articulated.resizing import load_maker, resize_model
from roomkin.stages.contracts import Asset, InputError
from roomkin.stages.contracts.library import Vector

CHANGE, TINT = 0.15, 0.06  # largest relative change of an extent or of all colors, and of one color channel
SALT = 0xF1715
Rng = np.random.Generator


@dataclass(frozen=True)
class Appearance:
    """Folders of a room's models by item name (none: in the library), direction of the key light, channels' gains."""

    folders: dict[str, Path]
    light: tuple[float, float, float] | None = None
    gain: NDArray[np.float64] | None = None


AS_IS = Appearance({})


def repaint_room(cast_room: CastRoom, library: Mapping[str, Path], out: Path, seed: int) -> tuple[CastRoom, Appearance]:
    """The room with models made anew in `out`: other sizes, finishes, walls and light; ids and counts stay.

    `library`: folders of its models, by id. Models without a recipe (a user's) keep their finish.

    Raises:
        InputError: the models fit at no size.
    """
    rng = np.random.default_rng(np.random.SeedSequence((seed, SALT)))
    for _ in range(ATTEMPTS):
        sizes = {name: _stretch_size(asset.size, rng) for name, asset in cast_room.assets.items()}
        layout = arrange(cast_room.room, sizes)
        if layout is not None:
            break
    else:
        raise InputError(
            cast_room.room.name, "its models fit at no other size.", "change the seed", code="E-ROOM-LAYOUT"
        )
    folders = {name: out / name for name in cast_room.assets}
    assets = {
        name: _paint_model(asset, library[asset.id], sizes[name], folders[name], rng)
        for name, asset in cast_room.assets.items()
    }
    room = cast_room.room.model_copy(update=colors(rng))
    light = (-rng.uniform(0.3, 0.8), rng.uniform(-0.7, 0.7), -1.0)
    gain = (1 + CHANGE * rng.uniform(-1, 1)) * (1 + TINT * rng.uniform(-1, 1, 3))
    return replace(cast_room, room=room, layout=layout, assets=assets), Appearance(folders, light, gain)


def _stretch_size(size: Vector, rng: Rng) -> Vector:
    x, y, z = (np.array(size) * (1 + CHANGE * rng.uniform(-1, 1, 3))).tolist()
    return x, y, z


def _paint_model(asset: Asset, home: Path, size: Vector, out: Path, rng: Rng) -> Asset:
    if asset.recipe is not None:
        asset = asset.model_copy(update={"recipe": load_maker().refinish(asset.recipe, rng)})
    robot, about = resize_model(home, asset, size)
    return write_asset(robot, out, about)
