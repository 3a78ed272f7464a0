"""Pictures of a MuJoCo model without a window: depth, and what is seen at each pixel."""

from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from roomkin.stages.contracts.errors import InputError


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
