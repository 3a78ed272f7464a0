"""Say what this machine has and lacks: `roomkin check [--mend] [--brief]`.

Every line is a check; a failed one comes with the command that mends it. `--mend` runs the
mends that are safe to run unasked: a Vulkan driver and the libraries of Open3D, where we are root
on Debian or Ubuntu. `--brief`, of every `make`: where all was well, and the environment is as it was
then, drivers are not tried again, and only what is missing is told.
Exit code 1 if something that the default run needs is missing.
"""

import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from contextlib import suppress
from importlib import metadata
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[2]
DISK_GB = 5
DRIVERS = ("VK_DRIVER_FILES", "VK_ICD_FILENAMES", "VK_ADD_DRIVER_FILES")  # which hide the drivers that are installed
VULKAN_PROBE = "import sapien; print(sapien.render.RenderSystem().device.name)"
OPEN3D_PROBE = "import open3d; print(open3d.__version__)"
# Run by Python before anything else, in the place of the script.
TELL_PREFIX = "import os, sys; print(sys.prefix, flush=True); os._exit(0)"
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


def _as_root(script: str) -> str:
    line = f"bash {ROOT / 'envs' / script}"
    return line if os.geteuid() == 0 else f"run as root: {line}"


def _read_pins(requirements: Path) -> dict[str, str]:
    """Name -> version of the pins that apply to this platform (rough: the last pin of a name wins nothing)."""
    pins: dict[str, str] = {}
    for line in requirements.read_text(encoding="utf-8").splitlines():
        match = re.match(r"^([A-Za-z0-9_.-]+)==([^ ;]+)(?: ;.*)?", line)
        if match and "'never'" not in line:
            pins.setdefault(match[1], match[2])
    return pins


def check_python() -> Check:
    """Python 3.11 or 3.12."""
    version = ".".join(map(str, sys.version_info[:3]))
    good = (3, 11) <= sys.version_info[:2] <= (3, 12)
    return Check("python", good, version, "install Python 3.11 or 3.12, then: make setup")


def check_folder(scripts: Path) -> Check:
    """The environment lies where it was made: its scripts name their Python by its whole path."""
    script = scripts / "snakemake"
    if not script.is_file():
        return Check("folder", True, "no scripts here")
    prefix = _prefix_of(script)
    if prefix and Path(prefix).resolve() == scripts.parent.resolve():
        return Check("folder", True, "as the environment was made")
    made = f"was made in {prefix}" if prefix else "was made elsewhere"
    return Check("folder", False, f"the environment {made}, and moved or copied", "rm -r .venv; make setup")


def _prefix_of(script: Path) -> str:
    """The environment whose Python a script starts, by that Python's own word; '' if it starts none."""
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "sitecustomize.py").write_text(TELL_PREFIX, encoding="utf-8")
        try:
            env = os.environ | {"PYTHONPATH": folder}
            done = subprocess.run([script], capture_output=True, text=True, timeout=120, env=env)
        except (OSError, subprocess.TimeoutExpired):
            return ""
    return done.stdout.strip() if done.returncode == 0 else ""


def check_packages() -> Check:
    """The packages that pyproject.toml asks for are there."""
    wanted = ["snakemake", "pydantic", "numpy", "scipy", "torch", "sapien", "mani-skill", "open3d-cpu", "trimesh"]
    wanted += ["h5py", "pandas"]
    pins = _read_pins(ROOT / "envs" / "requirements.txt") if (ROOT / "envs" / "requirements.txt").exists() else {}
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
    stale = [(name, path) for name in DRIVERS for path in os.environ.get(name, "").split(os.pathsep) if path]
    if not device and (gone := [(name, path) for name, path in stale if not Path(path).exists()]):
        name, path = gone[0]
        return Check("vulkan", False, f"{name} names {path}, which is not there", f"unset {name}")
    return Check("vulkan", bool(device), device or "SAPIEN finds no rendering device", _as_root("vulkan.sh"))


def check_open3d() -> Check:
    """Open3D and the system libraries it links to."""
    version = _probe(OPEN3D_PROBE)
    what = version or "cannot be imported: a system library is missing (libGL, libEGL, libX11, libusb)"
    return Check("open3d", bool(version), what, _as_root("open3d.sh"))


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
    found = {name: _answers(name) for name in ("apptainer", "singularity", "podman", "docker") if shutil.which(name)}
    names = ", ".join(name if works else f"{name} (installed, but nothing answers)" for name, works in found.items())
    return Check("containers", any(found.values()), names or "none: rules run in this environment", needed=False)


