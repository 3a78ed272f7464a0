"""Pictures of the user's: one by one, in a folder of input folders, or in a table with a row for each."""

import csv
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Literal

from pydantic import ConfigDict, Field, PrivateAttr, ValidationError

from plugins.inputs.known_cameras import FIELD_OF_VIEW, FIELDS_OF_VIEW
from stages.config.experiment import ExperimentConfig
from stages.config.inputs import HOLDS, INPUT_FILES, NAME, Input, describe_missing, scene_of, scene_of_folder
from stages.config.mistakes import Mistake
from stages.contracts.errors import suggest_file, suggest_nearest

COLOR = ("color", "rgb", "image", "colour")  # what pictures, and folders of them, are called besides depth


class Picture(Input):
    """A picture of the user's: an input folder, a frame with depth, or a picture alone; a row of a table."""

    model_config = ConfigDict(extra="forbid")

    image: str = Field("", description="the picture; without `depth` networks find what it shows (section `photo`)")
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
    fov: float | None = Field(
        None,
        ge=FIELD_OF_VIEW[0],
        le=FIELD_OF_VIEW[1],
        description="in the place of both: degrees over the picture's width",
    )
    masks: str = Field(
        "",
        description="COCO or labelme JSON, or a PNG of indices or colors; none: networks find things (section `eyes`)",
    )
    labels: str = Field("", description="what the PNG's values are called, as JSON")
    drawing: str = Field(
        "", description="of a picture without depth: project.json that the page wrote, in the place of networks"
    )
    _row: str = PrivateAttr("")

    @property
    def alone(self) -> bool:
        """Whether it is a picture without depth, for networks."""
        return bool(self.image) and not self.depth

    @property
    def intrinsics(self) -> list[float]:
        """fx, fy, cx, cy, as far as they are given, pixels."""
        return [value for value in (self.fx, self.fy, self.cx, self.cy) if value is not None]

    def place(self, scene: str) -> str:
        """The input folder: the user's own, or the one that is made of the picture."""
        return self.folder or (f"results/photo/{scene}" if self.alone else f"results/scenes/{scene}/frame")

    def files(self) -> dict[str, str]:
        """The user's files and folders by their keys; no camera that is known by its name."""
        keys = ["folder", "image", "depth", "recording", "masks", "labels", "drawing"]
        keys += ["camera"] if self.camera not in FIELDS_OF_VIEW else []
        return {key: path for key in keys if (path := getattr(self, key))}

    def mistakes(self, key: str) -> Iterator[Mistake]:
        """Its mistakes; `key`: where it stands in the config, if not in a table."""
        for name, *rest in self._list_contradictions():
            where = f"{key}.{name}".lstrip(".") if name != "folder" else key
            where = f"{self._row}, column {name}" if self._row else where
            yield Mistake(where, *rest)

    def _list_contradictions(self) -> Iterator[tuple[str, ...]]:
        """Key, what is wrong with it, how to mend it, and the code if it is not the usual one."""
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
        if self.drawing and not self.alone:
            yield "drawing", "is given, but no picture without depth", "leave it out"
        cameras = [bool(self.camera), bool(self.intrinsics), self.fov is not None]
        if sum(cameras) > 1:
            yield "camera", "is given in two ways", "camera, or fx, fy, cx and cy, or fov"
        if len(self.intrinsics) in (1, 2, 3) or (self.depth and not any(cameras)):
            yield "camera", "nothing says what camera took the picture", "camera, or fx, fy, cx and cy, or fov"
        for name in sorted(self.model_fields_set - {"image", "fov", "depth", "drawing"} if self.alone else ()):
            yield name, "is given for a picture without depth", "give depth, or leave it out"


def _as_written(schema: dict[str, Any]) -> None:
    """The values under `inputs`, for editors."""
    one = {"anyOf": [{"type": "string"}, schema.pop("additionalProperties")]}
    text = {"type": "string"}
    schema.pop("type")
    schema["anyOf"] = [{"type": "object", "additionalProperties": one}, text, {"type": "array", "items": text}]


