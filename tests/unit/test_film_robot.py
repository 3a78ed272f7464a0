"""The robot of films: few triangles, but of the same form and colors."""

import numpy as np
import pytest
import trimesh

from roomkin.stages.simulation.film_renderer import SHARE, thin_scene
from roomkin.stages.simulation.robot import PANDA


@pytest.mark.parametrize("name", ["hand", "link5"])
def test_a_thin_mesh_has_the_form_and_the_colors_of_the_stock_one(name: str) -> None:
    path = PANDA.parent / "franka_description" / "meshes" / "visual" / f"{name}.glb"
    stock, thin = trimesh.load_scene(path), thin_scene(path)
    assert sum(len(mesh.faces) for mesh in thin.geometry.values()) < 1.1 * SHARE * stock.triangles.shape[0]
    assert np.abs(thin.bounds - stock.bounds).max() < 0.001
    for key, mesh in stock.geometry.items():
        assert (thin.geometry[key].visual.material.baseColorFactor == mesh.visual.material.baseColorFactor).all()
