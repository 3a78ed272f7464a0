"""How each kind of file is checked, and which files lie beside it: for the command line and the stages' readers."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path

from pydantic import BaseModel

from roomkin.stages.contracts.cousins import Cousins, Distances
from roomkin.stages.contracts.files import read_json, read_rows
from roomkin.stages.contracts.generated import GeneratedScene
from roomkin.stages.contracts.hand import Corrections
from roomkin.stages.contracts.library import Library
from roomkin.stages.contracts.library_folder import SceneShards
from roomkin.stages.contracts.policies import ChosenRuns, Rollout, SceneScore, TaskAssets
from roomkin.stages.contracts.scenes import Truth
from roomkin.stages.contracts.things import Things


@dataclass(frozen=True)
class FileKind:
    """`check` raises an `InputError`; `companions` are names of files beside it, {stem} is the file's own."""

    check: Callable[[Path], object]
    companions: tuple[str, ...] = ()

    def files(self, path: Path) -> Iterator[Path]:
        """The file and those of its companions that exist."""
        names = [path.name, *(name.format(stem=path.stem) for name in self.companions)]
        yield from (path.with_name(name) for name in dict.fromkeys(names) if path.with_name(name).is_file())


def _json(model: type[BaseModel]) -> Callable[[Path], object]:
    return lambda path: read_json(model, path)


def _with_companions(function: str) -> Callable[[Path], object]:
    """A check that needs numpy and more: 'module:function' of this package, imported when it is used."""
    module, name = function.split(":")
    return lambda path: getattr(import_module(f"roomkin.stages.contracts.{module}"), name)(path)


KINDS: dict[str, FileKind] = {
    "library": FileKind(_json(Library)),
    "shards": FileKind(_json(SceneShards)),
    "library_part": FileKind(_with_companions("library_folder:check_models"), ("{stem}.zip",)),
    "asset": FileKind(_with_companions("library_folder:check_asset")),
    "snapshots": FileKind(_with_companions("features:check_snapshots"), ("{stem}.json", "{stem}.h5")),
    "features": FileKind(_with_companions("features:check_features"), ("{stem}.json", "{stem}.npy", "{stem}.npz")),
    "camera": FileKind(_with_companions("scene_input:check_camera"), ("rgb.png", "depth.npz")),
    "annotations": FileKind(_with_companions("scene_input:read_annotations"), ("masks.png",)),
    "things": FileKind(_json(Things)),
    "corrections": FileKind(_json(Corrections)),
    "truth": FileKind(_json(Truth)),
    "objects": FileKind(_with_companions("extracted:check_extracted"), ("masks.png", "depth.npz", "clouds.npz")),
    "cousins": FileKind(_json(Cousins)),
    "distances": FileKind(_json(Distances)),
    "generated": FileKind(_json(GeneratedScene)),
    "task": FileKind(_json(TaskAssets)),
    "attempts": FileKind(_with_companions("episode_store:read_attempts")),
    "episodes": FileKind(_with_companions("episode_store:check_episodes")),
    "policy": FileKind(
        _with_companions("trained:check_policy"), ("policy.safetensors", "last.safetensors", "checkpoints.zip")
    ),
    "metrics": FileKind(_with_companions("episode_store:read_metrics")),
    "chosen": FileKind(_json(ChosenRuns)),
    "rollouts": FileKind(lambda path: read_rows(Rollout, path)),
    "scores": FileKind(lambda path: read_rows(SceneScore, path)),
}
PACKAGES = Path(__file__).resolve().parents[2] / "plugins"
for _file in sorted(PACKAGES.glob("*/kinds.py")):  # those of packages: a check by the name of each
    _checks = import_module(f"roomkin.plugins.{_file.parent.name}.kinds").CHECKS
    KINDS |= {name: FileKind(check) for name, check in _checks.items()}
