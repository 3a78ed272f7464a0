"""Plan a run and count what it would submit: `python -m tests.cluster.submissions ARGUMENTS OF SNAKEMAKE`."""

import sys
from collections import Counter
from typing import Any

from snakemake import cli
from snakemake.executors.dryrun import Executor


def main(arguments: list[str]) -> int:
    """Print how many submissions of each kind: the name of a group, a rule, or `local`."""
    counts: Counter[str] = Counter()

    def run_job(self: Any, job: Any) -> None:
        if job.is_group():
            counts[f"group {job.groupid}"] += 1
        else:
            rule = job.rule
            counts["local" if rule.norun or rule.name in self.workflow._localrules else rule.name] += 1
        planned(self, job)

    planned, Executor.run_job = Executor.run_job, run_job
    sys.argv = ["snakemake", "-n", "--quiet=all", *arguments]
    try:
        cli.main()
    except SystemExit as leaves:
        for name, count in sorted(counts.items()):
            print(f"{count:6d} {name}")
        return int(leaves.code or 0)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
