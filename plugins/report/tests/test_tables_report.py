"""Figures and the report page, on a small made-up run."""

import base64
import re
import shutil
from html import unescape
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import yaml
from PIL import Image

from roomkin.plugins.report import report
from roomkin.plugins.report.album import Album, SnapshotShards
from roomkin.plugins.report.page import result
from roomkin.plugins.report.page.benchmarks import by_stage, duration, longest_table, read_jobs, times_table
from roomkin.plugins.report.page.files import RunFiles
from roomkin.plugins.report.page.policies import losses
from roomkin.plugins.report.page.result import line_chart, sentences
from roomkin.stages.config.model import Config
from roomkin.stages.contracts.images import read_narrow
from roomkin.stages.tables import policies, scenes
from tests.refusals import refused
from tests.unit.tables_results import MADE, VIEWER, declared, picture, write_run

OPTIONS = '{"bootstrap_samples": 400}'
PUBLISHED = Path(__file__).resolve().parents[3] / "report" / "published"


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A whole run with its tables, figures and page."""
    root = write_run(tmp_path_factory.mktemp("run"))
    results = root / "results"
    out = results / "tables"
    write_policies(root, out, results / "figures")
    write_scenes(root, out, results / "figures")
    page(root, results / "report" / "index.html")
    return root


def write_policies(root: Path, out: Path, figures: Path) -> None:
    rolled = tuple(sorted((root / "results/evaluation/policies").glob("*/rollouts.csv")))
    more = ("roomkin.plugins.claims.more",)
    policies.run(out=out, figures=figures, rollouts=rolled, more=more, published=PUBLISHED, options=OPTIONS)


def write_scenes(root: Path, out: Path, drawn: Path) -> None:
    results = root / "results"
    pictures = tuple(
        f"{room}/default={results}/generation/default/{room}/comparison.png" for room in ("room_1", "room_2")
    )
    scores = tuple(sorted(results.glob("evaluation/scenes/default/*/scores.csv")))
    scenes.run(out=out, figures=drawn, scores=scores, comparisons=pictures, published=PUBLISHED)


def page(root: Path, out: Path, **flags: object) -> str:
    report.run(out=out, published=PUBLISHED, viewer=out.with_name(VIEWER.name), **(declared(root) | flags))  # type: ignore[arg-type]
    return out.read_text()


VOID = ("meta", "link", "img", "source", "input", "br")


class Checker(HTMLParser):
    """Collects what must hold of the page's elements."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.ids: set[str] = set()
        self.links: set[str] = set()
        self.sources: list[str] = []
        self.unnamed: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        values = dict(attrs)
        if tag not in VOID:
            self.open.append(tag)
        if "id" in values:
            assert values["id"] not in self.ids, values["id"]
            self.ids.add(str(values["id"]))
        if tag == "a":
            self.links.add(str(values["href"]))
        if tag == "img":
            self.sources.append(str(values["src"]))
            self.unnamed += [] if values.get("alt") or values["src"] == "data:," else [str(values)[:80]]

    def handle_endtag(self, tag: str) -> None:
        if tag not in VOID:
            assert self.open.pop() == tag, self.getpos()

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.handle_starttag(tag, attrs)
        self.handle_endtag(tag)


def test_page_shows_demonstrations_inside_generated_scenes(made: Path) -> None:
    text = (made / "results/report/index.html").read_text()
    part = text[text.index("In the generated scenes") : text.index("<summary>Demonstrations</summary>")]
    assert "rank 1" in part and "success after" in part
    assert "rank 2: the robot cannot open it: sofa_1 is in its place." in part


def test_a_rooms_heading_names_encoder_and_judge_of_the_run(made: Path) -> None:
    """Whatever the paper's variant of that name is."""
    text = (made / "results/report/index.html").read_text()
    assert "<h4>Variant default · encoder hog · judge geometry</h4>" in text
    assert "(b) encoder model, encoder orientation" not in text[: text.index('id="tables"')]


def test_page_holds_seed_and_digests_of_every_scene(made: Path) -> None:
    text = (made / "results/report/index.html").read_text()
    for room in ("room_1", "room_2"):
        row = re.search(rf"default/{room}/scene_1.json</th><td>(\w+)</td>(.*)</tr>", text)
        assert row and row[1] == str(MADE.seed)
        assert re.findall(r"<code>(\w+)</code>", row[2]) == [MADE.options, MADE.inputs, MADE.code]


