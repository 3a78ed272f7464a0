"""Film strips of rollouts: one success and one failure per test asset."""

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from stages.evaluation.episodes import RolloutEpisode

Image = NDArray[np.uint8]

FRAMES, SIZE = 8, 160
GOOD, BAD = (30, 140, 60), (190, 40, 40)


def pick(episodes: Sequence[RolloutEpisode]) -> list[RolloutEpisode]:
    """The first filmed success and the first filmed failure, as far as there are any."""
    filmed = [episode for episode in episodes if episode.pictures]
    return [
        next(episode for episode in filmed if episode.success == outcome)
        for outcome in (True, False)
        if any(episode.success == outcome for episode in filmed)
    ]


def strip(episode: RolloutEpisode, title: str) -> Image:
    """(SIZE + 24, FRAMES * SIZE, 3): pictures evenly over the episode below a line of text, green for success."""
    index = np.linspace(0, len(episode.pictures) - 1, FRAMES).round().astype(int)
    row = np.concatenate([cv2.resize(episode.pictures[i], (SIZE, SIZE)) for i in index], axis=1)
    line = np.full((24, row.shape[1], 3), 255, np.uint8)
    outcome = "success" if episode.success else "failure"
    text = f"{title}: {outcome} after {episode.steps} steps, opened {max(0.0, episode.opened):.0%}"
    cv2.putText(line, text, (6, 17), cv2.FONT_HERSHEY_SIMPLEX, 0.5, GOOD if episode.success else BAD, 1, cv2.LINE_AA)
    return np.concatenate([line, row])


def film(episodes: Sequence[RolloutEpisode], title: str) -> Image:
    """Strips below each other."""
    return np.concatenate([strip(episode, title) for episode in pick(episodes)])
