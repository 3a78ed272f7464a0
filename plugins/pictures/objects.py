"""Verb `objects`: overview.png, the picture with what extraction found in it."""

from pathlib import Path

from plugins.pictures.overview import draw_overview
from stages.contracts import Objects, read_json, write_atomically
from stages.contracts.extracted import read_object_masks
from stages.contracts.images import check_size, read_rgb


def run(*, objects: Path, image: Path, out: Path) -> None:
    """Draw what `extract` wrote, ours or another's.

    Args:
        objects: objects.json, with masks.png beside it.
        image: the scene's picture.
        out: the picture to write.
    """
    found, picture = read_json(Objects, objects), read_rgb(image)
    check_size(image, picture, found.width, found.height, objects.name)
    with write_atomically(out) as path:
        draw_overview(picture, read_object_masks(objects, found), found).save(path)
