"""Verb `report`: the whole run on one page that needs nothing but a browser, and its times on another."""

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import pandas as pd
from markupsafe import Markup

from stages.config.tables import TablesConfig
from stages.contracts.files import read_options, read_text, write_text
from stages.tables import asset_tables, assets, claims, formatting, robustness, table2, table3
from stages.tables.claim_tables import claims_table, stability_table
from stages.tables.markup import Table, environment, number, percent
from stages.tables.order import role_title
from stages.tables.page import library, policies, result, rooms
from stages.tables.page.benchmarks import by_stage, duration, read_jobs
from stages.tables.page.charts import inline
from stages.tables.page.files import RunFiles
from stages.tables.page.headline import rate, tiles
from stages.tables.page.pictures import Album
from stages.tables.rows import published_policies, read_table
from stages.tables.scenes import named

MAX_BYTES = 12_000_000
TIMES_PAGE = "times.html"
SCRIPTS = ("page.js", "viewer.js", "turntable.js")
STAGES = ["assets", "scenes", "extraction", "matching", "generation", "experiment"]
STAGES += ["demonstrations", "training", "evaluation", "tables"]
TEXT = ["scene", "protocol", "variant", "judge", "task", "cloud", "claim", "verdict", "test_asset", "training_set"]
TEXT += ["assets_of", "baseline", "over", "by", "handle"]
WHOLE = re.compile(
    r".*_correct|(published_)?n_.*|((baseline|published)_)?runs|(published_)?collapsed|assets|families|places|episodes"
    r"|(official_)?successes|seed"
)
FIGURES = {
    "figure4": "Figure 4: success on unseen assets against their distance from the twin and the length of their "
    "handles (faint: one asset; bold: thirds of the assets, with intervals over assets); below, on the roles of Table "
    "3, and the paper's, with standard deviations.",
    "figure9": "Figure 9: success on the test assets for every training set; the paper's values are dashed.",
}


def _table(path: Path | None, columns: list[str]) -> pd.DataFrame | None:
    if path is None:
        return None
    table = read_table(path, columns, TEXT)
    return table.astype(dict.fromkeys((name for name in columns if WHOLE.fullmatch(name)), "Int64"))


class Shown(NamedTuple):
    """Tables of the run: about policies, their breakdown (folded), the others; and the frames behind the headline."""

    policies: list[Table]
    folded: list[Table]
    others: list[Table]
    scenes: pd.DataFrame | None
    assets: pd.DataFrame | None
    cells: pd.DataFrame | None
    gains: pd.DataFrame | None


def _tables(files: RunFiles, published: Path, options: TablesConfig) -> Shown:
    def made(name: str, columns: list[str]) -> pd.DataFrame | None:
        return _table(files.one(f"tables/{name}.csv"), columns)

    def shown(form: Callable[..., Table], table: pd.DataFrame | None, *more: Any) -> list[Table]:
        return [form(table, *more)] if table is not None and len(table) else []

    scenes, cells = made("table2", table2.ALL_COLUMNS), made("table3_cells", table3.CELL_COLUMNS)
    unseen, gains = made("assets", assets.COLUMNS), made("table3_differences", table3.DIFFERENCE_COLUMNS)
    over, paper = shown(asset_tables.assets_table, unseen, options), published_policies(published)
    others = shown(formatting.scenes_table, scenes, options)
    others += shown(formatting.robustness_table, made("table2_robustness", robustness.COLUMNS))
    others += [formatting.policies_table(cells, paper, options)] if cells is not None else []
    others += shown(stability_table, made("table3_stability", claims.STABILITY))
    others += shown(formatting.differences_table, gains, options)
    return Shown(
        policies=[*over, *shown(claims_table, made("table3_claims", claims.COLUMNS), options)],
        folded=shown(asset_tables.by_handle_table, made("assets_by_handle", assets.BY_HANDLE), options),
        others=others, scenes=scenes, assets=unseen, cells=cells, gains=gains,
    )  # fmt: skip


