"""The robot of films: few triangles, but of the same form and colors."""

import shutil
from pathlib import Path

import numpy as np
import pytest
import trimesh

from roomkin.stages.simulation import film_renderer
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


def test_an_environment_that_is_gone_leaves_no_robot_to_others(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    class Thin:
        def export(self, file: Path) -> None:
            file.touch()

    monkeypatch.setattr(film_renderer, "thin_scene", lambda path: Thin())
    monkeypatch.setattr(film_renderer, "cache_folder", lambda: tmp_path)
    film_renderer.film_urdf.cache_clear()
    here = film_renderer.film_urdf()
    (tmp_path / "other").mkdir()
    for suffix in (".urdf", ".srdf"):
        shutil.copy(film_renderer.PANDA.with_suffix(suffix), tmp_path / "other")
    monkeypatch.setattr(film_renderer, "PANDA", tmp_path / "other" / film_renderer.PANDA.name)
    film_renderer.film_urdf.cache_clear()
    there = film_renderer.film_urdf()
    film_renderer.film_urdf.cache_clear()
    assert there != here and str(film_renderer.PANDA.parent) in there.read_text()
