"""What a policy is trained on and how (paper B.3): section `task`, training sets, `training.configs`."""

import re
from typing import Any, ClassVar, Literal, NamedTuple

from pydantic import Field, model_validator

from roomkin.stages.contracts.section import KWARGS, NotNegative, Range, Section

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


RULES = {"cousins": "cousin", "random": "random", "cover": "cover"}  # rules that name a number of assets -> their roles
DRAWN = ("random", "cover")  # rules by chance: their assets are drawn anew for every draw
DRAW = 16  # assets of a draw; the numbers of the next draw's roles go on behind them
RANDOMISED = "_randomised"  # ends a set or role whose every attempt draws extents, friction and mass anew
SET_NAME = rf"(?:twin|all|(?:{'|'.join(RULES)})_[1-9]\d*)(?:{RANDOMISED})?"
ROLE_NAME = rf"(?:twin|all|(?:{'|'.join(RULES.values())})_[1-9]\d*)(?:{RANDOMISED})?"


class SetName(NamedTuple):
    """The parts of a training set's name: `cousins_8_randomised` is eight cousins, randomised."""

    rule: str
    size: int  # stores of demonstrations: one per asset; `all` is one store of many assets
    randomised: bool


def read_set(name: str) -> SetName:
    """The parts of a training set's name, which matches `SET_NAME`."""
    rule, _, size = strip_randomised(name).partition("_")
    return SetName(rule, int(size or 1), is_randomised(name))


def is_set(name: str) -> bool:
    """Whether a name is that of a training set."""
    return re.fullmatch(SET_NAME, name) is not None


def is_randomised(name: str) -> bool:
    """Whether the assets of a set or role are randomised."""
    return name.endswith(RANDOMISED)


def strip_randomised(name: str) -> str:
    """The set or role without its randomisation: that of the same assets."""
    return name.removesuffix(RANDOMISED)


def drawn_role(rule: str, draw: int, place: int) -> str:
    """The role of an asset by its place in a draw, both from 0: random_3 is the third of the first draw."""
    return f"{RULES[rule]}_{draw * DRAW + place + 1}"


class PolicyConfig(Section):
    """One hyper-parameter set. The defaults are `lite`: minutes on one core."""

    policy: str = Field("bc_rnn_gmm", json_schema_extra={"kind": "policies"}, description="the paper's")
    kwargs: dict[str, Any] = KWARGS
    horizon: int = Field(10, ge=1, description="steps per training sequence; paper: 10")
    points: int = Field(192, ge=16, description="random subset of each cloud that is seen (official: 1024 of 2048)")
    handle: bool = Field(
        False,
        description="the policy goes by the handle: its points, those before the front, are flagged, its middle is an "
        "input, and in training fronts move under their handles (not in the paper; docs/policies.md)",
    )

    # Optimisation
    steps: int = Field(2500, ge=1, description="AdamW updates; official code: 300000")
    batch_size: int = Field(16, ge=1, description="sequences per update; official code: 32")
    learning_rate: float = Field(2e-3, gt=0, description="peak; official code: 1e-3")
    schedule: Literal["linear", "cosine", "constant"] = Field(
        "cosine",
        description="cosine: to zero at the last step; linear: to a tenth over 10000 steps, then flat (official)",
    )
    warmup: int = Field(
        100, ge=0, description="first updates, over which the learning rate rises to its schedule; official code: 0"
    )
    weight_decay: float = Field(1e-4, ge=0, description="of AdamW; official code: 0")

    # Augmentation (paper B.3: random downsampling, translation, jitter)
    translation: float = Field(0.04, ge=0, description="uniform +/- metres per axis (official: 0.04)")
    translation_mode: Literal["sequence", "cloud_only"] = Field(
        "sequence",
        description="sequence: one shift per sequence, of cloud and end-effector position together; cloud_only: one "
        "per step, proprioception stays (official code; it breaks the relation of hand and handle)",
    )
    jitter: float = Field(0.01, ge=0, description="standard deviation per point and axis, metres (official: 0.01)")

    # Data, checkpoints, logs
    release_included: bool = Field(
        True,
        description="false: demonstrations end before the hand opens for the last time. A test is over at success, and "
        "policies that learn to let go do so by where the hand is: wide doors too early (docs/policies.md). Not for "
        "tasks that succeed by letting go, such as put_away_bowl",
    )
    select: Literal["validation", "last"] = Field(
        "validation", description="which checkpoint becomes policy.safetensors: lowest validation loss, or the last"
    )
    num_checkpoints: int = Field(
        0, ge=0, description="evenly spaced checkpoints kept for `evaluation: {checkpoint: rollouts}`"
    )
    log_freq: int = Field(100, ge=1, description="steps between lines of metrics.jsonl and validations")
    wandb: Literal["disabled", "offline", "online"] = Field(
        "disabled", description="Weights & Biases run beside metrics.jsonl, below logs/training/wandb"
    )

    @model_validator(mode="after")
    def _check_cloud(self) -> "PolicyConfig":
        if self.handle and not has_eyes(self):
            raise ValueError("handle: flags points of a cloud, but kwargs.cloud is false")
        return self


def has_eyes(config: PolicyConfig) -> bool:
    """Whether a policy looks at clouds at all."""
    return bool(config.kwargs.get("cloud", True))
