"""What pixels show, as points."""

import numpy as np

from stages.geometry.cameras import PointMap, make_intrinsics
from stages.geometry.frames import rigid


def test_points_are_in_its_frame_where_depth_is_known() -> None:
    depth = np.array([[2.0, 0.0], [1.0, 4.0]], np.float32)
    seen = PointMap(depth, make_intrinsics(2, 2, 0, 0), rigid([[0, 0, 1], [-1, 0, 0], [0, -1, 0]], [0, 0, 1.5]))
    np.testing.assert_allclose(seen.points[1, 1], [4, -2, -0.5])
    assert np.isnan(seen.points[0, 1]).all()
    np.testing.assert_allclose(seen.of(np.array([[True, True], [False, True]])), [[2, 0, 1.5], [4, -2, -0.5]])
