"""Models of every file that passes between stages; see `docs/contracts.md`."""

from roomkin.stages.contracts.cousins import Cousins
from roomkin.stages.contracts.errors import InputError
from roomkin.stages.contracts.files import (
    Contract,
    read_json,
    read_options,
    read_text,
    write_atomically,
    write_json,
    write_text,
)
from roomkin.stages.contracts.generated import GeneratedScene
from roomkin.stages.contracts.library import Asset, LeftOut, Library, LibraryEntry, LibraryPart, SnapshotShard
from roomkin.stages.contracts.objects import Objects
from roomkin.stages.contracts.policies import Attempt, Rollout, SceneScore, TaskAssets
from roomkin.stages.contracts.scenes import Annotations, Camera, Truth

__all__ = [
    "Annotations", "Asset", "Attempt", "Camera", "Contract", "Cousins", "GeneratedScene", "InputError", "LeftOut",
    "Library", "LibraryEntry", "LibraryPart", "Objects", "Rollout", "SceneScore", "SnapshotShard", "TaskAssets",
    "Truth", "read_json", "read_options", "read_text", "write_atomically", "write_json", "write_text",
]  # fmt: skip
