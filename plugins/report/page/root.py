"""Things that were found in a picture and left out of its scene, for the top of its page."""

import shlex
from functools import partial
from pathlib import Path
from typing import NamedTuple

from roomkin.stages.contracts.hand import CORRECTIONS, digest_of_picture, find_hand_file, read_corrections
from roomkin.stages.contracts.images import read_masks
from roomkin.stages.contracts.matched import Matched, match_corrections
from roomkin.stages.contracts.things import Thing, Things
from roomkin.stages.geometry.masks import outline_mask


class UnplacedThing(NamedTuple):
    """A thing that was found and is not placed.

    outlines: of its pixels, as points of SVG. at: where its name stands, the highest pixel.
    """

    thing: Thing
    outlines: list[str]
    at: tuple[int, int]


def draw_again(image: Path) -> str:
    """The command that opens the drawing in the folder of a picture."""
    return shlex.join(["roomkin", "annotator", "annotate", str(image), "--out", str(image.parent)])


def read_said(folder: Path) -> Matched:
    """What a person said of the things of an input folder."""
    path = find_hand_file(folder, CORRECTIONS, partial(digest_of_picture, folder))
    if not path.is_file():
        return Matched({}, [], [])
    return match_corrections(read_corrections([path]), read_masks(folder / "masks.png"), digest_of_picture(folder))


def list_left_out(things: Things | None, folder: Path, said: Matched) -> list[UnplacedThing]:
    """Things that were left out and nobody has taken; `folder`: of the input, with masks.png."""
    taken = {mask for item in said.corrections.values() for mask in (item.mask, *item.joins)}
    found: list[UnplacedThing] = []
    if things is None:
        return found
    masks = read_masks(folder / "masks.png")
    for thing in things.left_out:
        if thing.mask not in taken and (masks == thing.mask).any():
            curves = outline_mask(masks == thing.mask)
            x, y = min((point for curve in curves for point in curve), key=lambda point: point[1])
            found.append(UnplacedThing(thing, [" ".join(f"{u},{v}" for u, v in curve) for curve in curves], (x, y)))
    return found
