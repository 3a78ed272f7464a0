"""Verb `draw`: contact sheets of the snapshots."""

from pathlib import Path

from stages.assets.contact_sheet import contact_sheet
from stages.contracts.arrays import readable
from stages.contracts.files import atomic
from stages.contracts.snapshot_file import AGAIN, open_snapshots


def run(*, snapshots: tuple[Path, ...]) -> None:
    """Write a contact sheet (.png) beside each shard.

    Args:
        snapshots: shards (.h5), each with its .json beside it.
    """
    for shard in snapshots:
        sidecar, file = open_snapshots(shard)
        with file, readable(shard, "snapshot file", AGAIN):  # a chunk may be damaged
            sheet = contact_sheet(file["rgb"], sidecar.assets)
        with atomic(shard.with_suffix(".png")) as path:
            sheet.save(path)
