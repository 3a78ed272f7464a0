"""Command `results`: what a study found, as Markdown, CSV and figures to commit; also while it is still running."""

import os
from collections.abc import Iterator
from pathlib import Path
from typing import Literal, NamedTuple

import pandas as pd

from roomkin.plugins.claims import more, trainings
from roomkin.plugins.claims.assets import of_splits
from roomkin.plugins.report.roles import list_demonstrated_assets, lists_table, roles_table
from roomkin.plugins.robustness import table as robustness
from roomkin.plugins.robustness.table import robustness_table
from roomkin.plugins.studies import conditions
from roomkin.plugins.studies.associations import ShownAssets, associations_table, traits
from roomkin.plugins.studies.associations import build as associate
from roomkin.plugins.studies.study import (
    cost,
    facts,
    fold_table,
    list_counting_runs,
    policy_file,
    progress_table,
    split_totals,
)
from roomkin.stages.config.evaluation import USUAL
from roomkin.stages.config.model import Config, read_files
from roomkin.stages.config.targets import Cell
from roomkin.stages.config.training import policy_tables
from roomkin.stages.contracts.files import read_json, write_text
from roomkin.stages.contracts.library import Library
from roomkin.stages.contracts.policies import ChosenRuns, SceneScore, TaskAssets
from roomkin.stages.contracts.policy_config import is_randomised
from roomkin.stages.tables import policy_tables as table3_text
from roomkin.stages.tables import table2, table3
from roomkin.stages.tables.figures import figure6, save, style
from roomkin.stages.tables.policies import collect, write_figures
from roomkin.stages.tables.rows import ONE_SCENE, SKILL, SPLITS, published_scenes, read_rows, target_title, title
from roomkin.stages.tables.table2 import scenes_table
from roomkin.stages.tables.text import TextTable, write_csv

SCENE_STAGES = ["assets", "scenes", "extraction", "matching", "generation", "evaluation", "tables"]
POLICY_STAGES = ["demonstrations", "training", "evaluation"]


class StudyResults(NamedTuple):
    """The results of a study: facts about it, tables for people, CSV files by name, figures with their captions."""

    title: str
    facts: list[tuple[str, str]]
    tables: list[TextTable]
    frames: dict[str, pd.DataFrame]
    figures: dict[str, str]


def policies_of(config: Config, results: Path) -> Iterator[tuple[Cell, str, int]]:
    """Cell, hyper-parameters and seed of the policies of a study that count."""
    for cell in config.experiment.cells:
        for run in list_counting_runs(config, results, cell):
            yield from ((cell, run, seed) for seed in config.experiment.plan(cell.policy).seeds)


def rollout_files(config: Config, results: Path, condition: str = "") -> Iterator[Path]:
    """The rollouts of the study's policies, and of the skill on the same assets, as far as they are there."""
    skills = f"conditions/{condition}/{{}}/skill" if condition else "skill/{}"
    paths = [policy_file(results, condition, *policy) for policy in policies_of(config, results)]
    paths += [results / "evaluation" / skills.format(name) / "rollouts.csv" for name in config.experiment.targets]
    yield from filter(Path.is_file, paths)


def _trainings(config: Config, results: Path) -> pd.DataFrame:
    """How the trainings of the study ended, as far as they are there."""
    found = policies_of(config, results)
    paths = [results / "training" / Path(*cell) / f"{run}/seed_{seed}/config.json" for cell, run, seed in found]
    return trainings.collect([path for path in paths if path.is_file()])


def list_cells(config: Config) -> pd.DataFrame:
    """The cells that the study is to fill, with `table3.CELL`, task and cloud; targets pooled."""
    experiment, pools = config.experiment, table3_text.pool_of(policy_tables(config), config.experiment.targets)
    cells = [
        (pools[target], policy, asset, name, experiment.task(target), config.task_of(target).cloud)
        for target, policy, name in experiment.cells
        for asset in config.evaluation.test_assets
    ]
    return pd.DataFrame(cells, columns=[*table3.CELL, "task", "cloud"]).drop_duplicates()