def test_page_is_whole_and_stands_alone(made: Path) -> None:
    text = (made / "results/report/index.html").read_text()
    checker = Checker()
    checker.feed(text)
    assert checker.open == [] and checker.unnamed == []
    assert all(link.removeprefix("#") in checker.ids for link in checker.links - {"times.html", "data:,"})
    assert len(checker.sources) > 15 and all(source.startswith("data:") for source in checker.sources)
    for outside in (r"(src|href)=\"(https?:)?//", "@import", r"url\((?!#)"):
        assert not re.search(outside, text), outside


def test_page_tells_what_happened(made: Path) -> None:
    text = (made / "results/report/index.html").read_text()
    for words in (
        "13 models in 2 categories", "only 12 points &lt;after cleaning&gt;", "lamp_1 has fallen",
        "cabinet 01", "grasp slip 1", "8/10", "[49–95]", "Loss of the policy lite, trained on 4 cousins",
        "Table 3:", "paper 5/5",
        "Lite, trained on 4 cousins, seed 0", "not run", "+17 points",
        "32 of 35 rows and",
        "failure, opened 12 % in 23 steps", "Rebuilt from cousins of rank",
    ):  # fmt: skip
        assert words in text, words
    assert text.count("only 12 points") == 2  # once per room: a failure is told where it happened first
    assert "no cloud" not in text


def test_a_headline_of_one_training_a_side_says_so(made: Path) -> None:
    (path,) = (made / "results/tables").glob("*claims*.csv")
    claims = pd.read_csv(path, keep_default_na=False, na_values=[""])
    names = dict.fromkeys(claims["policy"], "a policy")
    told = [sentences(claims.assign(runs=runs, baseline_runs=2), "door", names)[0] for runs in (1, 2)]
    assert told[0] == f"{told[1]}; 1 training a side, and another may turn out otherwise" and told[1]


def test_first_screen_shows_unseen_assets_and_the_roles_stand_below(made: Path, tmp_path: Path) -> None:
    text = unescape((made / "results/report/index.html").read_text())
    first, below = text[: text.index('<p class="lede">')], text[text.index('id="policies"') :]
    for words in (
        "success over 24 unseen assets", 'class="chart"',
        "2 pictures of 7 objects became ", " objects have the right category, and they stand ", " from their true",
        "Door opening on 24 unseen assets succeeds ", " after training on the twin: ",
        "over 2 and 2 seeds of training: whether cousins help cannot be said.",
    ):  # fmt: skip
        assert words in first, words
    assert "success of the policies by test asset" not in first and "On the roles of Table 3" in below
    assert 'id="assets"' in below and below.index("<details><summary>Success over unseen assets, by kind") > 0
    flags = declared(made)
    files = tuple(path for path in flags["files"] if not path.name.startswith("assets"))  # type: ignore[attr-defined]
    without = page(made, tmp_path / "index.html", files=files)
    assert "success of the policies by test asset" in without[: without.index('<p class="lede">')]
    assert "On the roles of Table 3" not in without and "families that no policy" not in without


def test_page_and_figures_are_the_same_bytes_again(made: Path, tmp_path: Path) -> None:
    write_policies(made, tmp_path, tmp_path)
    write_scenes(made, tmp_path, tmp_path)
    for name in ("figure4", "figure6", "figure9"):
        for suffix in ("svg", "png"):
            again = (tmp_path / f"{name}.{suffix}").read_bytes()
            assert again == (made / "results/figures" / f"{name}.{suffix}").read_bytes(), name
    assert page(made, tmp_path / "index.html") == (made / "results/report/index.html").read_text()


def test_figures_without_results_are_drawn_as_not_run(tmp_path: Path) -> None:
    policies.run(out=tmp_path, more=("roomkin.plugins.claims.more",), published=PUBLISHED)
    scenes.run(out=tmp_path, published=PUBLISHED)
    assert sorted(path.name for path in tmp_path.glob("figure*")) == sorted(
        f"figure{n}.{suffix}" for n in (4, 6, 9) for suffix in ("png", "svg")
    )
    with Image.open(tmp_path / "figure6.png") as drawn:
        assert drawn.width > 500


