"""Run the rule `table3` in its container with podman, on rows made for the purpose, and compare with a run on the host.

Called by containers/check.sh once the report image is built; it is a script because pytest must not need podman.
"""

import csv
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from stages.contracts import Rollout

ROOT = Path(__file__).resolve().parents[2]
SNAKEMAKE = [
    str(Path(sys.executable).parent / "snakemake"),
    "--cores",
    "1",
    "--allowed-rules",
    "table3",
    "--quiet",
    "rules",
]


def rows() -> list[Rollout]:
    """A few plausible rows."""
    return [
        Rollout(
            task="door", assets_of="door", cloud="object", training_set="twin", run="lite", seed=0,
            checkpoint="last", test_asset="twin", asset="a1", family="a1", handle="bar", handle_length=0.2,
            dino_distance=0.0, episode=k, initial_state=k, success=k % 3 > 0, official_success=True, steps=50,
            opened=0.4,
        )
        for k in range(8)
    ]  # fmt: skip


def write(path: Path, items: list) -> None:
    """Write rows as CSV."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("w", newline="") as file:
        writer = csv.DictWriter(file, list(type(items[0]).model_fields))
        writer.writeheader()
        writer.writerows(item.model_dump() for item in items)


def main() -> int:
    """Exit code 0 if the container's tables equal the host's."""
    rollouts = rows()
    with tempfile.TemporaryDirectory() as folder:
        work = Path(folder) / "workflow"
        passed_over = (".venv", ".git", ".snakemake", "results", "logs", "*.egg-info", "__pycache__")
        shutil.copytree(ROOT, work, symlinks=True, ignore=shutil.ignore_patterns(*passed_over))
        experiment = "{rooms: [room_3], training_sets: [twin], tasks: {door_handle: null}}"
        (work / "one.yaml").write_text(f"experiment: {experiment}\n")
        write(work / "results/evaluation/policies/door/twin/rollouts.csv", rollouts)
        of_skill = {"training_set": "skill", "run": "scripted", "checkpoint": "none"}
        write(
            work / "results/evaluation/skill/door/rollouts.csv", [row.model_copy(update=of_skill) for row in rollouts]
        )
        base = [*SNAKEMAKE, "--configfile", "config.yaml", "one.yaml", "--", "table3"]
        produced = {}
        for place, extra in (
            ("host", []),
            ("container", ["--set-resources", "table3:shell_exec=containers/sh-report"]),
        ):
            shutil.rmtree(work / "results/tables", ignore_errors=True)
            command = [base[0], *extra, *base[1:]]
            done = subprocess.run(command, cwd=work, text=True, capture_output=True)
            if done.returncode:
                print(done.stdout, done.stderr, sep="\n")
                print(f"containers: the rule failed on the {place}")
                return 1
            produced[place] = {path.name: path.read_bytes() for path in sorted((work / "results/tables").iterdir())}
        if produced["host"] != produced["container"]:
            print("containers: the tables of the container differ from those of the host")
            return 1
    count = len(produced["host"])
    print(f"containers: rule table3 ran in its image and wrote {count} files, byte for byte those of the host")
    return 0


if __name__ == "__main__":
    sys.exit(main())
