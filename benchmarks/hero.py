"""The moving picture at the top of the README: an input, the scene of its objects' cousins, a robot that opens one.

After the default run:

    python -m benchmarks.hero --results results --scene room_1 --rank 2 --object cabinet_1 --out docs/images/hero.webp

The skill of the demonstrations opens the door; no policy does.
"""

import argparse
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory

import cv2
import numpy as np

from roomkin.plugins.films.writing import write_film
from roomkin.plugins.in_scene.room import GeneratedRoom, find_obstacle, list_base_shifts, read_room
from roomkin.stages.config.training import DemonstrationsConfig
from roomkin.stages.contracts import read_json
from roomkin.stages.contracts.generated import Look
from roomkin.stages.contracts.images import read_rgb
from roomkin.stages.contracts.policy_config import TaskConfig
from roomkin.stages.demonstrations.attempt import Recorder
from roomkin.stages.plugins import load
from roomkin.stages.simulation.film_renderer import FilmRenderer, Image, Moment, Recording
from roomkin.stages.tasks.api import EnvWrapper

SMALL, LARGE = (320, 240), (640, 480)  # pixels: input and scene, the robot beside them
FREQUENCY, BETWEEN = 10, 2  # moments per second, and pictures to a moment
QUALITY, WAIT = 85, 8  # of the film; pictures before it moves
GAP, WHITE = 6, 255


def find_demonstration(room: GeneratedRoom, task: str) -> Recording:
    """The first successful demonstration in a scene."""
    still = TaskConfig(object_xy=0.0, object_yaw=0.0, scale_range=(1.0, 1.0))
    joint = load("tasks", task).suitable_joint(room.target.folder)
    env = EnvWrapper(task, room.target.folder, joint, None, still, vary_scale=False, room=room)
    recorder = Recorder(env, DemonstrationsConfig(recovery=0.0, noise=0.0), film=True)
    for seed, room.shift in enumerate(list_base_shifts()):
        env.place(seed)
        if not find_obstacle(env, room) and recorder.attempt(seed)[1].success:
            return recorder.filmed[0].recording
    raise SystemExit(f"the robot cannot open {room.target.id}")


def smooth(moments: Sequence[Moment]) -> list[Moment]:
    """Moments with others between them: joints move evenly, nothing else does."""
    found = [moments[0]] * WAIT
    for one, other in pairwise(moments):
        for share in np.arange(1, BETWEEN + 1) / BETWEEN:
            found.append(
                replace(
                    other,
                    robot_joints=mix_joints(one.robot_joints, other.robot_joints, share),
                    asset_joints=mix_joints(one.asset_joints, other.asset_joints, share),
                )
            )
    return found


def mix_joints(one: Mapping[str, float], other: Mapping[str, float], share: float) -> dict[str, float]:
    """Joint values on the way from one to the other."""
    return {name: (1 - share) * value + share * other[name] for name, value in one.items()}


def add_title(picture: Image, size: tuple[int, int], text: str) -> Image:
    """A picture at its size, with a line in its corner."""
    shown = np.ascontiguousarray(cv2.resize(picture, size, interpolation=cv2.INTER_AREA))
    (width, height), _ = cv2.getTextSize(text, cv2.FONT_HERSHEY_SIMPLEX, 0.5, 1)
    shown[: height + 14, : width + 16] = WHITE
    cv2.putText(shown, text, (8, height + 7), cv2.FONT_HERSHEY_SIMPLEX, 0.5, (30, 30, 30), 1, cv2.LINE_AA)
    return shown


def pictures(results: Path, scene: str, rank: int, object: str, task: str) -> Iterator[Image]:
    """Input above scene, and beside them what the robot does."""
    folder = results / "generation/default" / scene
    look = read_json(Look, folder / "look.json")
    with TemporaryDirectory() as cache:
        room = read_room(folder / f"scene_{rank}.json", object, results / "assets/library/library.json", Path(cache))
        recording = find_demonstration(replace(room, look=look), task)
        moments = smooth(recording.moments)
        film = FilmRenderer(look.light, 3 * LARGE[0] // 2).film(replace(recording, moments=moments), len(moments))
    left = [
        add_title(read_rgb(results / "scenes" / scene / "input/rgb.png"), SMALL, "1  a picture"),
        np.full((GAP, SMALL[0], 3), WHITE, np.uint8),
        add_title(read_rgb(folder / f"scene_{rank}.png"), SMALL, "2  a scene of its cousins"),
    ]
    column = np.concatenate(left)
    size = round(column.shape[0] * LARGE[0] / LARGE[1]), column.shape[0]
    between = np.full((size[1], GAP, 3), WHITE, np.uint8)
    for picture in film:
        yield np.concatenate([column, between, add_title(picture, size, "3  a robot opens one of them")], axis=1)


def main() -> None:
    """Write the film."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--results", type=Path, required=True)
    parser.add_argument("--scene", required=True)
    parser.add_argument("--rank", type=int, required=True)
    parser.add_argument("--object", required=True)
    parser.add_argument("--task", default="door")
    parser.add_argument("--out", type=Path, required=True)
    given = parser.parse_args()
    frames = list(pictures(given.results, given.scene, given.rank, given.object, given.task))
    write_film(given.out, frames, FREQUENCY * BETWEEN, QUALITY)


if __name__ == "__main__":
    main()
