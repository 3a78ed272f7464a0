"""Run the micro config in its images with podman, by profiles/podman, and compare every file with a run on the host.

Called by containers/check.sh with the families whose images are built; with all three the whole workflow runs, with
`report` alone the rules of its family, on what a run on the host left: that in MICRO_RUN, if that is set. With
`workflow` the all-in-one image makes the library, too. It is a script because pytest must not need podman.
"""

import os
import shutil
import subprocess
import sys
import tempfile
from hashlib import sha256
from pathlib import Path

from roomkin.stages.config.code import content
from roomkin.stages.config.files import ContainersConfig
from roomkin.stages.contracts.files import CHECKSUMS

ROOT = Path(__file__).resolve().parents[2]
SNAKEMAKE = [str(Path(sys.executable).parent / "snakemake"), "--cores", "2", "--quiet", "all"]
MICRO = ["--configfile", "config/test/micro.yaml"]  # as tests/workflow/workspace.py has it
OF_REPORT = ("results/tables", "results/figures", "results/report")
CLOCK = "results/report/times.html"  # says how long the jobs took
PASSED_OVER = (".venv*", ".git", ".snakemake", "results", "logs", "*.egg-info", "__pycache__")


def run(folder: Path, *command: str) -> None:
    """Run a command in a folder; what it prints is shown if it fails."""
    done = subprocess.run(command, cwd=folder, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    if done.returncode:
        sys.exit(f"{done.stdout}\ncontainers: failed in {folder}: {' '.join(command)}")


def digests(folder: Path) -> dict[str, str]:
    """Of all files of a run, by name; of NumPy's archives by their arrays."""
    files = [path for path in sorted((folder / "results").rglob("*")) if path.is_file()]
    files = [path for path in files if CHECKSUMS not in path.parts]  # of the bytes, also of NumPy's archives
    named = {str(path.relative_to(folder)): sha256(content(path)).hexdigest() for path in files}
    named.pop(CLOCK, None)
    return named


def main(families: list[str]) -> int:
    """Exit code 0 if what the containers wrote equals what the host wrote."""
    whole = {"simulation", "learning", "report"} <= set(families)
    with tempfile.TemporaryDirectory() as folder:
        host, contained = Path(folder) / "host", Path(folder) / "container"
        shutil.copytree(ROOT, host, symlinks=True, ignore=shutil.ignore_patterns(*PASSED_OVER))
        if whole:
            shutil.copytree(host, contained, symlinks=True)
        made = Path(os.environ.get("MICRO_RUN", "none")) / "results"
        if made.is_dir():
            shutil.copytree(made, host / "results")
        else:
            run(host, *SNAKEMAKE, *MICRO)
        if not whole:
            shutil.copytree(host, contained, symlinks=True)
            for name in OF_REPORT:
                shutil.rmtree(contained / name)
        run(contained, *SNAKEMAKE, "--profile", "profiles/podman", *MICRO)
        ours, theirs = digests(host), digests(contained)
        differ = sorted(name for name in ours.keys() | theirs.keys() if ours.get(name) != theirs.get(name))
        if differ:
            print(f"containers: {len(differ)} of {len(ours)} files differ from the host's: {', '.join(differ[:10])}")
            return 1
        what = "the whole micro run" if whole else "the rules of the report image"
        print(f"containers: {what} by profiles/podman, {len(ours)} files, byte for byte those of the host")
        if "workflow" in families:
            shutil.rmtree(contained / "results")
            image = ContainersConfig().template.replace("{family}", "workflow")
            inside = ["snakemake", "--cores", "2", "--quiet", "all", *MICRO, "--", "library"]
            podman = [str(ROOT / "containers/podman"), "run", "--rm", "--network=none"]
            run(contained, *podman, "-v", f"{contained}:{contained}", "-w", str(contained), image, *inside)
            made = digests(contained)
            if any(ours[name] != digest for name, digest in made.items()):
                print("containers: the library made inside the workflow image differs")
                return 1
            print(f"containers: target library inside the workflow image, {len(made)} files, those of the host")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
