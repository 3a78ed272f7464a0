"""Verb `picture`: one picture, what was found in it and what became of it, on one page."""

from pathlib import Path

from plugins.report.album import Album
from plugins.report.page import rooms, single
from plugins.report.page.files import RunFiles
from plugins.report.page.root import read_root
from plugins.report.report import link_to, script
from stages.config.tables import TablesConfig
from stages.contracts import InputError
from stages.contracts.files import read_options, write_text
from stages.tables.markup import environment
from stages.tables.text import number


def run(
    *,
    files: tuple[Path, ...],
    image: Path,
    camera: Path,
    scene: str,
    out: Path,
    viewer: Path | None = None,
    options: str = "",
) -> None:
    """Write the page: input, what was found, cousins and story of every object, scenes, doubts, files to save.

    Args:
        files: everything that the page may show, in the fixed layout of results/, of this scene and the snapshots.
        image: the picture that went in.
        camera: camera.json beside it.
        scene: its name.
        out: the HTML file.
        viewer: three.min.js, to which the page links; without it the scene cannot be turned.
        options: JSON of the config section `tables`.
    """
    settings = read_options(TablesConfig, options)
    album, declared = Album(settings.picture_width, settings.picture_quality), RunFiles(files, {scene: image})
    found = rooms.collect(declared, album)
    if len(found) != 1:
        raise InputError("--files", f"are of {len(found)} pictures.", "name the files of one", code="E-FILES-PICTURES")
    (room,) = found
    page = environment("plugins.report").get_template("page/scene.html.jinja")
    text = page.render(
        room=room,
        root=read_root(
            declared.find_first(f"extraction/{room.name}/objects.json"),
            image.parent,
            room.reconstructions[0] if room.reconstructions else None,
        ),
        found=single.input_facts(declared, room.name, camera, album),
        doubts=[
            (single.split_doubts(single.doubts(room, one)), single.list_further_doubts(one), single.notes(one))
            for one in (*room.reconstructions,) or (None,)
        ],
        links=single.links(declared, room.name, out),
        first=room.reconstructions[0] if room.reconstructions else None,
        script=script("page.js", "viewer.js", "back.js"),
        viewer=link_to(viewer, out),
        number=number,
    )
    write_text(out, text)
