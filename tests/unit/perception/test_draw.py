"""The command: one photograph without depth as a drawing and an input folder."""

import os
from pathlib import Path
from threading import Thread
from typing import Any

import numpy as np
import pytest
from PIL import Image

from roomkin.plugins.annotator.kept import OutdatedError
from roomkin.plugins.annotator.session import Session
from roomkin.stages.config.model import load, with_defaults
from roomkin.stages.config.perception import DrawOptions
from roomkin.stages.contracts import Camera, InputError, read_json, write_json
from roomkin.stages.contracts.doubt import DoubtKind
from roomkin.stages.contracts.files import digest_of
from roomkin.stages.contracts.hand import PROJECT, digest_of_picture
from roomkin.stages.contracts.images import read_rgb
from roomkin.stages.contracts.scene_input import read_scene_input
from roomkin.stages.contracts.things import read_things
from roomkin.stages.geometry.masks import polygons
from roomkin.stages.perception import draw
from roomkin.stages.perception.drawing.project import Project
from roomkin.stages.perception.drawing.write import finish_drawing, write_folder
from roomkin.stages.perception.read.photo import read_photo
from tests.refusals import refused
from tests.unit.perception.room_alone import LABELS, WIDTH, outline_room, see_lines, show_room
from tests.unit.perception.test_naming import known

DATA = Path(os.environ.get("ACDC_TEST_DATA", Path(__file__).resolve().parents[4] / "shared/data"))


