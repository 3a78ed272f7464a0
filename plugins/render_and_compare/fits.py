"""Candidates fitted to one object: every way that one may stand, rendered in place and compared."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from roomkin.plugins.render_and_compare.config import GeometryConfig
from roomkin.plugins.render_and_compare.fitting import Measured, lay_over, measure
from roomkin.plugins.render_and_compare.noisy_cloud import NoisyCloud
from roomkin.plugins.render_and_compare.observation import observe
from roomkin.plugins.render_and_compare.rendering import Rendering, render
from roomkin.plugins.render_and_compare.solid import ColoredSolid
from roomkin.plugins.render_and_compare.terms import Terms, compare, line_field
from roomkin.plugins.render_and_compare.yaws import aligned_yaws, is_front_known, touched_walls
from roomkin.stages.contracts import Objects
from roomkin.stages.contracts.objects import SceneObject
from roomkin.stages.geometry.boxes import UprightBox
from roomkin.stages.geometry.crop import View
from roomkin.stages.geometry.frames import SYMMETRY_PERIOD, wrap_angle
from roomkin.stages.geometry.viewing import view_angle, view_yaw

SAME_YAW = np.deg2rad(2)  # ways to stand that differ by less are one; chosen


class Fit(NamedTuple):
    """A candidate in the object's place. yaw: of the view, as in cousins.json; box: floor frame."""

    asset: str
    yaw: float
    box: UprightBox
    picture: Rendering
    terms: Terms

    def score(self, weights: GeometryConfig) -> float:
        """Weighted sum of the terms: more is better."""
        terms = self.terms
        return (
            weights.outline * terms.outline
            + weights.depth * terms.depth
            + weights.lines * terms.lines
            + weights.colour * terms.colour
            - weights.proportions * terms.proportions
        )


class Fitter:
    """Fits models of a library to one object that has depth, intrinsics and a box."""

    def __init__(self, view: View, item: SceneObject, scene: Objects, resolution: int) -> None:
        assert item.box is not None
        self.box = UprightBox(item.box.center, item.box.size, item.box.yaw)
        self.seen = observe(view, np.array(scene.floor_from_camera, dtype=float), scene.depth_error, resolution)
        self.lines = line_field(self.seen.rgb)
        self.sight = NoisyCloud(self.seen.cloud, self.seen.eye, scene.depth_error.predict)
        self.wall = next(((np.array(wall.normal), wall.offset) for wall in touched_walls(item, scene)), None)
        self._measured: dict[float, Measured] = {}
        self._fits: dict[tuple[str, float], Fit] = {}
        self.front_known = is_front_known(item, scene)
        self.aligned = aligned_yaws(item, scene)

    def fit(self, solid: ColoredSolid, yaws: Sequence[float]) -> list[Fit]:
        """The model at several yaws of the floor frame, those left out that its symmetry makes equal."""
        return [self._fit(solid, yaw) for yaw in leave_out_equal(yaws, SYMMETRY_PERIOD[solid.asset.symmetry])]

    def _fit(self, solid: ColoredSolid, yaw: float) -> Fit:
        known = self._fits.get((solid.asset.id, yaw))
        if known is not None:
            return known
        box = self.box_of(solid, yaw)
        picture = render(solid, box, self.seen)
        terms = compare(self.seen, picture, box.size, solid.asset.size, self.lines)
        fit = Fit(solid.asset.id, view_angle(self.seen.eye, self.box.center, yaw), box, picture, terms)
        self._fits[solid.asset.id, yaw] = fit
        return fit

    def box_of(self, solid: ColoredSolid, yaw: float) -> UprightBox:
        """The box of a model that stands at a yaw of the floor frame in the object's place."""
        if yaw not in self._measured:
            self._measured[yaw] = measure(self.sight, self.box, yaw, self.wall)
        return lay_over(solid, self._measured[yaw], self.seen)

    def floor_yaw(self, view: float) -> float:
        """Yaw in the floor frame of a model that is seen at the yaw of a view."""
        return view_yaw(self.seen.eye, self.box.center, view)


def leave_out_equal(yaws: Sequence[float], period: float) -> list[float]:
    """The yaws, but those that equal an earlier one modulo the period (0: all are equal)."""
    kept: list[float] = []
    for yaw in yaws:
        if not kept or (period and all(abs(wrap_angle(yaw - other, period)) > SAME_YAW for other in kept)):
            kept.append(yaw)
    return kept
