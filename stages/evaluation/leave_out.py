"""Verb `leave_out`: the true models of a room, which matching is to do without (protocol `unknown`)."""

from pathlib import Path

from stages.contracts import LeftOut, Truth, read_json, write_json


def run(*, truth: Path, out: Path) -> None:
    """Name the true models: all that matching learns of the truth is that they are not in its library.

    Args:
        truth: truth.json of the room.
        out: JSON file of the ids.
    """
    write_json(out, LeftOut(assets=sorted({item.asset for item in read_json(Truth, truth).objects})))
