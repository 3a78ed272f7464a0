"""One picture of an imported model: everything open, its front marked by an arrow on the ground before it."""

from pathlib import Path

import numpy as np
import trimesh
from numpy.typing import NDArray
from PIL import Image, ImageDraw
from sapien.physx import PhysxArticulation

from roomkin.plugins.importing.hinges import seen_points
from roomkin.stages.articulated.asset_folder import read_asset, read_model
from roomkin.stages.articulated.forward_kinematics import link_frames
from roomkin.stages.simulation.framing import frame_all, intrinsics_of
from roomkin.stages.simulation.loading import load_visual, remove
from roomkin.stages.simulation.rendering import RenderCamera, make_scene

WIDTH, HEIGHT = 360, 288
OPEN = 0.6  # of its range
FROM = np.array([0.8, 0.5, 0.45])  # before it, from its left
ARROW = (200, 40, 30)


class Portraits:
    """The camera; made once, as the first picture of a scene takes seconds."""

    def __init__(self) -> None:
        self.scene = make_scene(light=(-0.65, -0.35, -1.0))
        self.intrinsics = intrinsics_of(WIDTH, HEIGHT)
        self.camera = RenderCamera(self.scene, self.intrinsics, WIDTH, HEIGHT)

    def take(self, folder: Path) -> Image.Image:
        """The picture of an asset folder."""
        asset = read_asset(folder)
        body = load_visual(self.scene, folder, 1.0)
        if isinstance(body, PhysxArticulation):
            limits = body.get_qlimits()
            body.set_qpos((limits[:, 0] + OPEN * (limits[:, 1] - limits[:, 0])).astype(np.float32))
        low, high = np.array(asset.box_min), np.array(asset.box_max)
        reach = 0.35 * float((high - low).max())
        foot = np.array([high[0] + 0.3 * reach, (low[1] + high[1]) / 2, low[2]])
        robot = read_model(folder)
        seen = seen_points(robot, robot.links, link_frames(robot, OPEN))
        opened = np.array([seen.min(axis=0), seen.max(axis=0)])
        foot[0] = max(foot[0], opened[1, 0] + 0.1 * reach)
        tip = foot + np.array([[reach, -0.3 * reach, 0], [reach, 0.3 * reach, 0]])
        shown = np.concatenate([trimesh.bounds.corners(opened), tip])
        view = frame_all(shown, FROM, HEIGHT / WIDTH)
        picture = Image.fromarray(self.camera.render(view).rgb)
        remove(self.scene, body)
        self._arrow(picture, view, foot, reach)
        return picture

    def _arrow(self, picture: Image.Image, view: NDArray[np.float64], foot: NDArray[np.float64], reach: float) -> None:
        """Draw an arrow on the ground, towards the front."""
        outline = [(0, 0.08), (0.6, 0.08), (0.6, 0.24), (1, 0), (0.6, -0.24), (0.6, -0.08), (0, -0.08)]
        points = np.array([foot + reach * np.array([x, y, 0]) for x, y in outline])
        seen = (points - view[:3, 3]) @ view[:3, :3] @ self.intrinsics.T
        ImageDraw.Draw(picture).polygon([tuple(point) for point in (seen[:, :2] / seen[:, 2:]).tolist()], fill=ARROW)
