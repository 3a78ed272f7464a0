"""Before a workflow starts: can the files of its pictures be read? Of a picture the header alone is looked at."""

from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path

from roomkin.stages.config.experiment import ExperimentConfig
from roomkin.stages.config.pictures import Picture
from roomkin.stages.contracts.files import read_json
from roomkin.stages.contracts.images import open_picture, read_depth
from roomkin.stages.contracts.scenes import Annotations, Camera
from roomkin.stages.perception.drawing.project import Project
from roomkin.stages.perception.read.depth_files import read_raw
from roomkin.stages.perception.read.frame import check_upright
from roomkin.stages.perception.read.mask_files import read_labelled
from roomkin.stages.perception.read.photo import check_photo
from roomkin.stages.perception.read.views import ViewFiles, choose_camera, find_view


def check_pictures(experiment: ExperimentConfig) -> None:
    """Of the scenes of a run: refuse what no job could read, before those that make the library have run for nothing.

    For a run of one picture: of many, the others are to be made.

    Raises:
        InputError: names the first such file.
    """
    with redirect_stdout(StringIO()):  # the jobs say what they make of it
        for picture in (experiment.inputs[room] for room in experiment.rooms if room in experiment.inputs):
            if picture.folder:
                _check_folder(Path(picture.folder))
            elif picture.alone:
                check_photo(Path(picture.image))
                if picture.drawing:
                    read_json(Project, Path(picture.drawing))
            else:
                _check_frame(picture)


def _check_folder(folder: Path) -> None:
    read_json(Camera, folder / "camera.json")
    read_json(Annotations, folder / "annotations.json")
    read_depth(folder / "depth.npz")
    for name in ("rgb.png", "masks.png"):
        with open_picture(folder / name):
            pass


def _check_frame(picture: Picture) -> None:
    words = [*map(str, picture.intrinsics or filter(None, (picture.camera, picture.fov)))]
    camera, file = choose_camera(words)
    if picture.recording:
        view = find_view(Path(picture.recording), picture.number, camera, file)
    else:
        assert camera is not None, "a picture with depth and without a camera is no valid config"
        view = ViewFiles(Path(picture.image), Path(picture.depth), camera, file)
    with open_picture(view.color) as image:
        shown = (*image.size, view.color.name)
    check_upright(view.color)
    read_raw(view.depth)
    view.camera(*shown)
    if picture.masks:
        read_labelled(Path(picture.masks), Path(picture.labels) if picture.labels else None, *shown)
