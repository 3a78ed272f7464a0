"""Command `cluster`: what a SLURM cluster has and lacks, from one of its login nodes."""

import fcntl
import getpass
import re
import secrets
import shlex
import subprocess
import sys
import tempfile
from importlib import metadata
from pathlib import Path

from roomkin.plugins.ops.doctor import Check, report

PLUGIN = "snakemake-executor-plugin-slurm"
MIN_AGE = 60  # seconds that a finished job must stay in the queue for squeue to tell how it ended


def answer(*command: str, seconds: float = 30.0) -> str:
    """The output of a command; '' if it is not there, fails or takes too long."""
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=seconds)
    except (OSError, subprocess.TimeoutExpired):
        return ""
    return done.stdout.strip() if done.returncode == 0 else ""


def setting(config: str, name: str) -> str:
    """A value of what `scontrol show config` prints; '' if it is not there."""
    match = re.search(rf"^{name}\s*=\s*(.*?)\s*$", config, re.MULTILINE)
    return match[1] if match else ""


def check_slurm(config: str) -> Check:
    """A controller answers."""
    name, version = setting(config, "ClusterName"), setting(config, "SLURM_VERSION")
    what = f"cluster {name}, SLURM {version}" if config else "scontrol does not answer"
    return Check("slurm", bool(config), what, "run this on a login node of the cluster, where `sinfo` answers")


def check_plugin() -> Check:
    """Snakemake's executor plugin."""
    try:
        return Check("plugin", True, f"{PLUGIN} {metadata.version(PLUGIN)}")
    except metadata.PackageNotFoundError:
        return Check("plugin", False, f"no {PLUGIN}", "make slurm")


def check_accounting(config: str) -> Check:
    """Without a database of finished jobs, squeue must remember them for a while."""
    if not setting(config, "AccountingStorageType").endswith("none"):
        output = answer("sacctmgr", "-n", "-P", "show", "assoc", f"user={getpass.getuser()}", "format=account")
        what = f"yes; accounts of yours: {', '.join(sorted(set(output.split()))) or 'none listed'}"
        return Check("accounting", True, what)
    age = int(re.sub(r"\D", "", setting(config, "MinJobAge")) or 0)
    what = f"none; squeue tells for {age} s how a job ended"
    fix = f"have MinJobAge=300 set in slurm.conf: profiles/slurm asks squeue, which must remember {MIN_AGE} s at least"
    return Check("accounting", age >= MIN_AGE, what, fix)


def check_flock(folder: Path) -> Check:
    """Locks, which keep a second workflow out of a folder."""
    with tempfile.TemporaryFile(dir=folder) as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            fix = "after a kill -9 of the workflow: snakemake --unlock; or use a folder of a filesystem with flock"
            return Check("flock", False, f"{folder} has none ({error.strerror})", fix, needed=False)
    return Check("flock", True, "a second workflow in this folder is refused")


def check_shared(folder: Path) -> Check:
    """A node runs this very Python and sees this folder."""
    with tempfile.NamedTemporaryFile("w", dir=folder, prefix=".doctor-") as file:
        file.write(word := secrets.token_hex(8))
        file.flush()
        code = f"print(open({file.name!r}).read())"
        output = answer("srun", "--ntasks=1", "--time=2", "--immediate=60", sys.executable, "-c", code, seconds=120)
    if output == word:
        return Check("shared", True, f"a node sees {folder} and {sys.executable}")
    line = shlex.join(["srun", "--ntasks=1", "--time=2", "ls", str(folder), sys.executable])
    fix = f"clone and set up in a folder that all nodes mount, e.g. below your home; {line} says what a node lacks"
    return Check("shared", False, "no node showed within a minute that it sees this folder and this Python", fix)


def check_gpu() -> Check:
    """GPUs that jobs may ask for: optional."""
    lines = {line for line in answer("sinfo", "--noheader", "--format=%P %G").splitlines() if "gpu" in line}
    fix = "leave `device: cpu`; else ask for GresTypes=gpu in slurm.conf and a line in gres.conf"
    return Check("gpu", bool(lines), "; ".join(sorted(lines)) or "no partition has any", fix, needed=False)


def checks() -> list[Check]:
    """All of them; the first alone if no controller answers."""
    config, folder = answer("scontrol", "show", "config"), Path.cwd()
    found = [check_slurm(config), check_plugin(), check_flock(folder)]
    return found + ([check_accounting(config), check_shared(folder), check_gpu()] if config else [])


def run() -> None:
    """Print what this cluster has and lacks, with the line that mends it; exit code 1 if needed things are missing."""
    sys.exit(report(checks()))
