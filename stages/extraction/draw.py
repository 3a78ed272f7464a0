"""Verb `draw`: overview.png, the picture with what extraction found in it."""

from pathlib import Path

from stages.contracts import Objects, atomic, read_json
from stages.extraction.observation import read_masks, read_rgb
from stages.extraction.overview import draw_overview


def run(*, objects: Path, image: Path, out: Path) -> None:
    """Draw what `extract` wrote, ours or another's.

    Args:
        objects: objects.json, with masks.png beside it.
        image: the scene's picture.
        out: the picture to write.
    """
    found, masks = read_json(Objects, objects), read_masks(objects.parent / "masks.png")
    with atomic(out) as path:
        draw_overview(read_rgb(image), masks, found).save(path)
