"""Command `after`: what `make picture` ends with where somebody sits before it."""

import os
import shlex
import sys
from pathlib import Path

from roomkin.plugins.annotator.annotate import run as annotate
from roomkin.stages.config.model import load


def run(image: Path, /, *, depth: Path | None = None, camera: str | None = None) -> None:
    """Serve the page of a picture's scene: what was found and made, doubts first, and *Make it again*.

    Without a browser a line says how the page is served. Nothing happens without a terminal, and for the frames of a
    recording, which are many.

    Args:
        image: as `make picture RGB=` has it.
        depth: likewise `DEPTH=`.
        camera: likewise `INTRINSICS=`.
    """
    if image.is_dir() or not sys.stdout.isatty():
        return
    given = {"image": str(image), "depth": depth and str(depth), "camera": camera}
    config = load({key: value for key, value in given.items() if value})
    for scene, picture in config.experiment.inputs.items():
        if not has_browser():
            print(f"No browser here. To put it right in one elsewhere: roomkin correct {shlex.quote(scene)}")
            continue
        folder = Path(picture.place(scene))
        if picture.alone and not picture.measured:
            annotate(image, out=folder)
        else:
            annotate(folder, scene=scene)


def has_browser() -> bool:
    """Whether a browser with windows can be opened here."""
    return bool(os.environ.get("BROWSER") or os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))
