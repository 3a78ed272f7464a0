"""Command `annotate`: a page in the browser to draw a photograph into an input folder, or to correct one."""

import json
import webbrowser
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

from roomkin.plugins.annotator.correcting import Correcting
from roomkin.plugins.annotator.said import is_bare, name_drawn
from roomkin.plugins.annotator.server import Page, PageServer
from roomkin.plugins.annotator.session import Session
from roomkin.stages.config.inputs import describe_missing, scene_of_folder
from roomkin.stages.contracts import Camera, InputError, Library, read_json
from roomkin.stages.contracts.categories import known_categories
from roomkin.stages.contracts.errors import count, suggest_nearest
from roomkin.stages.contracts.hand import CORRECTIONS, PROJECT, is_drawn
from roomkin.stages.contracts.images import orientation_of, read_depth
from roomkin.stages.perception.drawing.write import at_size
from roomkin.stages.perception.read.photo import read_photo


def _categories(library: Path | None) -> list[str]:
    """Names that labels are completed with."""
    names = known_categories() if library is None else {entry.category for entry in read_json(Library, library).assets}
    return sorted(name.replace("_", " ") for name in names)


def run(
    image: Path,
    /,
    *,
    out: Path | None = None,
    depth: Path | None = None,
    camera: Path | None = None,
    lens: Path | None = None,
    library: Path | None = None,
    results: Path = Path("results"),
    scene: str | None = None,
    variant: str | None = None,
    choose: str | None = None,
    port: int = 0,
    browser: bool = True,
) -> None:
    """Draw camera, room and objects into a photograph; the folder can then be an input of an experiment.

    The page saves what is drawn into `project.json` as it goes; started again with the same folder it goes on.
    Given an input folder in the photograph's place, what was found and chosen there is corrected: `corrections.json` in
    the folder keeps it, and the next run heeds it. A folder with picture, depth and camera alone gets its masks there.

    Args:
        image: the photograph, or an input folder.
        out: folder to write; default: beside the photograph, named as it is.
        depth: depth.npz in metres by a sensor or a network, of the same view; boxes and masks are drawn by hand.
        camera: camera.json of the picture, whose focal length the drawing starts from, as from EXIF data.
        lens: calibration with distortion, as OpenCV, ROS, Kalibr write it: the picture is made straight first.
        library: library.json whose categories complete the labels; default: ours.
        results: of a folder: where the last run left what it made of it.
        scene: of a folder: its name in that run; default: as the folder is called.
        variant: of a folder: the variant of matching whose cousins are shown; default: the first.
        choose: of a folder: the object that is chosen when the page opens, e.g. cabinet_1.
        port: of this machine; 0: any free one.
        browser: open the page; else its address is only printed.
    """
    if image.is_dir():
        for name, given in (("--out", out), ("--depth", depth), ("--camera", camera), ("--lens", lens)):
            if given is not None:
                what = "is for a picture; the folder has its own."
                raise InputError(name, what, "leave it out", code="E-OPTION-CONFLICT")
        name, picture = scene or scene_of_folder(image), image / "rgb.png"
        correcting = Correcting(image, _categories(library), results, name, variant, choose)
        _check_named(correcting, results, scene, choose)
        session: Page = correcting
        draw = partial(_open_photograph, picture, None, image, None, None, library)
        other: Callable[[], Page] | None = draw if is_drawn(image) else None
    elif lens is not None and depth is not None:
        what, mend = "bends the picture, not the depth.", "`perception from-rgbd` straightens both"
        raise InputError("--lens", what, mend, code="E-OPTION-CONFLICT")
    else:
        session = _open_photograph(image, lens, out, depth, camera, library)
        other = partial(_open_scene, session.folder, _categories(library), results)
    session.begin_looking()
    try:
        server = PageServer(session, port, other)
    except OSError as error:
        what = f"cannot be used ({error.strerror})."
        raise InputError(f"--port {port}", what, "leave it out", code="E-PORT-TAKEN") from None
    path = session.kept.path
    if (taken := path.with_name(PROJECT if isinstance(session, Session) else CORRECTIONS)) != path:
        print(f"{taken}: is of another picture: kept, not opened")
    print(f"Draw at {server.address}\nEnd it there, or with Ctrl+C: {path} keeps what is drawn.", flush=True)
    if browser:
        webbrowser.open(server.address)
    try:
        server.serve_forever(poll_interval=0.1)
    except KeyboardInterrupt:
        print()
    finally:
        server.making.stop()
        server.server_close()
    session = server.session
    folder = session.folder
    if isinstance(session, Correcting) and is_bare(folder):
        print(f"{folder}: no masks yet: open it again, and end it with Done")
        return
    if isinstance(session, Correcting):
        print(f"To make again what depends on it: {session.command()}")
        return
    written = folder / "annotations.json"
    if written.is_file():
        many = len(json.loads(written.read_text(encoding="utf-8"))["objects"])
        print(f"{folder}: an input folder with {count(many, 'object')}; {folder / 'config.yaml'} names it as a scene")


def _check_named(session: Correcting, results: Path, scene: str | None, choose: str | None) -> None:
    """Refuse a scene that the last run did not make, and an object that is not in the picture."""
    runs = sorted(path.parent.name for path in (results / "extraction").glob("*/objects.json"))
    if scene is not None and runs and scene not in runs:
        fix = suggest_nearest(scene, runs)
        raise InputError("--scene", f"{results} has no scene '{scene}'.", fix, code="E-OBJECT-MISSING")
    names = [
        *(item.id for item in session.made.items.values()),
        *(thing.id for thing in session.open_drawing().objects),
        *map(name_drawn, session.left_out),
    ]
    if choose is not None and choose not in names:
        fix = suggest_nearest(choose, list(dict.fromkeys(names)))
        raise InputError("--choose", f"there is no '{choose}' in the picture.", fix, code="E-OBJECT-MISSING")


def _open_scene(folder: Path, categories: list[str], results: Path) -> Correcting:
    """What was made of the folder of a drawing."""
    if describe_missing(folder):
        raise InputError(folder, "has no scene yet.", "make scenes of it, first", code="E-SCENE-EMPTY")
    return Correcting(folder, categories, results, scene_of_folder(folder))


def _open_photograph(
    image: Path, lens: Path | None, out: Path | None, depth: Path | None, camera: Path | None, library: Path | None
) -> Session:
    """A photograph that is drawn into."""
    photo = read_photo(image, lens)
    height, width = photo.rgb.shape[:2]
    if photo.shrunk > 1:
        print(f"{image}: made smaller, to {width}x{height} pixels")
    if camera is not None:
        known = read_json(Camera, camera)
        photo = replace(photo, focal=known.intrinsics[0][0] * width / known.width)
    if depth is not None and (turned := orientation_of(image)) > 1:
        print(f"{image}: is turned by its EXIF data ({turned}); {depth} is taken to be upright")
    given = None if depth is None else at_size(read_depth(depth)[0], width, height)
    folder = out or image.with_suffix("")
    if folder.exists() and not folder.is_dir():
        raise InputError(folder, "is a file, not a folder.", "give a folder with --out", code="E-OUTPUT-FOLDER")
    session = Session(photo, _name(image), folder, _categories(library), given)
    session.open_drawing()
    return session


def _name(image: Path) -> str:
    """What a picture is called; rgb.png in an input folder as the file that it was read from."""
    about = image.with_name("camera.json")
    known = read_json(Camera, about).picture if image.name == "rgb.png" and about.is_file() else ""
    return known or image.name