class PicturesExperiment(ExperimentConfig):
    """The experiment, with scenes of pictures."""

    inputs: dict[str, Picture] = Field(  # type: ignore[assignment]
        {},
        json_schema_extra=_as_written,
        description="Your own scenes: name -> input folder (docs/scenes.md), or what a row of a table says; or a table "
        "(CSV), a folder of input folders, or a list of these (docs/your-data.md). They are reconstructed like the "
        "rooms, but not scored: there is no truth.",
    )

    @property
    def frames(self) -> list[str]:
        """Scenes whose input folders the workflow makes of frames with depth and masks."""
        return [name for name, one in self.inputs.items() if not one.folder and not one.alone and one.masks]

    @property
    def views(self) -> list[str]:
        """Scenes whose input folders the workflow makes of frames with depth, and whose things it finds itself."""
        return [name for name, one in self.inputs.items() if not one.folder and not one.alone and not one.masks]

    @property
    def photographs(self) -> list[str]:
        """Scenes whose input folders networks make of pictures without depth."""
        return [name for name, one in self.inputs.items() if not one.folder and one.alone and not one.drawing]

    @property
    def drawn(self) -> list[str]:
        """Scenes whose input folders the workflow makes of pictures without depth and what was drawn into them."""
        return [name for name, one in self.inputs.items() if one.alone and one.drawing]

    @property
    def pictures(self) -> list[str]:
        """Pictures of this run that networks look at."""
        given = [self.inputs[room] for room in self.rooms if room in self.inputs]
        return [one.image for one in given if one.alone and not one.drawing]


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
                mistakes.append(
                    Mistake(where, f"there are two scenes '{name}'", "give one another name", "E-CONFIG-TWICE")
                )
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
        lines = table.read_text(encoding="utf-8-sig").splitlines(keepends=True)
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
            wrong = Mistake(
                where, f"has {len(cells)} cells for {len(columns)} columns", "quote commas", "E-CONFIG-VALUE"
            )
            yield where, scene, wrong
        elif not NAME.fullmatch(scene):
            mend = "letters, digits, - and single _ inside"
            yield where, scene, Mistake(f"{where}, column scene", f"'{scene}' is no name", mend, "E-CONFIG-NAME")
        else:
            yield where, scene, _of_row(cells_by_name, where, table.parent)


def _of_row(cells_by_name: dict[str, str], where: str, folder: Path) -> Picture | Mistake:
    try:
        plain = Picture.model_validate(cells_by_name)
    except ValidationError as error:
        detail = error.errors()[0]
        what = f"{detail['msg'].removeprefix('Value error, ')} (got '{detail['input']}')"
        return Mistake(
            f"{where}, column {detail['loc'][0]}", what, "docs/your-data.md says what a column holds", "E-CONFIG-VALUE"
        )
    found = plain.model_copy(update={key: (folder / path).as_posix() for key, path in plain.files().items()})
    found._row = where
    return found


def of_picture(config: Any) -> Any:
    """The config with the picture of `image`, or every frame of its recording, as its scenes, without policies."""
    if not config.image:
        return config
    path = Path(config.image)
    own = path.stem.lower() not in COLOR or path.is_dir() or path.parent == Path()
    name = scene_of(path.with_suffix("") if own else path.parent)  # color.png of every recording is no name
    name = f"{name}-photo" if name in config.rooms() else name
    given = {"camera": config.camera} if config.camera else {}
    if path.is_dir():
        from plugins.inputs.rgbd.layouts import list_frames  # what it imports takes a second at every start

        frames = range(len(list_frames(path)))
        inputs = {f"{name}-{k}": Picture(recording=config.image, number=k, **given) for k in frames}
    else:
        given |= {"depth": config.depth} if config.depth else {}
        inputs = {name: Picture(image=config.image, **given)}
    only = {"rooms": list(inputs), "inputs": inputs}
    only |= {key: {} for key in ("targets", "policies", "pools", "protocols")}
    return config.model_copy(update={"experiment": config.experiment.model_copy(update=only)})
