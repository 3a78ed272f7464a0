"""Command `report`: the whole run on one page that needs nothing but a browser, and its times on another."""

import json
import os
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pandas as pd
import yaml
from markupsafe import Markup

from roomkin.plugins.claims import assets, claims
from roomkin.plugins.claims import tables as claim_tables
from roomkin.plugins.claims.trainings import failed, failed_note, read_trainings, trainings_table
from roomkin.plugins.report.album import Album
from roomkin.plugins.report.doubts import mountings_agree
from roomkin.plugins.report.page import policies, result, rooms
from roomkin.plugins.report.page.benchmarks import by_stage, longest_table, read_jobs, times_table
from roomkin.plugins.report.page.files import RunFiles
from roomkin.plugins.report.page.objects import measure_extents
from roomkin.plugins.report.page.result import embed_svg
from roomkin.plugins.report.roles import role_title
from roomkin.plugins.robustness import table as robustness
from roomkin.plugins.robustness.table import robustness_table
from roomkin.stages.config.evaluation import PolicyTables
from roomkin.stages.contracts.errors import count, describe_size
from roomkin.stages.contracts.files import read_json, read_options, read_text, write_text
from roomkin.stages.contracts.generated import measure_place_sureness, measure_sureness
from roomkin.stages.contracts.library import Library
from roomkin.stages.tables import policy_tables, table2
from roomkin.stages.tables.policy_tables import join_published, kinds_of, policy_notes
from roomkin.stages.tables.rows import CELL, RATE, published_policies, read_table, records
from roomkin.stages.tables.rows import title as title_of
from roomkin.stages.tables.scenes import parse_comparisons
from roomkin.stages.tables.text import TextTable, environment, number, percent

TIMES_PAGE, CONFIG_PAGE = "times.html", "config.yaml"
STAGES = ["assets", "scenes", "extraction", "matching", "generation", "experiment"]
STAGES += ["demonstrations", "training", "evaluation", "tables"]
COLUMNS = {
    "table2": table2.ALL_COLUMNS,
    "table2_robustness": robustness.COLUMNS,
    "table3_cells": [*CELL, *RATE],
    "table3_claims": claims.COLUMNS,
    "table3_stability": claims.STABILITY,
    "assets": assets.COLUMNS,
    "assets_by_handle": assets.BY_HANDLE,
}
# What templates call to write things out.
WORDS: dict[str, Any] = {"title_of": title_of} | {
    one.__name__: one
    for one in (
        number, count, percent, describe_size, role_title, mountings_agree, measure_extents, embed_svg,
        measure_sureness, measure_place_sureness,
    )
}  # fmt: skip


def render(template: str, scripts: tuple[str, ...] = (), **values: Any) -> str:
    """A page of the package, its scripts written into it."""
    script = Markup("\n".join(read_text(Path(__file__).with_name("page") / name) for name in scripts))
    page = environment("roomkin.plugins.report").get_template(f"page/{template}")
    return page.render(script=script, **WORDS, **values)


def link_to(viewer: Path | None, page: Path) -> str:
    """The link from a page to three.min.js; empty: none."""
    return os.path.relpath(viewer, page.parent) if viewer else ""


def link_there_and_back(other: Path, page: Path) -> str:
    """The link from a page to another, which leads back (back.js)."""
    return f"{os.path.relpath(other, page.parent)}?from={os.path.relpath(page, other.parent)}"


def _frames(files: RunFiles) -> dict[str, pd.DataFrame]:
    """The CSV tables of the run that have rows, by name; integers with missing values stay integers."""
    found = {}
    for name, columns in COLUMNS.items():
        if path := files.find_first(f"tables/{name}.csv"):
            table = read_table(path, columns, ["scene", "variant", "judge", *CELL, "task"])
            found[name] = table.convert_dtypes(
                infer_objects=False, convert_string=False, convert_boolean=False, convert_floating=False
            )
    return {name: table for name, table in found.items() if len(table)}


