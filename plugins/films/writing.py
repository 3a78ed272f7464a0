"""Films of episodes: films.zip, films.json, animated WebP, and strips of pictures."""

from collections.abc import Iterable, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import cv2
import numpy as np
import torch
from numpy.typing import NDArray
from PIL import Image as Pillow

from roomkin.plugins.films.kinds import Film, Films
from roomkin.stages.contracts.archives import pack
from roomkin.stages.contracts.errors import InputError
from roomkin.stages.contracts.files import write_atomically, write_json
from roomkin.stages.contracts.images import TILE
from roomkin.stages.demonstrations.attempt import FilmedAttempt
from roomkin.stages.simulation.film_renderer import FilmRenderer, Image, pick_evenly

FRAMES = 8  # pictures on a strip; a film has twice as many
LAST = 1200  # milliseconds that the last picture stays


def write_films(out: Path, films: Sequence[tuple[Film, Sequence[Image]]], control_frequency: float) -> None:
    """Write the archive of films, each at the speed of its episode, with the list of them.

    Args:
        out: films.zip.
        films: what was filmed, with its pictures, evenly over its steps.
        control_frequency: steps per second.
    """
    with TemporaryDirectory(prefix="acdc-films-") as folder:
        for film, pictures in films:
            write_film(Path(folder, film.file), pictures, control_frequency * max(len(pictures) - 1, 1) / film.steps)
        write_json(Path(folder, "films.json"), Films(films=[film for film, _ in films]))
        pack(Path(folder), out)


def write_film(path: str | Path, pictures: Iterable[Any], frequency: float, quality: int = 60) -> None:
    """Write a film that stays at its last picture for a while; .webp and .gif run for ever.

    Args:
        path: its ending says the format: .webp, .gif or .mp4.
        pictures: of one size, (H, W, 3) uint8 RGB of numpy or torch; (N, H, W, 3): of N environments, side by side.
        frequency: of the pictures, in the episode: an environment's control frequency if there is one for each step.
        quality: of WebP, 0 to 100.

    Raises:
        InputError: there are no pictures, or the ending is another.
    """
    form = Path(path).suffix.lower()
    if form not in (".webp", ".gif", ".mp4"):
        fix = "end its name with .webp, .gif or .mp4"
        raise InputError(path, "is in no format that is written.", fix, code="E-FILM")
    arrays = [np.asarray(torch.as_tensor(picture).cpu()) for picture in pictures]
    if not arrays:
        raise InputError(path, "gets no pictures.", "append `env.render()` after every step", code="E-FILM")
    images = [Pillow.fromarray(np.concatenate([*each], axis=1) if each.ndim == 4 else each) for each in arrays]
    step = max(round(1000 / frequency), 20)  # milliseconds; what is faster browsers show slowly
    with write_atomically(Path(path)) as temporary:
        if form == ".mp4":
            _write_mp4(temporary, [*images, *images[-1:] * (LAST // step)], 1000 / step)
            return
        images[0].save(
            temporary, form[1:].upper(), save_all=True, append_images=images[1:], quality=quality, method=4, loop=0,
            duration=[step] * (len(images) - 1) + [LAST],
        )  # fmt: skip


def _write_mp4(path: Path, images: Sequence[Pillow.Image], frequency: float) -> None:
    """H.264, with sides made even, as players ask for."""
    import imageio.v2 as imageio  # ManiSkill's own; it looks for ffmpeg when it is imported

    even: list[Any] = [np.asarray(image)[: image.height // 2 * 2, : image.width // 2 * 2] for image in images]
    imageio.mimwrite(path, even, format="FFMPEG", fps=frequency, codec="libx264", macro_block_size=2)


def make_film_strip(pictures: Sequence[Image]) -> Image:
    """An episode in a row: (H, FRAMES * TILE, 3)."""
    height = TILE * pictures[0].shape[0] // pictures[0].shape[1]
    shown = pick_evenly(pictures, FRAMES)
    row = [cv2.resize(picture, (TILE, height), interpolation=cv2.INTER_AREA) for picture in shown]
    return np.concatenate(row, axis=1).astype(np.uint8, copy=False)


def write_png(path: Path, picture: Image) -> None:
    """Write an RGB picture atomically."""
    with write_atomically(path) as temporary:
        cv2.imwrite(str(temporary), picture[..., ::-1])


def plot_cloud(cloud: NDArray[np.floating]) -> Image:
    """A cloud (P, 4) in the base frame as (TILE / 2, TILE, 3): from the front (y, z) and from the side (x, z)."""
    half = TILE // 2
    image = np.full((half, TILE, 3), 255, np.uint8)
    scale = half / 1.2  # pixels per metre
    for left, across in ((0, half / 2 - cloud[:, 1] * scale), (half, cloud[:, 0] * scale)):
        u = np.round(across).astype(int)
        v = np.round(half * 0.75 - (cloud[:, 2] - 0.2) * scale).astype(int)
        seen = (u >= 0) & (u < half) & (v >= 0) & (v < half)
        image[v[seen], left + u[seen]] = np.where(cloud[seen, 3:] > 0.5, (255, 0, 0), 0)  # fingers red
    return image


def make_strip(pictures: Sequence[Image], clouds: Sequence[NDArray[np.floating]]) -> Image:
    """One episode: pictures in a row, the clouds below them."""
    below = [plot_cloud(cloud) for cloud in pick_evenly(clouds, FRAMES)]
    return np.concatenate([make_film_strip(pictures), np.concatenate(below, axis=1)])


def film_demonstrations(folder: Path, taken: Sequence[FilmedAttempt], role: str, frequency: float) -> None:
    """Write films.zip and film.png into `folder`; what was recorded must still be open."""
    renderer = FilmRenderer()
    films, strips = [], []
    for number, item in enumerate(taken):
        pictures = renderer.film(item.recording, FRAMES * 2)
        steps = len(item.recording.moments) - 1
        film = Film(
            role=role, asset=item.asset, seed=item.seed, success=True, steps=steps,
            opened=round(item.opened, 4), file=f"{number}.webp",
        )  # fmt: skip
        films.append((film, pictures))
        strips.append(make_strip(pictures, item.clouds))
    write_films(folder / "films.zip", films, frequency)
    write_png(folder / "film.png", np.concatenate(strips))
