"""Files that hang, flood, crash or show nothing: each is left out with a line, and the models beside it go on."""

import os
import signal
from collections.abc import Callable
from pathlib import Path

import pytest
import trimesh

import stages.assets.apart as limits
from stages.assets.apart import apart
from stages.assets.import_ import run
from stages.assets.imports import IMPORTERS, by_suffix, import_models, named_models
from stages.contracts.errors import InputError

FLOODS = {
    "replicate": '<worldbody><replicate count="100000000"><geom size=".1"/></replicate></worldbody>',
    "hfield": '<asset><hfield name="h" nrow="50000" ncol="50000" size="1 1 1 1"/></asset>'
    '<worldbody><geom type="hfield" hfield="h"/></worldbody>',
}


def good(folder: Path, name: str = "box/zz.glb") -> None:
    (folder / name).parent.mkdir(parents=True, exist_ok=True)
    trimesh.creation.box((0.3, 0.2, 0.25)).export(folder / name)


def own(folder: Path, out: Path) -> tuple[list[str], list[str]]:
    kinds = by_suffix(IMPORTERS)
    assets, left_out = import_models(named_models([folder], kinds), kinds, out)
    return [asset.id for asset in assets], left_out


def transparent(folder: Path) -> None:
    (folder / "box").mkdir(parents=True, exist_ok=True)
    colour = '<material name="m"><color rgba="1 0 0 0"/></material>'
    shape = '<geometry><box size="0.3 0.3 0.3"/></geometry>'
    (folder / "box/aa.urdf").write_text(
        f'<robot name="r"><link name="a"><visual>{shape}{colour}</visual></link></robot>'
    )


def thin(folder: Path) -> None:
    (folder / "box").mkdir(parents=True, exist_ok=True)
    trimesh.creation.box((0.0002, 0.0002, 1.0)).export(folder / "box/aa.stl")


@pytest.mark.parametrize("write", [transparent, thin])
def test_what_shows_nothing_is_left_out(
    tmp_path: Path, write: Callable[..., object], capsys: pytest.CaptureFixture[str]
) -> None:
    write(tmp_path / "theirs")
    good(tmp_path / "theirs")
    assets, left_out = own(tmp_path / "theirs", tmp_path / "library")
    assert assets == ["box_zz"]
    assert len(left_out) == 1
    assert "cannot be seen: it is transparent, or too thin. Fix: " in left_out[0]
    assert not (tmp_path / "library/box_aa").exists()
    run(tmp_path / "theirs", out=tmp_path / "mine")
    assert "not used: cannot be seen" in capsys.readouterr().out


@pytest.mark.parametrize("kind", FLOODS)
def test_mjcf_that_floods_stops_no_other(tmp_path: Path, kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(limits, "SECONDS", 4)
    monkeypatch.setattr(limits, "MEGABYTES", 400)
    good(tmp_path / "theirs")
    (tmp_path / "theirs/box/aa.xml").write_text(f"<mujoco>{FLOODS[kind]}</mujoco>")
    assets, left_out = own(tmp_path / "theirs", tmp_path / "library")
    assert assets == ["box_zz"]
    assert len(left_out) == 1
    assert str(left_out[0]).startswith(f"{tmp_path}/theirs/box/aa.xml: ")


def test_what_takes_too_long_or_too_much_or_crashes_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    def told(work: Callable[..., object]) -> str:
        with pytest.raises(InputError) as error:
            apart(Path("a.obj"), work)  # type: ignore[arg-type]
        return error.value.what

    def hang() -> str:
        while True:
            pass

    def refuse() -> str:
        raise InputError("b.obj", "is bad.", "mend it")

    monkeypatch.setattr(limits, "SECONDS", 1)
    monkeypatch.setattr(limits, "MEGABYTES", 200)
    assert apart(Path("a.obj"), lambda: "ä" * 200_000) == "ä" * 200_000
    assert told(hang) == "takes more than 1 s to read."
    assert told(lambda: str(len(bytearray(300 * 2**20)))) == "takes more than 200 MB of memory to read."
    assert "SIGKILL" in told(lambda: str(os.kill(os.getpid(), signal.SIGKILL)))
    assert told(refuse) == "is bad."


def test_a_name_that_is_not_utf8_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    good(tmp_path / "theirs")
    (tmp_path / "theirs/box/zz.glb").rename(os.fsdecode(os.fsencode(tmp_path / "theirs/box") + b"/\xff.glb"))
    good(tmp_path / "theirs")
    assert own(tmp_path / "theirs", tmp_path / "library")[0] == ["box_zz"]
    assert "left out: box/\\udcff.glb: its name is not UTF-8" in capsys.readouterr().err


def test_links_to_nothing_and_pipes_are_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    good(tmp_path / "theirs")
    (tmp_path / "theirs/box/gone.glb").symlink_to("nowhere.glb")
    os.mkfifo(tmp_path / "theirs/box/pipe.obj")
    assert own(tmp_path / "theirs", tmp_path / "library")[0] == ["box_zz"]
    said = capsys.readouterr().err
    assert "left out: box/gone.glb: is a link to nothing" in said
    assert "left out: box/pipe.obj: is no file that can be read" in said


def test_parts_of_a_category_and_folders_that_say_nothing(tmp_path: Path) -> None:
    good(tmp_path / "theirs", "output/cabinet_panel.glb")
    good(tmp_path / "theirs", "output/cabinet.glb")
    good(tmp_path / "theirs", "shelf_window.glb")
    found = named_models([tmp_path / "theirs"], by_suffix(IMPORTERS))
    told = {one.path.stem: one.category for one in found.values()}
    assert told == {"cabinet_panel": "cabinet_panel", "cabinet": "bottom_cabinet", "shelf_window": "shelf_window"}
