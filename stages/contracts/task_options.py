"""Options of a task's environment, as section `task` of the config and every episodes.h5 hold them."""

from typing import ClassVar, Literal

from pydantic import Field

from roomkin.stages.contracts.section import NotNegative, Range, Section

SIMULATION_FREQUENCY = 100  # physics steps per second; a task may have a multiple of it


class TaskConfig(Section):
    """The task as the policy meets it. It is stored in every episodes.h5, so that evaluation uses the same one."""

    # Success
    success_fraction: float = Field(
        0.5, gt=0, lt=1, description="the target joint must pass this fraction of its range, ..."
    )
    success_angle: float = Field(60.0, gt=0, description="... or so many degrees (door), whichever is less")
    success_distance: float = Field(0.15, gt=0, description="... or so many metres (drawer), whichever is less")
    max_steps: int | None = Field(
        None, ge=10, description="steps after which an episode is over; null: the task's own (door and drawer 100)"
    )
    sim_backend: Literal["physx_cpu", "physx_cuda"] = Field(
        "physx_cpu", description="where the physics runs; physx_cuda needs a GPU"
    )

    # Action (paper B.3: delta end-effector pose through inverse kinematics)
    controller: Literal["pd_ee_dls", "pd_ee_target_delta_pose"] = Field(
        "pd_ee_dls", description="damped least squares, or ManiSkill's stock controller"
    )
    control_frequency: int = Field(10, gt=0, description="actions per second; divides 100 (official code: 12)")
    position_step: float = Field(0.05, gt=0, description="metres per step at action 1 (official code: 0.05)")
    rotation_step: float = Field(0.2, gt=0, description="radians per step at action norm 1 (official code: 0.2)")

    # Observation (paper B.3: one over-the-shoulder camera, finger points, farthest point sampling)
    cloud: Literal["target_link", "object"] = Field(
        "target_link", description="the cloud shows the door or drawer that is meant, or the whole object"
    )
    points: int = Field(
        512, ge=64, description="points of the cloud, an eighth of them on the gripper fingers (official code: 2048)"
    )
    camera_size: int = Field(128, ge=32, description="width and height of the depth image, pixels")
    camera_fov: float = Field(1.0, gt=0.1, lt=2.5, description="field of view, radians")
    camera_eye: tuple[float, float, float] = Field((0.05, -0.65, 1.05), description="in the robot base frame, metres")
    camera_target: tuple[float, float, float] = Field((0.65, 0.0, 0.42), description="point it looks at, same frame")
    camera_jitter: tuple[NotNegative, NotNegative] = Field(
        (0.01, 0.05), description="uniform +/- metres and radians (official: 0.01, 0.10)"
    )
    workspace_min: tuple[float, float, float] = Field((0.15, -0.5, 0.15), description="crop of the cloud, base frame")
    workspace_max: tuple[float, float, float] = Field((1.0, 0.5, 0.9), description="crop of the cloud, base frame")

    # Randomisation of the initial state (paper A.5: robot pose, object pose, object scale)
    base_distance: float = Field(0.65, gt=0, description="robot base in front of the handle, metres (official: 0.5)")
    # Robot base away from the hinge of a door, metres
    base_side: ClassVar[float] = 0.1
    # Handle of a door above the robot base, metres
    handle_height: ClassVar[float] = 0.4
    # Handle of a drawer above the robot base, metres
    drawer_height: ClassVar[float] = 0.5
    # Robot base before, beside and below the handle of a flap, metres
    flap_base: ClassVar[tuple[float, float, float]] = (0.6, 0.42, 0.45)
    base_xy: float = Field(0.03, ge=0, description="uniform +/- metres (official: 0.03)")
    base_z: float = Field(0.07, ge=0, description="uniform +/- metres (official: 0.07)")
    base_yaw: float = Field(0.31, ge=0, description="uniform +/- radians (official: pi/10)")
    object_xy: float = Field(0.02, ge=0, description="uniform +/- metres")
    object_yaw: float = Field(0.1, ge=0, description="uniform +/- radians")
    scale_range: Range = Field((0.75, 1.25), description="per axis, of the nominal size (official: 0.75 to 1.25)")
    scale_variants: int = Field(64, ge=1, description="different scales per asset")
    qpos_noise: float = Field(0.02, ge=0, description="standard deviation of the initial arm joints, radians")

    @property
    def finger_points(self) -> int:
        """How many of the cloud's points lie on the gripper fingers."""
        return self.points // 8
