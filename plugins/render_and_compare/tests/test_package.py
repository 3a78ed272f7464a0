"""What of the config and the workflow is this package's."""

from pathlib import Path

import roomkin.plugins.render_and_compare
from roomkin.stages.config.model import load
from roomkin.stages.config.reads import options_of
from tests.refusals import refused
from tests.workflow.workspace import dry_run, make

CORES = "{model_selection: distance, orientation_selection: distance}"
PICTURE = "results/matching/default/room_1/cousins.png"


def test_the_section_is_read_where_its_judge_is_asked() -> None:
    def told(**changes: object) -> dict[str, object]:
        given = {"geometry": {"nearest": 7}, "experiment": {"variants": {"default": changes}}}
        return options_of(load(given), "matching", "match", {"variant": "default"})

    assert told()["geometry"] == {"nearest": 7, "outline": 1, "depth": 0.5, "lines": 0.5, "colour": 0}
    assert told(geometry={"colour": 1})["geometry"] == told()["geometry"] | {"colour": 1}  # type: ignore[operator]
    assert "geometry" not in told(model_selection="distance", orientation_selection="rerender")


def test_where_the_section_was_is_told() -> None:
    with refused("E-CONFIG-KEY", "matching.geometry: unknown key. Fix: do you mean geometry?"):
        load({"matching": {"geometry": {"nearest": 7}}})


def test_cousins_are_shown_in_place_if_the_package_is_on(tmp_path: Path) -> None:
    folder = make(tmp_path)
    assert (
        f"--in-place {roomkin.plugins.render_and_compare.__name__}.in_place --out"
        in dry_run(folder, PICTURE, "-p").stdout
    )
    (folder / "off.yaml").write_text(f"packages: {{render_and_compare: false}}\nmatching: {CORES}\n")
    assert "--in-place --out" in " ".join(dry_run(folder, PICTURE, "-p", "--configfile", "off.yaml").stdout.split())
