"""Verb `extract`: one input folder -> objects.json, masks.png, depth.npz, clouds.npz."""

import zlib
from pathlib import Path

import cv2
import numpy as np

from stages.config.extraction import ExtractionConfig
from stages.contracts import atomic, read_options, write_json
from stages.extraction.reconstruct import reconstruct
from stages.extraction.sources import Source
from stages.plugins import load


def run(*, input: Path, scene: str, out: Path, options: str = "{}", seed: int = 0) -> None:
    """Find the objects of one picture in space.

    Args:
        input: folder with rgb.png, camera.json, depth.npz, masks.png, annotations.json.
        scene: name of the scene, written into the result.
        out: objects.json; masks.png, depth.npz and clouds.npz are written beside it.
        options: JSON of the config section `extraction`.
        seed: seed of the depth noise and of RANSAC.
    """
    config = read_options(ExtractionConfig, options)
    noise, steps = np.random.default_rng(np.random.SeedSequence((seed, zlib.crc32(scene.encode())))).spawn(2)
    observe: Source = load("sources", config.source)
    image = observe(input, config, noise)
    result = reconstruct(scene, image, config, steps)

    folder = out.parent
    with atomic(folder / "masks.png") as path:
        cv2.imwrite(str(path), result.masks)
    with atomic(folder / "depth.npz") as path:
        np.savez_compressed(path, depth=image.depth)
    with atomic(folder / "clouds.npz") as path:
        np.savez_compressed(path, **result.clouds)  # type: ignore[arg-type]
    write_json(out, result.objects)
    for item in result.objects.objects:
        kind = f"mounting {item.mounting.type}" if item.mounting else f"failed: {item.reason}"
        print(f"{scene} {item.id}: {kind}, {item.points} points")
