"""Placed objects for the tests of generation."""

from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from roomkin.stages.config.generation import GenerationConfig
from roomkin.stages.contracts import Asset
from roomkin.stages.contracts.objects import Mounting, Wall
from roomkin.stages.generation.collisions import resolve_collisions
from roomkin.stages.generation.inputs import Inputs
from roomkin.stages.generation.placed import Placed, Prism
from roomkin.stages.generation.placing import Places, choose_models
from roomkin.stages.generation.scene_file import doubt_placements
from roomkin.stages.generation.stacking import assign_supports
from roomkin.stages.geometry.boxes import UprightBox

BACK = Wall(id="wall_1", normal=(-1, 0, 0), offset=-4.0, points=100)  # the plane x = 4, seen from x < 4


class Built(NamedTuple):
    """Things in their places, why others have none, and pairs that still collide."""

    items: list[Placed]
    failed: dict[str, str]
    left: list[tuple[str, str]]


def build(inputs: Inputs, rank: int, options: GenerationConfig) -> Built:
    """The scene of a rank before physics runs."""
    items, failed = choose_models(inputs, rank, Places(inputs, options))
    freed = resolve_collisions(
        assign_supports(items, inputs.supports, inputs.nudges, options, inputs.categories),
        inputs.objects.walls,
        options,
    )
    return Built(doubt_placements(freed.items, inputs), failed, freed.left)


def asset(size, **values) -> Asset:
    half = np.asarray(size) / 2
    values = {"id": "a", "category": "thing", "mass": 1.0, "licence": "CC0-1.0", "provenance": "test"} | values
    return Asset(box_min=tuple(-half), box_max=tuple(half), checksum="0", **values)


def upright(outline, low, high) -> Prism:
    """A piece that fills its prism."""
    outline = np.asarray(outline, dtype=float)
    vertices = [np.column_stack([outline, np.full(len(outline), z)]) for z in (low, high)]
    return Prism(outline, low, high, np.concatenate(vertices))


def thing(name, center, size, yaw=0.0, mounting=2, walls=(), support="floor") -> Placed:
    """A thing of which nothing collides: its surface is that of its box."""
    box, held = UprightBox(center, size, yaw), Mounting(type=mounting, walls=list(walls))
    return Placed(name, name, asset(size), Path(), box, held, support)


def solid(item: Placed) -> Placed:
    """The same with its whole box as one collision shape."""
    x, y, z = item.size / 2
    return replace(item, prisms=(upright([(-x, -y), (x, -y), (x, y), (-x, y)], -z, z),))
