"""The pictures of `env.render()`: a renderer per environment, a shot per episode."""

from collections.abc import Iterable
from dataclasses import replace

from plugins.films.film_renderer import FilmRenderer, Image, Shot
from stages.tasks.filmed import FilmedEnv


class Renderer:
    """Renders the environments of a task."""

    def __init__(self, env: FilmedEnv) -> None:
        self.env = env
        self._renderers: dict[int, FilmRenderer] = {}  # by environment, once it is rendered
        self._shots: dict[int, Shot] = {}  # by environment, those of the present episodes

    def picture(self, index: int) -> Image:
        """(H, W, 3) uint8 of environment `index`, by a camera that sees hand and door or drawer, closed and open."""
        return self._shot(index).picture(self.env.moment(index))

    def cut(self, indices: Iterable[int]) -> None:
        """The next pictures of these environments are of another episode."""
        for index in indices:
            if shot := self._shots.pop(index, None):
                shot.close()

    def _shot(self, index: int) -> Shot:
        if index not in self._shots:
            env = self.env
            target, now = env.targets[index], env.moment(index)
            opened = target.lower + env.success_opening(index) * (target.upper - target.lower)
            then = replace(now, asset_joints={**now.asset_joints, env.joint_name: opened})
            if index not in self._renderers:
                asked = env._custom_human_render_camera_configs or {}
                self._renderers[index] = FilmRenderer(
                    **{side: asked[side] for side in ("width", "height") if side in asked}
                )
            self._shots[index] = Shot(self._renderers[index], env.recording([now, then], index), [now, then])
        return self._shots[index]
