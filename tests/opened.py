"""Whether anything opened the files of a folder, by whatever library: the kernel tells."""

import ctypes
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

OPENED = 0x20
FOLDER = 0x40000000


@contextmanager
def unopened(folder: Path) -> Iterator[None]:
    """The block, with its children, opens no file of the folder."""
    try:
        system = ctypes.CDLL(None, use_errno=True)
        events = system.inotify_init1(os.O_NONBLOCK)
    except AttributeError:
        pytest.skip("needs inotify")
    try:
        assert system.inotify_add_watch(events, os.fsencode(folder), OPENED) >= 0
        yield
        assert not (names := opened(events)), f"{names} opened"
    finally:
        os.close(events)


def opened(events: int) -> list[str]:
    """Names of the files that were opened so far."""
    try:
        told = os.read(events, 2**16)
    except BlockingIOError:
        return []
    names = []
    while told:
        kind, length = int.from_bytes(told[4:8], "little"), int.from_bytes(told[12:16], "little")
        if not kind & FOLDER:
            names.append(os.fsdecode(told[16 : 16 + length].rstrip(b"\0")))
        told = told[16 + length :]
    return names