def _tabulate_trials(config: Config, results: Path) -> list[TextTable]:
    """The selection rollouts of the policy configs; nothing if there were none."""
    rows = []
    for cell in config.experiment.cells:
        path = results / "evaluation/selection" / Path(*cell) / "chosen.json"
        if config.experiment.needs_choice(cell.policy) and path.is_file():
            chosen = read_json(ChosenRuns, path)
            scores = ", ".join(f"{score.run} {score.successes}/{score.episodes}" for score in chosen.scores)
            name = f"{target_title(cell.target, config.experiment.task(cell.target))}, {cell.policy}"
            rows.append([name, title(cell.training_set), ", ".join(chosen.runs), scores])
    columns = ["Policy", "Training set", "Chosen", "Trials on the twin (best checkpoint of the first seed)"]
    return [TextTable("chosen", "Hyper-parameter sets chosen by trials.", columns, rows, headers=2)] if rows else []


def _with_traits(config: Config, results: Path, rollouts: pd.DataFrame) -> pd.DataFrame:
    """The rollouts on unseen assets of the targets whose assets.json is there, with what is known of each asset."""
    experiment, parts = config.experiment, []
    for target, part in of_splits(rollouts).groupby("target", sort=False):
        path = results / f"experiment/{experiment.policy_variant}/{target}/assets.json"
        if path.is_file():
            chosen, stretch = read_json(TaskAssets, path), config.task_of(str(target)).scale_range
            wider, policies = config.demonstrations.randomise.extents, part[part["training_set"] != SKILL]
            sets = {
                (name, seed): ShownAssets(
                    list_demonstrated_assets(chosen, experiment.roles(name, seed)),
                    wider if is_randomised(name) else stretch,
                )
                for name, seed in policies[["training_set", "seed"]].drop_duplicates().itertuples(index=False)
            }
            known = traits([*chosen.test_assets, *chosen.validation_assets], sets)
            parts.append(part.merge(known, on=["training_set", "seed", "asset"]))
    return pd.concat(parts, ignore_index=True) if parts else rollouts[:0]


def _tabulate_conditions(config: Config, results: Path, usual: pd.DataFrame) -> list[TextTable]:
    """Success under each of `evaluation.conditions`, and there minus the baselines; nothing where none was tested."""
    found, options = (
        {name: list(rollout_files(config, results, name)) for name in config.evaluation.conditions},
        policy_tables(config),
    )
    tested = [table3_text.read_pooled(paths, options).assign(condition=name) for name, paths in found.items() if paths]
    if not tested:
        return []
    episodes = of_splits(pd.concat([usual.assign(condition=USUAL), *tested], ignore_index=True))
    return [
        conditions.conditions_table(conditions.build(episodes, options)),
        conditions.baselines_table(conditions.against_baselines(episodes, options)),
    ]


def _about_rollouts(config: Config, episodes: pd.DataFrame) -> list[tuple[str, str]]:
    """Seeds and numbers of rollouts."""
    policies = episodes[episodes["training_set"] != SKILL]
    seeds = sorted(policies["seed"].unique())
    policy = ["target", "task", "policy", "training_set", "run", "seed"]
    each = policies.groupby([*policy, "test_asset"]).size().groupby(["target", "task", "test_asset"]).max()
    rollouts = f"{len(policies)} episodes of {policies.groupby(policy).ngroups} policies"
    roles = each[~each.index.isin(SPLITS, level="test_asset")].groupby(["target", "task"]).max()
    grouped = roles.groupby(roles)
    counts = [f"{count} ({'; '.join(target_title(*name) for name in part.index)})" for count, part in grouped]
    if len(roles):
        rollouts += f", {' and '.join(counts) if len(counts) > 1 else roles.iloc[0]} per role"
    about = [("Seeds", f"{', '.join(map(str, seeds)) or 'none'} of training; {config.seed} of everything else")]
    about.append(("Rollouts", rollouts))
    for (target, task, split), part in of_splits(policies).groupby(["target", "task", "test_asset"], sort=False):
        pairs, models = part["asset"].nunique(), part["asset"].str.rsplit("/").str[-1].nunique()
        assets = f"{pairs} pairs of room and asset, {models} assets" if models < pairs else str(pairs)
        assets += f" of {part['family'].nunique()} families"
        states = part.groupby("asset")["initial_state"].nunique().max()
        name = f"{target_title(str(target), str(task))}, {title(str(split))}"
        about.append((name, f"{assets}, {states} initial states each"))
    return about


