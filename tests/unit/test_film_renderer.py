"""The camera of films: everything in the frame, as near as that allows, from where the hand is seen."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from roomkin.stages.contracts.policy_config import TaskConfig
from roomkin.stages.simulation.film_renderer import HAND, FilmRenderer, Shot, directions, pick_evenly
from roomkin.stages.simulation.framing import FIELD_OF_VIEW, MARGIN, frame_all
from roomkin.stages.simulation.loading import remove
from roomkin.stages.simulation.rendering import add_block
from roomkin.stages.tasks.api import EnvWrapper
from tests.unit.demo_assets import cabinet


@pytest.mark.parametrize("side", [1.0, -1.0, 0.0])
def test_everything_is_in_the_frame_and_something_touches_its_edge(side: float) -> None:
    points = np.random.default_rng(3).uniform([-0.4, -0.5, -0.2], [1.1, 0.6, 1.3], (400, 3))
    direction = directions(side)[0]
    camera_from_world = np.linalg.inv(frame_all(points, direction, 0.8))
    x, y, depth = (points @ camera_from_world[:3, :3].T + camera_from_world[:3, 3]).T
    assert (depth > 0).all() and camera_from_world[1, 2] < 0  # y points down
    limit = np.tan(FIELD_OF_VIEW / 2)
    reach = np.abs(x / depth) / limit, np.abs(y / depth) / (limit * 0.8)
    assert max(values.max() for values in reach) == pytest.approx(1 / (1 + MARGIN))
    assert direction @ camera_from_world[2, :3] == pytest.approx(-1) and direction[2] > 0
    assert np.sign(direction[1]) == (side or 1.0)


def test_moments_are_spread_evenly_with_both_ends() -> None:
    assert pick_evenly(range(101), 5) == [0, 25, 50, 75, 100]
    assert pick_evenly([7, 8], 4) == [7, 7, 8, 8]


def test_the_hand_is_seen_and_the_room_stands_about(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    cabinet(tmp_path / "cabinet")
    task = EnvWrapper("door", tmp_path / "cabinet", "door_0_joint", None, TaskConfig())
    task.place(3)
    closed, renderer = task.env.moment(), FilmRenderer()
    opened = replace(closed, asset_joints={**closed.asset_joints, "door_0_joint": 1.0})
    recording = task.env.recording([closed, opened])
    shot = Shot(renderer, recording, recording.moments)
    pictures = [shot.picture(moment) for moment in recording.moments]
    assert all(shot._sees_hand(shot.world_from_camera, moment) for moment in recording.moments)
    hand = next(link.pose.p for link in shot.robot.links if link.name == HAND)
    screen = add_block(shot.scene, (hand + shot.world_from_camera[:3, 3]) / 2, [0.3] * 3, (1, 0, 0), "screen")
    assert not shot._sees_hand(shot.world_from_camera, recording.moments[-1]), "something is before it"
    remove(shot.scene, screen)
    assert (renderer.camera.render(shot.world_from_camera).depth > 0).all(), "floor and wall fill the picture"
    shot.close()
    assert all(picture.shape == (360, 480, 3) for picture in pictures) and (pictures[0] != pictures[1]).any()
    assert np.array_equal(renderer.film(recording, 2), pictures), "nothing is left in the renderer"
    assert FilmRenderer(width=160, height=90).film(recording, 1)[0].shape == (90, 160, 3)

    monkeypatch.setattr(Shot, "_sees_hand", lambda *_: False)
    first = Shot(renderer, recording, recording.moments).world_from_camera
    monkeypatch.setattr(Shot, "_sees_hand", lambda _, view, moment: view[2, 2] < -0.45)  # from above alone
    higher = Shot(renderer, recording, recording.moments).world_from_camera
    assert higher[2, 2] < -0.45 < first[2, 2]
    task.close()
