"""Verb `features`: encode the patches of one shard of snapshots, once per library and encoder."""

from pathlib import Path

from stages.cli import progress
from stages.config.matching import EncoderOptions
from stages.contracts import read_options
from stages.contracts.features import FeatureIndex
from stages.matching.encoders import encode_rows, make_encoder, settings_digest
from stages.matching.snapshots import SnapshotFile
from stages.matching.store import write_store


def run(*, snapshots: Path, out: Path, options: str = "{}", batch: int = 0) -> None:
    """Write the feature store of one shard.

    Args:
        snapshots: shard_I.h5 of the assets stage, with shard_I.json beside it.
        out: .npy file to write; its .json index comes beside it.
        options: JSON of the encoder's keys of the config section `matching`.
        batch: pictures per forward pass of dinov2; 0: as the options say.
    """
    settings = read_options(EncoderOptions, options)
    if batch:
        settings = settings.model_copy(update={"dinov2": settings.dinov2.model_copy(update={"batch": batch})})
    encoder = make_encoder(settings)
    rows, starts = [], [0]
    with SnapshotFile(snapshots) as shard:
        for asset in progress(shard.sidecar.assets, "assets encoded", len(shard.sidecar.assets)):
            for patches in encode_rows(encoder, shard.views(asset)):
                rows.append(patches)
                starts.append(starts[-1] + len(patches))
        index = FeatureIndex(
            encoder=settings.encoder,
            settings=settings_digest(settings, encoder),
            upright=shard.sidecar.elevation is not None,
            assets=shard.sidecar.assets,
            yaws=shard.sidecar.yaws,
            starts=starts,
        )
    write_store(out, index, rows)
