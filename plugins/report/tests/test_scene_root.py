"""The top of a scene's page: ground, walls, what was left out, what corrections lost, and the gravest doubts."""

import os
import re
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from roomkin.plugins.report.page.rooms import RebuiltScene
from roomkin.plugins.report.page.single import doubt_camera, doubt_physics
from roomkin.plugins.report.tests.test_report_browser import browser  # noqa: F401
from roomkin.plugins.report.tests.test_scene_page import page
from roomkin.stages.contracts import Camera, Objects, read_json, write_json
from roomkin.stages.contracts.doubt import Doubt, DoubtKind
from roomkin.stages.contracts.generated import GeneratedScene, Plausibility
from roomkin.stages.contracts.hand import PROJECT
from roomkin.stages.contracts.objects import Box, Mounting
from roomkin.stages.contracts.things import THINGS, Ground, Name, Thing, Things
from tests.unit.tables_results import CAMERA, write_run

SURFACE = "a level surface below which 0.3 % of the points lie"


@pytest.fixture
def root(tmp_path: Path) -> Path:
    """A run whose room_1 has a thing that was left out, and a correction that lost its pixels."""
    write_run(tmp_path)
    write_json(tmp_path / "camera.json", Camera(width=240, height=160, intrinsics=CAMERA))
    folder = tmp_path / "results/scenes/room_1/input"
    masks = np.zeros((160, 240), np.uint16)
    masks[60:120, 150:210], masks[10:30, 10:30] = 77, 78
    cv2.imwrite(str(folder / "masks.png"), masks)
    left = [
        Thing(mask=mask, names=[Name(name=name, probability=0.41)], other=0.3, score=0.8, source="ssd", left_out=why)
        for mask, name, why in ((77, "armchair", "no name is sure"), (78, "clock", "it is 1.2 m wide"))
    ]
    height = read_json(Objects, tmp_path / "results/extraction/room_1/objects.json").floor_from_camera[2][3]
    ground = Ground(camera_height=height, taken_from=SURFACE, share=0.012)
    write_json(folder / THINGS, Things(ground=ground, walls=1, things=left))
    write_json(folder / "corrections.json", {"version": 1, "objects": [{"mask": 78, "label": "clock"}]})
    path = tmp_path / "results/extraction/room_1/objects.json"
    lost = {"lost": ["box: no pixel shows it, left out"]}
    write_json(path, read_json(Objects, path).model_copy(update=lost))
    return tmp_path


def _section(path: Path) -> str:
    text = path.read_text()
    return text[text.index('<section id="doubts">') : text.index('<section id="found">')]


def test_it_says_the_root_before_the_doubts(root: Path) -> None:
    page(root, "room_1", root / "page.html")
    said = _section(root / "page.html")
    assert f"m above the ground, which was taken from {SURFACE} (1.2 % of the picture)" in said
    assert re.search(r"\d things were found, 1 left out", said) and re.search(r"walls? (was|were) found|No wall", said)
    assert "<b>armchair, 41 %</b>: no name is sure" in said and "clock" not in said, "a person has taken it"
    folder = root / "results/scenes/room_1/input"
    assert f"<code>roomkin annotator annotate {folder} --scene room_1 --variant default</code>" in said
    assert said.count("<polygon") == 1
    assert "box: no pixel shows it, left out" in said
    assert said.index("above the ground") < said.index('class="doubt"')


def test_where_a_fit_moved_the_floor_both_heights_are_said(root: Path) -> None:
    path = root / "results/scenes/room_1/input" / THINGS
    things = read_json(Things, path)
    assert things.ground is not None
    lower = things.ground.model_copy(update={"camera_height": things.ground.camera_height - 0.015})
    write_json(path, things.model_copy(update={"ground": lower}))
    page(root, "room_1", root / "page.html")
    assert f"({lower.camera_height:.2f} m before the floor was fitted), which was taken" in _section(root / "page.html")