def test_page_of_an_empty_run_says_not_run(tmp_path: Path) -> None:
    report.run(out=tmp_path / "index.html", published=PUBLISHED, title="Nothing <yet>", seed=3)
    text = (tmp_path / "index.html").read_text()
    assert text.count("Not run:") >= 5 and "<title>Nothing &lt;yet&gt;</title>" in text
    assert "seed of this run is 3" in text
    with refused("E-FILE-MISSING"):
        report.run(out=tmp_path / "x.html", files=(tmp_path / "none.csv",), published=PUBLISHED)
    with refused("E-PICTURE-NAME"):
        report.run(out=tmp_path / "x.html", images=("x.png",), published=PUBLISHED)


def test_page_shows_what_was_declared_and_nothing_else(made: Path, tmp_path: Path) -> None:
    flags, text = declared(made), (made / "results/report/index.html").read_text()
    old = tmp_path / "run"
    shutil.copytree(made, old)
    results = old / "results"
    for kept, planted in (
        ("training/door/lite/twin/lite/seed_0", "training/door/lite/twin/old_run/seed_7"),
        ("evaluation/policies/door/lite/twin/lite/seed_0", "evaluation/policies/door/lite/twin/old_run/seed_7"),
        ("matching/default/room_1", "matching/old_variant/room_1"),
        ("generation/default/room_1", "generation/old_variant/room_1"),
        ("extraction/room_1", "extraction/room_77"),
        ("demonstrations/door/twin", "demonstrations/drawer/twin"),
    ):
        shutil.copytree(results / kept, results / planted)
    shutil.copy(old / "benchmarks/assets/library.tsv", old / "benchmarks/assets/old_library.tsv")
    moved = {
        name: tuple(type(item)(str(item).replace(str(made), str(old))) for item in value)  # type: ignore[attr-defined]
        if isinstance(value, tuple)
        else old / "benchmarks"
        for name, value in flags.items()
    }
    assert page(old, tmp_path / "index.html", **moved).replace(str(old), str(made)) == text
    assert "old_library" not in (tmp_path / "times.html").read_text()


def test_the_variant_of_the_default_run_stands_first(made: Path, tmp_path: Path) -> None:
    results = tmp_path / "run/results"
    shutil.copytree(made, results.parent)
    for stage in ("matching", "generation"):
        shutil.copytree(results / stage / "default/room_1", results / stage / "c-local/room_1")
    text = page(results.parent, tmp_path / "index.html", **declared(results.parent))
    assert 0 < text.index("Variant default") < text.index("Variant c-local")


def test_times_stand_on_a_page_of_their_own(made: Path, tmp_path: Path) -> None:
    text = page(made, tmp_path / "index.html")
    times = (tmp_path / "times.html").read_text()
    assert all(words in times and words not in text for words in ("matching/default/room_1", "800 MiB"))
    assert 'href="times.html"' in text
    assert page(made, tmp_path / "again" / "index.html", benchmarks=()) == text
    assert "No benchmark files were found" in (tmp_path / "again" / "times.html").read_text()


def test_the_config_of_the_run_lies_beside_the_page(made: Path, tmp_path: Path) -> None:
    asked = Config().model_copy(update={"seed": 11})
    text = page(made, tmp_path / "index.html", config=asked.model_dump_json())
    assert Config.model_validate(yaml.safe_load((tmp_path / "config.yaml").read_text())) == asked
    assert 'href="config.yaml"' in text and 'href="config.yaml"' not in page(made, tmp_path / "other" / "index.html")


@pytest.mark.parametrize(
    ("name", "text", "code"),
    [
        ("results/extraction/room_1/objects.json", "{", "E-CONTRACT-BROKEN"),
        ("results/demonstrations/door/twin/attempts.jsonl", '{"attempt": 0}\n', "E-CONTRACT-BROKEN"),
        ("results/demonstrations/door/twin/attempts.jsonl", "", "E-FILE-EMPTY"),
        ("results/training/door/lite/twin/lite/seed_0/metrics.jsonl", '{"step": 1}\nnan,\n', "E-CONTRACT-BROKEN"),
        ("results/generation/default/room_1/scene_1.png", "no picture", "E-IMAGE-UNREADABLE"),
        ("results/assets/snapshots/shard_0.h5", "no snapshots", "E-FILE-UNREADABLE"),
        ("results/demonstrations/door/twin/films.zip", "no film", "E-FILE-UNREADABLE"),
        ("benchmarks/assets/library.tsv", "a\tb\n1\t2\n", "E-BENCHMARK"),
        ("results/tables/table2.csv", "scene\n", "E-TABLE-COLUMN"),
    ],
)
def test_broken_input_gives_one_line_and_no_page(tmp_path: Path, name: str, text: str, code: str) -> None:
    root = write_run(tmp_path)
    (root / name).parent.mkdir(parents=True, exist_ok=True)
    (root / name).write_text(text)
    with refused(code, Path(name).name) as error:
        page(root, tmp_path / "out" / "index.html")
    assert "\n" not in str(error.value) and not (tmp_path / "out").exists()


