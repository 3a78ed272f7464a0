"""Verb `generate`: cousins + objects -> one scene per rank, with its physics check."""

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from stages.cli import progress
from stages.config.generation import GenerationConfig
from stages.config.made import made
from stages.contracts import GeneratedScene, InputError, read_options, write_json
from stages.contracts.generated import PlacedObject
from stages.generation.build import Built, build
from stages.generation.inputs import Inputs, read_inputs
from stages.generation.settling import Settled, load_items, settle
from stages.geometry.frames import rounded
from stages.simulation.backdrop import add_backdrop
from stages.simulation.loading import physics_scene


def physics_check(built: Built, inputs: Inputs, options: GenerationConfig) -> Settled:
    """The physics check; nothing is rendered."""
    scene = physics_scene()
    camera = np.array(inputs.objects.floor_from_camera)[:3, 3]
    add_backdrop(scene, [item.box for item in built.items], inputs.objects.walls, camera)
    bodies = load_items(scene, built.items, built.folders)
    return settle(scene, bodies, built.items, len(built.left), options, inputs.objects.walls)


def scene_of(built: Built, settled: Settled, inputs: Inputs, variant: str, rank: int) -> GeneratedScene:
    """The contract of one scene; objects in the order of objects.json, failed ones with their reason."""
    placed = {item.id: item for item in built.items}
    objects = []
    for extracted in inputs.objects.objects:
        if extracted.id in built.failed:
            objects.append(
                PlacedObject(id=extracted.id, label=extracted.label, status="failed", reason=built.failed[extracted.id])
            )
            continue
        item = placed[extracted.id]
        objects.append(
            PlacedObject(
                id=item.id,
                label=item.label,
                asset=item.asset.id,
                category=item.asset.category,
                position=rounded(item.center),
                yaw=round(item.box.yaw, 6),
                size=rounded(item.size),
                support=item.support,
                mounting=item.mounting,
                cousin=item.cousin,
                chosen=item.chosen,
                steps=list(item.steps),
                doubts=list(item.doubts),
                moved=round(item.moved, 6),
                settled_shift=settled.shifts[item.id],
            )
        )
    source = inputs.objects
    return GeneratedScene(
        scene=source.scene,
        variant=variant,
        rank=rank,
        width=source.width,
        height=source.height,
        intrinsics=source.intrinsics,
        floor_from_camera=source.floor_from_camera,
        walls=source.walls,
        objects=objects,
        plausibility=settled.plausibility,
    )


def summary(scene: GeneratedScene, left: list[tuple[str, str]]) -> str:
    """One line for the log."""
    check = scene.plausibility
    failed = [item.id for item in scene.objects if item.status == "failed"]
    parts = [f"{scene.scene} rank {scene.rank}: {len(scene.objects) - len(failed)} placed"]
    if failed:
        parts.append(f"failed {', '.join(failed)}")
    if check is not None:
        parts.append("stable" if check.stable else f"NOT stable: {check.wrong}")
        parts.append(f"penetration {1000 * check.max_penetration:.1f} mm")
    parts += [f"{item.id}: {what}" for item in scene.objects for what in item.doubts]
    parts += [f"{a} and {b} still collide" for a, b in left]
    return "; ".join(parts)


def run(
    *,
    cousins: Path,
    objects: Path,
    library: Path,
    variant: str,
    out: Path,
    options: str = "{}",
    corrections: tuple[Path, ...] = (),
) -> None:
    """Make the scenes of one picture.

    Args:
        cousins: cousins.json of matching.
        objects: objects.json of extraction; clouds.npz lies beside it.
        library: library.json.
        variant: name of the matching variant, written into the scenes.
        out: folder; gets scene_<rank>.json of every rank.
        options: JSON of the config section `generation`.
        corrections: corrections.json beside the picture: which models a person chose, and what they moved.
    """
    config = read_options(GenerationConfig, options)
    inputs = read_inputs(cousins, objects, library, corrections)
    scenes = []
    with TemporaryDirectory(prefix="acdc-sized-") as cache:
        for rank in progress(range(1, config.ranks + 1), "scenes", config.ranks):
            built = build(inputs, rank, config, Path(cache))
            if not built.items:
                raise InputError(
                    objects, "has no object that could be placed.", "see the reasons in it and in cousins.json"
                )
            scenes.append(scene_of(built, physics_check(built, inputs, config), inputs, variant, rank))
            print(summary(scenes[-1], built.left))
    origin = made("stages.generation.generate", config, [cousins, objects, library, *corrections])
    for scene in scenes:
        write_json(out / f"scene_{scene.rank}.json", scene.model_copy(update={"made": origin}))
