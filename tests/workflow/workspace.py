"""A working directory for workflow tests: the repository's files linked in, results its own."""

import fcntl
import json
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from zlib import crc32

import numpy as np
from PIL import Image

ROOT = Path(__file__).resolve().parents[2]
LINKED = ("Snakefile", "rules", "plugins", "report", "config.yaml", "config", "profiles", "containers")
MICRO = ("--configfile", "config/test/micro.yaml")
JSON_FILES = {
    "camera.json": {"version": 1, "width": 64, "height": 48, "intrinsics": [[60, 0, 32], [0, 60, 24], [0, 0, 1]]},
    "annotations.json": {"version": 1, "objects": [{"mask": 1, "label": "cabinet", "articulated": True, "doors": 1}]},
    "labels.json": {"1": "cabinet"},
}
Done = subprocess.CompletedProcess[str]


def make(folder: Path) -> Path:
    """Link what a run needs into `folder`."""
    folder.mkdir(parents=True, exist_ok=True)
    for name in LINKED:
        (folder / name).symlink_to(ROOT / name)
    return folder


def put(*files: Path) -> None:
    """Files of a picture of the user's that can be read, each of the kind that its name says, no two alike."""
    for path in files:
        path.parent.mkdir(parents=True, exist_ok=True)
        numbers = 1500 + crc32(str(path).encode()) % 1000 + 10 * np.arange(64) + np.zeros((48, 1), int)  # a wall
        if path.suffix == ".json":
            path.write_text(json.dumps(JSON_FILES.get(path.name, {"fx": 60, "fy": 60, "cx": 32, "cy": 24})))
        elif path.suffix == ".npz":
            np.savez(path, depth=(numbers / 1000).astype(np.float32))
        elif "depth" in (path.parent.name, *path.stem.split("_")):
            Image.fromarray(numbers.astype(np.uint16)).save(path)
        elif path.stem == "masks":
            Image.fromarray(np.ones((48, 64), np.uint8)).save(path)
        else:
            Image.fromarray((numbers[..., None] % [251, 241, 239]).astype(np.uint8)).save(path)


def copy(run: Path, folder: Path) -> Path:
    """A finished run of one's own."""
    shutil.copytree(run, folder, symlinks=True, ignore=shutil.ignore_patterns("mine*"))
    return folder


def overlay(folder: Path, text: str) -> tuple[str, ...]:
    """Config arguments of the micro run plus `text`."""
    path = folder / "mine.yaml"
    path.write_text(text)
    return (*MICRO, str(path))


def snakemake(folder: Path, *arguments: str, environment: dict[str, str] | None = None) -> Done:
    """Run snakemake in `folder` and return all that it says (stdout and stderr together)."""
    return subprocess.run(
        [str(Path(sys.executable).parent / "snakemake"), "--cores", "2", *arguments],
        cwd=folder,
        env=os.environ | {"VERBOSE": "1"} | (environment or {}),
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
    )


def dry_run(folder: Path, *arguments: str) -> Done:
    """The same for `snakemake -n`, in a fork of this process: Snakemake and our config are imported once."""
    from snakemake import cli

    import roomkin.stages.config.reads  # noqa: F401  (by the Snakefile)

    cli.get_argument_parser()
    with tempfile.TemporaryFile("w+") as output:
        child = os.fork()
        if not child:
            code = 1
            try:
                os.chdir(folder)
                os.dup2(output.fileno(), 1)
                os.dup2(output.fileno(), 2)
                sys.stdout, sys.stderr = os.fdopen(1, "w"), os.fdopen(2, "w")
                sys.argv = ["snakemake", "--cores", "2", "-n", *arguments]
                cli.main()
            except SystemExit as leaves:
                code = int(leaves.code or 0)
            finally:
                sys.stdout.flush()
                sys.stderr.flush()
                os._exit(code)
        _, status = os.waitpid(child, 0)
        output.seek(0)
        return Done(arguments, os.waitstatus_to_exitcode(status), output.read())


plan = cache(dry_run)  # of a folder whose configs stay as they are


def planned(output: str) -> dict[str, int]:
    """How often each rule stands in the job table of a run or a dry run."""
    lines = output.splitlines()
    start = next((index for index, line in enumerate(lines) if line.startswith("job ")), len(lines))
    counts = {}
    for line in lines[start + 2 :]:
        if not line.strip() or line.startswith("total"):
            break
        name, count = line.split()[:2]
        counts[name] = int(count)
    return counts


@contextmanager
def only_one(path: Path) -> Iterator[None]:
    """Hold a lock file, which other workers of the tests wait for."""
    with path.open("a") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        yield
