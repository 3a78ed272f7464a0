"""What a policy is given at each step, by the environment as by the stores."""

from typing import TypedDict

import numpy as np
from numpy.typing import NDArray


class Observation(TypedDict):
    """What a policy sees (paper B.3), in the robot base frame.

    point_cloud: (P, 4) float32 xyz in metres and a flag: 0 scene, 1 gripper finger. Fingers come last.
    proprio: (9,) float32 end-effector position, quaternion wxyz, the two finger joints.
    """

    point_cloud: NDArray[np.float32]
    proprio: NDArray[np.float32]
