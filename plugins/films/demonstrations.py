"""Films of demonstrations; film.png: pictures of each episode in a row, above what the policy saw, from two sides."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from roomkin.plugins.films.contract import Film
from roomkin.plugins.films.writing import FRAMES, TILE, make_film_strip, write_films, write_png
from roomkin.stages.demonstrations.attempt import FilmedAttempt
from roomkin.stages.simulation.film_renderer import FilmRenderer, Image, pick_evenly


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
