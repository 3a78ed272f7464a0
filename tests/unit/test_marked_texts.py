"""Whatever text a user gives is read as Windows' programs save it: with a byte order mark, in UTF-8 or UTF-16."""

import codecs
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from PIL import Image

from roomkin.stages.articulated.urdf_reader import read_urdf
from roomkin.stages.config.files import read_file
from roomkin.stages.config.inputs import list_objects
from roomkin.stages.config.pictures import read_sources
from roomkin.stages.config.recordings import list_frames
from roomkin.stages.contracts.files import read_text
from roomkin.stages.perception.read.depth_scale import find_stated_units
from roomkin.stages.perception.read.lens import read_lens
from roomkin.stages.perception.read.mask_files import read_labelled
from roomkin.stages.tables.rows import read_table
from tests.refusals import refused

MARKED = {
    "no mark": b"",
    "UTF-8": codecs.BOM_UTF8,
    "UTF-16": codecs.BOM_UTF16_LE,
    "UTF-16 of other machines": codecs.BOM_UTF16_BE,
}
ENCODING = {codecs.BOM_UTF16_LE: "utf-16-le", codecs.BOM_UTF16_BE: "utf-16-be"}
LABELME = {"shapes": [{"label": "tür", "points": [[1, 1], [9, 1], [9, 9]]}]}
PINHOLE = {"fx": 20.0, "fy": 20.0, "cx": 10.0, "cy": 8.0}
URDF = '<robot name="tür"><link name="tür"><visual><geometry><box size="1 1 1"/></geometry></visual></link></robot>'


def masks(path: Path) -> Any:
    return list(read_labelled(path, None, 20, 16, "a.png").labels.values())


def names(path: Path) -> Any:
    picture = path.with_name("masks.png")
    Image.fromarray(np.eye(16, 20, dtype=np.uint8)).save(picture)
    return list(read_labelled(picture, path, 20, 16, "a.png").labels.values())


def lines(path: Path) -> Any:
    path.with_name("names.json").write_text('["tür"]')
    return list(read_labelled(path, path.with_name("names.json"), 20, 16, "a.png").labels.values())


def pictures(path: Path) -> Any:
    path.with_name("depth.txt").write_text("1.0 d.png")
    return [color.name for color, _ in list_frames(path.parent)]


READERS: list[tuple[str, str, Callable[[Path], Any], Any]] = [
    ("labels.json", '{"1": "tür"}', names, ["tür"]),
    ("data.yaml", "names: [background, tür]", names, ["tür"]),
    ("classes.txt", "background\ntür\n", names, ["tür"]),
    ("masks.json", json.dumps(LABELME, ensure_ascii=False), masks, ["tür"]),
    ("masks.txt", "0 .1 .1 .9 .1 .9 .9\n", lines, ["tür"]),
    ("k.json", json.dumps(PINHOLE), lambda path: read_lens(path, 20, 16).intrinsics[0, 0], 20),
    ("k.yaml", yaml.safe_dump(PINHOLE), lambda path: read_lens(path, 20, 16).intrinsics[0, 0], 20),
    ("k.csv", "20, 0, 10\n0, 20, 8\n0, 0, 1\n", lambda path: read_lens(path, 20, 16).intrinsics[0, 0], 20),
    ("unit.json", '{"depth_scale": 5000}', lambda path: len(find_stated_units(path.with_name("d.png"), path)), 1),
    ("rgb.txt", "# tür\n1.0 a.png\n", pictures, ["a.png"]),
    ("table.csv", "scene,note\ntür,1\n", lambda path: read_table(path, ["scene"])["scene"].tolist(), ["tür"]),
    ("config.yaml", "name: tür\n", read_file, {"name": "tür"}),
    ("pack.yaml", "up: tür\n", read_text, "up: tür\n"),  # as of packs of models, rooms and all contracts
    ("cabinet.urdf", URDF, lambda path: read_urdf(path, path.parent).root, "tür"),
    ("annotations.json", '{"objects": [{"label": "cup"}]}', lambda path: [*list_objects(path.parent)], ["cup_1"]),
]
REFUSING = [one for one in READERS if one[0] not in ("unit.json", "annotations.json")]  # those are looked at in passing


@pytest.mark.parametrize("mark", MARKED.values(), ids=MARKED)
@pytest.mark.parametrize(("name", "text", "read", "found"), READERS, ids=[name for name, *_ in READERS])
def test_text_with_a_mark(
    tmp_path: Path, name: str, text: str, read: Callable[[Path], Any], found: object, mark: bytes
) -> None:
    (tmp_path / name).write_bytes(mark + text.encode(ENCODING.get(mark, "utf-8")))
    assert read(tmp_path / name) == found


@pytest.mark.parametrize(("name", "text", "read", "_"), REFUSING, ids=[name for name, *_ in REFUSING])
def test_text_of_another_alphabet_is_told(
    tmp_path: Path, name: str, text: str, read: Callable[[Path], Any], _: object
) -> None:
    (tmp_path / name).write_bytes(text.encode() + "ü".encode("latin-1"))
    with refused("E-FILE-ENCODING", f"{name}: is no UTF-8 text. Fix: "):
        read(tmp_path / name)


@pytest.mark.parametrize("mark", MARKED.values(), ids=MARKED)
def test_a_table_of_pictures_with_a_mark(tmp_path: Path, mark: bytes) -> None:
    (tmp_path / "t.csv").write_bytes(mark + "scene,folder\nkitchen,k\n".encode(ENCODING.get(mark, "utf-8")))
    found, _ = read_sources({"experiment": {"inputs": str(tmp_path / "t.csv")}})
    assert "kitchen" in str(found)
