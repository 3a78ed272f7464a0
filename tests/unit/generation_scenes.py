"""Placed objects for the tests of generation."""

import numpy as np

from stages.contracts import Asset
from stages.contracts.objects import Mounting, Wall
from stages.generation.placed import Placed
from stages.generation.prisms import Prism
from stages.geometry.boxes import UprightBox

BACK = Wall(id="wall_1", normal=(-1, 0, 0), offset=-4.0, points=100)  # the plane x = 4, seen from x < 4


def asset(size, **values) -> Asset:
    half = np.asarray(size) / 2
    values = {"id": "a", "category": "thing", "mass": 1.0, "licence": "CC0-1.0", "provenance": "test"} | values
    return Asset(box_min=tuple(-half), box_max=tuple(half), checksum="0", **values)


def thing(name, center, size, yaw=0.0, mounting=2, walls=(), support="floor") -> Placed:
    return Placed(
        name, name, asset(size), UprightBox(center, size, yaw), Mounting(type=mounting, walls=list(walls)), support
    )


def solid(item: Placed) -> list[Prism]:
    """The whole box as one collision shape."""
    x, y, z = item.size / 2
    return [Prism(np.array([(-x, -y), (x, -y), (x, y), (-x, y)]), -z, z)]
