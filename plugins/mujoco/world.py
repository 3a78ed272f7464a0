"""A Panda before one articulated model in MuJoCo, and pictures of it: depth, and what is seen at each pixel.

It shares no physics with ManiSkill: contacts, friction and drives are as MuJoCo has them.
"""

import tempfile
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from roomkin.plugins.mujoco.mjcf_writer import write_model
from roomkin.stages.articulated.asset_folder import read_model
from roomkin.stages.contracts.errors import InputError
from roomkin.stages.geometry.frames import quaternion_from_matrix
from roomkin.stages.simulation.robot import TCP, low_poly_urdf

Array = NDArray[np.float64]

TIMESTEP = 0.002  # seconds
ARM_GAINS = (4500.0, 4500.0, 3500.0, 3500.0, 2000.0, 2000.0, 2000.0)  # N m / rad: MuJoCo Menagerie's Panda
SETTLING = 0.04  # seconds, damping over gain, in which a drive comes near its target; Menagerie's 0.1 lag a step behind
ARMATURE = 0.1  # kg m^2 of the motors of the arm and kg of the fingers', as in Menagerie
ARM_FORCE = (87.0, 87.0, 87.0, 87.0, 12.0, 12.0, 12.0)  # N m: the robot's data sheet
FINGER_GAIN, FINGER_FORCE = 5000.0, 70.0  # N / m; N: the data sheet's continuous grasp
STIFF = (0.004, 1.0)  # solref of what must not give way: the fingers' limits, and that both move mimic
ARM_JOINTS = tuple(f"panda_joint{number}" for number in range(1, 8))
FINGER_JOINTS = ("panda_finger_joint1", "panda_finger_joint2")
CAMERA, ROBOT, MODEL = "shoulder", "robot/", "model/object/"  # names: of the camera, and what bodies' begin with
ROBOT_BIT, MODEL_BIT = 1, 2  # of contact: each touches the other alone, as links of one body have limits instead


