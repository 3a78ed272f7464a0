"""Pictures of the user's: one by one, in a folder of input folders, or in a table with a row for each."""

import csv
import os
import re
import shlex
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any, Literal

from pydantic import Field, PrivateAttr, ValidationError, model_validator

from roomkin.stages.config.inputs import (
    HOLDS,
    INPUT_FILES,
    describe_missing,
    is_scene,
    scene_of,
    scene_of_folder,
    suggest_scene,
)
from roomkin.stages.config.mistakes import Mistake
from roomkin.stages.config.recordings import FIELDS_OF_VIEW, DegreesWide, list_frames, name_picture
from roomkin.stages.contracts.errors import InputError, suggest_file, suggest_nearest
from roomkin.stages.contracts.files import decode_file
from roomkin.stages.contracts.hand import digest_of_image, digest_of_picture
from roomkin.stages.contracts.section import Section

CAMERA_MEND = "camera (--intrinsics of roomkin picture, INTRINSICS of make picture), or fx, fy, cx and cy, or fov"
UNFIT = re.compile(r"-|.*[{}\ud800-\udfff]", re.DOTALL)  # paths of options, of wildcards, of no text


class Picture(Section):
    """A picture of the user's: an input folder, a frame with depth, or a picture alone; a row of a table."""

    folder: str = Field("", description="an input folder (docs/scenes.md), in the place of all else")
    image: str = Field("", description="the picture; without `depth` what it shows is found (section `perception`)")
    depth: str = Field("", description="its depth, aligned to it")
    unit: str = Field("auto", description="of the depth: auto, m, mm, or the number that stands for one metre")
    depth_is: Literal["z", "ray"] = Field("z", description="along the optical axis, or along the ray of each pixel")
    recording: str = Field("", description="in the place of both: a recording ...")
    number: int = Field(0, ge=0, description="... and which of its frames, from 0")
    camera: str = Field("", description="file of its intrinsics (camera.json, JSON, YAML, text), or the camera's name")
    fx: float | None = Field(None, gt=0, description="in the place of `camera`, pixels; so fy, cx, cy")
    fy: float | None = Field(None, gt=0)
    cx: float | None = None
    cy: float | None = None
    fov: DegreesWide | None = Field(None, description="in the place of both: degrees over the picture's width")
    masks: str = Field(
        "",
        description="JSON, YOLO's text, a PNG or a folder of outlines; none: they are found (section `perception`)",
    )
    labels: str = Field("", description="what their numbers are called, if they do not say it: JSON or data.yaml")
    drawing: str = Field(
        "", description="of a picture without depth: project.json that the page wrote, in the place of networks"
    )
    _row: str = PrivateAttr("")
    _measured: bool = PrivateAttr(False)  # a network measures its depth, as the whole config says

    @model_validator(mode="before")
    @classmethod
    def _of_text(cls, given: Any) -> Any:
        """A text alone names a folder."""
        return {"folder": given} if isinstance(given, str) else given

    @property
    def alone(self) -> bool:
        """Whether it is a picture without depth, for networks."""
        return bool(self.image) and not self.depth

    @property
    def intrinsics(self) -> list[float]:
        """fx, fy, cx, cy, as far as they are given, pixels."""
        return [value for value in (self.fx, self.fy, self.cx, self.cy) if value is not None]

    @property
    def row(self) -> str:
        """Its row, if it stands in a table."""
        return self._row

    @property
    def measured(self) -> bool:
        """Whether it is one whose depth a network measures."""
        return self._measured

    def read_digest(self, frames: Callable[[Path], list[tuple[Path, Path]]] = list_frames) -> str:
        """SHA-256 of the picture's file; empty: it cannot be read, which the rule that reads it says.

        Args:
            frames: what lists those of a recording.
        """
        try:
            if self.folder:
                return digest_of_picture(Path(self.folder))
            path = Path(self.image) if self.image else frames(Path(self.recording))[self.number][0]
            return digest_of_image(path) if path.is_file() else ""  # a pipe would be read for ever
        except (InputError, OSError, IndexError):
            return ""

    def place(self, scene: str) -> str:
        """The input folder: the user's own, or the one that is made of the picture."""
        drawn = self.alone and not self.measured
        return self.folder or (f"results/photo/{scene}" if drawn else f"results/scenes/{scene}/frame")

    def files(self) -> dict[str, str]:
        """The user's files and folders by their keys; no camera that is known by its name."""
        keys = ["folder", "image", "depth", "recording", "masks", "labels", "drawing"]
        keys += ["camera"] if self.camera not in FIELDS_OF_VIEW else []
        return {key: path for key in keys if (path := getattr(self, key))}

    def flags(self, files: Mapping[str, Any]) -> str:
        """The flags of `from-rgbd` for a frame; `files`: where its files lie now, by their keys."""
        flags = {
            "--rgb": files.get("image"), "--depth": files.get("depth"), "--recording": files.get("recording"),
            "--masks": files.get("masks"), "--labels": files.get("labels"), "--unit": self.unit,
            "--depth-is": None if self.depth_is == "z" else self.depth_is,
            "--number": None if self.depth else self.number, "--camera": files.get("camera") or self.camera or self.fov,
        }  # fmt: skip
        words = [word for flag, value in flags.items() if value for word in (flag, str(value))]
        matrix = ["--camera", *map(str, self.intrinsics)] if self.intrinsics else []
        return shlex.join([*words, *matrix])

    def mistakes(self, key: str) -> Iterator[Mistake]:
        """Its mistakes; `key`: where it stands in the config, if not in a table."""
        for name, *rest in self._list_contradictions():
            where = f"{key}.{name}".lstrip(".") if name != "folder" else key
            where = f"{self._row}, column {name}" if self._row else where
            yield Mistake(where, *rest)

    def _list_contradictions(self) -> Iterator[tuple[str, ...]]:
        """Key, what is wrong with it, how to mend it, and the code if it is not the usual one."""
        for name, path in self.files().items():
            if UNFIT.match(path):
                what = f"{path} begins with -, has {{ or }}, or is not UTF-8, and no rule can be given it"
                yield name, what, "call the file or folder otherwise", "E-CONFIG-NAME"
        if self.folder:
            for name in sorted(self.model_fields_set - {"folder"}):
                yield name, "is given together with a folder", "leave one of them out: a folder holds everything"
            for what in describe_missing(Path(self.folder)):
                yield "folder", what, HOLDS, "E-CONFIG-FILE"
            return
        if not self.image and not self.recording:
            yield "image", "nothing says where the picture is", "image, folder or recording"
        if self.recording and (self.image or self.depth):
            yield "recording", "has pictures of its own", "leave out image and depth"
        for name, path in self.files().items():
            if not Path(path).exists():
                known = f", or one of {', '.join(FIELDS_OF_VIEW)}" if name == "camera" else ""
                yield name, f"no file {path}", suggest_file(path) or f"correct the path{known}", "E-CONFIG-FILE"
            elif name != "recording" and not (Path(path).is_file() or (name == "masks" and Path(path).is_dir())):
                yield name, f"{path} is no file, but a folder, a pipe or a device", "correct the path", "E-CONFIG-FILE"
        if self.drawing and not self.alone:
            yield "drawing", "is given, but no picture without depth", "leave it out"
        cameras = [bool(self.camera), bool(self.intrinsics), self.fov is not None]
        if sum(cameras) > 1:
            yield "camera", "is given in two ways", CAMERA_MEND
        if len(self.intrinsics) in (1, 2, 3) or (self.depth and not any(cameras)):
            yield "camera", "nothing says what camera took the picture", CAMERA_MEND
        for name in sorted(self.model_fields_set - {"image", "fov", "depth", "drawing"} if self.alone else ()):
            yield name, "is given for a picture without depth", "give depth, or leave it out"


