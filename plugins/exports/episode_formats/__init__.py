"""Demonstrations in the formats of other people's tools: a module each, with `write(stores, out, library)`."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from stages.contracts.episode_store import EpisodeStore, read_episodes

Float = NDArray[np.float32]


@dataclass(frozen=True)
class Demonstration:
    """One episode of a store: (T, P, 4) clouds, (T, 9) proprioception, (T, 7) clean actions."""

    store: EpisodeStore
    asset: str
    clouds: NDArray[np.float16]
    proprio: Float
    actions: Float


def demonstrations(paths: Sequence[Path]) -> Iterator[Demonstration]:
    """All episodes of some stores, in order."""
    for path in paths:
        store = read_episodes(path)
        for asset, (clouds, proprio, actions) in zip(store.assets, store.episodes, strict=True):
            yield Demonstration(store, asset, clouds, proprio, actions)