def _page(
    files: RunFiles,
    published: Path,
    facts: dict[str, Any],
    options: TablesConfig,
    width: int,
) -> str:
    album = Album(width, options.picture_quality)
    shown = _tables(files, published, options)
    over, by_role = result.over_assets(shown.assets), result.over_roles(shown.cells, shown.gains)
    first = [*over, *(each for each in by_role if each.group not in {one.group for one in over})]
    models, tasks, made = library.collect(files, album), policies.collect(files, album), rooms.collect(files, album)
    of_tasks = [room for task in tasks for room in made if room.name == task.scene]
    drawn = {name: (files.one(f"figures/{name}.svg"), alt) for name, alt in FIGURES.items()}
    return (
        environment()
        .get_template("page/page.html.jinja")
        .render(
            **facts,
            first=next(iter([*of_tasks, *made]), None),
            results=first,
            roles=[each for each in by_role if each not in first],
            tiles=tiles(shown.scenes, models, tasks, options),
            rooms=made,
            library=models,
            tasks=tasks,
            tables=shown.others,
            of_policies=shown.policies,
            folded=shown.folded,
            figures={
                name: (inline(read_text(path), alt) if path else None, alt) for name, (path, alt) in drawn.items()
            },
            script=Markup("\n".join(read_text(Path(__file__).with_name("page") / name) for name in SCRIPTS)),
            times_page=TIMES_PAGE,
            number=number,
            percent=percent,
            rate=lambda successes, episodes: rate(successes, episodes, options.confidence),
            role_title=role_title,
        )
    )


def _times_page(benchmarks: tuple[Path, ...], root: Path, page: str, more: int) -> str:
    """The page of the times, with a link back to `page`; `more` scenes are not counted."""
    jobs = read_jobs(benchmarks, root)
    return (
        environment()
        .get_template("page/times.html.jinja")
        .render(
            page=page,
            more=more,
            times=by_stage(jobs, STAGES),
            longest=sorted(jobs, key=lambda job: (-job.seconds, job.name))[:8],
            duration=duration,
            number=number,
            percent=percent,
        )
    )


def run(
    *,
    out: Path,
    files: tuple[Path, ...] = (),
    images: tuple[str, ...] = (),
    benchmarks: tuple[Path, ...] = (),
    benchmarks_root: Path = Path("benchmarks"),
    published: Path = Path("report/published"),
    title: str = "Digital cousins from one picture",
    config_digest: str = "",
    seed: int | None = None,
    more: int = 0,
    options: str = "",
) -> None:
    """Write the page; every part that was not run is said to be so.

    The same run gives the same page, byte for byte: how long its jobs took stands in times.html beside it.

    Args:
        out: the HTML file.
        files: everything that the page may show, in the fixed layout of results/; nothing else is looked at.
        images: the pictures that went in, as room=picture.
        benchmarks: Snakemake's benchmark files of this run; those that are not there are left out.
        benchmarks_root: the folder whose first level names the stage of a benchmark.
        published: folder with the paper's values.
        title: title of the page.
        config_digest: digest of the config, to be shown.
        seed: seed of the run, to be shown.
        more: how many more scenes the run has, which are neither shown nor counted here.
        options: JSON of the config section `tables`.
    """
    settings = read_options(TablesConfig, options)
    declared = RunFiles(files, {room: path for (room, _), path in named(images, "--images").items()})
    facts = {"title": title, "config_digest": config_digest, "seed": seed, "more": more}
    for width in (settings.picture_width, settings.picture_width * 2 // 3, settings.picture_width // 2):
        page = _page(declared, published, facts, settings, width)
        if len(page.encode()) <= MAX_BYTES:
            break
    write_text(out.with_name(TIMES_PAGE), _times_page(benchmarks, benchmarks_root, out.name, more))
    write_text(out, page)
