"""Boxes with a sprung push button on their front; in no default library (config/study/button.yaml)."""

from typing import Literal

from roomkin.plugins.furniture.category import Category, sized
from roomkin.plugins.furniture.colors import METALS, PAINTS
from roomkin.plugins.furniture.fields import between, chance, in_turn, of, one_of
from roomkin.plugins.furniture.finishes import shade
from roomkin.plugins.furniture.model import PLASTIC, Model, Moving, Parts, Size, part
from roomkin.plugins.furniture.recipe import Coating, Generator
from roomkin.plugins.furniture.shapes import box, rod

FILLING = 400.0  # kg / m^3: a case with switches and wires in it


class ButtonBox(Generator):
    """A case with one button, round, square or wider in front."""

    style: Literal["round", "square", "mushroom"] = in_turn("round", "square", "mushroom")
    half: float = between(0.022, 0.036)  # radius of the button, or half of its side
    travel: float = between(0.008, 0.018)
    left: float = between(0.008, 0.014)  # by which it still stands out when it is pushed all the way
    across: float = between(-0.8, 0.8)  # of the way from the middle to where it would touch an edge
    up: float = between(-0.2, 0.8)
    plate: bool = chance()  # a sheet around it
    colour: Coating = of(METALS, PAINTS)
    button_colour: Coating = one_of(
        "paint 0.52 0.03 0.03 0", "paint 0.04 0.3 0.08 0", "paint 0.75 0.5 0.03 0", "paint 0.03 0.12 0.45 0"
    )

    def build(self, size: Size) -> Model:
        x, y, z = size[0] / 2, size[1] / 2, size[2]
        face = x - self.travel - self.left
        half = min(self.half, 0.8 * y, 0.4 * z)
        at, level = self.across * (y - 1.2 * half), z / 2 + self.up * (z / 2 - 1.2 * half)
        case = Parts()
        case.add(box((-x, face), (-y, y), (0, z)), self.colour, FILLING)
        if self.plate:
            edges = (at - 1.15 * half, at + 1.15 * half), (level - 1.15 * half, level + 1.15 * half)
            case.add(box((face, face + 0.002), *edges), shade(self.colour, 0.5), PLASTIC, solid=False)
        stem = half if self.style == "round" else 0.6 * half
        button = [part(rod((face - 0.003, at, level), (x, at, level), stem), self.button_colour, PLASTIC, smooth=True)]
        if self.style == "square":
            front = box((face - 0.003, x), (at - half, at + half), (level - half, level + half))
            button = [part(front, self.button_colour, PLASTIC)]
        elif self.style == "mushroom":
            head = rod((x - 0.6 * self.left, at, level), (x, at, level), half)
            button.append(part(head, self.button_colour, PLASTIC, smooth=True))
        moving = Moving("button_0", "button", button, (face, at, level), (-1.0, 0.0, 0.0), self.travel, "face")
        return Model(case, [moving], placement="object")


# As large as a toaster, so that a picture of a room shows the button.
SIZES = ((0.14, 0.2, 0.18), (0.24, 0.34, 0.34))
BUTTON_BOX = Category(name="button_box", sample=sized(ButtonBox, SIZES), templates=24, count=0)
