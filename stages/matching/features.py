"""Command `features`: encode the patches of one shard of snapshots, once per library and encoder."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from roomkin.stages.cli import progress
from roomkin.stages.config.matching import EncoderOptions
from roomkin.stages.contracts import read_options
from roomkin.stages.contracts.features import FeatureIndex
from roomkin.stages.matching import encoders
from roomkin.stages.matching.snapshots import SnapshotFile
from roomkin.stages.matching.store import learn, write_store

SAMPLE_ASSETS, SAMPLE_VIEWS = 60, 4  # that a codec is learned on; chosen


def run(*, snapshots: Path, out: Path, options: str = "{}") -> None:
    """Write the feature store of one shard.

    Args:
        snapshots: shard_I.h5 of the assets stage, with shard_I.json beside it.
        out: .npy file to write; its index (.json) and what goes with it (.npz) come beside it.
        options: JSON of the encoder's keys of the config section `matching`.
    """
    settings = read_options(EncoderOptions, options)
    encoder = encoders.make_encoder(settings)
    rows: list[NDArray[np.float16] | NDArray[np.int8]] = []
    wholes, starts = [], [0]
    with SnapshotFile(snapshots) as shard:
        codec = None
        if settings.dimensions and shard.sidecar.assets:
            codec = learn(sample_rows(shard, encoder), settings.dimensions, encoders.EXTRA_COLUMNS)
        for asset in progress(shard.sidecar.assets, "assets encoded", len(shard.sidecar.assets)):
            for patches in encoders.encode_rows(encoder, shard.views(asset)):
                rows.append(codec.encode(patches) if codec else patches)
                wholes.append(encoders.pool_patches(patches))
                starts.append(starts[-1] + len(patches))
        index = FeatureIndex(
            encoder=settings.encoder, settings=encoders.settings_digest(settings, encoder), starts=starts,
            upright=shard.sidecar.elevation is not None, assets=shard.sidecar.assets, yaws=shard.sidecar.yaws,
        )  # fmt: skip
    write_store(out, index, rows, wholes, codec)


def sample_rows(shard: SnapshotFile, encoder: encoders.PatchEncoder) -> NDArray[np.float16]:
    """Rows (N, D + 5) of some views of some assets, evenly spaced."""
    assets = shard.sidecar.assets[:: -(-len(shard.sidecar.assets) // SAMPLE_ASSETS)]
    found = []
    for number, asset in enumerate(assets):
        views = shard.views(asset)
        step = -(-len(views) // SAMPLE_VIEWS)
        found += encoders.encode_rows(encoder, views[number % step :: step])
    return np.concatenate(found)
