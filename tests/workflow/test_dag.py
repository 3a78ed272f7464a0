"""Dry runs: every shipped config makes a DAG, every rule is declared as it should be, mistakes are explained."""

import json
import os
import re
import shlex
import subprocess
from itertools import pairwise
from pathlib import Path

import pytest
import yaml

from roomkin import demo
from roomkin.plugins.annotator.correcting import Correcting
from roomkin.plugins.annotator.tests.test_correcting import BOXES
from roomkin.plugins.ops.outside import list_key_variables, list_outside_paths
from roomkin.stages.config import reference
from roomkin.stages.config.files import ContainersConfig, tag
from roomkin.stages.config.inputs import INPUT_FILES
from roomkin.stages.config.model import complete, load, with_defaults
from roomkin.stages.config.packages import find_packages
from roomkin.stages.config.weights import DINOV2, LOOKING, is_there
from roomkin.stages.perception.write import write_config
from tests.commands import list_rule_files
from tests.unit.synthetic_room import write_room
from tests.workflow.workspace import ROOT, dry_run, make, plan, planned, put

STUDY = Path("config/study/table3.yaml")
BASES = {  # what these are laid over
    STUDY.with_name("roles.yaml"): STUDY,
    STUDY.with_name("object_cloud.yaml"): STUDY,
    STUDY.with_name("over_assets.yaml"): STUDY,
    STUDY.with_name("registered_addendum.yaml"): STUDY.with_name("registered.yaml"),
}
OVERLAYS = sorted(path.relative_to(ROOT) for path in (ROOT / "config").rglob("*.yaml") if not path.is_symlink())


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return make(tmp_path_factory.mktemp("dag"))


@pytest.mark.parametrize("overlay", [None, *OVERLAYS], ids=str)
def test_every_shipped_config_has_a_dag(folder: Path, overlay: Path | None) -> None:
    files = [path for path in (BASES.get(overlay), overlay) if path] if overlay else []
    if overlay and "\n  encoder: dinov2" in (ROOT / overlay).read_text() and not is_there(DINOV2):
        pytest.skip("no weights of DINOv2")
    done = plan(folder, "all", *(["--configfile", *map(str, files)] if files else []))
    assert done.returncode == 0 and planned(done.stdout)["all"] == 1, done.stdout


@pytest.mark.parametrize("name", find_packages())
def test_a_switch_of_a_package_is_a_switch(folder: Path, name: str) -> None:
    """A run without it is planned, rooms, pictures and pages; or lines say what wants it. No rule of it is left."""
    put(*(folder / file for file in ("color.png", "depth.png", "k.json")))
    frame = "inputs: {mine: {image: color.png, depth: depth.png, camera: k.json}}"
    text = f"packages: {{{name}: false}}\nexperiment: {{{frame}, rooms: [room_1, room_2, room_3, mine]}}"
    (folder / f"off_{name}.yaml").write_text(text)
    done = dry_run(folder, "all", "--configfile", f"off_{name}.yaml")
    if done.returncode:
        told = [line for line in done.stdout.splitlines() if "Fix: " in line]
        assert told and all(name in line for line in told), done.stdout
        assert "Exception" not in done.stdout and "Traceback" not in done.stdout, done.stdout
        return
    rules = "".join(file.read_text() for file in (ROOT / "plugins" / name).glob("*.smk"))
    assert not set(re.findall(r"^(?:rule|checkpoint) (\w+):", rules, re.M)) & set(planned(done.stdout)), done.stdout
    assert planned(done.stdout)["see"] == 1, done.stdout


def test_a_target_of_a_package_that_is_off_is_refused(folder: Path) -> None:
    (folder / "silent.yaml").write_text("packages: {report: false}")
    done = dry_run(folder, "overview", "--configfile", "silent.yaml")
    assert "error: overview: is a target of the package report, which is off" in done.stdout and done.returncode == 1
    put(folder / "color.png")
    frame = ("image=color.png", "depth=depth.png", "camera=k.json")
    done = dry_run(folder, "photo", "--configfile", "silent.yaml", "--config", *frame)
    assert planned(done.stdout)["photo"] == 1 and "scene_page" not in planned(done.stdout), done.stdout


def test_all_eight_rooms_can_be_asked_for(folder: Path) -> None:
    assert planned(dry_run(folder, "scenes8").stdout)["room"] == 8


