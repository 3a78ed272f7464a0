"""Command `cousins`: cousins.png, each object beside its cousins."""

from importlib import import_module
from pathlib import Path

from plugins.pictures.rows_of_cousins import write_picture
from stages.contracts import Cousins, read_json
from stages.matching.scene import Scene


def run(
    *,
    cousins: Path,
    objects: Path,
    image: Path,
    snapshots: list[Path],
    out: Path,
    library: Path | None = None,
    in_place: tuple[str, ...] = (),
) -> None:
    """Draw what `match` wrote, ours or another's.

    Args:
        cousins: cousins.json.
        objects: objects.json of extraction, with masks.png and depth.npz beside it.
        image: the scene's picture.
        snapshots: shards of snapshots (.h5).
        out: the picture to write.
        library: library.json, its archives beside it, for `in_place`.
        in_place: the module of a package that shows cousins in the object's place, too.
    """
    scene = Scene(objects, image)
    show = import_module(in_place[0]).InPlace(scene, library).show if in_place and library else None
    write_picture(out, read_json(Cousins, cousins), scene, snapshots, show)
