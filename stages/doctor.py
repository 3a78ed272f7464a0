"""Say what this machine has and lacks: `python -m stages.doctor [--mend]`.

Every line is a check; a failed one comes with the command that mends it. `--mend` runs the one
mend that is safe to run unasked: a Vulkan driver, where we are root on Debian or Ubuntu.
Exit code 1 if something that the default run needs is missing.
"""

import os
import re
import shutil
import subprocess
import sys
from importlib import metadata
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parent.parent
DISK_GB = 5
VULKAN_PROBE = "import sapien; print(sapien.render.RenderSystem().device.name)"
CUDA_PROBE = "import torch; print(torch.cuda.get_device_name() if torch.cuda.is_available() else '')"


class Check(NamedTuple):
    """Outcome of one check; `needed` ones decide the exit code."""

    name: str
    good: bool
    found: str
    fix: str = ""
    needed: bool = True


def _probe(code: str) -> str:
    """Output of a Python one-liner in a process of its own (a bad driver crashes, not raises); '' if it fails."""
    try:
        done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120)
    except subprocess.TimeoutExpired:
        return ""
    return done.stdout.strip() if done.returncode == 0 else ""


def _pinned(requirements: Path) -> dict[str, str]:
    """Name -> version of the pins that apply to this platform (rough: the last pin of a name wins nothing)."""
    pins: dict[str, str] = {}
    for line in requirements.read_text(encoding="utf-8").splitlines():
        match = re.match(r"^([A-Za-z0-9_.-]+)==([^ ;]+)(?: ;.*)?", line)
        if match and "'never'" not in line:
            pins.setdefault(match[1], match[2])
    return pins


def check_python() -> Check:
    """Python 3.11 to 3.13."""
    version = ".".join(map(str, sys.version_info[:3]))
    good = (3, 11) <= sys.version_info[:2] <= (3, 13)
    return Check("python", good, version, "install Python 3.11, 3.12 or 3.13, then: make setup")


def check_packages() -> Check:
    """The packages that pyproject.toml asks for are there."""
    wanted = ["snakemake", "pydantic", "numpy", "scipy", "torch", "sapien", "mani-skill", "trimesh", "h5py", "pandas"]
    pins = _pinned(ROOT / "envs" / "requirements.txt") if (ROOT / "envs" / "requirements.txt").exists() else {}
    missing, other = [], []
    for name in wanted:
        try:
            version = metadata.version(name)
        except metadata.PackageNotFoundError:
            missing.append(name)
            continue
        if name in pins and version.split("+")[0] != pins[name] and name not in ("numpy", "scipy"):
            other.append(f"{name} {version} (pinned {pins[name]})")
    if missing:
        return Check("packages", False, "missing: " + ", ".join(missing), "make setup")
    return Check("packages", True, "other versions: " + ", ".join(other) if other else f"{len(wanted)} as pinned")


def check_vulkan() -> Check:
    """A device that SAPIEN can render with."""
    device = _probe(VULKAN_PROBE)
    fix = "run as root: bash envs/vulkan.sh" if os.geteuid() != 0 else "bash envs/vulkan.sh"
    return Check("vulkan", bool(device), device or "SAPIEN finds no rendering device", fix)


def check_cuda() -> Check:
    """A CUDA device: optional."""
    name = _probe(CUDA_PROBE)
    return Check("cuda", bool(name), name or "none: networks run on the CPU", needed=False)


def check_disk() -> Check:
    """Room for the results."""
    free = shutil.disk_usage(Path.cwd()).free / 1e9
    return Check("disk", free >= DISK_GB, f"{free:.0f} GB free", f"free {DISK_GB} GB on this disk")


def check_containers() -> Check:
    """Something that runs the images: optional."""
    found = [name for name in ("apptainer", "singularity", "podman", "docker") if shutil.which(name)]
    return Check("containers", bool(found), ", ".join(found) or "none: rules run in this environment", needed=False)


def mend_vulkan(check: Check) -> Check:
    """Install lavapipe if a device is missing and we may; else return the check as it was."""
    if check.good or os.geteuid() != 0 or not shutil.which("apt-get"):
        return check
    print("no Vulkan device: installing Mesa's lavapipe", flush=True)
    subprocess.run(["bash", str(ROOT / "envs" / "vulkan.sh")], check=False)
    return check_vulkan()


def main(arguments: list[str]) -> int:
    """Print all checks; returns the exit code."""
    vulkan = check_vulkan()
    if "--mend" in arguments:
        vulkan = mend_vulkan(vulkan)
    checks = [check_python(), check_packages(), vulkan, check_cuda(), check_disk(), check_containers()]
    for check in checks:
        mark = "ok  " if check.good else ("MISS" if check.needed else "-   ")
        print(
            f"{mark} {check.name:<11} {check.found}"
            + (f"\n     fix: {check.fix}" if not check.good and check.fix else "")
        )
    return int(any(check.needed and not check.good for check in checks))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
