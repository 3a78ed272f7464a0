"""Meshes of an asset folder in the asset frame, every joint closed: what is seen, and what collides."""

from dataclasses import replace
from functools import lru_cache
from pathlib import Path

from trimesh import Trimesh

from stages.articulated.asset_folder import read_asset
from stages.articulated.model import Link, link_frames, moved
from stages.articulated.urdf_reader import read_urdf


@lru_cache(maxsize=64)
def _closed_links(folder: Path) -> list[Link]:
    """Links with their meshes in the asset frame. Asset folders never change: their names are keys of their content."""
    robot = read_urdf(folder / read_asset(folder).urdf, folder)
    frames = link_frames(robot)
    return [
        replace(
            link,
            visuals=[moved(mesh, frames[link.name]) for mesh in link.visuals],
            collisions=[moved(mesh, frames[link.name]) for mesh in link.collisions],
        )
        for link in robot.links.values()
    ]


def visual_meshes(folder: Path) -> list[Trimesh]:
    """What is seen, with its colours."""
    return [mesh for link in _closed_links(folder) for mesh in link.visuals]


def collision_pieces(folder: Path) -> list[Trimesh]:
    """The convex pieces that collide."""
    return [mesh for link in _closed_links(folder) for mesh in link.collisions]
