"""Config section `extraction`: from image to objects in space (paper 2.1, A.2, A.7)."""

from typing import Any, Literal

from pydantic import Field

from roomkin.stages.contracts.objects import USUAL_ERROR
from roomkin.stages.contracts.section import KWARGS, Section


class DepthNoiseConfig(Section):
    """Error that is added to perfect depth, so that it errs as estimated depth does."""

    range_constant: float = Field(USUAL_ERROR.a, ge=0, description="a of the range noise sigma(z) = a + b z^2, metres.")
    range_quadratic: float = Field(
        USUAL_ERROR.b, ge=0, description="b of the range noise, 1/metres: 1.7 cm in all at 3 m."
    )
    scale: float = Field(0.01, ge=0, description="Standard deviation of one factor on all depths of the picture.")


class ExtractionConfig(Section):
    """From pixels, depth and masks to objects in the floor frame."""

    source: str = Field(
        "folder",
        json_schema_extra={"kind": "sources"},
        description="Where depth, masks and captions come from. folder: from the files in the input folder.",
    )
    kwargs: dict[str, Any] = KWARGS
    depth_noise: Literal["model", "none"] = Field(
        "model",
        description="model: exact depth from the renderer is put through `noise` first. none: it is used as it is. "
        "Depth of your own pictures is never disturbed.",
    )
    noise: DepthNoiseConfig = Field(DepthNoiseConfig(), description="The noise model of `depth_noise: model`.")
    crop: float = Field(0.9, gt=0, le=1, description="Central part of the image that is used (paper: 0.9).")
    restore_border: bool = Field(
        True, description="Continue depth onto the border that was taken off, so that boxes keep their size."
    )
    max_tilt: float = Field(60.0, gt=0, lt=90, description="Largest angle between image-up and floor normal, degrees.")
    dbscan_eps: float = Field(0.04, gt=0, description="DBSCAN radius in metres (A.7); grows where points are sparse.")
    dbscan_min_points: int = Field(8, ge=1, description="DBSCAN core size (A.7).")
    trim: float = Field(
        0.01,
        ge=0,
        lt=0.25,
        description="Share of the points left out at either end of a box (0: raw extremes).",
    )

    def list_unread(self) -> set[str]:
        """The noise model, if there is no noise."""
        return {"noise"} if self.depth_noise == "none" else set()
