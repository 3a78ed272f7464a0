"""Films of rollouts: one success and one failure per test asset; film.png: a strip of each."""

from collections.abc import Sequence
from functools import cached_property
from pathlib import Path

import cv2
import numpy as np

from roomkin.plugins.films.kinds import Film
from roomkin.plugins.films.writing import FRAMES, make_film_strip, write_films, write_png
from roomkin.stages.evaluation.vector_env import RolloutEpisode
from roomkin.stages.simulation.film_renderer import FilmRenderer, Image

CAPTION = 40  # pixels of the line above a strip: read where the strip is shown at half its size


class RolloutFilms:
    """Films of a policy's rollouts, taken while their environments are there."""

    def __init__(self) -> None:
        self.films: list[tuple[Film, list[Image]]] = []

    @cached_property
    def renderer(self) -> FilmRenderer:
        """The renderer of all films."""
        return FilmRenderer()

    def take(self, episodes: Sequence[RolloutEpisode], role: str) -> None:
        """Film the picked episodes; the more frequent outcome comes first."""
        mostly = 2 * sum(episode.success for episode in episodes) >= len(episodes)
        for episode in sorted(pick_episodes(episodes), key=lambda episode: episode.success != mostly):
            assert episode.recording
            outcome = "success" if episode.success else "failure"
            film = Film(
                role=role, asset=episode.asset.asset, seed=episode.seed, success=episode.success, steps=episode.steps,
                opened=round(episode.opened, 4), file=f"{role}_{outcome}.webp",
            )  # fmt: skip
            self.films.append((film, self.renderer.film(episode.recording, 2 * FRAMES)))

    def write(self, folder: Path, frequency: float) -> None:
        """Write films.zip and film.png into `folder`; `frequency`: control steps per second."""
        write_films(folder / "films.zip", self.films, frequency)
        write_png(folder / "film.png", np.concatenate([add_caption(*item) for item in self.films]))


def pick_episodes(episodes: Sequence[RolloutEpisode]) -> list[RolloutEpisode]:
    """The first recorded success and the first recorded failure, as far as there are any."""
    first = {episode.success: episode for episode in reversed(episodes) if episode.recording}
    return [first[outcome] for outcome in (True, False) if outcome in first]


def add_caption(film: Film, pictures: Sequence[Image]) -> Image:
    """(H, W, 3): pictures of the episode in a row, below a line of text."""
    row = make_film_strip(pictures)
    line = np.full((CAPTION, row.shape[1], 3), 255, np.uint8)
    outcome = "success" if film.success else "failure"
    text = f"{film.role} ({film.asset}): {outcome} after {film.steps} steps, opened {max(0.0, film.opened):.0%}"
    cv2.putText(line, text, (8, 28), cv2.FONT_HERSHEY_SIMPLEX, 0.8, (0, 0, 0), 1, cv2.LINE_AA)
    return np.concatenate([line, row])
