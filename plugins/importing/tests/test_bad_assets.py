"""Files that hang, flood, crash or show nothing: each is left out with a line, and the models beside it go on."""

import gc
import json
import os
import signal
import time
from collections.abc import Callable
from pathlib import Path

import pytest
import trimesh

import roomkin.plugins.importing.sandbox as limits
from roomkin.plugins.importing.examine import read
from roomkin.plugins.importing.import_ import run
from roomkin.plugins.importing.imports import IMPORTERS, by_suffix, import_models, named_models
from roomkin.plugins.importing.sandbox import MEGABYTES, SIMPLER, run_in_fork
from roomkin.stages.contracts.errors import InputError
from tests.refusals import refused

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
    color = '<material name="m"><color rgba="1 0 0 0"/></material>'
    shape = '<geometry><box size="0.3 0.3 0.3"/></geometry>'
    (folder / "box/aa.urdf").write_text(
        f'<robot name="r"><link name="a"><visual>{shape}{color}</visual></link></robot>'
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
            run_in_fork(Path("a.obj"), work)  # type: ignore[arg-type]
        return error.value.what

    def hang() -> str:
        while True:
            pass

    def refuse() -> str:
        raise InputError("b.obj", "is bad.", "mend it", code="E-BAD")

    monkeypatch.setattr(limits, "SECONDS", 1)
    monkeypatch.setattr(limits, "MEGABYTES", 200)
    assert run_in_fork(Path("a.obj"), lambda: "ä" * 200_000) == "ä" * 200_000
    assert told(hang) == "takes more than 1 s to read."
    # More than any hole that earlier tests may have left in what this process has already.
    assert told(lambda: str(len(bytearray(4 * 2**30)))) == "takes more than 200 MB of memory to read."
    assert "SIGKILL" in told(lambda: str(os.kill(os.getpid(), signal.SIGKILL)))
    assert told(refuse) == "is bad."


def test_what_its_parent_left_to_be_collected_ends_in_no_fork(monkeypatch: pytest.MonkeyPatch) -> None:
    """Some of it waits for threads that a fork does not have."""
    monkeypatch.setattr(limits, "WAIT", 3)
    ours = os.getpid()

    class Waiting:
        def __init__(self) -> None:
            self.itself = self  # only the collector of cycles ends it

        def __del__(self) -> None:
            time.sleep(0 if os.getpid() == ours else 60)

    gc.disable()
    try:
        Waiting()
        assert run_in_fork(Path("a.obj"), lambda: str(gc.collect() >= 0)) == "True"
    finally:
        gc.enable()


def test_a_mesh_that_takes_too_much_memory_is_told_with_a_fix(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """As one of 10 million faces does."""
    (tmp_path / "box").mkdir()
    (tmp_path / "box/huge.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")

    def fill(*args: object, **more: object) -> None:
        raise MemoryError

    monkeypatch.setattr(trimesh, "load_scene", fill)
    kinds = by_suffix(IMPORTERS)
    models = {"huge": next(iter(named_models([tmp_path], kinds).values()))}
    assert import_models(models, kinds, tmp_path / "out")[0] == []
    assert f"huge.obj: takes more than {MEGABYTES} MB of memory to read. Fix: {SIMPLER}\n" in capsys.readouterr().out


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


def notes_pipe(folder: Path) -> None:
    good(folder, "box/m/aa.glb")
    os.mkfifo(folder / "box/m/asset.json")


def meta_pipe(folder: Path) -> None:
    (folder / "123").mkdir()
    (folder / "123/mobility.urdf").write_text("<robot")
    os.mkfifo(folder / "123/meta.json")


def meta_deep(folder: Path) -> None:
    (folder / "123").mkdir()
    (folder / "123/mobility.urdf").write_text("<robot")
    (folder / "123/meta.json").write_text("[" * 200_000)


def sparse(folder: Path) -> None:
    with (folder / "box/aa.urdf").open("wb") as file:
        file.truncate(10**11)


def endless(folder: Path) -> None:
    (folder / "box/aa.urdf").symlink_to("/dev/zero")


def replicas(folder: Path) -> None:
    two = '<replicate count="2000"><replicate count="1500"><geom size=".1"/></replicate></replicate>'
    (folder / "box/aa.xml").write_text(f"<mujoco><worldbody>{two}</worldbody></mujoco>")


def attachments(folder: Path) -> None:
    """Every file attaches the next one twice."""
    (folder / "shelf").mkdir()
    twice = '<attach model="n" body="b" prefix="p_"/><attach model="n" body="b" prefix="q_"/>'
    for number in range(30):
        named = f'<asset><model name="n" file="{number + 1}.txt"/></asset>'
        body = f'<body name="b"><geom size=".1"/>{twice if number < 29 else ""}</body>'
        text = f"<mujoco>{named if number < 29 else ''}<worldbody>{body}</worldbody></mujoco>"
        (folder / "shelf" / (f"{number}.txt" if number else "aa.xml")).write_text(text)


def circle(folder: Path) -> None:
    named = '<asset><model name="n" file="aa.xml"/></asset>'
    body = '<body name="b"><geom size=".1"/><attach model="n" body="b" prefix="p_"/></body>'
    (folder / "box/aa.xml").write_text(f"<mujoco>{named}<worldbody>{body}</worldbody></mujoco>")


def shapes(folder: Path) -> None:
    box = '<visual><geometry><box size=".1 .1 .1"/></geometry></visual>'
    (folder / "box/aa.urdf").write_text(f'<robot name="r"><link name="a">{box * 200_000}</link></robot>')


def geoms(folder: Path) -> None:
    text = '<geom size=".1"/>' * 200_000
    (folder / "box/aa.xml").write_text(f"<mujoco><worldbody>{text}</worldbody></mujoco>")


def nodes(folder: Path) -> None:
    trimesh.creation.box().export(folder / "box/aa.gltf")
    told = json.loads((folder / "box/aa.gltf").read_text())
    told["nodes"] = [{"mesh": 0} for _ in range(200_000)]
    told["scenes"] = [{"nodes": list(range(200_000))}]
    (folder / "box/aa.gltf").write_text(json.dumps(told))


def folders_in_circles(folder: Path) -> None:
    good(folder, "model/box.glb")
    for name in ("model/model", "model/obj", "model/mesh"):
        (folder / name).symlink_to("..")


HELD: dict[Callable[[Path], None], str] = {
    notes_pipe: "asset.json: is no file that can be read",
    meta_pipe: "is not XML",
    meta_deep: "is not XML",
    sparse: "MB of memory",
    endless: "",
    replicas: "has 3002003 elements once all is included, attached and replicated",
    attachments: "elements once all is included",
    circle: "includes or attaches aa.xml",
    shapes: "has 200000 shapes",
    geoms: "has 200002 elements",
    nodes: "has 200000 nodes",
    folders_in_circles: "",
}


@pytest.mark.parametrize("write", HELD, ids=lambda write: write.__name__)
def test_what_would_hold_an_import_is_named_in_seconds(tmp_path: Path, write: Callable[[Path], None]) -> None:
    good(tmp_path / "theirs")
    write(tmp_path / "theirs")
    began = time.monotonic()
    kinds = by_suffix(IMPORTERS)
    left_out = []
    for found in named_models([tmp_path / "theirs"], kinds).values():
        try:
            read(found, kinds[found.path.suffix], tmp_path / "out" / found.name)
        except InputError as error:
            left_out.append(str(error))
    assert time.monotonic() - began < 60
    assert (tmp_path / "out/zz/model.urdf").is_file()
    assert len(left_out) == bool(HELD[write]) and HELD[write] in "".join(left_out)
    assert all(str(tmp_path / "theirs") in line for line in left_out)


def test_what_waits_for_ever_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(limits, "WAIT", 0.5)
    with refused("E-MODEL-TIME", "a.obj: takes more than 0.5 s to read"):
        run_in_fork(Path("a.obj"), lambda: str(time.sleep(60)))


def test_names_of_files_steer_no_terminal(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    theirs = tmp_path / "theirs"
    for name in ("\x1b]0;pwned\x07\x1b[31mred", "two\nlines", "\u202eback", "\x9b2J"):
        (theirs / "box").mkdir(parents=True, exist_ok=True)
        (theirs / f"box/{name}.obj").write_text("nothing")
        (theirs / f"box/{name}.glb").symlink_to("nowhere")
    with pytest.raises(InputError) as caught:
        run(theirs, out=tmp_path / "mine")
    captured = capsys.readouterr()
    bars = (line for line in captured.err.splitlines() if "models read" not in line)
    lines = [*captured.out.splitlines(), *filter(None, bars), str(caught.value)]
    assert len(lines) == 4 + 4 + 2 and all(line.isprintable() for line in lines), lines
    assert any("\\x1b]0;pwned\\x07\\x1b[31mred.obj: not used" in line for line in lines)
    assert any("box/two\\nlines.glb: is a link to nothing" in line for line in lines)
