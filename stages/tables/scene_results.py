"""Verb `scene_results`: what a study of Table 2 found, as Markdown and CSV to be committed; also while it runs."""

from pathlib import Path

import pandas as pd
from matplotlib import pyplot as plt

from stages.config.model import Config
from stages.contracts.files import atomic, read_json, write_text
from stages.contracts.library import Library
from stages.contracts.policies import SceneScore
from stages.tables import formatting, robustness, table2
from stages.tables.drawing import look
from stages.tables.markup import markdown
from stages.tables.rows import published_scenes, read_rows
from stages.tables.scene_figure import figure6
from stages.tables.scenes import ONE_SCENE
from stages.tables.study import cost, facts, read_config
from stages.tables.writing import as_csv

STAGES = ["assets", "scenes", "extraction", "matching", "generation", "evaluation", "tables"]


def score_files(config: Config, results: Path) -> list[Path]:
    """The scores of the study that are there; of a protocol's draw, only if they are there for all rooms."""
    experiment = config.experiment
    rooms = [room for room in experiment.rooms if room not in experiment.inputs]
    groups: dict[tuple[str, str], list[Path]] = {}
    for variant in experiment.variants:
        for room in rooms:
            groups[variant, room] = [results / f"evaluation/scenes/{variant}/{room}/scores.csv"]
    for scene, variants in experiment.met().items():
        for variant in variants:
            path = results / f"evaluation/scenes/{variant}/{scene}/scores.csv"
            groups.setdefault((variant, scene.partition(".")[2]), []).append(path)
    return [path for paths in groups.values() if all(each.is_file() for each in paths) for path in paths]


def asked(config: Config) -> list[tuple[str, str]]:
    """Protocols of the study with their variants."""
    experiment = config.experiment
    pairs = [
        (name, variant)
        for name, protocol in experiment.protocols.items()
        for variant in protocol.variants or experiment.variants
    ]
    return [*(("", variant) for variant in experiment.variants), *pairs]


def _pictures(config: Config, results: Path, drawn: tuple[str, ...]) -> dict[tuple[str, str], Path]:
    """The comparison pictures that are there, by room and variant."""
    pairs = [(room, variant) for room in config.experiment.rooms for variant in drawn or config.experiment.variants]
    found = {pair: results / f"generation/{pair[1]}/{pair[0]}/comparison.png" for pair in pairs}
    return {pair: path for pair, path in found.items() if path.is_file()}


def run(
    *,
    out: Path,
    configs: tuple[Path, ...] = (Path("config.yaml"),),
    results: Path = Path("results"),
    benchmarks: Path = Path("benchmarks"),
    published: Path = Path("report/published"),
    machine: str = "",
    commit: str = "",
    drawn: tuple[str, ...] = (),
) -> None:
    """Write table2.md, table2.csv, table2_robustness.csv, figure6.jpg into `out`: what is there; the rest is `not run`.

    Args:
        out: folder to write into.
        configs: the config files of the study, later ones over earlier ones.
        results: folder that the study writes.
        benchmarks: folder of its benchmark files.
        published: folder with the paper's values.
        machine: what it ran on; this machine if left out.
        commit: of the code, to be named.
        drawn: variants in Figure 6; all if left out.
    """
    config = read_config(configs)
    files = score_files(config, results)
    rows = read_rows(SceneScore, files, ONE_SCENE)
    scenes = table2.build(rows, published_scenes(published), config.tables)
    companion = robustness.build(rows, asked(config))
    seeds = ", ".join(
        f"{name} {' '.join(map(str, protocol.seeds))}" for name, protocol in config.experiment.protocols.items()
    )
    told = [
        ("Seeds", f"{config.seed} of library, rooms and depth noise; {seeds}"),
        ("Library", _library(results)),
        ("Scenes", f"{len(files)} scored, {len(rows[rows['rank'] == 1])} objects"),
    ]
    shown = [formatting.scenes_table(scenes, config.tables), formatting.robustness_table(companion)]
    shown.append(cost(benchmarks, STAGES))
    text = ["# Table 2", "", facts("table2", configs, commit, machine, told), *map(markdown, shown)]
    if pictures := _pictures(config, results, drawn):
        with look(), atomic(out / "figure6.jpg") as path:
            figure = figure6(pictures, list(config.tables.scenes))
            figure.savefig(path, format="jpg", pil_kwargs={"quality": 85})
            plt.close(figure)
        text.append("**Figure 6: the rooms and their reconstructions.**\n\n![Figure 6](figure6.jpg)\n")
    text.append("`table2.csv` and `table2_robustness.csv` hold all columns ([what they are](../tables.md)).\n")
    write_text(out / "table2.csv", as_csv(scenes))
    write_text(out / "table2_robustness.csv", as_csv(companion))
    write_text(out / "table2.md", "\n".join(text))
    print(f"{len(files)} scenes, {(pd.notna(companion['n_draws'])).sum()} of {len(companion)} rows of the companion")


def _library(results: Path) -> str:
    path = results / "assets/library/library.json"
    if not path.is_file():
        return ""
    assets = read_json(Library, path).assets
    return f"{len(assets)} models in {len({entry.category for entry in assets})} categories"
