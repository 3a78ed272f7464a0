"""Verb `picture`: one picture, what was found in it and what became of it, on one self-contained page."""

from pathlib import Path

from markupsafe import Markup

from stages.config.tables import TablesConfig
from stages.contracts import InputError
from stages.contracts.files import read_options, read_text, write_text
from stages.tables.markup import environment, number
from stages.tables.page import rooms, single
from stages.tables.page.files import RunFiles
from stages.tables.page.pictures import Album
from stages.tables.report import MAX_BYTES, SCRIPTS


def _page(files: RunFiles, camera: Path, options: TablesConfig, width: int) -> str:
    album = Album(width, options.picture_quality)
    made = rooms.collect(files, album)
    if len(made) != 1:
        raise InputError("--files", f"are of {len(made)} pictures.", "name the files of one")
    (room,) = made
    first = room.reconstructions[0] if room.reconstructions else None
    return (
        environment()
        .get_template("page/scene.html.jinja")
        .render(
            room=room,
            found=single.found(files, room.name, camera, album),
            doubts=[single.doubts(room, one) for one in room.reconstructions] or [single.doubts(room, None)],
            downloads=single.downloads(files, room.name),
            origins=single.origins(files, room.name),
            first=first,
            script=Markup("\n".join(read_text(Path(__file__).with_name("page") / name) for name in SCRIPTS)),
            number=number,
        )
    )


def run(*, files: tuple[Path, ...], image: Path, camera: Path, scene: str, out: Path, options: str = "") -> None:
    """Write the page: input, what was found, cousins and story of every object, scenes, doubts, files to save.

    Args:
        files: everything that the page may show, in the fixed layout of results/, of this scene and the snapshots.
        image: the picture that went in.
        camera: camera.json beside it.
        scene: its name.
        out: the HTML file.
        options: JSON of the config section `tables`.
    """
    settings = read_options(TablesConfig, options)
    declared = RunFiles(files, {scene: image})
    for width in (settings.picture_width, settings.picture_width * 2 // 3, settings.picture_width // 2):
        page = _page(declared, camera, settings, width)
        if len(page.encode()) <= MAX_BYTES:
            break
    write_text(out, page)
