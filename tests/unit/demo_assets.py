"""A small cabinet with one door, or one drawer, for the tests of tasks and demonstrations."""

from dataclasses import replace
from pathlib import Path
from typing import Any

from roomkin.plugins.furniture.folder import build
from roomkin.stages.articulated.asset_folder import Description, read_model, write_asset
from roomkin.stages.contracts.library import Asset, Recipe
from roomkin.stages.contracts.policies import TaskAsset
from roomkin.stages.geometry.frames import invert_transform

FRONT: dict[str, Any] = {
    "digest": "c0ffee",
    "handle": "bar",
    "hinge": "left",
    "panel_height": 0.4,
    "panel_size": (0.4, 0.6),
    "handle_length": 0.2,
    "handle_height": 0.5,
}


def an_asset(name: str, distance: float = 1.0, **changes: Any) -> TaskAsset:
    """An asset of the family that its name begins with: near_1 is of `near`."""
    about = {"role": "usable", "asset": name, "family": name.split("_")[0], "category": "cabinet", "joint": "j"}
    return TaskAsset(**about | FRONT | {"size": (1.0, 1.0, 1.0), "distance": distance} | changes)


PARAMETERS: dict[str, Any] = {
    "layout": [["door"]],
    "major": "columns",
    "drawer_weight": 0.35,
    "open_weight": 0.6,
    "panel_weight": 0.2,
    "hinge": 1,
    "panel": "flat",
    "handle": "bar",
    "handle_length": 0.25,
    "handle_at": 0.3,
    "handle_inset": 0.045,
    "protrusion": 0.038,
    "board": 0.018,
    "base": "none",
    "base_height": 0.08,
    "top": 0.0,
    "top_thickness": 0.03,
    "reach": 0.85,
    "shelves": 1,
    "front_thickness": 0.018,
    "size": [0.4, 0.45, 0.7],
    **{
        f"{name}_colour": [0.7, 0.6, 0.5]
        for name in ("body", "front", "field", "handle", "top", "base", "inside", "panel")
    },
}


def cabinet(folder: Path, **changes: Any) -> Asset:
    """Build the cabinet, with some parameters changed, in `folder`; its box is 0.4 x 0.45 x 0.7 m."""
    recipe = Recipe(generator="cabinet", parameters={**PARAMETERS, **changes})
    return build(recipe, None, folder, folder.name, "bottom_cabinet")


def shifted(folder: Path, by: float) -> Path:
    """The model in `folder`, closed as it was, with the limits of its joints moved; in a folder beside it."""
    model = read_model(folder)
    joints = []
    for joint in model.joints:
        if joint.type != "fixed":
            origin = joint.origin @ joint.motion(joint.lower) @ invert_transform(joint.motion(joint.lower + by))
            joint = replace(joint, origin=origin, lower=joint.lower + by, upper=joint.upper + by)
        joints.append(joint)
    out = folder.with_name(f"{folder.name}_shifted")
    write_asset(replace(model, joints=joints), out, Description(out.name, "bottom_cabinet", "CC0-1.0", "test"))
    return out
