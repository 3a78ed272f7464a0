"""What a person did to the pictures of a run, and results of another picture than the one that has their name now."""

from collections.abc import Iterator
from functools import cache, partial
from pathlib import Path
from typing import TYPE_CHECKING

from pydantic import BaseModel, ValidationError

from roomkin.stages.config.experiment import ExperimentConfig
from roomkin.stages.config.mistakes import Mistake
from roomkin.stages.config.recordings import list_frames
from roomkin.stages.contracts import hand
from roomkin.stages.contracts.errors import InputError
from roomkin.stages.contracts.files import read_text

if TYPE_CHECKING:
    from roomkin.stages.config.model import Config


def hand_file(experiment: ExperimentConfig, scene: str, name: str) -> Path:
    """Where a person's corrections.json or project.json of a scene's picture is, or will be."""
    return hand.find_hand_file(Path(experiment.input_folder(scene)), name, partial(_read_digest, experiment, scene))


def describe_corrections(experiment: ExperimentConfig, scene: str, stage: hand.Reader) -> str:
    """A person's corrections of a scene, as far as a stage reads them, as text; "": there are none."""
    path = hand_file(experiment, scene, hand.CORRECTIONS)
    said = hand.read_corrections([path] if path.is_file() else []).read_by(stage)
    return said.model_dump_json(exclude_defaults=True) if said.is_any else ""


def are_taken_back(path: str) -> bool:
    """Whether a file of corrections is there that says nothing any more."""
    return Path(path).is_file() and not hand.read_corrections([Path(path)]).is_any


def drawing_of(experiment: ExperimentConfig, scene: str) -> str:
    """What was drawn into a scene's picture; "": nothing."""
    kept = hand_file(experiment, scene, hand.PROJECT)
    return experiment.inputs[scene].drawing or (str(kept) if hand.is_by_hand(kept) else "")


def _read_digest(experiment: ExperimentConfig, scene: str) -> str:
    """SHA-256 of the file of a scene's picture; "": it is not there yet."""
    folder = Path(experiment.input_folder(scene))
    if own := experiment.inputs.get(scene):
        return own.read_digest()
    return hand.digest_of_picture(folder) if (folder / "rgb.png").is_file() else ""


HOLD = [f"{place}/camera.json" for place in ("scenes/{}/view", "scenes/{}/frame", "photo/{}")]
HOLD += ["extraction/{}/objects.json"]


class _Made(BaseModel):
    """What a file says of the picture that it was made of."""

    digest: str = ""


def read_digest(path: Path) -> str:
    """The digest of the picture that camera.json or objects.json was made of; empty: it does not tell."""
    try:
        return _Made.model_validate_json(read_text(path)).digest
    except (InputError, ValidationError):
        return ""  # it is not there, or the stage that reads it says what is wrong


def find_mistakes(config: "Config") -> Iterator[Mistake]:
    """Scenes whose results are of another picture. Pictures are read only where there are such results."""
    frames = cache(list_frames)
    for scene in config.experiment.rooms:
        given = config.experiment.inputs.get(scene)
        if given is None:
            continue
        made = {path: read_digest(path) for path in (Path("results", each.format(scene)) for each in HOLD)}
        if not any(made.values()) or any(given.mistakes("")):
            continue
        digest = given.read_digest(frames)
        if others := [path for path, found in made.items() if digest and found and found != digest]:
            key = given.row or ("image" if config.image else f"experiment.inputs.{scene}")
            rgb = others[0].with_name("rgb.png")
            what = f"results/ holds another picture under this name: see {rgb if rgb.is_file() else others[0]}"
            folders = dict.fromkeys(str(Path(*path.parts[:3])) for path in others)
            yield Mistake(key, what, f"call the file or the scene otherwise, or delete {' and '.join(folders)}")