def _policies(config: Config, results: Path, published: Path, out: Path) -> StudyResults:
    options, trained = policy_tables(config), _trainings(config, results)
    rows, kinds = (
        table3_text.read_rollouts(list(rollout_files(config, results)), options),
        table3_text.kinds_of(options),
    )
    episodes, asked = table3_text.pool_rollouts(rows, options), list_cells(config)
    found = collect(episodes, published, options, asked)
    notes = [*table3_text.policy_notes(options), *trainings.failed_note(trained)]
    beside = more.collect(found, options)
    tables = more.asset_tables(beside, options, kinds, notes)
    tables += [table3_text.policies_table(found.cells, found.published, options, kinds, notes)]
    tables += more.claim_tables(beside, options)
    tables += [trainings.trainings_table(trained)] if len(trained) else []
    tables += more.target_tables(rows, options, kinds)
    known = _with_traits(config, results, rows)
    if len(known):
        tables.append(associations_table(associate(table3_text.pool_rollouts(known, options), options)))
    tables += _tabulate_conditions(config, results, episodes)
    for target in config.experiment.targets:
        path = results / f"experiment/{config.experiment.policy_variant}/{target}/assets.json"
        if path.is_file():
            chosen, roles = read_json(TaskAssets, path), config.experiment.list_trained_roles(target)
            name = target_title(target, config.experiment.task(target))
            tables.append(roles_table(chosen, roles, f"roles-{target}", f"{name}: the assets."))
            tables += lists_table(chosen, f"lists-{target}", f"{name}: sets of assets.")
    write_figures(out, found, options, more.make_panels(episodes, options), ("webp",))
    done = found.runs[found.runs["status"] == "run"].drop_duplicates(table3.CELL)
    print(f"{len(done)} of {len(asked)} cells of the study, {len(episodes)} episodes")
    return StudyResults(
        title=f"Table 3: success {'over unseen assets, and ' if len(of_splits(episodes)) else ''}by role",
        facts=_about_rollouts(config, episodes),
        tables=[progress_table(config, results), *tables, *_tabulate_trials(config, results)],
        frames={"table3": found.runs, "assets": beside.assets, "assets_by_handle": beside.by_handle},
        figures={"figure4.webp": "Figure 4", "figure9.webp": "Figure 9"},
    )


def score_files(config: Config, results: Path) -> list[Path]:
    """The scores of the study that are there; of a draw of a perturbation only if all its rooms are there."""
    experiment = config.experiment
    groups: dict[tuple[str, str], list[Path]] = {}
    for variant in experiment.variants:
        for room in (room for room in experiment.rooms if room not in experiment.inputs):
            groups[variant, room] = [results / f"evaluation/scenes/{variant}/{room}/scores.csv"]
    for scene, variants in experiment.perturbed_scenes().items():
        for variant in variants:
            path = results / f"evaluation/scenes/{variant}/{scene}/scores.csv"
            groups.setdefault((variant, scene.partition(".")[2]), []).append(path)
    return [path for paths in groups.values() if all(each.is_file() for each in paths) for path in paths]


def list_perturbations(config: Config) -> list[tuple[str, str]]:
    """Perturbations of the study with their variants; '' is the rooms as they are."""
    experiment = config.experiment
    perturbations = {"": experiment.variants} | {
        name: perturbation.variants or experiment.variants for name, perturbation in experiment.protocols.items()
    }
    return [(name, variant) for name, variants in perturbations.items() for variant in variants]


