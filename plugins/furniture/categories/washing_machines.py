"""Washing machines: a round door on the front, held by an arch at its free side."""

from typing import Literal

import numpy as np
from trimesh import Trimesh

from roomkin.plugins.furniture.category import Category, sized
from roomkin.plugins.furniture.colors import METALS
from roomkin.plugins.furniture.finishes import DARK, finish_of, shade
from roomkin.plugins.furniture.fronts import STYLES, handle_parts
from roomkin.plugins.furniture.model import GLASS, METAL, PLASTIC, Model, Moving, Part, Parts, Size
from roomkin.plugins.furniture.recipe import Coating, Generator, between, in_turn, of, one_of, whole
from roomkin.plugins.furniture.shapes import box, cushion, lathe, rod, rotate, translate

MACHINE = 200.0  # kg / m^3: 65 kg in 60 x 60 x 85 cm
WHITE = "paint 0.84 0.84 0.83 0"
GAP = 0.003  # metres between the closed door and the body


class WashingMachine(Generator):
    """A front loader."""

    hinge: Literal[-1, 1] = one_of(-1, 1)  # side (low or high y) on which its door hangs
    porthole: float = between(0.27, 0.31)  # radius of the door, as a share of the width
    at: float = between(0.46, 0.54)  # height of its middle, as a share
    ring: float = between(0.68, 0.8)  # radius of its glass, as a share
    thickness: float = between(0.03, 0.04)  # of the door
    strip: float = between(0.11, 0.15)  # height of the controls, as a share
    buttons: int = whole(2, 6, ge=1, le=50)
    colour: Coating = one_of(WHITE, WHITE, "steel 0.52 0.53 0.55 0", "enamel 0.1 0.1 0.11 0")
    ring_colour: Coating = of(METALS[:3])
    handle_colour: Coating = in_turn(str(METALS[2]), str(METALS[0]))

    @property
    def fronts(self) -> tuple[int, int]:
        return 1, 0

    def build(self, size: Size) -> Model:
        x, y, z = size[0] / 2, size[1] / 2, size[2]
        out = min(STYLES["arch"].protrusion, 0.2 * x)
        thick = min(self.thickness, 0.2 * x)
        face = x - out - thick - GAP  # the body's front
        radius = min(self.porthole * size[1], 0.3 * z)
        middle = self.at * z
        parts = Parts()
        parts.add(cushion((-x, -y, 0.02), (face, y, z), 0.008), self.colour, MACHINE)
        for a in (-0.8 * x, 0.6 * face):
            for b in (-0.8 * y, 0.8 * y):
                parts.add(rod((a, b, 0), (a, b, 0.025), 0.022), DARK, PLASTIC)
        opening = rod((face - 0.01, 0, middle), (face + 0.001, 0, middle), 0.8 * self.ring * radius, segments=32)
        parts.add(opening, DARK, METAL, solid=False)
        parts += self._controls(face, y, z)
        return Model(parts, [self._door(face + GAP, thick, out, radius, middle)])

    def _controls(self, face: float, y: float, z: float) -> Parts:
        low, high = z * (1 - self.strip), 0.985 * z
        level, short = (low + high) / 2, high - low
        parts = Parts()
        parts.add(box((face, face + 0.002), (-y, y), (low - 0.006, low - 0.003)), DARK, PLASTIC, solid=False)
        drawer = box((face, face + 0.006), (-0.95 * y, -0.4 * y), (low, high))
        parts.add(drawer, shade(self.colour, 0.9), PLASTIC, solid=False)
        knob = rod((face, 0, level), (face + 0.02, 0, level), 0.36 * short)
        parts.add(knob, self.ring_colour, PLASTIC, smooth=True, solid=False)
        display = box((face, face + 0.003), (0.2 * y, 0.5 * y), (level - 0.25 * short, level + 0.25 * short))
        parts.add(display, DARK, PLASTIC, solid=False)
        for k in range(self.buttons):
            across = y * (0.58 + 0.36 * (k + 0.5) / self.buttons)
            button = rod((face, across, level), (face + 0.006, across, level), min(0.01, 0.12 * short))
            parts.add(button, self.ring_colour, PLASTIC, smooth=True, solid=False)
        return parts

    def _door(self, face: float, thick: float, out: float, radius: float, middle: float) -> Moving:
        """A ring with a bulging glass; it hangs at its front's edge, so that it turns away from the body."""
        inner = self.ring * radius
        profile = [(inner, 0.0), (radius, 0.0), (radius, 0.6 * thick), (0.95 * radius, thick), (inner, 0.8 * thick)]
        ring = lathe([*profile, profile[0]], 32)
        disc = lathe([(0, 0), *profile[1:4], (0, thick)])
        bulge = [(inner, 0.0), (inner, 0.5 * thick), (0.7 * inner, 0.8 * thick), (0.3 * inner, 0.95 * thick)]
        glass = lathe([(0, 0), *bulge, (0, thick)], 32)

        def upright(mesh: Trimesh) -> Trimesh:
            return translate(rotate(mesh, np.pi / 2, [0, 1, 0]), (face, 0, middle))

        parts = [
            Part(upright(ring), finish_of(self.ring_colour), PLASTIC, (upright(disc),), True),
            Part(upright(glass), finish_of("paint 0.06 0.07 0.09 0"), GLASS, (), True),
        ]
        at = (face + 0.97 * thick, -self.hinge * 0.86 * radius, middle)
        parts += handle_parts("arch", at, "z", min(0.13, 0.5 * radius), out, self.handle_colour)
        origin = (face + thick, self.hinge * radius, middle)
        return Moving("door_0", "door", parts, origin, (0.0, 0.0, float(self.hinge)), np.pi / 2, "arch")


DEEP = ((0.58, 0.59, 0.83), (0.66, 0.62, 0.87))
WASHING_MACHINE = Category(
    name="washing_machine",
    sample=sized(WashingMachine, DEEP, DEEP, ((0.42, 0.59, 0.83), (0.5, 0.62, 0.87))),
    templates=3,
    names="washer, clothes washer, laundry machine, front loader, tumble dryer",
    like="tumbledryer, spinner",
    kin="appliance",
    carries="top",
)
