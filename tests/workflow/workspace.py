"""A working directory for workflow tests: the repository's files linked in, results its own."""

import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
LINKED = ("Snakefile", "rules", "report", "config.yaml", "config", "profiles", "containers")


def make(folder: Path) -> Path:
    """Link what a run needs into `folder`."""
    folder.mkdir(parents=True, exist_ok=True)
    for name in LINKED:
        (folder / name).symlink_to(ROOT / name)
    return folder


def snakemake(
    folder: Path, *arguments: str, environment: dict[str, str] | None = None
) -> subprocess.CompletedProcess[str]:
    """Run snakemake in `folder` and return what it printed (stdout and stderr together)."""
    return subprocess.run(
        [str(Path(sys.executable).parent / "snakemake"), "--cores", "2", *arguments],
        cwd=folder,
        env=os.environ | (environment or {}),
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
    )
