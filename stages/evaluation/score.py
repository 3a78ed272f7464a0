"""Command `score`: generated scenes of one room + its truth -> one row per rank and object (paper B.1)."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import pandas as pd

from roomkin.stages.contracts import Cousins, GeneratedScene, InputError, Library, Objects, Truth, read_json
from roomkin.stages.contracts.files import write_atomically
from roomkin.stages.contracts.generated import PlacedObject
from roomkin.stages.contracts.library_folder import AssetFolders
from roomkin.stages.contracts.policies import SceneScore
from roomkin.stages.contracts.scenes import TrueObject
from roomkin.stages.evaluation.scoring import score_scene


def check_same_scene(scenes: list[GeneratedScene], objects: Objects, truth: Truth) -> None:
    """All files must be of one room.

    Raises:
        InputError: they are not.
    """
    names = {scene.scene for scene in scenes} | {objects.scene, truth.scene}
    if len(names) > 1:
        what = f"are of different scenes: {', '.join(sorted(names))}."
        raise InputError("--scenes, --objects, --truth", what, code="E-SCENE-MIXED")


def check_categories(path: Path, items: Sequence[PlacedObject | TrueObject], categories: Mapping[str, str]) -> None:
    """Models are of the categories that the library knows by their ids.

    Raises:
        InputError: one is not.
    """
    for item in items:
        known = categories.get(item.asset, item.category)
        if item.category != known:
            what = f"says that {item.asset} is a '{item.category}', but in the library it is a '{known}'."
            raise InputError(path, what, "make it again", code="E-SCENES-CATEGORY")


def judges(cousins: Path | None, scene: str) -> dict[str, dict[str, str]]:
    """Who decided on model and orientation of each object, as columns of its row.

    Raises:
        InputError: the cousins are those of another scene.
    """
    if cousins is None:
        return {}
    found = read_json(Cousins, cousins)
    if found.scene != scene:
        raise InputError(cousins, f"is of scene {found.scene}, not of {scene}.", code="E-SCENE-MIXED")
    sides = [(item.id, item.decided_by, item.orientation_decided_by) for item in found.objects]
    return {name: {"model_judge": model, "orientation_judge": turn} for name, model, turn in sides}


def run(
    *,
    scenes: tuple[Path, ...],
    objects: Path,
    truth: Path,
    library: Path,
    out: Path,
    cousins: Path | None = None,
    protocol: str = "",
    draw: int = 0,
) -> None:
    """Score the scenes of one room.

    Args:
        scenes: scene_<rank>.json files.
        objects: objects.json, which says which mask is which object.
        truth: truth.json of the room.
        library: library.json; the true models must be in it.
        out: scores.csv.
        cousins: cousins.json that the scenes were made from: it says who decided.
        protocol: robustness variant of the room (`experiment.protocols`); empty: as for Table 2.
        draw: seed of that variant.
    """
    generated = [read_json(GeneratedScene, path) for path in scenes]
    seen, true = read_json(Objects, objects), read_json(Truth, truth)
    check_same_scene(generated, seen, true)
    folders = AssetFolders(library)
    strangers = sorted({item.asset for item in true.objects} - set(folders))
    if strangers:
        what = f"has assets that {library} lacks: {', '.join(strangers)}."
        raise InputError(truth, what, "render the room again", code="E-LIBRARY-ASSET")
    categories = {entry.id: entry.category for entry in read_json(Library, library).assets}
    for path, scene in zip(scenes, generated, strict=True):
        check_categories(path, scene.objects, categories)
    check_categories(truth, true.objects, categories)
    decided = judges(cousins, true.scene)
    variant = {"protocol": protocol, "draw": draw}
    scored = [row for scene in generated for row in score_scene(scene, seen, true, folders)]
    rows = [row.model_dump() | decided.get(row.object, {}) | variant for row in scored]
    table = pd.DataFrame(rows, columns=list(SceneScore.model_fields))
    with write_atomically(out) as path:
        table.to_csv(path, index=False, float_format="%.6g")
    best = table[table["rank"] == table["rank"].min()]
    print(
        f"{true.scene} rank {best['rank'].min()}: category {best.category_correct.mean():.2f}, "
        f"model {best.model_correct.mean():.2f}, L2 {best.l2_cm.mean():.1f} cm, "
        f"orientation {best.orientation_rad.mean():.2f} rad, IoU {best.iou.mean():.2f}, "
        f"oriented {best.oriented_iou.mean():.2f}"
    )
