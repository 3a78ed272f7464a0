"""What a person did to the pictures of a run: where it is."""

from functools import partial
from pathlib import Path

from roomkin.stages.config.experiment import ExperimentConfig
from roomkin.stages.contracts.hand import (
    CORRECTIONS,
    PROJECT,
    Reader,
    digest_of_picture,
    find_hand_file,
    is_by_hand,
    read_corrections,
)


def hand_file(experiment: ExperimentConfig, scene: str, name: str) -> Path:
    """Where a person's corrections.json or project.json of a scene's picture is, or will be."""
    return find_hand_file(Path(experiment.input_folder(scene)), name, partial(_read_digest, experiment, scene))


def describe_corrections(experiment: ExperimentConfig, scene: str, stage: Reader) -> str:
    """A person's corrections of a scene, as far as a stage reads them, as text; "": there are none."""
    path = hand_file(experiment, scene, CORRECTIONS)
    said = read_corrections([path] if path.is_file() else []).read_by(stage)
    return said.model_dump_json(exclude_defaults=True) if said.is_any else ""


def are_taken_back(path: str) -> bool:
    """Whether a file of corrections is there that says nothing any more."""
    return Path(path).is_file() and not read_corrections([Path(path)]).is_any


def drawing_of(experiment: ExperimentConfig, scene: str) -> str:
    """What was drawn into a scene's picture; "": nothing."""
    kept = hand_file(experiment, scene, PROJECT)
    return experiment.inputs[scene].drawing or (str(kept) if is_by_hand(kept) else "")


def _read_digest(experiment: ExperimentConfig, scene: str) -> str:
    """SHA-256 of the file of a scene's picture; "": it is not there yet."""
    folder = Path(experiment.input_folder(scene))
    if own := experiment.inputs.get(scene):
        return own.read_digest()
    return digest_of_picture(folder) if (folder / "rgb.png").is_file() else ""
