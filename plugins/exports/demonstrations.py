"""Command `demonstrations`: episode stores in the formats of other people's tools."""

from importlib import import_module
from pathlib import Path
from typing import Literal

from roomkin.stages.contracts.episode_store import read_episodes


def run(
    *,
    episodes: tuple[Path, ...],
    out: Path,
    format: Literal["robomimic", "lerobot", "maniskill"],
    library: Path | None = None,
) -> None:
    """Write what the format wants into a folder.

    Args:
        episodes: episode stores (episodes.h5), in the order in which their episodes are written.
        out: folder to write.
        format: robomimic: one HDF5 file; lerobot: a LeRobotDataset v3.0; maniskill: trajectories, a file per asset.
        library: library.json that the assets come from; maniskill alone needs it.
    """
    import_module(f"roomkin.plugins.exports.episode_formats.{format}").write(episodes, out, library)
    if format != "maniskill":  # which says itself how many succeed again
        kept = sum(len(read_episodes(path).assets) for path in episodes)
        print(f"exported: {kept} episodes of {len(episodes)} stores to {out}")
