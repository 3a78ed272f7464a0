"""films.zip, films.json and animated WebP files, for every stage that films episodes."""

from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

import cv2
import numpy as np
from PIL import Image as Pillow

from stages.contracts.archives import pack
from stages.contracts.files import atomic, write_json
from stages.contracts.films import Film, Films
from stages.simulation.studio import Image, evenly

FRAMES, SIZE = 8, 192  # pictures on a strip, and their width in pixels


def write_films(out: Path, films: Sequence[tuple[Film, Sequence[Image]]], control_frequency: float) -> None:
    """Write the archive of films, each at the speed of its episode, with the list of them.

    Args:
        out: films.zip.
        films: what was filmed, with its pictures, evenly over its steps.
        control_frequency: steps per second.
    """
    with TemporaryDirectory(prefix="acdc-films-") as folder:
        for film, pictures in films:
            images = [Pillow.fromarray(picture) for picture in pictures]
            step = round(1000 * film.steps / control_frequency / max(len(images) - 1, 1))
            images[0].save(
                Path(folder, film.file), "WEBP", save_all=True, append_images=images[1:], quality=75, method=4,
                loop=0, duration=[max(step, 20)] * (len(images) - 1) + [1200],  # milliseconds
            )  # fmt: skip
        write_json(Path(folder, "films.json"), Films(films=[film for film, _ in films]))
        pack(Path(folder), out)


def strip(pictures: Sequence[Image]) -> Image:
    """An episode in a row: (H, FRAMES * SIZE, 3)."""
    height = SIZE * pictures[0].shape[0] // pictures[0].shape[1]
    row = [cv2.resize(picture, (SIZE, height), interpolation=cv2.INTER_AREA) for picture in evenly(pictures, FRAMES)]
    return np.concatenate(row, axis=1).astype(np.uint8, copy=False)


def write_png(path: Path, picture: Image) -> None:
    """Write an RGB picture atomically."""
    with atomic(path) as temporary:
        cv2.imwrite(str(temporary), picture[..., ::-1])
