"""The workflow with `profiles/slurm`, and a stage that sleeps in the place of `training train` and `scenes render`."""

import json
import os
import shlex
import shutil
import subprocess
import sys
from collections import defaultdict
from pathlib import Path

from tests.cluster.slurm import Cluster
from tests.workflow.workspace import MICRO, copy

HERE = Path(__file__).parent
PROFILES = ("--profile", "profiles/slurm", "--profile", str(HERE / "profile"))
POLICIES = [
    f"results/training/door/{run}/seed_0/policy.safetensors"
    for run in ("micro/twin/micro", "micro/twin/micro_small", "micro_handle/twin/micro_handle")
]
ROOM = "results/scenes/room_1/truth.json"


def start(cluster: Cluster, folder: Path, *arguments: str) -> subprocess.Popen[bytes]:
    """Snakemake on the cluster; what it prints is appended to out.log."""
    heeds = ["env", "--default-signal=INT"]  # Ctrl-C, also where a shell has started the tests in the background
    command = [*heeds, sys.executable, "-P", str(HERE / "impatient.py"), *PROFILES, *arguments]
    with (folder / "out.log").open("ab") as log:
        return subprocess.Popen(
            command, cwd=folder, env=os.environ | cluster.environment, stdout=log, stderr=log, start_new_session=True
        )


def said(folder: Path) -> str:
    """What the workflows in a folder have printed."""
    return (folder / "out.log").read_text()


def with_sleepers(run: Path, folder: Path, config: str = "", **plan: object) -> tuple[str, ...]:
    """A finished run whose policies and room are to be made again, by `sleeper.py`; returns the arguments for it."""
    copy(run, folder)
    (folder / "results").rename(folder / "finished")
    shutil.copytree(folder / "finished", folder / "results")
    shutil.rmtree(folder / "results/training")
    shutil.rmtree(folder / "results/scenes")
    (folder / "plan.json").write_text(json.dumps(plan))
    sleeper = {"command": f"{shlex.quote(sys.executable)} {HERE / 'sleeper.py'}"}
    stages = {"training": {"train": sleeper}, "scenes": {"render": sleeper}}
    (folder / "mine.yaml").write_text(json.dumps({"stages": stages}) + "\n")
    (folder / "more.yaml").write_text(config or "{}")
    # what the sleepers make is older than what was made of it: nothing else is to be made again
    return ("--rerun-triggers", "mtime", *MICRO, "mine.yaml", "more.yaml", "--")


def journal(folder: Path) -> dict[str, dict[str, list[float]]]:
    """Name of the job -> its processes, in order, as `node pid` -> times at which it was at work."""
    beats: dict[str, dict[str, list[float]]] = defaultdict(dict)
    path = folder / "journal"
    for line in path.read_text().splitlines() if path.exists() else []:
        name, node, pid, moment = line.split()
        beats[name].setdefault(f"{node} {pid}", []).append(float(moment))
    return beats


def at_once(first: list[float], second: list[float]) -> bool:
    """Whether two processes worked at the same time."""
    return first[0] < second[-1] and second[0] < first[-1]
