"""Models of every file that passes between stages; see `docs/contracts.md`."""

from stages.contracts.cousins import Cousins
from stages.contracts.errors import InputError
from stages.contracts.files import (
    Contract,
    read_json,
    read_options,
    read_text,
    write_atomically,
    write_json,
    write_text,
)
from stages.contracts.generated import GeneratedScene
from stages.contracts.library import Asset, LeftOut, Library, LibraryEntry, LibraryPart, SnapshotShard
from stages.contracts.objects import Objects
from stages.contracts.policies import Attempt, Rollout, SceneScore, TaskAssets
from stages.contracts.scenes import Annotations, Camera, Truth

__all__ = [
    "Annotations",
    "Asset",
    "Attempt",
    "Camera",
    "Contract",
    "Cousins",
    "GeneratedScene",
    "InputError",
    "LeftOut",
    "Library",
    "LibraryEntry",
    "LibraryPart",
    "Objects",
    "Rollout",
    "SceneScore",
    "SnapshotShard",
    "TaskAssets",
    "Truth",
    "read_json",
    "read_options",
    "read_text",
    "write_atomically",
    "write_json",
    "write_text",
]
