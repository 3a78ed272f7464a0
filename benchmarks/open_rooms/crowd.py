"""Rooms to learn from: things of every kind alike, of packs, of our own models, and of what is no category of ours."""

from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np

from benchmarks.name_training.solids import JUNK, ON_WALLS
from benchmarks.open_rooms import packs
from roomkin.plugins.furniture.catalogue import CATEGORIES
from roomkin.plugins.furniture.model import Model as Built
from roomkin.plugins.furniture.model import Part, fit_model, parts_of
from roomkin.stages.contracts.categories import known_categories

OURS, COUNT = "ours", 12  # the pack of our own models, and so many of a category; chosen
MODELS = 4_000_037  # added to their seeds: no library has them, nor has the network of shapes
UPON = 40  # things that are tried upon others; chosen


@dataclass(frozen=True)
class Own(packs.PackModel):
    """A model of ours, or of what is none of our categories; its name is its number."""

    def read(self) -> list[packs.PaintedMesh]:
        """Its parts, in their colors as screens show them."""
        rng = np.random.default_rng(np.random.SeedSequence((MODELS, *self.kind.encode(), int(self.name))))
        return [_convert(part) for part in parts_of(self._build(rng))]

    def _build(self, rng: np.random.Generator) -> Built:
        if self.kind in JUNK:
            colors = rng.uniform(0.02, 0.8, (3, 3))
            parts = JUNK[self.kind](rng)
            finishes = [part.finish._replace(color=tuple(colors[rng.integers(3)].tolist())) for part in parts]
            return Built([replace(part, finish=finish) for part, finish in zip(parts, finishes, strict=True)])
        sampled = CATEGORIES[self.kind].sample(rng, int(self.name))
        return fit_model(sampled.recipe.build(sampled.size), sampled.size)

    @property
    def id(self) -> str:
        """A name that files can carry."""
        return f"{self.pack}_{self.kind}_{self.name}"


def _convert(part: Part) -> packs.PaintedMesh:
    mesh = part.mesh
    normals = np.array(mesh.vertex_normals) if part.smooth else None
    red, green, blue = (float(np.clip(value, 0, 1) ** (1 / 2.2)) for value in part.color)
    color, corners = (red, green, blue), np.array(mesh.vertices)
    if normals is None:  # flat: every face has corners of its own
        corners, faces = corners[mesh.faces.reshape(-1)], np.arange(3 * len(mesh.faces)).reshape(-1, 3)
        return packs.PaintedMesh(corners, faces, None, None, color, None, 1.0)
    return packs.PaintedMesh(corners, np.array(mesh.faces), normals, None, color, None, 1.0)


@cache
def own_models() -> list[packs.PackModel]:
    """So many of every category, and of every kind of thing that is none."""
    return [
        Own(OURS, str(number), kind, (), "", "none", "", 1.0, packs.HERE)
        for kind in (*CATEGORIES, *JUNK)
        for number in range(COUNT)
    ]


@cache
def kinds_by_place() -> dict[str, list[str]]:
    """Kinds of things that stand on the floor, hang on a wall, or stand on others."""
    found: dict[str, list[str]] = {"floor": [], "wall": [], "top": []}
    for name, kind in packs.kinds().items():
        places = known_categories()[kind.sensible[0]].places if kind.sensible else ("top",)
        for place in ("wall",) if name in ON_WALLS else ("floor",) if name in JUNK else places:
            found[place].append(name)
    return found


def plan_crowd(rng: np.random.Generator) -> dict[str, Any]:
    """A room of rooms.yaml's form with things of every kind alike."""
    width, deep = rng.uniform(3.4, 6.0, 2)
    places = kinds_by_place()
    spots: list[dict[str, Any]] = []
    for wall, length in (("north", width), ("west", deep), ("east", deep)):
        at = rng.uniform(0.3, 0.8)
        while at < length - 0.3:
            spots.append({"kinds": places["floor"], "name": f"stands_{len(spots)}", "wall": wall, "at": float(at)})
            at += rng.uniform(0.8, 1.5)
        for at in rng.uniform(0.3, length - 0.3, 2):
            bottom = float(rng.uniform(0.7, 1.7))
            spots.append({"kinds": places["wall"], "hang": wall, "at": float(at), "bottom": bottom})
    for _ in range(int(rng.integers(2, 6))):
        spot = rng.uniform([0.8, 1.2], [width - 0.8, deep - 0.8]).tolist()
        turn = float(rng.uniform(-180, 180))
        spots.append({"kinds": places["floor"], "name": f"stands_{len(spots)}", "xy": spot, "turn": turn})
    carriers = [spot["name"] for spot in spots if "name" in spot]
    upon = [{"kinds": places["top"], "upon": str(one), "tall": 0.7} for one in rng.choice(carriers, UPON)]
    eye = [float(rng.uniform(0.3, 0.7) * width), 0.4]
    look = [float(rng.uniform(0.25, 0.75) * width), float(rng.uniform(0.5, 0.8) * deep), float(rng.uniform(0.3, 0.8))]
    camera = {"eye": eye, "look": look, "height": [1.0, 1.8]}
    return {"size": [float(width), float(deep)], "camera": camera, "things": spots + upon}
