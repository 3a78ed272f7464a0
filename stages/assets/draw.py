"""Verb `draw`: contact sheets of the snapshots."""

from pathlib import Path

import h5py

from stages.assets.contact_sheet import contact_sheet
from stages.contracts.errors import InputError
from stages.contracts.files import atomic, read_json
from stages.contracts.library import SnapshotShard


def run(*, snapshots: tuple[Path, ...]) -> None:
    """Write a contact sheet (.png) beside each shard.

    Args:
        snapshots: shards (.h5), each with its .json beside it.
    """
    for shard in snapshots:
        sidecar = read_json(SnapshotShard, shard.with_suffix(".json"))
        try:
            with h5py.File(shard, "r") as file:
                sheet = contact_sheet(file["rgb"], sidecar.assets)
        except (OSError, KeyError) as error:
            raise InputError(shard, f"is no readable snapshot file ({error.__class__.__name__}).") from None
        with atomic(shard.with_suffix(".png")) as path:
            sheet.save(path)
