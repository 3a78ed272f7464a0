"""Where the handles of a model are, if whoever made it called them so: a group or material of an OBJ, or a geom, mesh
or site of a MuJoCo file."""

import re
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import mujoco
import numpy as np
import trimesh
from numpy.typing import NDArray

from benchmarks.open_rooms import packs
from roomkin.plugins.scorecard.truth import TrueHandle
from roomkin.stages.geometry.frames import transform_points

Floats = NDArray[np.float64]
Named = Iterator[tuple[str, Floats]]
WORD = "handle"
GAP = 0.01  # metres between two handles
PANEL = re.compile(r"on_(?:hinge|rail)_\d+")  # which door or drawer a group of Sweet Home 3D is of


def find_handles(model: packs.PackModel) -> tuple[TrueHandle, ...]:
    """The handles in the frame of the model's box; none: its source does not name one for each door and drawer.

    How many doors and drawers there are was counted by eye; where the handles are is the source's word.
    """
    if not model.opens:
        return ()
    named: dict[str, list[Floats]] = {}
    for name, boxes in _read_named(model):
        panel = PANEL.search(name)
        named.setdefault(panel[0] if panel else "", []).append(boxes)
    found = [(panel, *box) for panel, boxes in sorted(named.items()) for box in join_boxes(np.concatenate(boxes))]
    panels = [panel or str(place) for place, (panel, _, _) in enumerate(found)]
    order = sorted(set(panels))
    handles = (
        TrueHandle(order.index(panel), _plain((low + high) / 2 - [0, 0, model.size[2] / 2]), _plain(high - low))
        for panel, (_, low, high) in zip(panels, found, strict=True)
    )
    return tuple(handles) if len(order) == len(model.opens) else ()


def join_boxes(corners: Floats) -> list[tuple[Floats, Floats]]:
    """Low and high corners (3,) of what hangs together of boxes (N, 2, 3) that touch, or nearly so."""
    low, high = corners[:, 0], corners[:, 1]
    near = ((low[:, None] <= high + GAP) & (high[:, None] >= low - GAP)).all(axis=2)
    groups = trimesh.graph.connected_components(np.argwhere(near), nodes=np.arange(len(corners)))
    return [(low[group].min(axis=0), high[group].max(axis=0)) for group in groups]


def _plain(values: Floats) -> tuple[float, float, float]:
    x, y, z = (round(float(value), 4) + 0.0 for value in values)
    return x, y, z


def _read_named(model: packs.PackModel) -> Named:
    """Names of what is called a handle, and the boxes (N, 2, 3) of its pieces in the model's own frame."""
    if model.pack in packs.MJCF:
        turn, whole = packs.FRAMES[model.frame], np.concatenate([part.vertices for part in model.read()])
        named = list(_read_mjcf(model))
    elif model.pack in packs.BLENDS or model.pack in packs.URDFS:
        return
    else:
        path, rotation = model.find_obj()
        turn, whole, named = packs.FRAMES[model.frame] @ packs.TO_OURS @ rotation, *read_groups(path)
    turned = transform_points(turn, whole)
    low, scale = turned.min(axis=0), np.array(model.size) / np.ptp(turned, axis=0)
    for name, points in named:
        own = (transform_points(turn, points) - low) * scale - [model.size[0] / 2, model.size[1] / 2, 0]
        yield name, np.stack([own.min(axis=1), own.max(axis=1)], axis=1)


def read_groups(path: Path) -> tuple[Floats, list[tuple[str, Floats]]]:
    """All corners (N, 3) of an OBJ's faces, and by group those (M, 3, 3) of triangles that are called a handle."""
    vertices, used, named = list[list[float]](), list[int](), dict[str, list[list[int]]]()
    group = material = ""
    for line in path.read_text(encoding="latin-1").splitlines():
        key, *words = line.split() or [""]
        if key == "v":
            vertices.append([float(word) for word in words[:3]])
        elif key in ("g", "o"):
            group = " ".join(words)
        elif key == "usemtl":
            material = " ".join(words)
        elif key == "f":
            corners = [int(word.split("/")[0]) for word in words]
            face = [at - 1 if at > 0 else at + len(vertices) for at in corners]
            used += face
            if WORD in f"{group} {material}".casefold():
                named.setdefault(group, []).extend([face[0], *edge] for edge in pairwise(face[1:]))
    points = np.array(vertices)
    return points[used], [(name, points[np.array(faces)]) for name, faces in named.items()]


def _read_mjcf(model: packs.PackModel) -> Named:
    """Points (1, N, 3) of geoms and sites, as `packs` has those of the model."""
    world, data, inside, turn = model.load_mjcf()
    kinds = mujoco.mjtObj
    for geom in range(world.ngeom):
        mesh = world.geom_dataid[geom]
        names = [mujoco.mj_id2name(world, kinds.mjOBJ_GEOM, geom)]
        names += [mujoco.mj_id2name(world, kinds.mjOBJ_MESH, mesh)] if mesh >= 0 else []
        if world.geom_bodyid[geom] in inside and any(WORD in (name or "").casefold() for name in names):
            yield "", packs.read_geom(world, data, geom).vertices[None] @ turn
    for site in range(world.nsite):
        name = mujoco.mj_id2name(world, kinds.mjOBJ_SITE, site) or ""
        if world.site_bodyid[site] in inside and WORD in name.casefold():
            yield "", data.site_xpos[site][None, None] @ turn