def as_written(schema: dict[str, Any]) -> None:
    """The values under `inputs`, for editors."""
    one = {"anyOf": [{"type": "string"}, schema.pop("additionalProperties")]}
    text = {"type": "string"}
    schema.pop("type")
    schema["anyOf"] = [{"type": "object", "additionalProperties": one}, text, {"type": "array", "items": text}]


def read_sources(config: dict[str, Any]) -> tuple[dict[str, Any], list[Mistake]]:
    """`config` with every input under its name, in the place of tables and folders of input folders."""
    experiment = config.get("experiment")
    sources = experiment.get("inputs") if isinstance(experiment, dict) else None
    sources = [sources] if isinstance(sources, str) else sources
    if not isinstance(sources, list) or not all(isinstance(source, str) for source in sources):
        return config, []
    inputs: dict[str, Picture] = {}
    mistakes: list[Mistake] = []
    for source in map(Path, sources):
        for where, name, found in _of_folder(source) if source.is_dir() else _of_table(source):
            if isinstance(found, Mistake):
                mistakes.append(found)
            elif name in inputs:
                what = f"there are two scenes '{name}'"
                mistakes.append(Mistake(where, what, "give one another name", "E-CONFIG-TWICE"))
            else:
                inputs[name] = found
    return config | {"experiment": {**experiment, "inputs": inputs}}, mistakes  # type: ignore[dict-item]


Found = Iterator[tuple[str, str, Picture | Mistake]]  # where it stands, the scene's name, what it is or what is wrong


