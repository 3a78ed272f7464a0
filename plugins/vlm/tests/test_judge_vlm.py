"""The judge `vlm` in matching: what it shows, what it decides, and what happens where it does not decide."""

import json
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from roomkin.plugins.vlm.judges import vlm
from roomkin.plugins.vlm.package import keys
from roomkin.plugins.vlm.tests.chat_server import Handler, chooses, pictures, says, serving
from roomkin.stages.config.model import complete, load, read_files
from roomkin.stages.config.reads import options_of
from roomkin.stages.contracts import InputError
from roomkin.stages.contracts.cousins import ObjectCousins
from roomkin.stages.plugins import shorten_name
from tests.refusals import refused
from tests.unit.matching_data import SIZE, World
from tests.workflow.workspace import ROOT

BOTH = {"model_selection": "vlm", "orientation_selection": "vlm"}


@pytest.fixture(scope="module")
def world(tmp_path_factory: pytest.TempPathFactory) -> World:
    return World(tmp_path_factory.mktemp("judged"), least_candidates=1)


@pytest.fixture(autouse=True)
def _no_proxy(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("no_proxy", "127.0.0.1")


def judged(
    world: World, folder: Path, url: str, vlm: dict[str, Any] | None = None, seen: bool = True, **options: Any
) -> list[ObjectCousins]:
    """The objects that there are several models for: a cabinet with three, a shelf, a bowl with two."""
    given = {"url": url, "model": "toy", "key_env": "", "ledger": str(folder / "ledger")} | (vlm or {})
    snapshots = world.snapshots if seen else []
    return several(world.match(folder / "cousins.json", snapshots=snapshots, vlm=given, **options).objects)


def several(entries: list[ObjectCousins]) -> list[ObjectCousins]:
    return [entries[number] for number in (0, 2, 3)]


def texts(body: dict[str, Any]) -> str:
    return " ".join(part.get("text", "") for part in body["messages"][1]["content"])


def test_the_model_decides_on_what_table_2_says(world: World, tmp_path: Path) -> None:
    """(a), (c), (d): the second of the nearest models, the third of the nearest views; nothing else changes."""

    def second_or_third(handler: Handler, body: dict[str, Any]) -> None:
        chooses("3" if "one 3D model" in texts(body) else "2")(handler, body)

    plain = several(world.match(tmp_path / "plain.json").objects)
    with serving(second_or_third) as server:
        for variant, keys in (("a", {"orientation_selection"}), ("c", set(BOTH)), ("d", {"model_selection"})):
            options = {key: BOTH[key] for key in keys}
            for before, entry in zip(plain, judged(world, tmp_path, server.url, **options), strict=True):
                models = "model_selection" in keys
                assert entry.decided_by == ("vlm toy" if models else "distance"), variant
                near = [candidate.asset for candidate in entry.by_distance]
                assert [cousin.asset for cousin in entry.cousins] == ([near[1], near[0], *near[2:]] if models else near)
                assert entry.by_distance == before.by_distance and entry.note == before.note
                first = entry.cousins[0]
                views = next(cousin for cousin in before.cousins if cousin.asset == first.asset).orientations
                turned = "orientation_selection" in keys
                assert entry.orientation_decided_by == ("vlm toy" if turned else "distance")
                assert first.orientation == views[2 if turned else 0] and len(first.orientations) == 4
                assert entry.cousins[1].orientation == min(entry.cousins[1].orientations, key=lambda one: one.distance)
        assert len({body["messages"][0]["content"] for body in server.requests}) == 1


def test_it_is_shown_the_room_the_object_and_the_candidates(world: World, tmp_path: Path) -> None:
    with serving(chooses("1")) as server:
        first, *_ = judged(world, tmp_path, server.url, **BOTH)
        of_models, of_views = server.requests[:2]
    room, alone, *candidates = pictures(of_models)
    assert (room == (255, 0, 0)).all(-1).any() and room.shape[:2] == (64, 512) and alone.shape[0] < 128
    assert len(candidates) == len(first.by_distance) == 3 and len(pictures(of_views)) == 2 + 4
    sidecars = {path: json.loads(path.with_suffix(".json").read_text())["assets"] for path in world.snapshots}
    shard = {name: path for path, names in sidecars.items() for name in names}
    for picture, candidate in zip(candidates, first.by_distance, strict=True):
        path = shard[candidate.asset]
        position = sidecars[path].index(candidate.asset)
        with h5py.File(path) as file:
            assert picture.shape == (SIZE, SIZE, 3) and np.array_equal(picture, file["rgb"][position, -1])
    assert "labelled 'cabinet'" in texts(of_models) and "Candidate 3:" in texts(of_models)
    assert not any(name in texts(body) for name in shard for body in (of_models, of_views))  # names tell nothing away


@pytest.mark.parametrize(
    ("answer", "why"),
    [(chooses("none"), "vlm toy chooses none"), (chooses("9"), "choice: Input should be '1'")],
)
def test_where_it_abstains_distance_decides_and_the_file_says_so(
    world: World, tmp_path: Path, answer: Any, why: str
) -> None:
    plain = several(world.match(tmp_path / "plain.json").objects)
    with serving(answer) as server:
        for before, entry in zip(plain, judged(world, tmp_path, server.url, **BOTH), strict=True):
            assert entry.cousins == before.cousins
            assert entry.decided_by == entry.orientation_decided_by == "distance"
            assert "models from 1 on by distance: vlm toy" in entry.note and why in entry.note
            assert f"orientation of {entry.cousins[0].asset} by distance: vlm toy" in entry.note


def test_it_chooses_as_often_as_it_is_told(world: World, tmp_path: Path) -> None:
    with serving(chooses("3"), chooses("2"), chooses("none")) as server:
        first, *_ = judged(world, tmp_path, server.url, {"choices": 9}, model_selection="vlm")
        near = [candidate.asset for candidate in first.by_distance]
        assert [cousin.asset for cousin in first.cousins] == [near[2], near[1], near[0]]  # the last needs no asking
        assert len(pictures(server.requests[1])) == 4
        server.steps = [chooses("2"), chooses("none")]
        first, *_ = judged(world, tmp_path / "b", server.url, {"choices": 2}, model_selection="vlm")
        assert [cousin.asset for cousin in first.cousins] == [near[1], near[0], near[2]]
        assert first.decided_by == "vlm toy" and first.note == "models from 2 on by distance: vlm toy chooses none"


def test_a_scene_is_replayed_byte_for_byte(world: World, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with serving(chooses("2"), says("?"), says("?"), says("?"), chooses("3"), chooses("1")) as server:
        judged(world, tmp_path, server.url, **BOTH)
        asked = len(server.requests)
    first = (tmp_path / "cousins.json").read_bytes()
    judged(world, tmp_path, "http://127.0.0.1:9", {"mode": "replay", "key_env": "NO_SUCH_KEY"}, **BOTH)
    assert (tmp_path / "cousins.json").read_bytes() == first
    assert f"0 asked for; the ledger has {asked} requests" in capsys.readouterr().out
    with pytest.raises(InputError, match="lacks a call to other about test/cabinet_1: model"):
        judged(world, tmp_path, "http://127.0.0.1:9", {"mode": "replay", "model": "other"}, **BOTH)
    with refused("E-SNAPSHOTS-MISSING"):
        judged(world, tmp_path, "http://127.0.0.1:9", {"mode": "replay"}, seen=False, **BOTH)


def test_nothing_of_ours_counts_in_the_rows_of_the_paper() -> None:
    """The letter of the paper: in its own overlay, and in row (b) of the study."""
    paper, study = (
        read_files([ROOT / "config" / name]).matching_of("b") for name in ("paper/scenes.yaml", "study/table2.yaml")
    )
    ours = {name for name in type(paper).model_fields if name.endswith("_weight")} | {"symmetric", "colour", "views"}
    assert all(getattr(paper, name) == 0 for name in ours), ours
    assert (paper.nearest_views, paper.least_candidates, paper.count_threshold) == (1, 1, None)
    assert study == paper


def test_the_overlay_of_the_paper_has_its_variants() -> None:
    loaded = read_files([ROOT / "config/paper" / name for name in ("scenes.yaml", "judged.yaml")])
    variants = {name: loaded.matching_of(name) for name in "abcd"}
    judges = {
        name: (shorten_name(options.model_selection), shorten_name(options.orientation_selection))
        for name, options in variants.items()
    }
    near, again, model = "distance", "rerender", "vlm"
    assert judges == {"a": (near, model), "b": (near, again), "c": (model, model), "d": (model, again)}


@pytest.mark.parametrize(("captions", "read"), [("labels", False), ("vlm", True)])
def test_the_language_model_is_read_where_it_is_asked(captions: str, read: bool) -> None:
    Config = complete()
    config = Config.model_validate({"perception": {"captions": captions}, "vlm": {"model": "toy"}})
    assert ("toy" in repr(options_of(config, "perception", "see", {}))) == read
    assert "toy" not in repr(options_of(config, "matching", "match", {"variant": "default"}))
    judged = Config.model_validate({"matching": {"model_selection": "vlm"}, "vlm": {"model": "toy"}})
    assert "toy" in repr(options_of(judged, "matching", "match", {"variant": "default"}))
    other = {"variants": {"default": {"vlm": {"model": "other"}}}}
    judged = Config.model_validate({"matching": {"model_selection": "vlm"}, "experiment": other})
    assert options_of(judged, "matching", "match", {"variant": "default"})["vlm"]["model"] == "other"


def test_a_key_is_asked_for_where_pictures_are_captioned(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("a.png", "d.png", "k.json"):
        (tmp_path / name).touch()

    def ask(rooms: list[str], captions: str = "vlm") -> list[str] | None:
        frame = {"image": "a.png", "depth": "d.png", "camera": "k.json"}
        experiment = {"inputs": {"frame": frame}, "rooms": rooms}
        return keys(load({"experiment": experiment, "perception": {"captions": captions}}))

    assert ask(["room_1", "room_2", "room_3", "frame"]) == ["OPENAI_API_KEY"]
    assert (
        ask(["room_1", "room_2", "room_3"]) is None and ask(["room_1", "room_2", "room_3", "frame"], "labels") is None
    )


def test_without_a_key_the_stand_in_answers_and_everything_says_so(
    world: World, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The stand-in here: distance reversed, so that the last of the nearest is chosen; the ledger replays it."""

    class Last:
        def __init__(self, options: Any) -> None: ...

        def models(self, question: Any, by_votes: Any, by_distance: Any) -> Any:
            return by_distance[::-1]

        def orientations(self, question: Any, asset: str, by_votes: Any, by_distance: Any) -> Any:
            return by_distance[::-1]

    monkeypatch.setattr(vlm, "load", lambda *_: Last)
    monkeypatch.delenv("NO_KEY", raising=False)
    asked = {"key_env": "NO_KEY", "stand_in": "last"}
    plain = several(world.match(tmp_path / "plain.json").objects)
    found = judged(world, tmp_path, "http://127.0.0.1:9", asked, **BOTH)
    assert "last, no language model: 0 answers from the ledger" in capsys.readouterr().out
    for before, after in zip(plain, found, strict=True):
        assert {after.decided_by, after.orientation_decided_by} == {"last, no language model"}
        first = after.cousins[0]
        assert first.asset == before.by_distance[-1].asset
        for views in [cousin.orientations for cousin in before.cousins if cousin.asset == first.asset]:
            assert first.orientation == views[-1]
    entries = [json.loads(path.read_text()) for path in (tmp_path / "ledger").glob("*.json")]
    assert entries and {entry["model"] for entry in entries} == {"last, no language model"}
    assert not any(entry["exchanges"] or entry["cost"] for entry in entries)
    again = judged(world, tmp_path, "http://127.0.0.1:9", asked | {"mode": "replay"}, **BOTH)
    assert again == found
    monkeypatch.setenv("NO_KEY", "sk-test")
    for key in ("NO_KEY", ""):  # a server that wants no key is asked, too
        with serving(chooses("1")) as server:
            with_key = judged(world, tmp_path, server.url, asked | {"key_env": key}, **BOTH)
        assert {entry.decided_by for entry in with_key} == {"vlm toy"}


def test_the_stand_in_reads_its_options() -> None:
    study = read_files([ROOT / "config/study/table2.yaml"])
    assert {"geometry", "vlm"} <= set(options_of(study, "matching", "match", {"variant": "a"}))
    assert "geometry" not in options_of(study, "matching", "match", {"variant": "b"})
