"""Things that were found in a picture and left out of its scene, for the top of its page."""

from pathlib import Path
from typing import NamedTuple

from stages.contracts.corrections import CORRECTIONS, corrections_of
from stages.contracts.images import read_masks
from stages.contracts.things import Thing, Things
from stages.geometry.masks import outline_mask


class LeftOut(NamedTuple):
    """A thing that was found and is not placed.

    outlines: of its pixels, as points of SVG. at: where its name stands, the highest pixel.
    """

    thing: Thing
    outlines: list[str]
    at: tuple[int, int]


def list_left_out(things: Things | None, folder: Path) -> list[LeftOut]:
    """Things that were left out and nobody has taken; `folder`: of the input, with masks.png and corrections.json."""
    if things is None:
        return []
    path = folder / CORRECTIONS
    said = corrections_of((path,) if path.is_file() else (), "extraction").values()
    taken = {mask for item in said for mask in (item.mask, *item.joins)}
    masks, found = read_masks(folder / "masks.png"), []
    for thing in things.left_out:
        if thing.mask not in taken and (masks == thing.mask).any():
            curves = outline_mask(masks == thing.mask)
            x, y = min((point for curve in curves for point in curve), key=lambda point: point[1])
            found.append(LeftOut(thing, [" ".join(f"{u},{v}" for u, v in curve) for curve in curves], (x, y)))
    return found
