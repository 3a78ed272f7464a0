"""Command `extract`: one input folder -> objects.json, masks.png, depth.npz, clouds.npz."""

import zlib
from functools import partial
from pathlib import Path

import cv2
import numpy as np
import yaml
from pydantic import ValidationError

from roomkin.stages.config.code import record_provenance
from roomkin.stages.config.inputs import INPUT_FILES, ExtractionConfig
from roomkin.stages.contracts import InputError, read_options, write_atomically, write_json
from roomkin.stages.contracts.errors import first_error
from roomkin.stages.contracts.files import read_text
from roomkin.stages.contracts.hand import digest_of_picture, read_corrections
from roomkin.stages.contracts.matched import match_corrections
from roomkin.stages.extraction.floor import doubt_unit
from roomkin.stages.extraction.reconstruct import reconstruct, reconstruct_corrected
from roomkin.stages.extraction.sources import Source
from roomkin.stages.plugins import load


def run(
    *,
    input: Path,
    scene: str,
    out: Path,
    options: str = "{}",
    own: tuple[Path, ...] = (),
    corrections: tuple[Path, ...] = (),
    seed: int = 0,
) -> None:
    """Find the objects of one picture in space.

    Args:
        input: folder with rgb.png, camera.json, depth.npz, masks.png, annotations.json.
        scene: name of the scene, written into the result.
        out: objects.json; masks.png, depth.npz and clouds.npz are written beside it.
        options: JSON of the config section `extraction`.
        own: config.yaml beside the picture: its section `extraction` sets the options that `options` leaves at default.
        corrections: corrections.json beside the picture: what a person corrected.
        seed: seed of the depth noise and of RANSAC.
    """
    config = read_options(ExtractionConfig, options)
    for path in own:
        config = merge_own_options(config, path)
    noise, steps = np.random.default_rng(np.random.SeedSequence((seed, zlib.crc32(scene.encode())))).spawn(2)
    observe: Source = load("sources", config.source)
    image = observe(input, config, noise)
    said = match_corrections(
        read_corrections(corrections).read_by("extraction"),
        image.masks,
        digest_of_picture(input) if corrections else "",
    )
    result = reconstruct_corrected(image, said, partial(reconstruct, scene, options=config, rng=steps))

    folder = out.parent
    with write_atomically(folder / "masks.png") as path:
        cv2.imwrite(str(path), result.masks)
    with write_atomically(folder / "depth.npz") as path:
        np.savez_compressed(path, depth=result.depth)
    with write_atomically(folder / "clouds.npz") as path:
        np.savez_compressed(path, **result.clouds)  # type: ignore[arg-type]
    inputs = [input / name for name in INPUT_FILES if (input / name).is_file()]
    origin = record_provenance("roomkin.stages.extraction.extract", config, [*inputs, *own, *corrections], seed)
    write_json(out, result.objects.model_copy(update={"digest": digest_of_picture(input), "made": origin}))
    if doubt := doubt_unit(result.objects.objects):
        print(f"{scene}: in doubt: {doubt}")
    for item in result.objects.objects:
        kind = item.mounting.words if item.mounting else f"failed: {item.reason}"
        print(f"{scene} {item.id}: {kind}, {item.points} points")


def merge_own_options(config: ExtractionConfig, own: Path) -> ExtractionConfig:
    """The options, with the values of the picture's own config.yaml where they are at their defaults.

    Raises:
        InputError: it is no config.
    """
    mend = "write it as `from-rgbd` does, or take it away"
    try:
        section = (yaml.safe_load(read_text(own)) or {}).get("extraction") or {}
        return ExtractionConfig.model_validate(section | config.model_dump(exclude_defaults=True))
    except ValidationError as error:
        raise InputError(own, f"extraction: {first_error(error)}.", mend, code="E-CONFIG-FILE") from None
    except (yaml.YAMLError, AttributeError, TypeError):
        raise InputError(own, "is no config.", mend, code="E-CONFIG-FILE") from None
