"""Films of rollouts: one success and one failure per test asset; film.png: a strip of each."""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from stages.contracts.films import Film
from stages.evaluation.episodes import RolloutEpisode
from stages.simulation.films import make_film_strip
from stages.simulation.studio import Image, Studio

CAPTION = 40  # pixels of the line above a strip: read where the strip is shown at half its size


@dataclass(frozen=True)
class Filmed:
    """An episode and its pictures."""

    film: Film
    pictures: list[Image]


def pick_episodes(episodes: Sequence[RolloutEpisode]) -> list[RolloutEpisode]:
    """The first recorded success and the first recorded failure, as far as there are any."""
    recorded = [episode for episode in episodes if episode.recording]
    return [
        next(episode for episode in recorded if episode.success == outcome)
        for outcome in (True, False)
        if any(episode.success == outcome for episode in recorded)
    ]


def take(studio: Studio, episodes: Sequence[RolloutEpisode], role: str, frames: int) -> list[Filmed]:
    """Film the picked episodes; the more frequent outcome comes first."""
    filmed = []
    mostly = 2 * sum(episode.success for episode in episodes) >= len(episodes)
    for episode in sorted(pick_episodes(episodes), key=lambda episode: episode.success != mostly):
        assert episode.recording
        outcome = "success" if episode.success else "failure"
        film = Film(
            role=role, asset=episode.asset.asset, seed=episode.seed, success=episode.success, steps=episode.steps,
            opened=round(episode.opened, 4), file=f"{role}_{outcome}.webp",
        )  # fmt: skip
        filmed.append(Filmed(film, studio.film(episode.recording, frames)))
    return filmed


def add_caption(filmed: Filmed) -> Image:
    """(H, W, 3): pictures of the episode in a row, below a line of text."""
    film, row = filmed.film, make_film_strip(filmed.pictures)
    line = np.full((CAPTION, row.shape[1], 3), 255, np.uint8)
    outcome = "success" if film.success else "failure"
    text = f"{film.role} ({film.asset}): {outcome} after {film.steps} steps, opened {max(0.0, film.opened):.0%}"
    cv2.putText(line, text, (8, 28), cv2.FONT_HERSHEY_SIMPLEX, 0.8, (0, 0, 0), 1, cv2.LINE_AA)
    return np.concatenate([line, row])