def test_without_what_networks_found_it_says_what_is_known(root: Path) -> None:
    (root / "results/scenes/room_1/input" / THINGS).unlink()
    page(root, "room_1", root / "page.html")
    said = _section(root / "page.html")
    assert "m above the ground." in said and "nothing left out" in said and "<svg" not in said


def test_a_ground_that_a_person_put_elsewhere_is_not_the_one_that_geometry_found(root: Path) -> None:
    ground = Ground(camera_height=0.99, taken_from="table tops", share=0.3)
    write_json(root / "results/scenes/room_1/input" / THINGS, Things(ground=ground, walls=1, things=[]))
    page(root, "room_1", root / "page.html")
    said = _section(root / "page.html")
    assert "it is not table tops (30.0 % of the picture), which is 0.99 m below" in said


def _doubt(root: Path, doubts: dict[str, list[Doubt]]) -> str:
    """The section where every thing has few points and another mounting, and some are doubted besides, by id."""
    path = root / "results/extraction/room_1/objects.json"
    objects = read_json(Objects, path)
    items = [
        item.model_copy(update={"points": 4, "measured_mounting": Mounting(type=1), "doubts": doubts.get(item.id, [])})
        if item.status == "ok"
        else item
        for item in objects.objects
    ]
    write_json(path, objects.model_copy(update={"objects": items}))
    page(root, "room_1", root / "page.html")
    return _section(root / "page.html")


def test_five_doubts_are_shown_the_others_folded(root: Path) -> None:
    said = _doubt(root, {})
    shown, folded, *_ = re.split(r'<details class="story"><summary>\d+ more', said)
    (all_,), more = (
        re.findall(r"(\d+) doubts about \d+ things", said),
        re.findall(r"<summary>(\d+) more doubts?<", said),
    )
    assert int(all_) == 5 + int(more[0]) == 5 + folded.partition("</details>\n<details")[0].count('class="doubt"')
    assert shown.count('class="doubt"') == 5


def test_doubts_come_by_their_chance_times_the_size_of_the_thing(root: Path) -> None:
    path = root / "results/generation/default/room_1/scene_1.json"
    scene = read_json(GeneratedScene, path)
    sizes = {"bowl_1": (0.2, 0.2, 0.1)}
    placed = [one.model_copy(update={"size": sizes.get(one.id, one.size)}) for one in scene.objects]
    write_json(path, scene.model_copy(update={"objects": placed}))
    named = DoubtKind.NAME.of(name="cabinet", share=70, others="wardrobe")
    said = _doubt(root, {"cabinet_1": [named], "bowl_1": [DoubtKind.PLACE_UNSURE.of(share=20)]})
    of_cabinet, of_bowl = said.index("called cabinet by looks"), said.index("right to 5 cm with a chance of 20 %")
    assert said.index("<b>cabinet 1</b>: only 4 points") < of_cabinet < of_bowl


def test_scenes_that_do_not_stay_are_said_once_with_which_thing_and_why() -> None:
    def scene(rank: int, wrong: str) -> RebuiltScene:
        check = Plausibility.model_construct(fallen=[wrong] if wrong else [], how={}, collisions=0)
        return RebuiltScene(GeneratedScene.model_construct(rank=rank, plausibility=check), None, [], 0)

    found = doubt_physics([scene(1, "desk_1"), scene(2, ""), scene(3, "desk_1"), scene(4, "x")])
    said = [(about, doubt.what) for about, doubt in found]
    assert said == [("scenes of rank 1, 3", "desk_1 has fallen"), ("scene of rank 4", "x has fallen")]