def robot_spec() -> Any:
    """The robot with position drives; its base is the frame of the world."""
    spec = mujoco.MjSpec.from_string(_with_options(low_poly_urdf()))
    for body in spec.bodies:
        body.gravcomp = 1.0
    for geom in spec.geoms:
        geom.contype, geom.conaffinity = ROBOT_BIT, MODEL_BIT
        if "finger" in geom.parent.name:
            geom.friction = [1.0, 0.005, 0.0001]  # the tips are of rubber
            geom.condim = 4
    drives = [*zip(ARM_JOINTS, ARM_GAINS, ARM_FORCE, strict=True)]
    drives += [(name, FINGER_GAIN, FINGER_FORCE) for name in FINGER_JOINTS]
    for name, gain, force in drives:
        joint = spec.joint(name)
        joint.damping, joint.armature = np.zeros(3), ARMATURE  # the drives have their damping
        drive = spec.add_actuator(name=name, target=name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
        drive.set_to_position(kp=gain, kv=SETTLING * gain)
        drive.forcelimited, drive.forcerange = True, [-force, force]
    for name in FINGER_JOINTS:
        spec.joint(name).solref_limit = STIFF
    for mimic in spec.equalities:  # the URDF's `mimic`
        mimic.solref = STIFF
    spec.body(TCP).add_site(name=TCP)
    return spec


def _with_options(urdf: Path) -> str:
    """A URDF as MuJoCo is to read it: every link stays a body, and what collides is what is seen."""
    root = ET.parse(urdf).getroot()
    options = {"strippath": "false", "fusestatic": "false", "discardvisual": "true", "balanceinertia": "true"}
    ET.SubElement(ET.SubElement(root, "mujoco"), "compiler", options)
    return ET.tostring(root, encoding="unicode")


class ModelFiles:
    """The MJCF of asset folders, each written once. To be closed."""

    def __init__(self) -> None:
        self._folder = tempfile.TemporaryDirectory(prefix="acdc-mjcf-")
        self._written: dict[Path, Path] = {}

    def of(self, folder: Path) -> Path:
        """The model file of an asset folder."""
        if folder not in self._written:
            out = Path(self._folder.name) / str(len(self._written))
            write_model(read_model(folder), "object", out)
            self._written[folder] = out / "scene.xml"
        return self._written[folder]

    def close(self) -> None:
        """Delete them."""
        self._folder.cleanup()


def build(file: Path, base: Array, root: Array, camera: Array, field_of_view: float, size: int) -> Any:
    """A compiled `mujoco.MjModel`.

    Args:
        file: of the model, see `ModelFiles`.
        base, root, camera: (4, 4) of robot, model and depth camera in the world; the camera's x right, y up, z back.
        field_of_view: of the camera, radians. size: width and height of its picture.
    """
    world = mujoco.MjSpec()
    world.option.timestep = TIMESTEP
    world.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    world.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    world.option.impratio = 10.0  # as MuJoCo's documentation recommends for grasping
    world.visual.global_.offwidth = world.visual.global_.offheight = size
    world.visual.map.znear, world.visual.map.zfar = 0.01, 10.0
    world.stat.extent = 1.0  # metres, in which the two before are counted
    model = mujoco.MjSpec.from_file(str(file))
    for geom in model.geoms:
        if geom.contype:
            geom.contype, geom.conaffinity = MODEL_BIT, ROBOT_BIT
    for spec, prefix, pose in ((robot_spec(), ROBOT, base), (model, "model/", root)):
        frame = world.worldbody.add_frame(pos=pose[:3, 3], quat=quaternion_from_matrix(pose[:3, :3]))
        world.attach(spec, prefix=prefix, frame=frame)
    turn = quaternion_from_matrix(camera[:3, :3])
    world.worldbody.add_camera(name=CAMERA, pos=camera[:3, 3], quat=turn, fovy=np.rad2deg(field_of_view))
    return world.compile()


class DepthCamera:
    """A square camera of a compiled model, rendered through EGL. To be closed.

    Raises:
        InputError: there is no EGL, or no device that it can render on.
    """

    def __init__(self, model: Any, name: str, size: int) -> None:
        try:
            from mujoco.egl import GLContext  # not as MUJOCO_GL says, which is read when ManiSkill imports mujoco

            self._window = GLContext(size, size)
        except (ImportError, AttributeError, OSError, RuntimeError) as error:
            what, fix = f"cannot render: {error}.", "install EGL, on Debian: apt install libegl1 libgl1-mesa-dri"
            raise InputError("mujoco", what, fix, code="E-MUJOCO-EGL") from None
        self.model, self._rect = model, mujoco.MjrRect(0, 0, size, size)
        self._window.make_current()
        self._context = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_100.value)
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN.value, self._context)
        self._scene, self._options = mujoco.MjvScene(model, maxgeom=model.ngeom + 10), mujoco.MjvOption()
        self._view = mujoco.MjvCamera()
        self._view.type, self._view.fixedcamid = mujoco.mjtCamera.mjCAMERA_FIXED, model.camera(name).id
        for flag in (mujoco.mjtRndFlag.mjRND_SEGMENT, mujoco.mjtRndFlag.mjRND_IDCOLOR):
            self._scene.flags[flag] = True

    def take(self, data: Any) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
        """(H, W) depth along the optical axis in metres, and (H, W) id of the geom that is seen, -1 for none."""
        size = self._rect.width
        self._window.make_current()
        every = mujoco.mjtCatBit.mjCAT_ALL.value
        mujoco.mjv_updateScene(self.model, data, self._options, None, self._view, every, self._scene)
        mujoco.mjr_render(self._rect, self._scene, self._context)
        colors, raw = np.zeros((size, size, 3), np.uint8), np.zeros((size, size), np.float32)
        mujoco.mjr_readPixels(colors, raw, self._rect, self._context)
        near, far = (value * self.model.stat.extent for value in (self.model.vis.map.znear, self.model.vis.map.zfar))
        depth = near / (1 - raw.astype(float) * (1 - near / far))
        number = colors.astype(np.int64) @ [1, 256, 65536]  # of the scene's geoms, from 1
        shown = self._scene.geoms[: self._scene.ngeom]
        ids = np.full(self._scene.ngeom + 1, -1)
        for geom in shown:
            if geom.segid >= 0 and geom.objtype == mujoco.mjtObj.mjOBJ_GEOM:
                ids[geom.segid + 1] = geom.objid
        return depth[::-1], ids[number][::-1]

    def close(self) -> None:
        """Free what it draws with."""
        self._window.make_current()
        self._context.free()
        self._window.free()
