"""An input folder with results of a run beside it, for the page that corrects."""

import json
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from roomkin.plugins.annotator.correcting import Correcting
from roomkin.stages.contracts import Cousins, GeneratedScene, Library, Objects, read_json, write_json
from roomkin.stages.contracts.cousins import Candidate, Cousin, ObjectCousins, Orientation
from roomkin.stages.contracts.doubt import Doubt
from roomkin.stages.contracts.generated import PlacedObject
from roomkin.stages.contracts.hand import CORRECTIONS, Correction, Reader, read_corrections
from roomkin.stages.contracts.library import LibraryEntry
from roomkin.stages.extraction.extract import run as extract
from tests.unit.tables_results import snapshots

MODELS = [f"cabinet_{number}" for number in range(12)]


def _matched(name: str) -> ObjectCousins:
    """Ten cousins, and two models more that were compared."""
    view = Orientation(yaw=0.4, distance=0.5)
    compared = [Candidate(asset=asset, category="cabinet", distance=1 + n / 4) for n, asset in enumerate(MODELS)]
    cousins = [
        Cousin(rank=n, asset=one.asset, category="cabinet", distance=one.distance, votes=None, orientation=view,
               orientations=[view])
        for n, one in enumerate(compared[:10], 1)
    ]  # fmt: skip
    return ObjectCousins(id=name, label=name[:-2], by_distance=compared, cousins=cousins)


def write_run(folder: Path, results: Path, doubts: dict[int, list[Doubt]]) -> Correcting:
    """Extraction is run; of matching and generation files are written, with doubts by the number of a thing."""
    place = results / "extraction/kitchen/objects.json"
    extract(input=folder, scene="kitchen", out=place)
    objects = read_json(Objects, place)
    names = [item.id for item in objects.objects]
    cousins = Cousins(scene="kitchen", encoder="hog", objects=[_matched(name) for name in names])
    write_json(results / "matching/default/kitchen/cousins.json", cousins)
    placed = [
        PlacedObject(
            id=item.id, label=item.label, asset=MODELS[0], category="cabinet", position=item.box.center,
            yaw=np.pi, size=item.box.size, mounting=item.mounting, cousin=1, doubts=doubts.get(number, []),
        )
        for number, item in enumerate(objects.objects) if item.box is not None
    ]  # fmt: skip
    shared = objects.model_dump(include={"scene", "width", "height", "intrinsics", "floor_from_camera", "walls"})
    scene = GeneratedScene(variant="default", rank=1, objects=placed, **shared)
    write_json(results / "generation/default/kitchen/scene_1.json", scene)
    snapshots(results / "assets/snapshots", MODELS)
    Image.new("RGB", (48, 36), (200, 60, 40)).save(results / "generation/default/kitchen/scene_1.png")
    entries = [
        LibraryEntry(id=name, category="cabinet", archive="a.zip", doors=0, drawers=0, checksum="c",
                     size=(0.4, 0.5 + number / 100, 0.8))
        for number, name in enumerate(MODELS)
    ]  # fmt: skip
    write_json(results / "assets/library/library.json", Library(assets=sorted(entries, key=lambda one: one.id)))
    return Correcting(folder, ["mug"], results, "kitchen", None, "cabinet_1")


def read_told_to(path: Path, stage: Reader) -> dict[int, Correction]:
    """What a stage reads of corrections.json, by mask value."""
    return {item.mask: item for item in read_corrections([path]).read_by(stage).objects}


def read_told(page: Any, session: Correcting) -> dict[int, dict[str, Any]]:
    """What is kept, by mask value."""
    page.wait_for_function("() => document.getElementById('saved').textContent === 'saved'")
    path = session.folder / CORRECTIONS
    said = json.loads(path.read_text()).get("objects", []) if path.is_file() else []
    return {item.pop("mask"): item for item in said}
