"""The package as the core knows it."""

import shlex
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from pydantic import Field

from plugins.inputs.config import PhotoConfig, PhotoSection
from plugins.inputs.pictures import PicturesExperiment, of_picture, read_sources
from stages.config.mistakes import Mistake
from stages.config.packages import Package


def find_mistakes(config: Any) -> Iterator[Mistake]:
    """Pictures that `image` names, those without depth, and the weights that find what they show."""
    if config.image:
        for picture in config.experiment.inputs.values():
            yield from picture.mistakes("")
    elif config.depth or config.camera:
        key = "depth" if config.depth else "camera"
        yield Mistake(key, "is said of no picture", "--config image=color.png")
    pictures = config.experiment.pictures
    if not pictures:
        return
    if config.photo.captions == "vlm" and not config.packages.get("vlm"):
        yield Mistake("photo.captions", "is read by the package vlm, which is off or not here", "packages: {vlm: true}")
    key = "image" if config.image else "experiment.inputs"
    lacking = [
        f"photo.{name} ({folder})"
        for name, folder in config.photo.networks().items()
        if not Path(folder, "model.safetensors").is_file()
    ]
    if config.photo.asks_networks() and lacking and "estimate" not in config.stages.get("inputs", {}):
        mend = "python -m plugins.inputs fetch, or without weights draw it: python -m plugins.annotator annotate"
        yield Mistake(
            key, f"there are no weights in {', '.join(lacking)}", f"{mend} {shlex.quote(pictures[0])}", "E-CONFIG-FILE"
        )


def list_needed_files(config: Any) -> list[str]:
    """The weights that pictures need, and the ledger of a language model's answers about them."""
    if not config.experiment.pictures:
        return []
    if not config.photo.asks_networks():
        return []
    ledger = [config.vlm.ledger] if config.photo.captions == "vlm" else []
    return [*config.photo.networks().values(), *ledger]


def keys(config: Any) -> list[str] | None:
    """The key of the language model that is asked about pictures, if one is."""
    asks = config.experiment.pictures and config.photo.captions == "vlm" and config.vlm.mode == "record"
    return [config.vlm.key_env] if asks else None


def check_weights() -> tuple[str, bool, str]:
    """Weights, at their default places, of the networks that find what a picture shows: name, whether all, what."""
    files = {name: Path(folder, "model.safetensors") for name, folder in PhotoSection().networks().items()}
    there = [f"{name} {file.stat().st_size / 1e9:.1f} GB" for name, file in files.items() if file.is_file()]
    lacking = [name for name, file in files.items() if not file.is_file()]
    found = [f"weights: {', '.join(there)}, one in memory at a time"] if there else []
    if lacking:
        found.append(f"no weights of {', '.join(lacking)}: python -m plugins.inputs fetch, or draw by hand")
    return "photo", not lacking, "; ".join(found)


PACKAGE = Package(
    commands={"estimate": PhotoConfig, "fetch": PhotoSection},
    section="photo",
    sections={
        "depth": (str, Field("", description="Depth of the picture `image`, aligned to it.")),
        "camera": (str, Field("", description="Its intrinsics: a file, or the camera's name (docs/your-data.md).")),
        "photo": (
            PhotoSection,
            Field(PhotoSection(), description="From one RGB picture to an input folder (A.2, A.7)."),
        ),
    },
    widens={"experiment": PicturesExperiment},
    expand=read_sources,
    of_run=of_picture,
    outside=list_needed_files,
    keys=keys,
    mistakes=find_mistakes,
    check=check_weights,
)