def test_the_surest_of_what_is_left_out_comes_first_and_the_unlikely_is_folded(root: Path) -> None:
    folder = root / "results/scenes/room_1/input"
    masks = np.zeros((160, 240), np.uint16)
    guesses = {31: ("cutlery", 0.01), 32: ("mug", 0.1), 33: ("sofa", 0.44)}
    for k, mask in enumerate(guesses):
        masks[10:30, 40 * k : 40 * k + 20] = mask
    cv2.imwrite(str(folder / "masks.png"), masks)
    left = [
        Thing(mask=mask, names=[Name(name=name, probability=share)], other=0, score=1, source="ssd", left_out="unsure")
        for mask, (name, share) in guesses.items()
    ]
    write_json(folder / THINGS, Things(walls=1, things=left))
    page(root, "room_1", root / "page.html")
    said = _section(root / "page.html")
    listed, folded = said.split("<summary>1 more, each less than 10 % sure</summary>")
    assert re.findall(r'<li id="left-out-\d+"><b>(.*?)</b>', listed) == ["sofa, 44 %", "mug, 10 %"]
    assert "<b>cutlery, 1 %</b>" in folded
    assert re.findall("<text.*?>(.*?)</text>", said) == ["sofa, 44 %?", "mug, 10 %?"]
    assert said.count("--scene room_1 --variant default</code>") == 1, "one page takes them all"


def test_what_a_person_said_of_what_is_not_found_is_listed(root: Path) -> None:
    said = {"version": 1, "objects": [{"mask": 999, "label": "piano", "nudge": [0.1, 0.0]}]}
    write_json(root / "hand/room_1/corrections.json", said)
    page(root, "room_1", root / "page.html")
    assert "piano (mask 999): it is not found now" in _section(root / "page.html")


def test_what_a_drawing_leaves_out_is_taken_on_the_page_that_draws(root: Path) -> None:
    folder = root / "results/scenes/room_1/input"
    (folder / PROJECT).touch()
    page(root, "room_1", root / "page.html")
    command = f"roomkin annotator annotate {folder}/rgb.png --out {folder}"
    assert f"<code>{command}</code>" in _section(root / "page.html")


def test_a_click_on_the_dashed_outline_leads_to_its_line(root: Path, browser: Any) -> None:  # noqa: F811
    path = root / "results/scenes/room_1/input" / THINGS
    things = read_json(Things, path)
    unlikely = [one.model_copy(update={"names": [Name(name="mug", probability=0.05)]}) for one in things.things]
    write_json(path, things.model_copy(update={"things": unlikely}))
    page(root, "room_1", root / "page.html")
    shown = browser.new_page()
    shown.goto((root / "page.html").as_uri())
    line = shown.locator("#left-out-77")
    assert not line.is_visible()
    shown.locator(".left-out polygon").click()
    line.wait_for(state="visible")
    if shots := os.environ.get("ACDC_SCREENSHOTS"):
        shown.screenshot(path=f"{shots}/scene_root.png", full_page=True)
    shown.close()


def test_doubts_about_depth_and_a_tilt_that_nobody_gave_come_first(root: Path) -> None:
    camera = read_json(Camera, root / "camera.json")
    path = root / "results/extraction/room_1/objects.json"
    unaligned = "depth in doubt: it fits if it is moved by +5 % of the width"
    write_json(root / "camera.json", camera.model_copy(update={"note": f"focal length of its file; {unaligned}"}))
    objects = read_json(Objects, path)
    page(root, "room_1", root / "page.html")
    said = _section(root / "page.html")
    assert said.count('class="doubt"') >= 1 and said.index("moved by +5 %") - said.index('class="doubt"') < 300
    assert "focal length of its file" not in said and "is tilted by" not in said
    down = [[0.0, -0.99, 0.14, 0.0], [-1.0, 0.0, 0.0, 0.0], [0.0, -0.14, -0.99, 1.1], [0.0, 0.0, 0.0, 1.0]]
    looking_down = objects.model_copy(update={"floor_from_camera": down, "objects": []})
    assert [one.what for one in doubt_camera(camera, looking_down)] == [
        "the camera is tilted by 82 degrees: is that so, or is depth wrong?"
    ]
    small = [
        item.model_copy(update={"label": "fridge", "box": Box(center=(2, 0, 0.2), size=(0.2, 0.2, 0.44), yaw=0)})
        for item in objects.objects
    ]
    (unit,) = doubt_camera(camera, objects.model_copy(update={"objects": small}))
    assert unit.what.endswith("--unit 256 if depth was read as mm, 0.256 if as m")
    assert doubt_camera(camera.model_copy(update={"floor_from_camera": down}), looking_down) == []
