"""The same asset at another size: procedural ones are made again, imported ones are stretched."""

import hashlib
import json
from collections.abc import Sequence
from pathlib import Path

from stages.articulated.asset_folder import read_asset, stretch_asset
from stages.contracts.errors import InputError
from stages.contracts.types import LARGEST
from stages.procedural import build

SAME = 5e-4  # metres: a size this near to the native one is left alone


def resized(asset_folder: Path, size: Sequence[float], out: Path) -> Path:
    """A folder, inside `out`, of the asset with a closed box of exactly `size` (metres, own axes).

    The folder's name is a key of asset and size; one that is there already is used as it is.

    Raises:
        InputError: the size is not positive, or not of this world.
    """
    asset = read_asset(asset_folder)
    x, y, z = (float(value) for value in size)
    if not all(0 < extent <= LARGEST for extent in (x, y, z)):
        fix = f"all extents must be positive, {LARGEST:g} m at most"
        raise InputError(asset_folder, f"cannot be resized to {x:g} x {y:g} x {z:g} m.", fix, code="E-MODEL-SIZE")
    if max(abs(a - b) for a, b in zip((x, y, z), asset.size, strict=True)) < SAME:
        return Path(asset_folder)
    key = json.dumps([asset.id, asset.checksum, [round(value, 5) for value in (x, y, z)]])
    folder = Path(out) / f"{asset.id}-{hashlib.sha256(key.encode()).hexdigest()[:12]}"
    if (folder / "asset.json").exists():
        return folder
    if asset.recipe is not None:
        build(asset.recipe, (x, y, z), folder, asset.id, asset.category, asset.provenance)
    else:
        stretch_asset(asset_folder, asset, (x, y, z), folder)
    return folder
