"""The camera of films: everything in the frame, and as near as that allows."""

import numpy as np
import pytest

from stages.simulation.studio import FIELD_OF_VIEW, HEIGHT, MARGIN, WIDTH, evenly, frame_all, view_direction


@pytest.mark.parametrize("side", [1.0, -1.0, 0.0])
def test_everything_is_in_the_frame_and_something_touches_its_edge(side: float) -> None:
    points = np.random.default_rng(3).uniform([-0.4, -0.5, -0.2], [1.1, 0.6, 1.3], (400, 3))
    direction = view_direction(side)
    camera_from_world = np.linalg.inv(frame_all(points, direction))
    x, y, depth = (points @ camera_from_world[:3, :3].T + camera_from_world[:3, 3]).T
    assert (depth > 0).all() and camera_from_world[1, 2] < 0  # y points down
    limit = np.tan(FIELD_OF_VIEW / 2)
    reach = np.abs(x / depth) / limit, np.abs(y / depth) / (limit * HEIGHT / WIDTH)
    assert max(values.max() for values in reach) == pytest.approx(1 / MARGIN)
    assert direction @ camera_from_world[2, :3] == pytest.approx(-1) and direction[2] > 0
    assert np.sign(direction[1]) == (side or 1.0)


def test_moments_are_spread_evenly_with_both_ends() -> None:
    assert evenly(range(101), 5) == [0, 25, 50, 75, 100]
    assert evenly([7, 8], 4) == [7, 7, 8, 8]
