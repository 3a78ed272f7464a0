"""What lies in another thing: a can in a bowl."""

from pathlib import Path

import numpy as np
import pytest

from roomkin.plugins.furniture.catalogue import sample
from roomkin.plugins.furniture.folder import build
from roomkin.stages.config.generation import GenerationConfig
from roomkin.stages.contracts import Asset, read_json
from roomkin.stages.contracts.objects import Mounting
from roomkin.stages.generation.collisions import find_landing, resolve_collisions
from roomkin.stages.generation.placed import Placed, read_collisions, to_prisms
from roomkin.stages.generation.settling import load_items, run_physics
from roomkin.stages.generation.stacking import assign_supports
from roomkin.stages.geometry.boxes import UprightBox
from roomkin.stages.simulation.loading import physics_scene
from tests.unit.physics import add_ground


def block(x, y, z, half=0.5):
    corners = np.array([(i, j, k) for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)])
    return half * corners + [x, y, z]


GROOVE = [
    np.array([(0.0, y, 0.0) for y in (-1, 1)] + [(s, y, z) for y in (-1, 1) for z in (0.0, 1.0)]) for s in (-1, 1)
]


@pytest.mark.parametrize(
    ("lower", "x", "z", "rise"),
    [
        ([block(0, 0, 0.5)], 0.9, 3.0, -1.5),  # comes down on a cube by its edge
        ([block(0, 0, 0.5)], 0.0, 0.5, 1.0),  # in the cube
        ([block(0, 0, 0.5)], 1.1, 3.0, None),  # beside it
        (GROOVE, 0.0, 1.0, 0.0),  # slopes of 45 degrees touch both lower edges half a metre up
        (GROOVE, 0.2, 1.0, 0.2),
    ],
)
def test_where_a_cube_lands(lower, x, z, rise):
    assert find_landing([block(x, 0, z)], lower) == (None if rise is None else pytest.approx(rise))


@pytest.mark.parametrize("aside", [0.0, 0.02])
@pytest.mark.parametrize("index", [0, 2, 3])
def test_a_can_lies_in_a_bowl_and_stays(index: int, aside: float, tmp_path: Path) -> None:
    folders = {
        "bowl": tmp_path / "bowl",
        "can": tmp_path / "can",
    }
    build(sample("bowl", index, 0), (0.16, 0.16, 0.08), folders["bowl"], "bowl", "bowl")
    build(sample("jar", 1, 0), (0.07, 0.07, 0.1), folders["can"], "can", "jar")
    boxes = {
        "bowl": UprightBox([1, 0, 0.04], [0.16, 0.16, 0.08], 0.0),
        "can": UprightBox([1 + aside, 0, 0.06], [0.07, 0.07, 0.1], 0.0),
    }
    items = [
        Placed(
            name,
            name,
            read_json(Asset, folder / "asset.json"),
            folder,
            boxes[name],
            Mounting(type=2),
            prisms=to_prisms(read_collisions(folder)),
        )
        for name, folder in folders.items()
    ]
    options = GenerationConfig()
    result = resolve_collisions(assign_supports(items, {}, {}, options, {}), [], options)
    assert not result.left
    physics = physics_scene()
    add_ground(physics)
    settled = run_physics(physics, load_items(physics, result.items), result.items, 0, options)
    assert settled.plausibility.stable and settled.plausibility.max_penetration < 1e-3
    assert settled.shifts["can"] < 2e-3
    placed = {item.id: item for item in result.items}["can"]
    assert placed.support == "bowl" and placed.box.bottom < 0.05
    paper = GenerationConfig(stack_tolerance=None)
    left = resolve_collisions(assign_supports(items, {}, {}, options, {}), [], paper).left
    assert left == [("bowl", "can")], "the paper lets nothing down into another"
