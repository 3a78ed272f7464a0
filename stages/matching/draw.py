"""Verb `draw`: cousins.png, each object beside its cousins."""

from pathlib import Path

from stages.contracts import Cousins, read_json
from stages.matching.picture import write_picture
from stages.matching.scene import Scene


def run(
    *, cousins: Path, objects: Path, image: Path, snapshots: list[Path], out: Path, library: Path | None = None
) -> None:
    """Draw what `match` wrote, ours or another's.

    Args:
        cousins: cousins.json.
        objects: objects.json of extraction, with masks.png and depth.npz beside it.
        image: the scene's picture.
        snapshots: shards of snapshots (.h5).
        out: the picture to write.
        library: library.json, its archives beside it: cousins are shown in the object's place, too.
    """
    write_picture(out, read_json(Cousins, cousins), Scene(objects, image), snapshots, library)
