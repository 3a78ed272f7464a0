"""Many pictures of the user's: what is planned for them, and what a failed run says of each."""

import re
from pathlib import Path

import pytest

from roomkin.stages.config.inputs import INPUT_FILES
from tests.workflow.workspace import dry_run, make, planned, put, snakemake

SCENES = 30


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A clone with ten frames in a table and twenty input folders, one with options of its own."""
    folder = make(tmp_path_factory.mktemp("many"))
    for number in range(20):
        for name in INPUT_FILES:
            put(folder / f"data/folders/hall_{number}" / name)
    (folder / "data/folders/hall_3/config.yaml").write_text("extraction: {crop: 1.0}")
    put(*(folder / "data" / name for name in ("a.png", "a_depth.png", "masks.png", "labels.json")))
    rows = [f"desk_{number},a.png,a_depth.png,5000,60,61,32,24,masks.png,labels.json" for number in range(10)]
    (folder / "data/t.csv").write_text("\n".join(["scene,image,depth,unit,fx,fy,cx,cy,masks,labels", *rows]))
    inputs = "inputs: [data/t.csv, data/folders]"
    (folder / "mine.yaml").write_text(f"experiment: {{{inputs}, rooms: [room_1, '*'], targets: {{door: null}}}}")
    return folder


def test_every_picture_is_taken_to_scenes_and_the_overview(folder: Path) -> None:
    done = dry_run(folder, "overview", "-p", "--configfile", "mine.yaml")
    jobs = planned(done.stdout)
    assert (jobs["frame"], jobs["room"], jobs["overview_page"]) == (10, 1, 1), done.stdout[-3000:]
    assert jobs["extract"] == jobs["match"] == jobs["generate"] == jobs["draw_scenes"] == SCENES + 1
    told = re.search(r"from-rgbd (.*) --out results/scenes/desk_7/frame", done.stdout)
    assert told and told[1] == (
        "--rgb data/a.png --depth data/a_depth.png --masks data/masks.png --labels data/labels.json --unit 5000 "
        "--camera 60.0 61.0 32.0 24.0"
    )
    own = dict(re.findall(r"--scene (\w+) --options '[^']*' --own (\S+) +--seed", done.stdout))
    assert own["hall_3"] == "data/folders/hall_3/config.yaml"
    assert own["desk_7"] == "results/scenes/desk_7/frame/config.yaml"
    assert len(own) == 11, "ten frames and one folder have options of their own"


def test_the_report_shows_a_handful(folder: Path) -> None:
    done = dry_run(folder, "all", "-p", "--configfile", "mine.yaml")
    assert planned(done.stdout)["overview_page"] == 1, done.stdout[-3000:]
    report = re.search(r"roomkin.plugins.report report .*", done.stdout)
    assert report and "--more 22 " in report[0] and len(set(re.findall(r"results/extraction/(\w+)/", report[0]))) == 9


def test_a_failed_run_says_of_every_scene_where_it_stopped(folder: Path) -> None:
    command = 'echo "error: $4: nothing is in it. Fix: look again" >&2; false'
    (folder / "broken.yaml").write_text(
        "experiment: {rooms: ['hall_*']}\n"
        f"stages: {{extraction: {{extract: {{command: '{command} #', code: []}}}}}}\n"
    )
    configs = ("--configfile", "mine.yaml", "broken.yaml")
    targets = [f"results/extraction/hall_{number}/objects.json" for number in (1, 2)]
    done = snakemake(folder, *targets, "--keep-going", *configs)
    page = folder / "results/report/overview/default.failed.html"
    assert done.returncode and "20 scenes were made, 2 stopped, 18 not run" in done.stdout, done.stdout[-3000:]
    cells = re.findall(r'<th scope="row">(\w+)</th>.*?stopped in (\w+)</span>: ([^<]*)<', page.read_text(), re.DOTALL)
    assert ("hall_1", "extraction", "hall_1: nothing is in it. Fix: look again") in cells
    assert ("hall_0", "extraction", "not run") in cells
    assert not (folder / "results/report/overview/default.html").exists()
    causes = [f"error: hall_{number}: nothing is in it. Fix: look again" for number in (1, 2)]
    assert sorted(done.stdout.splitlines()[-2:]) == causes, "why, below all that Snakemake says"
