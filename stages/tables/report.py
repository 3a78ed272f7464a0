"""Verb `report`: the whole run on one page that needs nothing but a browser."""

import base64
import re
from pathlib import Path
from typing import Any

import pandas as pd
from markupsafe import Markup

from stages.config.tables import TablesConfig
from stages.contracts.errors import InputError
from stages.contracts.files import read_options, read_text, write_text
from stages.tables import formatting, table2, table3
from stages.tables.markup import Table, environment, number, percent
from stages.tables.order import title as name_title
from stages.tables.order import variant_title
from stages.tables.page import library, policies, rooms
from stages.tables.page.benchmarks import by_stage, duration, read_jobs
from stages.tables.page.headline import rate, tiles
from stages.tables.page.pictures import Album, Picture
from stages.tables.rows import published_policies, read_table

MAX_BYTES = 15_000_000
STAGES = ["assets", "scenes", "extraction", "matching", "generation", "experiment"]
STAGES += ["demonstrations", "training", "evaluation", "tables"]
TEXT = ["scene", "variant", "task", "test_asset", "training_set", "baseline", "run", "checkpoint", "asset", "status"]
WHOLE = re.compile(r".*_correct|(published_)?n_.*|(baseline_)?runs|states|episodes|successes|seed")
FIGURES = {
    "figure4": "Figure 4: success against the distance of the test asset from the twin, with Wilson intervals.",
    "figure9": "Figure 9: success on the four test assets for every training set; the paper's values are dashed.",
    "figure6": "Figure 6: every room beside its reconstruction.",
}


def _figure(path: Path, alt: str, album: Album) -> Picture | None:
    """A figure as it is if it is small (its lines stay sharp), else as a picture."""
    if not path.is_file():
        return None
    data = path.read_bytes()
    if len(data) > 400_000:
        return album.maybe(path.with_suffix(".png"), alt)
    return Picture("data:image/svg+xml;base64," + base64.b64encode(data).decode("ascii"), 0, 0, alt)


def _table(path: Path, columns: list[str]) -> pd.DataFrame | None:
    if not path.is_file():
        return None
    table = read_table(path, columns, TEXT)
    return table.astype(dict.fromkeys((name for name in columns if WHOLE.fullmatch(name)), "Int64"))


def _tables(folder: Path, published: Path, options: TablesConfig) -> tuple[list[Table], dict[str, pd.DataFrame | None]]:
    """Tables to show, and the data behind the headline."""
    scenes = _table(folder / "table2.csv", table2.ALL_COLUMNS)
    runs = _table(folder / "table3.csv", table3.ALL_COLUMNS)
    gains = _table(folder / "table3_differences.csv", table3.DIFFERENCE_COLUMNS)
    shown = [formatting.scenes_table(scenes, options)] if scenes is not None else []
    if runs is not None:
        shown.append(formatting.policies_table(runs, published_policies(published), options))
    if gains is not None and len(gains):
        shown.append(formatting.differences_table(gains, options))
    pooled = None if runs is None else table3.pool(runs, options.confidence)
    return shown, {"scenes": scenes, "pooled": pooled, "gains": gains}


def _page(results: Path, benchmarks: Path, tables: Path, figures: Path, published: Path, facts: dict[str, Any],
          options: TablesConfig, width: int) -> str:  # fmt: skip
    album = Album(width, options.picture_quality)
    shown, data = _tables(tables, published, options)
    jobs = read_jobs(benchmarks)
    times = by_stage(jobs, STAGES)
    models, tasks = library.collect(results, album), policies.collect(results, album)
    drawn = {name: (_figure(figures / f"{name}.svg", alt, album), alt) for name, alt in FIGURES.items()}
    template = environment().get_template("page/page.html.jinja")
    return template.render(
        **facts,
        tiles=tiles(data["scenes"], data["pooled"], models, tasks, times, options),
        rooms=rooms.collect(results, album),
        library=models,
        tasks=tasks,
        tables=shown,
        figures=drawn,
        times=times,
        longest=sorted(jobs, key=lambda job: (-job.seconds, job.name))[:8],
        script=Markup(read_text(Path(__file__).with_name("page") / "page.js")),
        duration=duration,
        number=number,
        percent=percent,
        rate=lambda successes, episodes: rate(successes, episodes, options.confidence),
        name=name_title,
        variant_title=variant_title,
    )


def run(
    *,
    out: Path,
    results: Path = Path("results"),
    benchmarks: Path = Path("benchmarks"),
    tables: Path = Path("results/tables"),
    figures: Path = Path("results/figures"),
    published: Path = Path("report/published"),
    title: str = "Digital cousins from one picture",
    config_digest: str = "",
    seed: int | None = None,
    options: str = "",
) -> None:
    """Write the page; every part that was not run is said to be so.

    Args:
        out: the HTML file.
        results: folder of the run's outputs, in their fixed formatting.
        benchmarks: folder of Snakemake's benchmark files.
        tables: folder of table2.csv, table3.csv and table3_differences.csv.
        figures: folder of figure4.svg, figure6.svg and figure9.svg.
        published: folder with the paper's values.
        title: title of the page.
        config_digest: digest of the config, to be shown.
        seed: seed of the run, to be shown.
        options: JSON of the config section `tables`.
    """
    settings = read_options(TablesConfig, options)
    if not results.is_dir():
        raise InputError(results, "no such folder.", "run the workflow first: snakemake --cores 2 all")
    facts = {"title": title, "config_digest": config_digest, "seed": seed}
    for width in (settings.picture_width, settings.picture_width * 2 // 3, settings.picture_width // 2):
        page = _page(results, benchmarks, tables, figures, published, facts, settings, width)
        if len(page.encode()) <= MAX_BYTES:
            break
    write_text(out, page)
