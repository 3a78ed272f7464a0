"""Command `picture`: one picture, what was found in it and what became of it, on one page."""

from pathlib import Path

from roomkin.plugins.report.album import Album
from roomkin.plugins.report.page import rooms, single
from roomkin.plugins.report.page.files import RunFiles
from roomkin.plugins.report.page.root import draw_again, list_left_out, read_said
from roomkin.plugins.report.report import link_to, render
from roomkin.stages.config.evaluation import TablesConfig
from roomkin.stages.contracts import InputError
from roomkin.stages.contracts.files import read_json, read_options, write_text
from roomkin.stages.contracts.hand import is_drawn
from roomkin.stages.contracts.scenes import Camera
from roomkin.stages.contracts.things import read_things


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
    path, objects = declared.find_first(f"extraction/{room.name}/objects.json"), room.found.objects
    taken_by = read_json(Camera, camera)
    things, first = read_things(image.parent), room.reconstructions[0] if room.reconstructions else None
    said = read_said(image.parent)
    doubts = [
        (single.list_doubts(room, one, taken_by), single.list_further_doubts(one), one.matches if one else [])
        for one in (*room.reconstructions,) or (None,)
    ]
    text = render(
        "scene.html.jinja",
        ("page.js", "viewer.js", "back.js"),
        room=room,
        things=things,
        left_out=list_left_out(things, image.parent, said) if path else [],
        take=draw_again(image) if is_drawn(image.parent) else first.correct if first else "",
        lost=list(dict.fromkeys([*said.lines, *(objects.lost if objects else [])])),
        camera=single.measure_camera(objects) if objects else None,
        title=taken_by.picture or room.title,
        note=taken_by.note,
        depth=single.draw_depth(path, objects, album) if path and objects else None,
        doubts=doubts,
        tell_doubts=single.tell_doubts,
        links=single.links(declared, room.name, out),
        first=first,
        viewer=link_to(viewer, out),
    )
    write_text(out, text)
    print(f"{out}: {'; '.join(single.tell_doubts(listed) for listed, *_ in doubts)}")