def _answers(name: str) -> bool:
    """Whether it can run an image: that its client is there is not enough."""
    try:
        ask = [name, "info"] if name in ("podman", "docker") else [name, "--version"]
        return subprocess.run(ask, capture_output=True, timeout=20).returncode == 0
    except (OSError, subprocess.TimeoutExpired):
        return False


def check_weights() -> list[Check]:
    """The published weights that look at pictures, at their default places: optional."""
    try:
        from roomkin.stages.config.perception import PerceptionSection
        from roomkin.stages.config.weights import list_lacking
    except ImportError:
        return [Check("packages", False, "not to be imported", needed=False)]
    section, lacking = PerceptionSection(), list_lacking()
    found = f"no {', '.join(lacking)}: roomkin perception fetch (300 MB)"
    small = Check("weights", not lacking, found if lacking else "MobileSAM, SSD MobileNet v2, CLIP", needed=False)
    lacking = section.list_lacking()
    files = {key: Path(folder, "model.safetensors") for key, folder in section.networks().items() if key not in lacking}
    said = [f"{key} {file.stat().st_size / 1e9:.1f} GB" for key, file in files.items()]
    told = [f"weights: {', '.join(said)}, one in memory at a time"] if said else []
    if lacking:
        told.append(f"no weights of {', '.join(lacking)}: roomkin perception fetch --networks, or draw by hand")
    return [small, Check("networks", not lacking, "; ".join(told), needed=False)]


Mendable = Callable[[], Check]

# check -> what `--mend` says, and the script that it runs
MENDS: dict[Mendable, tuple[str, str]] = {
    check_vulkan: ("no Vulkan device: installing Mesa's lavapipe", "vulkan.sh"),
    check_open3d: ("Open3D cannot be imported: installing the libraries it links to", "open3d.sh"),
}


def mend_check(check: Mendable) -> Check:
    """The check after its mend, if it fails and we may install packages; else as it is."""
    outcome = check()
    if outcome.good or "unset" in outcome.fix or os.geteuid() != 0 or not shutil.which("apt-get"):
        return outcome
    notice, script = MENDS[check]
    print(notice, flush=True)
    subprocess.run(["bash", str(ROOT / "envs" / script)], check=False)
    return check()


def quick_checks() -> list[Check]:
    """Those that start no driver and import nothing large."""
    return [check_python(), check_folder(Path(sys.executable).parent), check_packages(), check_disk()]


def checks(mend: bool) -> list[Check]:
    """Those about this machine."""
    vulkan, open3d = (mend_check(check) if mend else check() for check in (check_vulkan, check_open3d))
    *first, disk = quick_checks()
    return [*first, vulkan, open3d, check_cuda(), disk, check_containers(), *check_weights()]


def describe_environment(installed: Path) -> str:
    """What the checks of drivers depend on: when it was set up, and the drivers that are named; "": not by `make`."""
    if not installed.is_file():
        return ""
    return f"{installed.stat().st_mtime_ns} {[os.environ.get(name) for name in DRIVERS]}"


def main(arguments: list[str]) -> int:
    """Print all checks; returns the exit code."""
    if strange := [one for one in arguments if one not in ("--mend", "--brief")]:
        wants_help = strange[0] in ("-h", "--help")
        print(__doc__ if wants_help else f"error: there is no {strange[0]}. Fix: --mend, --brief, or nothing")
        return 0 if wants_help else 2
    record, now = Path(sys.prefix, ".checked"), describe_environment(Path(sys.prefix, ".installed"))
    if now and "--brief" in arguments and record.is_file() and record.read_text(encoding="utf-8") == now:
        return report([check for check in quick_checks() if not check.good])
    code = report(checks("--mend" in arguments))
    if now:
        with suppress(OSError):  # an environment that others own is checked every time
            record.write_text("" if code else now, encoding="utf-8")
    return code


def report(found: list[Check]) -> int:
    """Print checks, a line each; returns the exit code: 1 if something needed is missing."""
    for check in found:
        mark = "ok  " if check.good else ("MISS" if check.needed else "-   ")
        fix = f"\n     fix: {check.fix}" if not check.good and check.fix else ""
        print(f"{mark} {check.name:<11} {check.found}{fix}")
    return int(any(check.needed and not check.good for check in found))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
