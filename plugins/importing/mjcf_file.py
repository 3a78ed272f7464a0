"""An MJCF file as MuJoCo compiles it, with no disk: it gets the files of the user's folder in memory."""

import resource
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import mujoco

from roomkin.plugins.importing.inside import is_inside
from roomkin.plugins.importing.mjcf_sources import Sources, parse_root
from roomkin.stages.contracts.errors import InputError
from roomkin.stages.geometry.solids import MINIMUM_INERTIA, MINIMUM_MASS


def compile_model(path: Path, folder: Path) -> tuple[Any, Any]:
    """MuJoCo's specification and compiled model (MjSpec, MjModel) of a file.

    Raises:
        InputError: MuJoCo refuses the file, it is a part of a model, or it names files outside `folder`.
    """
    if (tag := parse_root(path, folder).tag) != "mujoco":
        raise InputError(path, f"has <{tag[:40]}> at the top.", "give the file that includes it", code="E-MJCF-PART")
    files = Sources(path, folder).files()
    mujoco.set_mju_user_warning(lambda text: None)  # else it writes MUJOCO_LOG.TXT where the user is
    try:
        with mujoco.MjVfs() as memory, _forbid_disk():
            for file, data in files.items():
                memory[str(file)] = data
            spec = mujoco.MjSpec.from_file(str(path), vfs=memory)
            # Bodies that nothing weighs, as of visual geoms alone, get their masses from their shapes later.
            spec.compiler.boundmass, spec.compiler.boundinertia = MINIMUM_MASS, MINIMUM_INERTIA
            for texture in spec.textures:
                texture.embed = mujoco.mjtEmbed.mjEMBED_TRUE  # else some are left as names, for a viewer to open
            return spec, spec.compile(vfs=memory)
    except Exception as error:  # of MuJoCo's own kinds, by version
        reason = " ".join(str(error).split())[:300]
        raise InputError(path, f"MuJoCo does not take it: {reason}", code="E-MJCF-REFUSED") from None


@contextmanager
def _forbid_disk() -> Iterator[None]:
    """Let nothing in this process open a file: what MuJoCo lacks in memory it would look for on the disk."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (0, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))


def root_tag(path: Path, folder: Path) -> str | None:
    """Name of the outermost element; empty: there is none; None: the file leads out of the folder, and is not read."""
    if not is_inside(path, folder):
        return None
    try:
        return next((element.tag for _, element in ET.iterparse(path, ["start"])), "")
    except (OSError, ET.ParseError, ValueError):
        return ""