def test_the_demonstration_makes_a_page(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    asked = list[str]()
    monkeypatch.setattr(demo, "run_snakemake", lambda _, *words: asked.extend(words))
    demo.run()
    assert asked[:2] == ["--directory", "demo"]
    done = dry_run(folder, *asked[2:])
    assert "results/report/scenes/room_1.html" in done.stdout, done.stdout
    jobs = planned(done.stdout)
    assert {"match", "generate", "draw_scenes", "scene_page"} <= set(jobs) and not {"train", "demonstrate"} & set(jobs)


def test_rooms_that_are_not_ours_are_a_target(tmp_path: Path) -> None:
    folder = make(tmp_path / "clone")
    (folder / "benchmarks").symlink_to(ROOT / "benchmarks")
    jobs = planned(dry_run(folder, "open_rooms").stdout)
    assert jobs["open_picture"] == 71 and jobs["open_room"] == 3 * 71 and jobs["open_rooms"] == 1


def test_a_task_may_have_targets_with_options_of_their_own(folder: Path) -> None:
    text = """
  targets:
    far: {task: door, options: {base_xy: 0.01}, episodes: 8}
    drawer: {room: room_2, object: chest_of_drawers_1}
  policies:
    lite: {targets: [door]}
    lite_handle: null
    lite_far: {configs: [lite], targets: [far], training_sets: [cousins_2, all], seeds: [0, 1, 2]}
    lite_drawer: {configs: [lite], targets: [drawer], training_sets: [twin]}
"""
    (folder / "targets.yaml").write_text(f"experiment:\n  training_sets: [twin, cousins_2]\n  seeds: [0]{text}")
    done = dry_run(folder, "evaluation", "-p", "--configfile", "targets.yaml")
    jobs = planned(done.stdout)
    assert jobs["select"] == 3 and jobs["demonstrate"] == 3 + 3 + 1, done.stdout
    assert jobs["train"] == jobs["rollout"] == 2 + 2 * 3 + 1
    collected = re.search(r"demonstrations collect .*/far/assets.json .*--role all .*", done.stdout)
    assert collected and "--episodes 8 " in collected[0] and '"base_xy":0.01' in collected[0]
    assert re.search(r"--task door .*--out results/experiment/default/far/assets.json", done.stdout)
    named = r"--target far --policy-name lite_far --training-set (\w+) --run-name lite --trained-roles (.*?) --options"
    assert set(re.findall(named, done.stdout)) == {("cousins_2", "cousin_1 cousin_3"), ("all", "all")}
    assert jobs["skill"] == 3 and re.search(r'scripted skill .*--target far .*"base_xy":0.01', done.stdout)


def test_the_policies_of_a_target_share_its_assets_and_demonstrations(folder: Path) -> None:
    sets = "[cousins_2_randomised, random_2, twin_randomised]"
    policies = f"{{lite_handle: null, flag: {{configs: [lite], training_sets: {sets}, seeds: [5, 6]}}}}"
    (folder / "shared.yaml").write_text(
        f"experiment: {{training_sets: [twin], seeds: [0], episodes: 8, policies: {policies}}}"
    )
    done = dry_run(folder, "all", "-p", "--configfile", "shared.yaml")
    jobs = planned(done.stdout)
    assert done.returncode == 0, done.stdout
    assert jobs["select"] == jobs["skill"] == jobs["demonstrate_in_scene"] == 1
    assert jobs["demonstrate"] == 1 + 2 + 2 * 2 + 1 and jobs["train"] == jobs["rollout"] == 1 + 2 * 3
    for seed, numbers in ((5, (1, 2)), (6, (17, 18))):  # each learns from a draw of its own
        ours = rf".*--out results/training/door/flag/random_2/lite/seed_{seed}"
        trained = re.search(rf"training train --episodes (\S+) (\S+) --per-store 4 {ours}", done.stdout)
        assert trained and list(trained.groups()) == [
            f"results/demonstrations/door/random_{number}/episodes.h5" for number in numbers
        ]
        roles = " ".join(f"random_{number}" for number in numbers)
        assert re.search(f"--trained-roles {roles} .*/door/flag/random_2/lite/seed_{seed}/", done.stdout)
    assert re.search(r'collect .*--role cousin_1_randomised .*--options .*"randomise"', done.stdout)
    rolled = re.findall(r"--assets (\S+) .*--target door --policy-name flag --training-set (\w+) ", done.stdout)
    assert set(rolled) == {
        ("results/experiment/default/door/assets.json", name)
        for name in ("cousins_2_randomised", "random_2", "twin_randomised")
    }
    exported = planned(dry_run(folder, "exports", "--configfile", "shared.yaml").stdout)
    assert exported["export_demonstrations"] == 3 * 4 and exported["export_policy"] == 7


def test_an_unknown_key_ends_the_plan_in_a_line(folder: Path) -> None:
    (folder / "old.yaml").write_text("experiment: {tasks: {door: {scene: room_3}}}")
    done = dry_run(folder, "all", "--configfile", "old.yaml")
    (line,) = (line for line in done.stdout.splitlines() if "experiment.tasks" in line)
    assert "unknown key. Fix: did you mean 'targets'?" in line and done.returncode


# Not asked for by name: what the library is made of and looks like.
MATERIAL = {"procedural", "library", "snapshots", "draw_snapshots", "features", "distances", "viewer"}


def test_what_a_failed_job_left_out_is_made_the_next_time(folder: Path) -> None:
    """Snakemake takes a file that is missing between made ones for needless, unless it is asked for by name."""
    said = plan(folder, "all").stdout
    jobs = re.findall(r"^ *(?:local)?rule (\w+):\n *input: (.*)\n(?: *output: (.*)\n)?", said, re.MULTILINE)
    (asked,) = [given.split(", ") for name, given, _ in jobs if name == "all"]
    left = {name for name, _, made in jobs if made and not set(made.split(", ")) & set(asked)}
    found = {name for name, *_ in jobs} - left
    assert found >= {"room", "extract", "match", "generate", "select", "demonstrate", "demonstrate_in_scene"}
    assert found >= {"train", "skill", "rollout", "merge", "score", "table3"} and left <= MATERIAL, left


def test_two_policies_are_trained_on_the_same_and_both_are_shown(folder: Path) -> None:
    (folder / "two.yaml").write_text("experiment: {seeds: [0, 1], training_sets: [twin]}")
    done = dry_run(folder, "all", "-p", "--configfile", "config/swaps/diffusion.yaml", "two.yaml")
    jobs = planned(done.stdout)
    assert done.returncode == 0 and jobs["train"] == jobs["rollout"] == 3 * 2 and jobs["demonstrate"] == 1, done.stdout
    (page,) = re.findall(r"roomkin.plugins.report report --files (.*)", done.stdout)
    shown = re.findall(r"results/training/(\S+)/metrics.jsonl", page)
    assert shown == [f"door/{name}/twin/{name}/seed_0" for name in ("lite", "lite_handle", "diffusion")]
    exported = dry_run(folder, "exports", "-p", "--configfile", "config/swaps/diffusion.yaml", "two.yaml").stdout
    assert set(re.findall(r"roomkin.plugins.exports policy --policy \S+/(\w+)/seed_", exported)) == {
        "lite",
        "lite_handle",
    }


def test_the_study_is_the_protocol_of_the_paper(folder: Path) -> None:
    study = ("--configfile", "config/study/table3.yaml")
    jobs = planned(dry_run(folder, "evaluation", *study).stdout)
    sets, candidates = {"door": 7, "drawer": 7}, 3
    assert jobs["choose"] == sum(sets.values())
    # Whole object, bowl, by the handle, without a cloud: training sets x seeds, and nothing to choose from.
    more = 2 * 3 + 2 * 5 + 2 * 7 * 3 + 2 * 3
    assert jobs["train"] == jobs["selection_rollout"] == candidates * sum(sets.values()) + more
    assert (
        jobs["merge"] == sum(sets.values()) + 2 + 2 + 2 * 7 + 2 and jobs["rollout"] == more
    )  # the others wait for `choose`
    assert jobs["demonstrate"] == 2 * (1 + 1 + 8 + 8 + 1) + 2 * (1 + 8)
    cells = [f"results/evaluation/policies/door/lite/{name}/rollouts.csv" for name in ("twin", "cousins_8")]
    first = planned(dry_run(folder, *cells, *study).stdout)
    assert first["choose"] == 2 and first["train"] == 2 * candidates and first["demonstrate"] == 1 + 8


def test_the_study_is_about_committed_assets_and_matches_nothing_for_them(folder: Path) -> None:
    study = ("--configfile", "config/study/table3.yaml")
    policies = ("door/lite", "drawer/lite", "bowl/lite_bowl")
    cells = [f"results/evaluation/policies/{name}/twin/rollouts.csv" for name in policies]
    done = dry_run(folder, *cells, "-p", *study)
    jobs = planned(done.stdout)
    assert jobs["pinned"] == 3 and jobs["demonstrate"] == 3, done.stdout
    assert not {"select", "distances", "match", "features", "generate", "room"} & set(jobs)
    told = "--assets config/study/assets/drawer.csv --task put_away_bowl "
    assert re.search(told + ".*experiment/b/bowl/", done.stdout)
    (folder / "anew.yaml").write_text("experiment: {targets: {door: {assets: null}}}")
    anew = planned(dry_run(folder, *cells, *study, "anew.yaml").stdout)
    assert anew["pinned"] == 2 and anew["select"] == anew["distances"] == 1


def test_the_twin_is_the_true_model_in_rooms_and_what_was_matched_in_scenes_of_yours(folder: Path) -> None:
    target = "results/experiment/default/door/assets.json"
    told = "--truth results/scenes/room_3/truth.json --objects results/extraction/room_3/objects.json"
    assert dry_run(folder, target, "-p").stdout.count(told) == 2, "distances and select"
    (folder / "mine").mkdir()
    for name in INPUT_FILES:
        put(folder / "mine" / name)
    (folder / "mine.yaml").write_text(
        "experiment: {rooms: [mine], inputs: {mine: mine}, targets: {door: {room: mine, object: cabinet_1}}}"
    )
    done = dry_run(folder, target, "-p", "--configfile", "mine.yaml")
    assert planned(done.stdout)["select"] == 1 and "--truth" not in done.stdout, done.stdout


def test_corrections_are_an_input_of_the_rules_that_they_concern(folder: Path, tmp_path: Path) -> None:
    mine = tmp_path / "mine"
    mine.mkdir()
    for name in INPUT_FILES:
        put(mine / name)
    (tmp_path / "mine.yaml").write_text(
        f"experiment: {{rooms: [mine], inputs: {{mine: {mine}}}, targets: {{door: null}}}}"
    )
    scene = "results/generation/default/mine/scene_1.json"
    for told, command in (({"panels": []}, "extract"), ({"nudge": [0.1, 0]}, "generate")):
        (mine / "corrections.json").write_text(json.dumps({"version": 1, "objects": [{"mask": 1, **told}]}))
        done = dry_run(folder, scene, "-p", "--configfile", str(tmp_path / "mine.yaml"))
        assert re.findall(rf" (\w+) [^\n]*--corrections {mine}/corrections.json", done.stdout) == [command], done.stdout
    (mine / "corrections.json").write_text('{"version": 1, "objects": [{"hight": 1}]}')
    done = dry_run(folder, scene, "--configfile", str(tmp_path / "mine.yaml"))
    assert done.returncode and "corrections.json: breaks the Corrections contract" in done.stdout


def test_table_2_trains_nothing_and_meets_rooms_by_protocols(folder: Path) -> None:
    assert not {"train", "demonstrate"} & set(planned(dry_run(folder, "table2").stdout))
    (folder / "met.yaml").write_text(
        "experiment: {rooms: [room_1, room_2], targets: {door: null}, protocols: {"
        "drawn: {layout: drawn, seeds: [1, 2]}, "
        "unscaled: {scale_error: false, seeds: [3]}, unknown: {unknown: true}, "
        "recoloured: {finish: other, seeds: [4]}}}"
    )
    done = dry_run(folder, "table2", "table2_robustness", "-p", "--configfile", "met.yaml")
    jobs = planned(done.stdout)
    assert jobs["room"] == 2 and jobs["room_by_protocol"] == 2 * (2 + 1)
    assert jobs["match"] == jobs["score"] == 2 * (1 + 2 + 1 + 1 + 1)
    assert jobs["leave_out"] == 2 and jobs["draw_scenes"] == 2
    lines = {name: " ".join(re.findall(rf".*{re.escape(name)}.*", done.stdout)) for name in (
        "results/scenes/room_1.drawn.2", "results/scenes/room_2.recoloured.4", "extraction/room_1.unscaled.3/objects",
        "results/matching/default/room_1.unknown.0/cousins")}  # fmt: skip
    assert "--protocol '' --draw 0 " in done.stdout and "--protocol 'drawn' --draw 2 " in done.stdout
    drawn, recoloured, unscaled, unknown = lines.values()
    assert "--scene room_1 " in drawn and "--layout-seed 2" in drawn and "--finish-seed 4" in recoloured
    assert "--input results/scenes/room_1/input --scene room_1 " in unscaled
    assert '"scale":0.0' in unscaled.replace(" ", "") and "--seed 3" in unscaled
    assert "--without results/evaluation/left_out/room_1.unknown.0.json" in unknown


def test_a_variant_that_looks_at_no_picture_plans_no_features(folder: Path) -> None:
    (folder / "blind.yaml").write_text(
        "experiment: {rooms: [room_1], targets: {door: null}, variants: {"
        "no-image: {model_selection: priors, orientation_selection: priors}, half: {model_selection: priors}}, "
        "protocols: {unknown: {unknown: true, variants: [no-image]}}}"
    )
    score = "results/evaluation/scenes/{}/scores.csv"
    asked = [score.format("no-image/room_1"), score.format("no-image/room_1.unknown.0")]
    done = dry_run(folder, *asked, "-p", "--configfile", "blind.yaml")
    jobs = planned(done.stdout)
    assert jobs["match"] == jobs["generate"] == jobs["score"] == 2 and jobs["leave_out"] == 1
    assert not {"features", "snapshots"} & set(jobs)
    assert "--truth results/scenes/room_1/truth.json --library results/assets/library/library.json" in done.stdout
    half = planned(dry_run(folder, score.format("half/room_1"), "--configfile", "blind.yaml").stdout)
    assert half["features"] == half["snapshots"] > 0  # one judge that looks is enough


def test_cousins_in_the_colors_of_the_picture_need_it(folder: Path) -> None:
    room = "experiment: {rooms: [room_1], targets: {door: null}}"
    (folder / "painted.yaml").write_text(f"{room[:-1]}, placements: {{default: {{finish: picture}}}}}}")
    done = dry_run(folder, "generation", "-p", "--configfile", "painted.yaml")
    assert re.search(r'"finish": ?"picture".* --image results/scenes/room_1/input/rgb.png --out', done.stdout), (
        done.stdout
    )
    assert "rgb.png --out results/generation" not in dry_run(folder, "generation", "-p").stdout


@pytest.mark.parametrize(("said", "worn"), [("", True), ("generation: {finish: library}", False)])
def test_pictures_of_yours_come_out_in_their_colors_and_rooms_in_the_library_s(
    folder: Path, said: str, worn: bool
) -> None:
    (folder / "mine").mkdir(exist_ok=True)
    for name in INPUT_FILES:
        put(folder / "mine" / name)
    experiment = "experiment: {rooms: [room_1, mine], inputs: {mine: mine}, targets: {door: null}}"
    (folder / "worn.yaml").write_text(f"{experiment}\n{said}")
    done = dry_run(folder, "generation", "-p", "--configfile", "worn.yaml")
    assert re.findall(r"--image (\S+) --out results/generation/default/", done.stdout) == ["mine/rgb.png"] * worn


def test_a_picture_needs_weights_or_is_drawn(tmp_path: Path) -> None:
    folder = make(tmp_path)
    said = dry_run(folder, "photo").stdout
    assert "Fix: snakemake --cores 2 photo --config image=kitchen.jpg" in said and ", line " not in said, said
    put(folder / "my kitchen.v2.jpg")
    photo = ("photo", "--config", "image=my kitchen.v2.jpg", "perception={by: networks}")
    done = dry_run(folder, *photo)
    lines = [line for line in done.stdout.splitlines() if "roomkin perception fetch" in line]
    assert done.returncode == 1 and len(lines) == 1 and "Traceback" not in done.stdout
    assert "weights/sam2" in lines[0] and "roomkin annotator annotate 'my kitchen.v2.jpg'" in lines[0]
    assert planned(dry_run(folder, "fetch").stdout)["fetch"] == 1
    for name in ("grounding_dino", "sam2", "depth_anything_v2"):
        (folder / "weights" / name).mkdir(parents=True)
        (folder / "weights" / name / "model.safetensors").touch()
    done = dry_run(folder, *photo, "-p")
    jobs = planned(done.stdout)
    assert jobs["measure"] == jobs["see"] == jobs["draw_scenes"] == jobs["scene_page"] == 1
    assert not {"train", "room", "report_page", "draw"} & set(jobs)
    assert (
        "--image 'my kitchen.v2.jpg'" in done.stdout
        and "--out results/scenes/my_kitchen_v2-2fec82/view " in done.stdout
    )
    assert "no file nothing.jpg" in dry_run(folder, "photo", "--config", "image=nothing.jpg").stdout


def test_a_picture_without_depth_is_drawn_where_only_its_outlines_have_networks(tmp_path: Path) -> None:
    folder = make(tmp_path)
    put(folder / "kitchen.jpg")
    given = ("image=kitchen.jpg", "perception={heights: {fridge: 1.8}, field_of_view: 60}")
    done = dry_run(folder, "photo", "-p", "--config", *given)
    if not all(is_there(weights) for weights in LOOKING):
        assert "Fix: make weights" in done.stdout and "annotate kitchen.jpg" in done.stdout
        return
    jobs = planned(done.stdout)
    assert jobs["draw"] == jobs["scene_page"] == 1 and "measure" not in jobs
    assert (
        '"field_of_view": 60.0, "heights": {"fridge": 1.8}' in done.stdout
        and "--out results/photo/kitchen " in done.stdout
    )


def test_a_frame_with_depth_and_a_recording_need_no_hand(tmp_path: Path) -> None:
    folder = make(tmp_path)
    for name in ("frames/color/0.png", "frames/color/1.png", "frames/depth/0.png", "frames/depth/1.png", "k.json"):
        put(folder / name)
    one = ("image=frames/color/0.png", "depth=frames/depth/0.png")
    done = dry_run(folder, "photo", "-p", "--config", *one, "camera=k.json")
    jobs = planned(done.stdout)
    assert jobs["view"] == jobs["see"] == jobs["match"] == jobs["scene_page"] == 1 and not {
        "frame",
        "measure",
        "train",
        "room",
    } & set(jobs)
    assert jobs["shards"] == 1 and not {"snapshots", "features"} & set(jobs)  # which, is known when objects are found
    assert "--camera k.json" in done.stdout and "--out results/scenes/0/view " in done.stdout
    assert "--picture results/scenes/0/view " in done.stdout and "--out results/scenes/0/frame " in done.stdout
    put(folder / "color.png")
    done = dry_run(folder, "photo", "-p", "--config", "image=color.png", one[1], "camera=k.json")
    assert "--out results/scenes/color/view " in done.stdout  # there is no folder's name
    put(folder / "living/color.png")
    done = dry_run(folder, "photo", "-p", "--config", "image=living/color.png", one[1], "camera=k.json")
    assert "--out results/scenes/living/view " in done.stdout  # another color.png is another scene
    assert "camera: nothing says what camera took" in dry_run(folder, "photo", "--config", *one).stdout
    assert "depth: is said of no picture" in dry_run(folder, "photo", "--config", one[1]).stdout
    done = dry_run(folder, "photo", "--config", "image=frames", "camera=k.json")
    assert planned(done.stdout)["see"] == planned(done.stdout)["scene_page"] == 2
    assert "shards" not in planned(done.stdout) and planned(done.stdout)["snapshots"] == 3  # all, for several
    assert "E-RECORDING-LAYOUT" in dry_run(folder, "photo", "--config", "image=frames/color").stdout


@pytest.mark.parametrize("scene", ["color", "frames-0"])
def test_the_command_that_the_correcting_page_prints_works_for_a_frame_that_the_workflow_made(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, scene: str
) -> None:
    """After `make picture` the frame's own config names the folder that a rule of that run has made."""
    folder = make(tmp_path / "clone")
    monkeypatch.chdir(folder)
    frame = Path(f"results/scenes/{scene}/frame")
    write_room(frame, BOXES, ["cabinet", "box"])
    write_config(frame)
    words = shlex.split(Correcting(frame, scene=scene).command())
    assert words[:3] == ["snakemake", "--cores", "2"] and f"{frame}/config.yaml" in words
    done = dry_run(folder, "-p", *words[3:])
    jobs = planned(done.stdout)
    assert done.returncode == 0, done.stdout
    assert jobs["extract"] == jobs["match"] == jobs["scene_page"] == 1 and not {"frame", "room"} & set(jobs)
    assert f"--scene {scene} " in done.stdout and f"results/report/scenes/{scene}.html" in done.stdout


def test_mistakes_in_the_config_are_a_line_each(folder: Path, tmp_path: Path) -> None:
    overlay = tmp_path / "mine.yaml"
    overlay.write_text("{maching: {encoder: hog}, experiment: {rooms: [room_9]}, evaluation: {test_assets: [uncle]}}")
    done = dry_run(folder, "all", "--configfile", str(overlay))
    assert done.returncode == 1
    assert "maching: unknown key. Fix: did you mean 'matching'?\n" in done.stdout, done.stdout
    assert "experiment.rooms: unknown scene 'room_9'" in done.stdout
    assert "evaluation.test_assets: there is no 'uncle'" in done.stdout
    assert "Traceback" not in done.stdout


def test_own_models_are_inputs_of_the_library(folder: Path) -> None:
    (folder / "my/assets/chair").mkdir(parents=True)
    (folder / "my/assets/chair/seat.obj").touch()
    (folder / "assets.yaml").write_text("assets: {folders: [my/assets]}")
    done = dry_run(folder, "library", "--configfile", "assets.yaml")
    assert "input: my/assets/chair/seat.obj" in done.stdout, done.stdout


def test_our_rooms_are_furnished_with_procedural_models_and_yours_with_all(folder: Path) -> None:
    (folder / "attic.yaml").write_text((ROOT / "plugins/scenes/rooms/room_1.yaml").read_text())
    (folder / "rooms.yaml").write_text(
        "experiment: {rooms: [room_1, attic], room_files: [attic.yaml], targets: {door: null}}"
    )
    done = dry_run(folder, "scenes", "-p", "--configfile", "rooms.yaml")
    said = re.findall(r"--library (.*?) --scene (\w+)", done.stdout)
    library = "results/assets/library"
    procedural = " ".join(f"{library}/shard_{k}.json" for k in range(planned(done.stdout)["procedural"]))
    assert sorted(said) == [(f"{library}/library.json", "attic"), (procedural, "room_1")], done.stdout


def test_containers_see_what_the_config_names_outside(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    mine = tmp_path / "my assets"
    mine.mkdir()
    (folder / "inside").mkdir()
    monkeypatch.chdir(folder)
    config = complete().model_validate({"assets": {"folders": [str(mine), "inside"]}})
    assert list_outside_paths(config) == [str(mine)]
    told = asked_of_podman("report", tmp_path, ACDC_OUTSIDE=f"{mine}\n/data")
    mounts = [after for before, after in pairwise(told) if before == "-v"]
    assert mounts[1:] == [f"{mine}:{mine}:ro", "/data:/data:ro", "/code:/code:ro"]


def asked_of_podman(shell: str, folder: Path, missing: bool = False, **environment: str) -> list[str]:
    """Arguments that the shell of a rule gives to podman."""
    script = "[ $1 = image ] && exit 1; echo" if missing else "[ $1 = image ] || printf '%s\\n' \"$@\""
    (folder / "podman").write_text(f"#!/bin/sh\n{script}\n")
    (folder / "podman").chmod(0o755)
    given = {"PATH": f"{folder}:{os.environ['PATH']}", "ACDC_IMAGE": "localhost/acdc-{family}:1", "ACDC_CODE": "/code"}
    command = [str(ROOT / f"containers/sh-{shell}"), "-c", "true"]
    done = subprocess.run(command, env=given | environment, text=True, capture_output=True)
    return done.stderr.splitlines() if missing else done.stdout.splitlines()


def test_containers_get_what_their_rule_needs_and_no_more(tmp_path: Path) -> None:
    def asked(shell: str, **environment: str) -> set[str]:
        wanted = {"--network=host", "--network=none", "nvidia.com/gpu=all", "MY_KEY"}
        return wanted & set(asked_of_podman(shell, tmp_path, **environment))

    assert asked("learning-online", ACDC_GPU="cuda") == {"--network=none"}
    assert asked("learning-online", ACDC_ONLINE="MY_KEY") == {"--network=host", "MY_KEY"}
    assert asked("learning", ACDC_ONLINE="MY_KEY") == {"--network=none"}
    assert asked("learning-fetch") == {"--network=host"}
    assert asked("simulation-gpu", ACDC_GPU="cuda") == {"--network=none", "nvidia.com/gpu=all"}
    assert asked("learning-online-gpu", ACDC_GPU="cuda", ACDC_ONLINE="") == {"--network=host", "nvidia.com/gpu=all"}


def test_an_image_of_other_environments_is_told(tmp_path: Path) -> None:
    (line,) = asked_of_podman("report", tmp_path, missing=True)
    assert "error: localhost/acdc-report:1: there is no such image" in line
    assert "FAMILIES=report make containers" in line


def test_the_network_is_for_language_models_that_are_asked() -> None:
    def of(text: str) -> list[str] | None:
        return list_key_variables(complete().model_validate(yaml.safe_load(text)))

    assert of("{}") is None
    assert of("{matching: {model_selection: vlm}, vlm: {key_env: MY_KEY}}") == ["MY_KEY"]
    assert of("experiment: {variants: {default: {model_selection: vlm, vlm: {mode: replay}}}}") is None


def test_images_are_named_once_by_what_they_are_built_from() -> None:
    ours, theirs = ContainersConfig(), ContainersConfig(image="docker://example.org/acdc-{family}:{tag}")
    assert re.fullmatch(r"localhost/acdc-\{family\}:[0-9a-f]{12}", ours.template)
    assert ours.report == f"images/acdc-report-{tag()}.sif"
    assert theirs.template == f"example.org/acdc-{{family}}:{tag()}"
    assert theirs.learning == f"docker://example.org/acdc-learning:{tag()}"


def test_images_hold_what_the_lists_name_and_nothing_else() -> None:
    """Without pyproject.toml's overrides sapien brings in an opencv-python that no list pins, and the build fails."""
    installs = re.findall(r"uv pip install .*", (ROOT / "containers/Containerfile").read_text())
    assert len(installs) == 4 and all("--no-deps" in line and "--require-hashes" in line for line in installs)


def test_generated_files_are_up_to_date() -> None:
    for name, text in reference.generate().items():
        assert (ROOT / name).read_text(encoding="utf-8") == text, f"{name} drifted from stages/config; run: make config"


def test_config_yaml_is_the_default_run_on_a_screen() -> None:
    text = (ROOT / "config.yaml").read_text(encoding="utf-8")
    assert load(with_defaults(yaml.safe_load(text))) == load({})
    lines = [line for line in text.splitlines() if not line.startswith("#")]
    assert len(text.splitlines()) <= 45
    assert not [line for line in lines if "  # " not in line and not line.endswith(":")], "a key without a comment"


def rules_text() -> dict[str, str]:
    """Body of every rule by name; of one made of another, what it was made of as well; with its file's container."""
    own = {}
    for path in list_rule_files():
        text = path.read_text()
        parts = re.split(r"^(?:rule|checkpoint|use rule (\w+) as) (\w+)(?: with)?:$", text, flags=re.MULTILINE)
        container = re.search(r"^container: CONFIG.*$", parts[0], flags=re.MULTILINE)
        for base, name, body in zip(parts[1::3], parts[2::3], parts[3::3], strict=True):
            own[name] = (base, body if "    container:" in body or not container else f"{body}\n    {container[0]}")
    return {name: (own[base][1] if base else "") + body for name, (base, body) in own.items()}


PLUMBING = re.compile(
    r"^    (?:log|benchmark|group|container|threads|resources):"
    r"|^        (?:\*\*command\(|(?:command|code|check|options)=)",
    re.MULTILINE,
)


def test_every_working_rule_has_container_log_resources_and_code() -> None:
    for name, body in rules_text().items():
        if "    shell:" not in body:
            assert "localrule: True" in body and "input:" in body, f"{name} is no target"
            continue
        for directive in ("container:", "log:", "**needs(", "params:"):
            assert directive in body, f"rule {name} lacks {directive}"
        assert "**command(" in body or " code=" in body, f"rule {name} does not see edits of its code"


def test_rules_say_little_that_is_not_theirs() -> None:
    """Paths are literal; of plumbing a rule has at most six directives and parameters; helpers fit on a few screens."""
    for name, body in rules_text().items():
        assert name.endswith(("_under", "_by_protocol")) or len(PLUMBING.findall(body)) <= 6, name
        assert not re.search(r"=rules\.\w+\.output", body), f"{name} hides a path"
    helpers = [path.read_text() for path in sorted((ROOT / "rules").glob("*.smk")) if "\nrule " not in path.read_text()]
    assert sum(len(text.splitlines()) for text in helpers) <= 400


def test_podman_profile_covers_every_working_rule() -> None:
    profile = yaml.safe_load((ROOT / "profiles/podman/config.yaml").read_text())
    working = {name for name, body in rules_text().items() if "    shell:" in body}
    assert set(profile["set-resources"]) == working
    for name, body in rules_text().items():
        if name in working:
            family = re.search(r"CONFIG\.containers\.(\w+)", body)
            shell = ROOT / profile["set-resources"][name]["shell_exec"]
            assert family and shell.name.split("-")[1] == family[1] and shell.is_file()
            assert ("gpu=" in body) == ("-gpu" in shell.name), name


def asked(output: str) -> dict[str, dict[str, str]]:
    """The resources that the last job of every rule asks for in a dry run."""
    found, rule = {}, ""
    for line in output.splitlines():
        head = re.match(r" *(?:local)?(?:rule|checkpoint) (\w+):$", line)
        rule = head[1] if head else rule
        if line.lstrip().startswith("resources: "):
            found[rule] = dict(pair.split("=", 1) for pair in line.partition(": ")[2].split(", "))
    return found


def test_a_gpu_is_asked_for_by_networks_and_only_on_cuda(folder: Path) -> None:
    cpu = plan(folder, "all").stdout
    assert "gpu=" not in cpu
    cuda = plan(folder, "all", "--configfile", "config/gpu.yaml").stdout
    asking = {rule: needs["gpu"] for rule, needs in asked(cuda).items() if "gpu" in needs}
    assert asking == {"train": "1", "rollout": "1"}


def test_training_asks_for_the_hours_that_its_size_takes(folder: Path) -> None:
    """Measured on one core: `lite` 42 s for 2,500 steps, the paper's network 2.17 s a step."""
    lite = plan(folder, "all").stdout
    assert 30 <= int(asked(lite)["train"]["runtime"]) <= 60
    paper = plan(folder, "all", "--configfile", "config/paper/policies.yaml").stdout
    assert 8 * 60 <= int(asked(paper)["train"]["runtime"]) <= 24 * 60


def test_files_stay_small() -> None:
    assert len((ROOT / "Snakefile").read_text().splitlines()) <= 80
    for path in list_rule_files():
        assert len(path.read_text().splitlines()) <= 170, path.name
    paths = [file for folder in ("stages", "plugins") for file in (ROOT / folder).rglob("*.py")]
    for path in (path for path in paths if "tests" not in path.relative_to(ROOT).parts):
        assert len(path.read_text().splitlines()) <= 300, path.name
