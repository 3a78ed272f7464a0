"""Imported assets: write one as an asset folder, and stretch one to another size."""

from pathlib import Path
from typing import Any

import numpy as np

from stages.articulated.asset_folder import atomic_folder, checksum
from stages.articulated.model import RobotModel, closed_box, stretched
from stages.articulated.urdf_reader import read_urdf
from stages.articulated.urdf_writer import contract_joints, write_robot
from stages.contracts.files import write_json
from stages.contracts.library import Asset


def write_imported(robot: RobotModel, out: Path, about: dict[str, Any]) -> Asset:
    """Write the asset folder of an imported thing.

    Args:
        robot: z up, front towards +x.
        about: fields of `Asset` that geometry does not tell: id, category, licence, provenance, symmetry, placement.
    """
    low, high = closed_box(robot).round(6)
    with atomic_folder(out) as folder:
        mass = write_robot(robot, folder)
        joints = contract_joints(robot)
        asset = Asset(
            box_min=tuple(low.tolist()),
            box_max=tuple(high.tolist()),
            mass=round(mass, 4),
            joints=joints,
            doors=sum(joint.role == "door" for joint in joints),
            drawers=sum(joint.role == "drawer" for joint in joints),
            checksum=checksum(folder),
            **about,
        )
        write_json(folder / "asset.json", asset)
    return asset


def stretch(asset_folder: Path, asset: Asset, size: tuple[float, float, float], out: Path) -> Asset:
    """Write the imported asset with a closed box of exactly `size`: everything in it is scaled per axis."""
    robot = read_urdf(Path(asset_folder) / asset.urdf, asset_folder)
    x, y, z = (np.array(size) / np.maximum(asset.size, 1e-9)).tolist()
    keep = {"id", "category", "licence", "provenance", "symmetry", "placement"}
    return write_imported(stretched(robot, (x, y, z)), out, asset.model_dump(include=keep))
