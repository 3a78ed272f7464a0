"""Points on meshes and their closed pieces: as Trimesh has them, in less time."""

import numpy as np
import pytest
import trimesh

from roomkin.stages.geometry.solids import sample_triangles, split_solids


@pytest.fixture
def touching() -> trimesh.Trimesh:
    """Boxes that share edges, one without its lid, and one lone triangle."""
    boxes = [trimesh.creation.box((1, 1, 1)).apply_translation((x, y, 0)) for x, y in ((0, 0), (1, 1), (3, 0))]
    boxes[2].update_faces(np.arange(10))
    triangle = trimesh.Trimesh(np.eye(3) + 9, [[0, 1, 2]])
    mesh = trimesh.util.concatenate([*boxes, triangle])
    assert isinstance(mesh, trimesh.Trimesh)
    return trimesh.Trimesh(mesh.vertices, mesh.faces)


def test_points_are_those_that_trimesh_draws(touching: trimesh.Trimesh) -> None:
    drawn = trimesh.sample.sample_surface(touching, 500, seed=np.random.default_rng(0))[0]
    assert np.array_equal(sample_triangles(touching.triangles, touching.area_faces, 500), drawn)


@pytest.mark.parametrize("scale", [(1.0, 1.0, 1.0), (2.0, 1.0, 0.5)])
def test_pieces_are_those_that_trimesh_splits(touching: trimesh.Trimesh, scale: tuple[float, float, float]) -> None:
    mesh = touching.apply_transform(np.diag([*scale, 1.0]))
    expected = [piece.triangles for piece in mesh.split()]
    found = [mesh.vertices[corners] for corners in split_solids(mesh)]
    assert len(found) == 3  # the lid is made anew, the triangle is not closed
    assert all(np.array_equal(a, b) for a, b in zip(found, expected, strict=True))
