"""Results that were made of another picture than the one that has their scene's name now."""

from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from pydantic import BaseModel, ValidationError

from roomkin.stages.config.mistakes import Mistake
from roomkin.stages.config.recordings import list_frames
from roomkin.stages.contracts.errors import InputError
from roomkin.stages.contracts.files import read_text

if TYPE_CHECKING:
    from roomkin.stages.config.model import Config

HOLD = (
    "scenes/{}/view/camera.json",
    "scenes/{}/frame/camera.json",
    "photo/{}/camera.json",
    "extraction/{}/objects.json",
)


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