def _of_folder(folder: Path) -> Found:
    """A scene per folder inside that holds anything of an input folder; or the folder itself."""
    inside = [folder] if not describe_missing(folder) else sorted(path for path in folder.iterdir() if path.is_dir())
    scenes = [path for path in inside if any((path / name).is_file() for name in INPUT_FILES)]
    if not scenes:
        yield "", "", Mistake("experiment.inputs", f"{folder} has no input folder in it", HOLDS, "E-CONFIG-FILE")
    for path in scenes:
        yield str(path), scene_of_folder(path), Picture(folder=path.as_posix())


def _of_table(table: Path) -> Found:
    """A scene per row; paths are relative to the table's folder, an empty cell says nothing."""
    try:
        lines = decode_file(table).splitlines(keepends=True)
    except (OSError, ValueError) as error:
        why = "no such file or folder" if isinstance(error, FileNotFoundError) else f"cannot be read ({error})"
        mend = "a table (CSV), or a folder of input folders"
        yield "", "", Mistake("experiment.inputs", f"{table}: {why}", mend, "E-CONFIG-FILE")
        return
    first = lines[0] if lines else ""
    rows = csv.reader(lines, delimiter=max(",;\t", key=first.count))
    columns = [name.strip() for name in next(rows, [])]
    known, head = ["scene", *Picture.model_fields], f"{table}, row 1"
    for name in columns:
        if name not in known or columns.count(name) > 1:
            mend = suggest_nearest(name, known) if name not in known else "name it once"
            yield "", "", Mistake(head, f"column '{name}' is not known, or there twice", mend, "E-CONFIG-UNKNOWN")
            return
    if "scene" not in columns:
        yield "", "", Mistake(head, "has no column 'scene'", "the name of each row's scene", "E-CONFIG-UNKNOWN")
        return
    for cells in rows:
        where = f"{table}, row {rows.line_num}"
        cells_by_name = {name: cell.strip() for name, cell in zip(columns, cells, strict=False) if cell.strip()}
        if not cells_by_name:
            continue
        scene = cells_by_name.pop("scene", "")
        if len(cells) > len(columns):
            what = f"has {len(cells)} cells for {len(columns)} columns"
            yield where, scene, Mistake(where, what, "quote commas", "E-CONFIG-VALUE")
        elif not is_scene(scene):
            what = f"'{scene}' is no name"
            yield where, scene, Mistake(f"{where}, column scene", what, suggest_scene(scene), "E-CONFIG-NAME")
        else:
            yield where, scene, _of_row(cells_by_name, where, table.parent)


def _of_row(cells_by_name: dict[str, str], where: str, folder: Path) -> Picture | Mistake:
    try:
        plain = Picture.model_validate(cells_by_name)
    except ValidationError as error:
        detail = error.errors()[0]
        what = f"{detail['msg'].removeprefix('Value error, ')} (got '{detail['input']}')"
        mend = "docs/your-data.md says what a column holds"
        return Mistake(f"{where}, column {detail['loc'][0]}", what, mend, "E-CONFIG-VALUE")
    found = plain.model_copy(update={key: (folder / path).as_posix() for key, path in plain.files().items()})
    found._row = where
    return found


def of_picture(config: Any) -> Any:
    """The config with the picture of `image`, or every frame of its recording, as its scenes, without policies."""
    if not config.image:
        return config
    path = Path(config.image)
    name = name_scene(path)
    name = f"{name}-photo" if name in config.rooms() else name
    given = {"camera": config.camera} if config.camera else {}
    if path.is_dir():
        names = [scene_of(Path(f"{name}-{k}")) for k in range(len(list_frames(path)))]
        inputs = {name: Picture(recording=config.image, number=k, **given) for k, name in enumerate(names)}
    else:
        given |= {"depth": config.depth} if config.depth else {}
        inputs = {name: Picture(image=config.image, **given)}
    only = {"rooms": list(inputs), "inputs": inputs}
    only |= {key: {} for key in ("targets", "policies", "pools", "protocols")}
    return config.model_copy(update={"experiment": config.experiment.model_copy(update=only)})


def name_scene(path: Path) -> str:
    """The name of the scene of a picture or a recording."""
    whole = Path(os.path.normpath(path.absolute()))
    if path.is_dir():
        return scene_of(whole)
    own = name_picture(path) or path.parent == Path()
    return scene_of(whole.with_suffix("") if own else whole.parent)  # color.png of every recording is no name


def mark_measured(config: Any) -> None:
    """Pictures without depth and without a drawing are measured where the networks for it are asked."""
    for one in config.experiment.inputs.values():
        one._measured = one.alone and not one.drawing and config.perception.asks_networks()
