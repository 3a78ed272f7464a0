"""The command: one photograph without depth as a drawing and an input folder."""

import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from plugins.annotator.project import PROJECT, Project
from plugins.annotator.session import Session
from plugins.inputs.photo.picture import read_photo
from plugins.single_view import draw
from plugins.single_view.package import find_mistakes
from plugins.single_view.tests.room import LABELS, WIDTH, build_once, outline_room, see_lines, show_room
from plugins.single_view.tests.test_naming import known
from stages.config.model import load, with_defaults
from stages.contracts import Camera, InputError, read_json, write_json
from stages.contracts.scene_input import read_scene_input

DATA = Path(os.environ.get("ACDC_TEST_DATA", Path(__file__).resolve().parents[4] / "shared/data"))


@pytest.fixture
def image(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A picture, of which networks see a fridge, a sofa and a coffee table."""
    masks = outline_room((1, 2, 3))
    monkeypatch.setattr(draw, "see_outlines", lambda _: [known(masks == k, (LABELS[k], 0.9)) for k in (1, 2, 3)])
    monkeypatch.setattr(draw, "see_camera", lambda *_: see_lines())
    monkeypatch.setattr(draw, "build_room", build_once)
    picture = show_room()
    picture[::2] += 60  # it shows something
    Image.fromarray(picture).save(tmp_path / "room.png")
    return tmp_path / "room.png"


def test_a_photograph_becomes_an_input_folder_and_a_drawing(image: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = image.with_suffix("")
    draw.run(image=image, out=out, options='{"heights": {"fridge": 1.8, "wardrobe": 2}}')
    told = capsys.readouterr().out
    assert "m above the floor" in told, "the scale is told: it has no spread"
    assert "3 things" in told and "no wardrobe is found" in told and f"annotate {image} --out {out}" in told
    scene = read_scene_input(out)
    assert [item.label for item in scene.annotations.objects] == ["fridge", "sofa", "coffee table"]
    box = scene.annotations.objects[0].box
    assert box is not None and box.size[2] == pytest.approx(1.8, rel=0.02)
    assert scene.depth.shape[1] == WIDTH and (scene.depth[scene.masks > 0] > 0).mean() > 0.9
    assert all(item.unsure for item in read_json(Project, out / PROJECT).objects)


def test_what_a_person_saved_is_kept_also_if_nothing_in_it_is_confirmed(
    image: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = image.with_suffix("")
    draw.run(image=image, out=out)
    capsys.readouterr()
    draw.run(image=image, out=out)
    told = capsys.readouterr().out
    assert "3 things" in told, "what nobody saved is drawn anew"
    session, note = Session(read_photo(image), image.name, out), read_json(Camera, out / "camera.json").note
    assert note in told and session.start()["notes"] == [note] and note.count("(± ") == 3
    project = read_json(Project, out / PROJECT)
    del project.objects[0]
    session.save(project.model_dump(mode="json"))
    assert session.start()["notes"] == [], "a person has drawn since"
    draw.run(image=image, out=out)
    assert "kept" in capsys.readouterr().out and read_json(Camera, out / "camera.json").note == ""
    assert [item.label for item in read_scene_input(out).annotations.objects] == ["sofa", "coffee table"]
    Image.fromarray(np.array(Image.open(image))[:, :600]).save(image)
    with pytest.raises(InputError, match="is of a picture of 640x480"):
        draw.run(image=image, out=out)


def test_what_is_wrong_with_a_box_is_told(image: Path, capsys: pytest.CaptureFixture[str]) -> None:
    draw.run(image=image, out=image.with_suffix(""), options='{"heights": {"camera": 15}}')
    told = capsys.readouterr().out
    assert "usual are" in told and "by networks alone" in told


def test_a_drawing_that_is_given_is_taken_and_needs_no_network(
    image: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    draw.run(image=image, out=image.with_suffix(""))
    project = read_json(Project, image.with_suffix("") / PROJECT)
    project.objects[0].label = "wardrobe"
    write_json(tmp_path / "mine.json", project)
    monkeypatch.setattr("plugins.single_view.package.is_there", lambda _: False)
    given = {"image": str(image), "drawing": str(tmp_path / "mine.json")}
    config: Any = load(with_defaults({"experiment": {"inputs": {"drawn": given}, "rooms": ["drawn"], "targets": None}}))
    assert list(find_mistakes(config)) == [] and config.experiment.drawn == ["drawn"] != config.experiment.photographs
    monkeypatch.setattr(draw, "see_outlines", None)
    draw.run(image=image, out=tmp_path / "out", drawing=tmp_path / "mine.json")
    assert read_scene_input(tmp_path / "out").annotations.objects[0].label == "wardrobe"
    project.width += 1
    write_json(tmp_path / "mine.json", project)
    with pytest.raises(InputError, match="is of a picture of"):
        draw.run(image=image, out=tmp_path / "out", drawing=tmp_path / "mine.json")


def test_a_picture_of_nothing_known_is_refused(image: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(draw, "see_outlines", lambda _: [])
    with pytest.raises(InputError, match="no thing that is known"):
        draw.run(image=image, out=image.with_suffix(""))
    assert not image.with_suffix("").exists()


def test_heights_are_metres_and_weights_are_asked_for(monkeypatch: pytest.MonkeyPatch, image: Path) -> None:
    monkeypatch.setattr("plugins.single_view.package.is_there", lambda _: True)
    given = {"image": str(image), "photo": {"by": "lines"}, "single_view": {"heights": {"fridge": 180}}}
    with pytest.raises(InputError, match="fridge: is 180"):
        load(with_defaults(given))
    config: Any = load(with_defaults(given | {"single_view": {"heights": {"fridge": 1.8}}}))
    assert list(find_mistakes(config)) == []
    monkeypatch.setattr("plugins.single_view.package.is_there", lambda _: False)
    (lacking,) = find_mistakes(config)
    assert lacking.key == "image" and "make weights" in str(lacking)


@pytest.mark.usefixtures("published")
@pytest.mark.skipif(not (DATA / "rooms/living").is_dir(), reason=f"no real frame in {DATA}")
def test_a_real_living_room_has_its_sofa_before_its_wall(tmp_path: Path) -> None:
    drawn = draw.draw_picture("color.png", np.array(Image.open(DATA / "rooms/living/color.png").convert("RGB")))
    labels = {item.id: item.label for item in drawn.project.objects}
    assert "sofa" in labels.values() and "picture" in labels.values() and drawn.project.walls
    assert drawn.room.view.above == pytest.approx(1.43, rel=0.25)  # by its depth, which nobody read