def _library(results: Path) -> str:
    path = results / "assets/library/library.json"
    if not path.is_file():
        return ""
    assets = read_json(Library, path).assets
    return f"{len(assets)} models in {len({entry.category for entry in assets})} categories"


def _scenes(config: Config, results: Path, published: Path, out: Path, variants: tuple[str, ...]) -> StudyResults:
    experiment, files = config.experiment, score_files(config, results)
    rows = read_rows(SceneScore, files, ONE_SCENE)
    scenes = table2.build(rows, published_scenes(published), config.tables)
    companion = robustness.build(rows, list_perturbations(config))
    seeds = [f"{name} {' '.join(map(str, perturbation.seeds))}" for name, perturbation in experiment.protocols.items()]
    pairs = [(room, variant) for room in experiment.rooms for variant in variants or experiment.variants]
    paths = {pair: results / f"generation/{pair[1]}/{pair[0]}/comparison.png" for pair in pairs}
    pictures = {pair: path for pair, path in paths.items() if path.is_file()}
    if pictures:
        with style():
            save(figure6(pictures, list(config.tables.scenes), config.tables.picture_width), out, "figure6", ("webp",))
    print(f"{len(files)} scenes, {companion['n_draws'].notna().sum()} of {len(companion)} rows of the companion")
    return StudyResults(
        title="Table 2",
        facts=[
            ("Seeds", f"{config.seed} of library, rooms and depth noise; {', '.join(seeds)}"),
            ("Library", _library(results)),
            ("Scenes", f"{len(files)} scored, {(rows['rank'] == 1).sum()} objects"),
        ],
        tables=[*split_totals(scenes_table(scenes, config.tables)), robustness_table(companion)],
        frames={"table2": scenes, "table2_robustness": companion},
        figures={"figure6.webp": "Figure 6: the rooms and their reconstructions"} if pictures else {},
    )


def run(
    *,
    out: Path,
    table: Literal[2, 3] = 3,
    configs: tuple[Path, ...] = (Path("config.yaml"),),
    results: Path = Path("results"),
    benchmarks: Path = Path("benchmarks"),
    published: Path = Path("report/published"),
    machine: str = "",
    commit: str = "",
    variants: tuple[str, ...] = (),
) -> None:
    """Write table<n>.md, its tables as CSV and its figures into `out`; cells without results are marked `not run`.

    Args:
        out: folder to write into.
        table: 2: scenes, with their robustness variants and Figure 6; 3: policies, with Figures 4 and 9.
        configs: the config files of the study, later ones over earlier ones.
        results: folder that the study writes.
        benchmarks: folder of its benchmark files.
        published: folder with the paper's values.
        machine: what it ran on; this machine if left out.
        commit: of the code, to be named on the page and in a column of every CSV file.
        variants: variants of matching in Figure 6; all if left out.
    """
    config = read_files(configs)
    if table == 2:
        found, target, stages = _scenes(config, results, published, out, variants), "table2", SCENE_STAGES
    else:
        found, target, stages = _policies(config, results, published, out), "all", POLICY_STAGES
    text = [f"# {found.title}", "", facts(target, configs, commit, machine, found.facts)]
    text += map(fold_table, [*found.tables, cost(benchmarks, stages)])
    text += [f"![{caption}]({name})\n" for name, caption in found.figures.items()]
    reference = os.path.relpath("docs/tables.md", out)
    text.append(f"All columns: {', '.join(f'`{name}.csv`' for name in found.frames)} ([reference]({reference})).\n")
    for name, frame in found.frames.items():
        write_csv(out / f"{name}.csv", frame.assign(commit=commit) if commit else frame)
    write_text(out / f"table{table}.md", "\n".join(text))
    print(f"Open {out / f'table{table}.md'}")
