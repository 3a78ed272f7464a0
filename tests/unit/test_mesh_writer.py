"""OBJ as text: few digits, no minus before zero, indices that go on from surface to surface. What is a box."""

from pathlib import Path

import numpy as np
import pytest
from trimesh import Trimesh
from trimesh.creation import box

from roomkin.stages.articulated.mesh_writer import TriangleSurface, is_box, write_obj
from roomkin.stages.articulated.model import Texture

CORNERS = np.array([[1 / 3, -0.0, 0.0], [1.0, -2e-6, 0.0], [2.0, 1.0, 0.123456]])
SEEN = TriangleSurface(CORNERS, np.array([[0, 2, 1]]), -CORNERS / 3, CORNERS[:, :2] ** 2)
VERTICES = "v 0.33333 0 0\nv 1 0 0\nv 2 1 0.12346\n"
NORMALS = "vn -0.1111 0 0\nvn -0.3333 0 0\nvn -0.6667 -0.3333 -0.0412\n"
PLACES = "vt 0.1111 0\nvt 1 0\nvt 4 1\n"


@pytest.mark.parametrize(
    ("surface", "text"),
    [
        (SEEN._replace(normals=None), 2 * VERTICES + "f 1 3 2\nf 4 6 5\n"),
        (SEEN, 2 * VERTICES + 2 * NORMALS + "f 1//1 3//3 2//2\nf 4//4 6//6 5//5\n"),
    ],
)
def test_two_surfaces_in_one_file(surface: TriangleSurface, text: str, tmp_path: Path) -> None:
    write_obj(tmp_path / "a.obj", [surface, surface])
    assert (tmp_path / "a.obj").read_text() == text


def test_a_texture_has_its_places_at_the_corners_of_every_face(tmp_path: Path) -> None:
    write_obj(tmp_path / "a.obj", [SEEN, SEEN], Texture("oak", b"", (1.0, 1.0)))
    faces = "f 1/1/1 3/2/3 2/3/2\nf 4/4/4 6/5/6 5/6/5\n"
    text = "mtllib oak.mtl\nusemtl oak\n" + 2 * VERTICES + 2 * PLACES + 2 * NORMALS + faces
    assert (tmp_path / "a.obj").read_text() == text


def test_a_box_has_a_vertex_in_each_of_its_corners() -> None:
    whole = box((0.1, 0.2, 0.3))
    moved, doubled = np.array(whole.vertices), np.array(whole.vertices)
    moved[0, 0] += 0.01
    doubled[0] = doubled[1]
    assert is_box(whole) and not is_box(box((0.1, 0.2, 0.3)).subdivide())
    assert not any(is_box(Trimesh(vertices, whole.faces, process=False)) for vertices in (moved, doubled))
