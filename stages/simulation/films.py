"""films.json and the animated WebP files beside it, for every stage that films episodes."""

from collections.abc import Sequence
from pathlib import Path

from PIL import Image as Pillow

from stages.contracts.files import atomic, write_json
from stages.contracts.films import Film, Films
from stages.simulation.studio import Image

HOLD = 1200  # milliseconds for which the last picture stays
QUALITY = 75


def write_films(folder: Path, films: Sequence[tuple[Film, Sequence[Image]]], control_frequency: float) -> None:
    """Write each film at the speed of its episode, and the list of them.

    Args:
        films: what was filmed, with its pictures, evenly over its steps.
        control_frequency: steps per second.
    """
    for film, pictures in films:
        images = [Pillow.fromarray(picture) for picture in pictures]
        step = round(1000 * film.steps / control_frequency / max(len(images) - 1, 1))
        with atomic(folder / film.file) as temporary:
            images[0].save(
                temporary, "WEBP", save_all=True, append_images=images[1:], quality=QUALITY, method=4, loop=0,
                duration=[max(step, 20)] * (len(images) - 1) + [HOLD],
            )  # fmt: skip
    write_json(folder / "films.json", Films(films=[film for film, _ in films]))
