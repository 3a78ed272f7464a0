"""The moving picture of docs/tutorial/first-policy.md: a policy opens an unseen fridge in a scene of a photograph.

After the run of that page:

    python -m benchmarks.policy_film --policy results/training/door/lite_handle/cousins_4/lite_handle/seed_0

The scene's fridge must be of the test split. Every trial is printed, the first success filmed.
"""

import argparse
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from benchmarks.hero import BETWEEN, FREQUENCY, add_title, smooth
from roomkin import load_policy
from roomkin.plugins.api.loaded import LoadedPolicy
from roomkin.plugins.films.writing import write_film
from roomkin.plugins.in_scene.room import GeneratedRoom, find_obstacle, list_base_shifts, read_room
from roomkin.stages.contracts import TaskAssets, read_json
from roomkin.stages.contracts.generated import Look
from roomkin.stages.contracts.images import read_rgb
from roomkin.stages.evaluation.states import initial_states
from roomkin.stages.simulation.film_renderer import FilmRenderer, Image
from roomkin.stages.simulation.room import Recording
from roomkin.stages.tasks.api import EnvWrapper

SMALL, LARGE = (239, 134), (480, 320)  # pixels: photograph and scene, below them the robot
GAP, WHITE, QUALITY = 2, 255, 85
TRIALS = 10
STILL = {"object_xy": 0.0, "object_yaw": 0.0, "scale_range": (1.0, 1.0)}  # the scene says where the object stands


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
    """The first success of `TRIALS` rollouts on the object of the scene, which must be of the test split."""
    plan = read_json(TaskAssets, given.results / f"experiment/default/{given.target}/assets.json")
    library = given.results / "assets/library/library.json"
    room = read_room(folder / f"scene_{given.rank}.json", plan.object, library, cache)
    room, name = replace(room, look=read_json(Look, folder / "look.json")), room.target.asset.id
    asset = next((asset for asset in plan.test_assets if asset.asset == name), None)
    if asset is None:
        raise SystemExit(f"rank {given.rank}: {name} is not of the test split")
    policy, found = load_policy(given.policy), []
    for seed in initial_states("test", 0, TRIALS):
        success, recording = roll_out(policy, plan.task, asset.joint, room, seed)
        print(f"{name}: {'opened' if success else 'not opened'}, robot shifted by {room.shift}", flush=True)
        found += [recording] * success
    print(f"{len(found)} of {TRIALS}")
    if not found:
        raise SystemExit("it opened none")
    return found[0]


def pictures(given: argparse.Namespace) -> Iterator[Image]:
    """Photograph and scene in a row, below them what the robot does."""
    folder = given.results / f"generation/default/{given.scene}"
    with TemporaryDirectory() as cache:
        recording = find_success(given, folder, Path(cache))
        moments = smooth(recording.moments)[:: given.every]
        light = read_json(Look, folder / "look.json").light
        film = FilmRenderer(light, *(3 * side // 2 for side in LARGE)).film(
            replace(recording, moments=moments), len(moments)
        )
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
    parser.add_argument("--every", type=int, default=1, help="of so many pictures one is kept")
    parser.add_argument("--out", type=Path, default=Path("docs/images/first_policy.webp"))
    given = parser.parse_args()
    write_film(given.out, list(pictures(given)), FREQUENCY * BETWEEN / given.every, QUALITY)


if __name__ == "__main__":
    main()