@pytest.fixture
def image(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A picture, of which networks see a fridge, a sofa and a coffee table."""
    masks = outline_room((1, 2, 3))
    monkeypatch.setattr(draw, "see_outlines", lambda *_: [known(masks == k, (LABELS[k], 0.9)) for k in (1, 2, 3)])
    monkeypatch.setattr(draw, "see_camera", lambda *_: see_lines())
    picture = show_room()
    picture[::2] += 60  # it shows something
    Image.fromarray(picture).save(tmp_path / "my room.png")
    return tmp_path / "my room.png"


def test_a_photograph_becomes_an_input_folder_and_a_drawing(image: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = image.with_suffix("")
    draw.run(image=image, out=out, options='{"heights": {"fridge": 1.8, "wardrobe": 2}}')
    told = capsys.readouterr().out
    assert "m above the floor" in told, "the scale is told: it has no spread"
    assert told.count("is found") == 1 and "perception.heights: no wardrobe is found" in told
    assert "3 things" in told and f"roomkin annotator annotate '{out}'\n" in told
    scene = read_scene_input(out)
    assert [item.label for item in scene.annotations.objects] == ["fridge", "sofa", "coffee table"]
    box = scene.annotations.objects[0].box
    assert box is not None and box.size[2] == pytest.approx(1.8, rel=0.02)
    assert scene.depth.shape[1] == WIDTH and (scene.depth[scene.masks > 0] > 0).mean() > 0.9
    assert all(item.unsure for item in read_json(Project, out / PROJECT).objects) and scene.camera.picture == "my room"
    assert scene.camera.digest == digest_of(image) == digest_of_picture(out)


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
    write_json(
        out / PROJECT, read_json(Project, out / PROJECT).model_copy(update={"digest": ""})
    )  # of an older version
    draw.run(image=image, out=out)
    assert read_json(Camera, out / "camera.json").digest == digest_of(image)
    Image.fromarray(np.array(Image.open(image))[:, :600]).save(image)
    with pytest.raises(InputError, match="holds another picture, 'my room': see rgb"):
        draw.run(image=image, out=out)


def test_what_a_person_saves_while_the_picture_is_looked_at_is_kept(
    image: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    out = image.with_suffix("")
    page, look = Session(read_photo(image), image.name, out), draw.draw_picture

    def look_slowly(*given: Any) -> draw.Drawn:
        drawn = look(*given)
        page.save(drawn.project.model_dump(mode="json") | {"objects": [drawn.project.objects[1].model_dump()]})
        return drawn

    monkeypatch.setattr(draw, "draw_picture", look_slowly)
    draw.run(image=image, out=out)
    told = capsys.readouterr().out
    assert f"{out / PROJECT}: drawn by a person: kept" in told and "3 things" not in told
    project = read_json(Project, out / PROJECT)
    assert [item.label for item in project.objects] == ["sofa"] and not project.untouched
    assert [item.label for item in read_scene_input(out).annotations.objects] == ["sofa"]


def test_a_save_at_the_moment_of_writing_is_refused_not_overwritten(
    image: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out, write, outcomes = image.with_suffix(""), draw.write_json, []
    page = Session(read_photo(image), image.name, out)

    def save() -> None:
        try:
            outcomes.append(page.save(page.start_drawing().model_dump(mode="json")))
        except OutdatedError as error:
            outcomes.append(str(error))

    thread = Thread(target=save)

    def write_slowly(path: Path, project: Project) -> None:
        thread.start()
        thread.join(0.3)  # it waits for the folder
        write(path, project)

    monkeypatch.setattr(draw, "write_json", write_slowly)
    draw.run(image=image, out=out)
    thread.join()
    (refusal,) = outcomes
    assert "is not saved" in refusal and len(read_json(Project, out / PROJECT).objects) == 3


@pytest.fixture
def unsure(image: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A picture whose sofa is nearly sure, and whose coffee table is not."""
    masks, shares = outline_room((1, 2, 3)), {1: 0.95, 2: 0.7, 3: 0.2}
    seen = [known(masks == k, (LABELS[k], share), ("bench", 0.1)) for k, share in shares.items()]
    monkeypatch.setattr(draw, "see_outlines", lambda *_: seen)
    monkeypatch.setattr(draw, "name_standing", lambda *_: ({}, set()))
    monkeypatch.setattr(draw, "name_others", lambda *_: {})
    return image


def test_what_has_no_sure_name_is_left_out_and_every_file_says_so(
    unsure: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    out = unsure.with_suffix("")
    monkeypatch.setattr(draw, "list_silent", lambda: ["no network of looks"])
    draw.run(image=unsure, out=out)
    told = capsys.readouterr().out
    assert "coffee table, 20 %: left out: no name is sure enough" in told and "no network of looks" in told
    project, things, scene = read_json(Project, out / PROJECT), read_things(out), read_scene_input(out)
    assert [item.label for item in project.objects] == ["fridge", "sofa"] and things is not None
    (guess,), (left,) = project.left_out, things.left_out
    assert guess.guess == left.guess == "coffee table, 20 %" and left.left_out == guess.left_out
    drawn = polygons(guess.outlines, scene.masks.shape)
    kept = scene.masks == left.mask
    assert not (kept & ~drawn).any() and 0.9 * drawn.sum() < kept.sum() < drawn.sum(), "all but the sofa's pixels"
    assert [one.name for one in guess.names] == ["coffee table", "bench"]
    assert "annotations.json does not name" not in capsys.readouterr().out


def test_a_name_that_is_not_sure_is_doubted_until_a_person_confirms_it(unsure: Path) -> None:
    out = unsure.with_suffix("")
    draw.run(image=unsure, out=out)
    fridge, sofa = read_scene_input(out).annotations.objects
    (doubt,) = [one for one in sofa.doubts if one.cause == "name"]
    assert doubt == DoubtKind.NAME.of(name="sofa", share=70, others="bench") and sofa.proposals == ["sofa", "bench"]
    assert not sofa.probabilities and not [one for one in fridge.doubts if one.cause == "name"]
    project = read_json(Project, out / PROJECT)
    project.objects[1].unsure = False
    write_folder(out, read_rgb(unsure), *finish_drawing(project, None))
    (_, sofa), things = read_scene_input(out).annotations.objects, read_things(out)
    assert not [one for one in sofa.doubts if one.cause == "name"] and things is not None
    assert [bool(thing.names) for thing in things.things] == [True, False, True], "nobody need ask what it is"


def test_what_is_wrong_with_a_box_is_told(image: Path, capsys: pytest.CaptureFixture[str]) -> None:
    draw.run(image=image, out=image.with_suffix(""), options='{"heights": {"camera": 15}}')
    told = capsys.readouterr().out
    assert "usual are" in told and "by networks alone" in told and "is found" not in told


def test_a_drawing_that_is_given_is_taken_and_needs_no_network(
    image: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    draw.run(image=image, out=image.with_suffix(""))
    project = read_json(Project, image.with_suffix("") / PROJECT)
    project.objects[0].label = "wardrobe"
    write_json(tmp_path / "mine.json", project)
    monkeypatch.setattr("roomkin.stages.config.weights.is_there", lambda *_: False)
    given = {"image": str(image), "drawing": str(tmp_path / "mine.json")}
    config: Any = load(with_defaults({"experiment": {"inputs": {"drawn": given}, "rooms": ["drawn"], "targets": None}}))
    assert config.experiment.drawn == ["drawn"] != config.experiment.photographs
    monkeypatch.setattr(draw, "see_outlines", None)
    draw.run(image=image, out=tmp_path / "out", drawing=tmp_path / "mine.json")
    assert read_scene_input(tmp_path / "out").annotations.objects[0].label == "wardrobe"
    assert "drawn by a person: kept" not in capsys.readouterr().out
    project.width += 1
    write_json(tmp_path / "mine.json", project)
    with pytest.raises(InputError, match="is of a picture of"):
        draw.run(image=image, out=tmp_path / "out", drawing=tmp_path / "mine.json")


def test_a_picture_of_nothing_known_is_refused(image: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(draw, "see_outlines", lambda *_: [])
    with pytest.raises(InputError, match="no thing that is known"):
        draw.run(image=image, out=image.with_suffix(""))
    assert not image.with_suffix("").exists()


def test_heights_are_metres_and_weights_are_asked_for(monkeypatch: pytest.MonkeyPatch, image: Path) -> None:
    monkeypatch.setattr("roomkin.stages.config.weights.is_there", lambda *_: True)
    given = {"image": str(image), "perception": {"by": "lines", "heights": {"fridge": 180}}}
    with pytest.raises(InputError, match="fridge: is 180"):
        load(with_defaults(given))
    given["perception"]["heights"]["fridge"] = 1.8
    load(with_defaults(given))
    monkeypatch.setattr("roomkin.stages.config.weights.is_there", lambda *_: False)
    with refused("E-CONFIG-FILE", "image", "make weights"):
        load(with_defaults(given))


@pytest.mark.usefixtures("published")
@pytest.mark.skipif(not (DATA / "rooms/living").is_dir(), reason=f"no real frame in {DATA}")
def test_a_real_living_room_has_its_sofa_before_its_wall(tmp_path: Path) -> None:
    rgb = np.array(Image.open(DATA / "rooms/living/color.png").convert("RGB"))
    drawn = draw.draw_picture("color.png", rgb, None, DrawOptions())
    labels = {item.id: item.label for item in drawn.project.objects}
    assert "sofa" in labels.values() and "picture" in labels.values() and drawn.project.walls
    assert drawn.room.view.above == pytest.approx(1.43, rel=0.25)  # by its depth, which nobody read