def test_benchmarks_by_stage(made: Path) -> None:
    root = made / "benchmarks"
    jobs = read_jobs([*root.rglob("*.tsv"), root / "assets" / "never_ran.tsv"], root)
    rows = by_stage(jobs, ["matching", "assets"]).set_index("stage")
    assert list(rows.index) == ["matching", "assets", "tables", "total"]
    assert rows.loc["assets", "seconds"] == 61.5 and rows.loc["assets", "memory"] == 300.25
    assert rows.loc["total", ["jobs", "memory"]].tolist() == [3, 800]
    assert rows.loc["tables", "cpu_seconds"] == 0  # too short to be measured
    assert times_table(by_stage(jobs, [])).rows[-1][:3] == ["total", "3", "1 min 14 s"]
    assert [row[:2] for row in longest_table(jobs).rows] == [
        ["assets/library", "1 min 02 s"], ["matching/default/room_1", "12 s"], ["tables/tables", "0 s"],
    ]  # fmt: skip
    assert [duration(s) for s in (0.4, 59.7, 74, 7500)] == ["0 s", "1 min 00 s", "1 min 14 s", "2 h 05 min"]


def test_losses_and_charts() -> None:
    series = losses([{"step": 10, "loss": 2.0, "lr": 1}, {"step": 20, "loss": 1.0, "valid_loss": 3}])
    assert series == {"loss": [(10.0, 2.0), (20.0, 1.0)], "valid_loss": [(20.0, 3.0)]}
    chart = line_chart({"<a>": [(0, 1), (1, float("nan")), (2, 0)]}, "step", "a & b")
    svg = base64.b64decode(chart.split("base64,")[1].split('"')[0]).decode()
    assert "&lt;a&gt;" in svg and 'alt="a &amp; b"' in chart and "nan" not in svg.lower()
    assert line_chart({"flat": [(0, 1)]}, "step", "x") != "" and line_chart({}, "step", "x") == ""


def test_snapshots_are_cut_out_at_the_nearest_yaw(made: Path) -> None:
    library = SnapshotShards(RunFiles(declared(made)["files"]).find_all("assets/snapshots/shard_*.h5"))  # type: ignore[arg-type]
    cut = library.picture("bowl_03", yaw=6.2)
    assert cut is not None and cut.mode == "RGBA" and cut.width == cut.height == 16  # 14 pixels and a margin
    assert library.picture("no_such_asset") is None


def test_pictures_are_made_smaller(tmp_path: Path) -> None:
    picture(tmp_path / "a.png", 400, 200)
    assert [read_narrow(tmp_path / "a.png", width).size for width in (100, 900)] == [(100, 50), (400, 200)]
    clear = Image.new("RGBA", (16, 16), (0, 0, 0, 0))
    clear.save(tmp_path / "clear.png")
    assert read_narrow(tmp_path / "clear.png", 16).getpixel((0, 0)) == (255, 255, 255)
    added = Album(100, 80).add(tmp_path / "a.png", "a box")
    assert added.source.startswith("data:image/webp;base64,") and (added.width, added.height) == (100, 50)


def test_bars_of_success_reach_from_the_low_end_to_the_high_one(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(result, "_draw_figure", lambda figure, alt: figure)
    about = {"training_set": "twin", "successes": 12, "episodes": 20}
    rows = [
        {**about, "test_asset": "twin", "mean": 0.6, "low": 0.2, "high": 0.7},
        {**about, "test_asset": "dissimilar", "mean": 0.1, "low": 0.05, "high": 0.4},
    ]
    figure: Any = result.success_chart(pd.DataFrame(rows), "", {"twin": "twin", "dissimilar": "other"}, "test_asset")
    (bars,) = figure.axes[0].containers[0].lines[2]
    ends = [(start[0], end[0]) for start, end in bars.get_segments()]
    assert np.ravel(ends) == pytest.approx([20, 70, 5, 40])
