"""Verb `policies`: Table 3 and what goes with it, from the rollouts of policies."""

from pathlib import Path

from stages.config.tables import TablesConfig
from stages.contracts.files import read_options, write_text
from stages.contracts.policies import Rollout
from stages.tables import claims, formatting, table3
from stages.tables.claim_tables import claims_table, stability_table
from stages.tables.rows import published_policies, published_runs, read_rows
from stages.tables.writing import as_csv, write

ONE_TEST = ["task", "training_set", "run", "seed", "checkpoint", "test_asset"]


def run(
    *,
    out: Path,
    rollouts: tuple[Path, ...] = (),
    published: Path = Path("report/published"),
    options: str = "",
) -> None:
    """Write table3.{csv,html,tex} and table3_{differences,claims,stability}.csv into `out`.

    Args:
        out: folder to write into.
        rollouts: rollouts.csv files of policies.
        published: folder with the paper's values, table3.csv.
        options: JSON of the config section `tables`.
    """
    settings = read_options(TablesConfig, options)
    episode_rows = read_rows(Rollout, rollouts, ONE_TEST)
    paper = published_policies(published)

    policies = table3.build(episode_rows, paper, settings)
    gains = table3.differences(episode_rows, settings)
    shown = [formatting.policies_table(policies, paper, settings)]
    runs = published_runs(published)
    answers, stable = claims.answer(episode_rows, runs, settings), claims.stability(policies, runs)
    shown += [claims_table(answers, settings)] if len(answers) else []
    shown += [stability_table(stable)] if len(stable) else []
    shown += [formatting.differences_table(gains, settings)] if len(gains) else []
    shown += [formatting.runs_table(policies)] if (policies["status"] == "run").any() else []
    write(out, "table3", policies, shown)
    write_text(out / "table3_differences.csv", as_csv(gains))
    write_text(out / "table3_claims.csv", as_csv(answers))
    write_text(out / "table3_stability.csv", as_csv(stable))
