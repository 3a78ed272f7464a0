"""Meshes of an asset folder in the asset frame, every joint closed: what is seen, and what collides."""

from functools import lru_cache
from pathlib import Path

from trimesh import Trimesh

from stages.articulated.asset_folder import read_model
from stages.articulated.forward_kinematics import link_frames
from stages.articulated.model import Link


@lru_cache(maxsize=64)
def _closed_links(folder: Path) -> list[Link]:
    """Links with their meshes in the asset frame. Asset folders never change: their names are keys of their content."""
    robot = read_model(folder)
    frames = link_frames(robot)
    return [link.mapped(frames[link.name]) for link in robot.links.values()]


def visual_meshes(folder: Path) -> list[Trimesh]:
    """What is seen, with its colours."""
    return [visual.painted() for link in _closed_links(folder) for visual in link.visuals]


def collision_pieces(folder: Path) -> list[Trimesh]:
    """The convex pieces that collide."""
    return [mesh for link in _closed_links(folder) for mesh in link.collisions]
