"""How each kind of file is checked, and which files lie beside it: for the command line and the stages' readers."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from pydantic import BaseModel

from stages.contracts.cousins import Cousins
from stages.contracts.distances import Distances
from stages.contracts.features import FeatureIndex
from stages.contracts.files import read_json, read_lines, read_rows
from stages.contracts.generated import GeneratedScene
from stages.contracts.library import Asset, Library, SnapshotShard
from stages.contracts.objects import Objects
from stages.contracts.policies import Attempt, Rollout, SceneScore, TaskAssets
from stages.contracts.scenes import Annotations, Camera, Truth


@dataclass(frozen=True)
class Kind:
    """`check` raises an `InputError`; `companions` are names of files beside it, {stem} is the file's own."""

    check: Callable[[Path], object]
    companions: tuple[str, ...] = ()

    def files(self, path: Path) -> Iterator[Path]:
        """The file and those of its companions that exist."""
        names = [path.name, *(name.format(stem=path.stem) for name in self.companions)]
        yield from (path.with_name(name) for name in dict.fromkeys(names) if path.with_name(name).is_file())


def _json(model: type[BaseModel], suffix: str = "") -> Callable[[Path], object]:
    return lambda path: read_json(model, path.with_suffix(suffix or path.suffix))


def _policy(path: Path) -> object:
    from stages.contracts.trained import TrainedPolicy

    return read_json(TrainedPolicy, path)


KINDS: dict[str, Kind] = {
    "library": Kind(_json(Library)),
    "asset": Kind(_json(Asset)),
    "snapshots": Kind(_json(SnapshotShard, ".json"), ("{stem}.json", "{stem}.h5")),
    "features": Kind(_json(FeatureIndex, ".json"), ("{stem}.json", "{stem}.npy")),
    "camera": Kind(_json(Camera), ("rgb.png", "depth.npz", "masks.png")),
    "annotations": Kind(_json(Annotations), ("masks.png",)),
    "truth": Kind(_json(Truth)),
    "objects": Kind(_json(Objects), ("masks.png", "depth.npz", "clouds.npz")),
    "cousins": Kind(_json(Cousins)),
    "distances": Kind(_json(Distances)),
    "generated": Kind(_json(GeneratedScene)),
    "task": Kind(_json(TaskAssets)),
    "attempts": Kind(lambda path: read_lines(Attempt, path)),
    "episodes": Kind(lambda path: path),
    "policy": Kind(_policy, ("policy.safetensors", "last.safetensors")),
    "rollouts": Kind(lambda path: read_rows(Rollout, path)),
    "scores": Kind(lambda path: read_rows(SceneScore, path)),
}