def _tables(files: RunFiles, published: Path, options: PolicyTables) -> dict[str, Any]:
    """The tables of the run as the page has them, and the results on its first screen."""
    frames, kinds = _frames(files), kinds_of(options)
    trainings = read_trainings(files.find_first("tables/trainings.csv"))
    notes = [*policy_notes(options), *failed_note(trainings)]
    trained = [trainings_table(trainings)] if len(trainings) else []

    def table(form: Callable[..., TextTable], name: str, *more: Any) -> list[TextTable]:
        return [form(frames[name], *more)] if name in frames else []

    judged, cells = frames.get("table3_claims"), frames.get("table3_cells")
    over_assets = result.compare_over_assets(frames.get("assets"), judged, kinds)
    by_role = result.compare_over_roles(cells, judged, kinds)
    first = [*over_assets, *(each for each in by_role if each.target not in {one.target for one in over_assets})]
    paper = None if cells is None else join_published(published_policies(published), cells, options)
    claimed = table(claim_tables.claims_table, "table3_claims", options)
    unsaid = judged is not None and all(map(claim_tables.count_lacking_runs, records(judged)))
    return {
        "rebuilt": result.describe_rooms(frames.get("table2")),
        "results": first,
        "roles": [each for each in by_role if each not in first],
        "of_policies": [
            *(trained if failed(trainings) else []),
            *table(claim_tables.assets_table, "assets", options, kinds, notes),
            *([] if unsaid else claimed),
        ],
        "folded": [
            *(claimed if unsaid else []),
            *table(claim_tables.by_handle_table, "assets_by_handle", options),
            *([] if failed(trainings) else trained),
        ],
        "tables": [
            *table(table2.scenes_table, "table2", options),
            *table(robustness_table, "table2_robustness"),
            *table(policy_tables.policies_table, "table3_cells", paper, options, kinds, notes),
            *table(claim_tables.stability_table, "table3_stability"),
        ],
    }


def _pictures(files: RunFiles, options: PolicyTables) -> dict[str, Any]:
    """Rooms, targets, the library and figures."""
    album = Album(options.picture_width, options.picture_quality)
    path, sheets = files.find_first("assets/library/library.json"), files.find_all("assets/snapshots/shard_*.png")
    library = sorted(read_json(Library, path).assets, key=lambda asset: asset.category) if path else []
    return {
        "rooms": rooms.collect(files, album),
        "targets": policies.collect(files, album, options.confidence),
        "library": library,
        "categories": Counter(asset.category.replace("_", " ") for asset in library).most_common(),
        "sheets": [album.add(sheet, f"Contact sheet of the library, {n}") for n, sheet in enumerate(sheets, start=1)],
        "figures": {path.stem: path.read_bytes() for path in files.find_all("figures/figure*.svg")},
    }


def run(
    *,
    out: Path,
    files: tuple[Path, ...] = (),
    images: tuple[str, ...] = (),
    viewer: Path | None = None,
    benchmarks: tuple[Path, ...] = (),
    benchmarks_root: Path = Path("benchmarks"),
    published: Path = Path("report/published"),
    title: str = "Digital cousins from one picture",
    config: str = "",
    seed: int | None = None,
    more: int = 0,
    options: str = "",
) -> None:
    """Write the page, and the config of the run beside it; parts that were not run are marked.

    The same run gives the same page, byte for byte: how long its jobs took stands in times.html beside it.

    Args:
        out: the HTML file.
        files: everything that the page may show, in the fixed layout of results/; nothing else is read.
        images: the pictures that went in, as room=picture.
        viewer: three.min.js, to which the page links; without it scenes cannot be turned.
        benchmarks: Snakemake's benchmark files of this run; those that are not there are left out.
        benchmarks_root: the folder whose first level names the stage of a benchmark.
        published: folder with the paper's values.
        title: title of the page.
        config: JSON of the whole config; the page links to it as config.yaml.
        seed: seed of the run.
        more: how many more scenes the run has, which are neither shown nor counted here.
        options: JSON of the config section `tables`, and of what the policies are.
    """
    settings = read_options(PolicyTables, options)
    declared = RunFiles(files, {room: path for (room, _), path in parse_comparisons(images, "--images").items()})
    page = render(
        "page.html.jinja",
        ("page.js", "viewer.js"),
        title=title,
        config_page=CONFIG_PAGE if config else "",
        times_page=TIMES_PAGE,
        seed=seed,
        more=more,
        viewer=link_to(viewer, out),
        pages={path.stem: link_there_and_back(path, out) for path in declared.find_all("report/scenes/*.html")},
        **_pictures(declared, settings),
        **_tables(declared, published, settings),
    )
    jobs = read_jobs(benchmarks, benchmarks_root)
    tables = [times_table(by_stage(jobs, STAGES)), longest_table(jobs)] if len(jobs) else []
    write_text(out.with_name(TIMES_PAGE), render("times.html.jinja", page=out.name, more=more, tables=tables))
    if config:
        write_text(out.with_name(CONFIG_PAGE), yaml.safe_dump(json.loads(config), sort_keys=False, allow_unicode=True))
    write_text(out, page)
