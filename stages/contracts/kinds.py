"""How each kind of file is checked, and which files lie beside it: for the command line and the stages' readers."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path

from pydantic import BaseModel

from stages.contracts.cousins import Cousins
from stages.contracts.distances import Distances
from stages.contracts.files import read_json, read_rows
from stages.contracts.films import read_films
from stages.contracts.generated import GeneratedScene
from stages.contracts.policies import Rollout, SceneScore, TaskAssets
from stages.contracts.scenes import Truth


@dataclass(frozen=True)
class Kind:
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
    return lambda path: getattr(import_module(f"stages.contracts.{module}"), name)(path)


KINDS: dict[str, Kind] = {
    "library": Kind(_with_companions("library_folder:check_library")),
    "asset": Kind(_with_companions("library_folder:check_asset")),
    "snapshots": Kind(_with_companions("snapshot_file:check_snapshots"), ("{stem}.json", "{stem}.h5")),
    "features": Kind(_with_companions("feature_rows:check_features"), ("{stem}.json", "{stem}.npy")),
    "camera": Kind(_with_companions("scene_input:check_camera"), ("rgb.png", "depth.npz")),
    "annotations": Kind(_with_companions("scene_input:read_annotations"), ("masks.png",)),
    "truth": Kind(_json(Truth)),
    "objects": Kind(_with_companions("extracted:check_extracted"), ("masks.png", "depth.npz", "clouds.npz")),
    "cousins": Kind(_json(Cousins)),
    "distances": Kind(_json(Distances)),
    "generated": Kind(_json(GeneratedScene)),
    "task": Kind(_json(TaskAssets)),
    "attempts": Kind(_with_companions("ledgers:read_attempts")),
    "episodes": Kind(_with_companions("episode_store:check_episodes")),
    "policy": Kind(_with_companions("policy_folder:check_policy"), ("policy.safetensors", "last.safetensors")),
    "metrics": Kind(_with_companions("ledgers:read_metrics")),
    "films": Kind(read_films),
    "rollouts": Kind(lambda path: read_rows(Rollout, path)),
    "scores": Kind(lambda path: read_rows(SceneScore, path)),
}
