"""Command `after`: what `make picture` ends with where somebody sits before it."""

import os
import shlex
import sys
from pathlib import Path

from roomkin.correct import run as correct


def run(image: Path, /) -> None:
    """Serve the page of a picture, as `roomkin correct` does.

    Without a browser a line says how the page is served. Nothing happens without a terminal, and for the frames of a
    recording, which are many.

    Args:
        image: as `make picture RGB=` has it.
    """
    if image.is_dir() or not sys.stdout.isatty():
        return
    if any(map(os.environ.get, ("BROWSER", "DISPLAY", "WAYLAND_DISPLAY"))):
        correct(image)
    else:
        print(f"No browser here. To put it right in one elsewhere: roomkin correct {shlex.quote(str(image))}")
