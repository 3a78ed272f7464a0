"""Command `demonstrate`: demonstrations inside generated scenes, with furniture in the way (the paper's Figure 7)."""

import sys
from collections import Counter
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import numpy as np

from roomkin.plugins.films.kinds import Film
from roomkin.plugins.films.writing import FRAMES, FilmedAttempt, make_strip, plot_cloud, write_films, write_png
from roomkin.plugins.in_scene.kinds import SceneDemonstration, SceneDemonstrations
from roomkin.plugins.in_scene.room import find_obstacle, find_touched, list_base_shifts, read_room
from roomkin.stages.config.training import DemonstrationsConfig
from roomkin.stages.contracts import GeneratedScene, InputError, read_json, read_options, write_json
from roomkin.stages.contracts.archives import pack
from roomkin.stages.contracts.errors import ObjectError
from roomkin.stages.contracts.generated import ROOM_LIGHT
from roomkin.stages.contracts.policy_config import TaskConfig
from roomkin.stages.demonstrations.attempt import Recorder, write_episodes
from roomkin.stages.demonstrations.collect import attempt_seeds
from roomkin.stages.plugins import load
from roomkin.stages.simulation.film_renderer import FilmRenderer
from roomkin.stages.tasks.api import EnvWrapper
from roomkin.stages.tasks.task import Task

SCENE_TRIES = 10  # attempts in one scene; chosen for time


class SceneSettings(NamedTuple):
    """The settings for all scenes; `cache`: folder for models at their sizes, `stores`: for episodes."""

    object: str
    task: str
    library: Path
    options: DemonstrationsConfig
    world: TaskConfig
    seed: int
    cache: Path
    stores: Path


def run(
    *,
    scenes: tuple[Path, ...],
    object: str,
    task: str,
    library: Path,
    out: Path,
    options: str = "",
    task_options: str = "",
    seed: int = 0,
) -> None:
    """Demonstrate a task once in every scene; write in_scene.json, films.zip, film.png and an episode store per scene.

    The stores are packed into episodes.zip.

    A scene in which the robot cannot do it is marked failed, with the reason.

    Args:
        scenes: scene_<rank>.json files of generation.
        object: id of the object that the task is about.
        task: door, drawer, ... or yours.
        library: library.json that the scenes are of.
        out: folder to write.
        options: the `demonstrations` section as JSON.
        task_options: the `task` section as JSON.
        seed: of the attempts.
    """
    settings = read_options(DemonstrationsConfig, options).model_copy(update={"recovery": 0.0})
    still = {"object_xy": 0.0, "object_yaw": 0.0, "scale_range": (1.0, 1.0)}  # the scene says where the object stands
    world = read_options(TaskConfig, task_options).model_copy(update=still)
    read = {path: read_json(GeneratedScene, path) for path in scenes}
    if not any(item.id == object for generated in read.values() for item in generated.objects):
        known = dict.fromkeys(item.id for generated in read.values() for item in generated.objects)
        what = f"no scene has an object '{object}'."
        raise InputError("--object", what, f"those there are: {', '.join(known)}", code="E-SCENE-OBJECT")
    found, films, strips = [], [], []
    with TemporaryDirectory(prefix="acdc-room-") as cache, TemporaryDirectory(prefix="acdc-stores-") as stores:
        setting = SceneSettings(object, task, library, settings, world, seed, Path(cache), Path(stores))
        renderer = FilmRenderer(ROOM_LIGHT)
        for path, generated in read.items():
            try:
                one, taken = demonstrate_in_scene(path, generated, setting)
            except ObjectError as error:  # a model that this task cannot use
                one, taken = _failed(generated, str(error)[:900]), None
            found.append(one)
            if one.film and taken:
                pictures = renderer.film(taken.recording, FRAMES * 2)
                films.append((one.film, pictures))
                strips.append(make_strip(pictures, taken.clouds))
            print(f"demonstrations: rank {one.rank}: {one.reason or 'ok'}", file=sys.stderr)
        pack(Path(stores), out / "episodes.zip")
    write_films(out / "films.zip", films, world.control_frequency)
    write_png(out / "film.png", np.concatenate(strips or [plot_cloud(np.zeros((0, 4)))]))
    write_json(out / "in_scene.json", SceneDemonstrations(task=task, object=object, demonstrations=found))


def _failed(generated: GeneratedScene, reason: str, **about: Any) -> SceneDemonstration:
    known = {"scene": generated.scene, "variant": generated.variant, "rank": generated.rank, "asset": ""}
    return SceneDemonstration(status="failed", reason=reason, **(known | about))


def demonstrate_in_scene(
    path: Path, generated: GeneratedScene, setting: SceneSettings
) -> tuple[SceneDemonstration, FilmedAttempt | None]:
    """A demonstration in one scene, with what is to be filmed."""
    object, placed = setting.object, {item.id: item for item in generated.objects}
    if object not in placed or placed[object].status == "failed":
        reason = f"{object}: {placed[object].reason}" if object in placed else f"the scene has no {object}"
        return _failed(generated, reason), None
    room = read_room(path, object, setting.library, setting.cache)
    known: Task = load("tasks", setting.task)
    asset, target = room.target.asset.id, known.target_joint(room.target.folder, flaps=True)
    if target is None:
        reason = f"{object} is {asset}, which has no {known.part_type} that the robot can open"
        return _failed(generated, reason, asset=asset), None
    task = EnvWrapper(setting.task, room.target.folder, target.joint, None, setting.world, vary_scale=False, room=room)
    recorder, reasons, attempts = Recorder(task, setting.options, film=True), Counter[str](), 0
    seeds = attempt_seeds(setting.seed, f"rank_{generated.rank}", len(list_base_shifts()))
    for room.shift, seed in zip(list_base_shifts(), seeds, strict=True):
        task.place(seed)
        obstacle = find_obstacle(task, room)
        if obstacle:
            reasons[obstacle] += 1
            continue
        attempts += 1
        episode, outcome = recorder.attempt(seed)
        if outcome.success:
            store = setting.stores / f"rank_{generated.rank}.h5"
            write_episodes(store, [episode], setting.task, known.gym_id, asset, setting.world)
            film = Film(
                role=f"rank_{generated.rank}", asset=asset, seed=seed, success=True, steps=len(episode.actions),
                opened=round(task.opened, 4), file=f"rank_{generated.rank}.webp",
            )  # fmt: skip
            task.close()
            done = SceneDemonstration(
                scene=generated.scene, variant=generated.variant, rank=generated.rank, asset=asset, joint=target.joint,
                status="ok", attempts=attempts, shift=room.shift, film=film,
            )  # fmt: skip
            return done, recorder.filmed[0]
        against = ", ".join(sorted(find_touched(task, room)))
        reasons[f"{outcome.cause}{f' against {against}' if against else ''}"] += 1
        if attempts == SCENE_TRIES or outcome.cause == "no_handle":
            break
    task.close()
    tried = "; ".join(f"{reason} ({count}x)" for reason, count in reasons.most_common())
    reason = f"the robot cannot open {target.joint} of {object} ({asset}): {tried}"
    return _failed(generated, reason, asset=asset, joint=target.joint, attempts=attempts), None
