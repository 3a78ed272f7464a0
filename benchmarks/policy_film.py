"""The moving picture of docs/tutorial/first-policy.md: a policy opens unseen fridges in the scene of a photograph.

After the run of that page:

    python -m benchmarks.policy_film --policy results/training/door/lite_handle/cousins_4/lite_handle/seed_0

Fridges of the test split are tried in their order, each once, in the place of the scene's; every trial is printed, the
first success filmed.
"""

import argparse
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from benchmarks.hero import BETWEEN, FREQUENCY, add_title, smooth
from plugins.api import load_policy
from plugins.api.loaded import LoadedPolicy
from plugins.films.writing import write_film
from plugins.in_scene.base_shifts import find_obstacle, list_base_shifts
from plugins.in_scene.room import GeneratedRoom, read_room
from stages.contracts import GeneratedScene, TaskAssets, read_json, write_json
from stages.contracts.images import read_rgb
from stages.contracts.look import Look
from stages.contracts.policies import TaskAsset
from stages.evaluation.states import initial_states
from stages.simulation.film_renderer import FilmRenderer, Image
from stages.simulation.recording import Recording
from stages.tasks.api import EnvWrapper

SMALL, LARGE = (239, 134), (480, 320)  # pixels: photograph and scene, below them the robot
GAP, WHITE, QUALITY = 2, 255, 50
STILL = {"object_xy": 0.0, "object_yaw": 0.0, "scale_range": (1.0, 1.0)}  # the scene says where the object stands


def stand_in(scene: Path, object: str, asset: TaskAsset, out: Path) -> Path:
    """The scene with another asset in the place and the box of one of its objects, in a file of its own."""
    generated = read_json(GeneratedScene, scene)
    found = next(item for item in generated.objects if item.id == object)
    found.asset, found.category, found.finish = asset.asset, asset.category, {}
    write_json(out, generated)
    return out


def roll_out(policy: LoadedPolicy, task: str, joint: str, room: GeneratedRoom, seed: int) -> tuple[bool, Recording]:
    """One rollout in a room, from the first place of the robot that is free."""
    options = policy.task_options.model_copy(update=STILL)
    env = EnvWrapper(task, room.target.folder, joint, None, options, vary_scale=False, room=room)
    for room.shift in list_base_shifts():
        observation = env.reset(seed)
        if not find_obstacle(env, room):
            break
    else:
        raise SystemExit(f"no place before {room.target.id} is free")
    policy.reset(seed)
    moments, done, success = [env.env.moment()], False, False
    while not done:
        result = env.step(policy.act(observation))
        observation, done, success = result.observation, result.done, result.success
        moments.append(env.env.moment())
    recording = env.env.recording(moments)
    env.close()
    return success, recording


def find_success(given: argparse.Namespace, folder: Path, cache: Path) -> Recording:
    """The first success on the test split's assets of the object's category."""
    plan = read_json(TaskAssets, given.results / f"experiment/b/{given.target}/assets.json")
    category = plan.find_asset("twin", given.policy).category
    policy, library = load_policy(given.policy), given.results / "assets/library/library.json"
    for place, asset in enumerate(plan.test_assets):
        if asset.category != category:
            continue
        scene = stand_in(folder / f"scene_{given.rank}.json", plan.object, asset, cache / f"{asset.asset}.json")
        room = replace(read_room(scene, plan.object, library, cache), look=read_json(Look, folder / "look.json"))
        seed = initial_states("test", 0, 1, place)[0]
        success, recording = roll_out(policy, plan.task, asset.joint, room, seed)
        print(f"{asset.asset}: {'opened' if success else 'not opened'}, robot shifted by {room.shift}", flush=True)
        if success:
            return recording
    raise SystemExit("it opened none")


def pictures(given: argparse.Namespace) -> Iterator[Image]:
    """Photograph and scene in a row, below them what the robot does."""
    folder = given.results / f"generation/b/{given.scene}"
    with TemporaryDirectory() as cache:
        recording = find_success(given, folder, Path(cache))
        moments = smooth(recording.moments)[:: given.every]
        light = read_json(Look, folder / "look.json").light
        film = FilmRenderer(light, *LARGE).film(replace(recording, moments=moments), len(moments))
    row = [
        add_title(read_rgb(given.photograph), SMALL, "1  a photograph"),
        np.full((SMALL[1], GAP, 3), WHITE, np.uint8),
        add_title(read_rgb(folder / f"scene_{given.rank}.png"), SMALL, "2  cousins of its things"),
    ]
    above = np.concatenate([np.concatenate(row, axis=1), np.full((GAP, LARGE[0], 3), WHITE, np.uint8)])
    for picture in film:
        yield np.concatenate([above, add_title(picture, LARGE, "3  a policy opens a fridge that it never saw")])


def main() -> None:
    """Write the film."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--policy", type=Path, required=True)
    parser.add_argument("--results", type=Path, default=Path("results"))
    parser.add_argument("--photograph", type=Path, default=Path("config/examples/kitchen/photograph.jpg"))
    parser.add_argument("--scene", default="kitchen")
    parser.add_argument("--target", default="door")
    parser.add_argument("--rank", type=int, default=2)
    parser.add_argument("--every", type=int, default=2, help="of so many pictures one is kept")
    parser.add_argument("--out", type=Path, default=Path("docs/images/first_policy.webp"))
    given = parser.parse_args()
    write_film(given.out, list(pictures(given)), FREQUENCY * BETWEEN / given.every, QUALITY)


if __name__ == "__main__":
    main()
