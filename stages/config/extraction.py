"""Config section `extraction`: from image to objects in space (paper 2.1, A.2, A.7)."""

from typing import Any, ClassVar, Literal

from pydantic import Field

from stages.contracts.objects import USUAL_ERROR
from stages.contracts.section import OWN, Section


class DepthNoiseConfig(Section):
    """Error that is added to perfect depth, so that it errs as estimated depth does."""

    range_constant: float = Field(USUAL_ERROR.a, ge=0, description="a of the range noise sigma(z) = a + b z^2, metres.")
    range_quadratic: float = Field(
        USUAL_ERROR.b, ge=0, description="b of the range noise, 1/metres: 1.7 cm in all at 3 m."
    )
    # Pixels over which the range noise varies: estimated depth errs in patches. 0: every pixel.
    correlation: ClassVar[float] = 6.0
    # Pixels over which near and far depth run into each other at an object's outline (A.7).
    bleeding: ClassVar[float] = 1.0
    # Relative error at the image border (A.7); none in the central 80 % of the picture.
    periphery: ClassVar[float] = 0.03
    scale: float = Field(0.01, ge=0, description="Standard deviation of one factor on all depths of the picture.")


class ExtractionConfig(Section):
    """From pixels, depth and masks to objects in the floor frame."""

    source: str = Field(
        "folder",
        json_schema_extra={"kind": "sources"},
        description="Where depth, masks and captions come from. folder: from the files in the input folder.",
    )
    depth_noise: Literal["model", "none"] = Field(
        "model",
        description="model: exact depth from the renderer is put through `noise` first. none: it is used as it is. "
        "Depth of your own pictures is never disturbed.",
    )
    noise: DepthNoiseConfig = Field(DepthNoiseConfig(), description="The noise model of `depth_noise: model`.")
    crop: float = Field(0.9, gt=0, le=1, description="Central part of the image that is used (paper: 0.9).")
    # An object with more of its pixels outside the crop than this fails.
    max_cut: ClassVar[float] = 0.4
    # An object with fewer pixels than this fails.
    min_pixels: ClassVar[int] = 60
    # Pixels taken off the border of masks before clouds are made (A.7 gives no number).
    erosion: ClassVar[int] = 2
    # Small or thin objects are eroded less, to keep this share of their pixels.
    erosion_keep: ClassVar[float] = 0.25
    restore_border: bool = Field(
        True, description="Continue depth onto the border that was taken off, so that boxes keep their size."
    )
    # Three-point hypotheses per plane.
    ransac_iterations: ClassVar[int] = 1000
    # Metres within which a point at 3 m belongs to a plane; grows with distance.
    plane_threshold: ClassVar[float] = 0.03
    max_tilt: float = Field(60.0, gt=0, lt=90, description="Largest angle between image-up and floor normal, degrees.")
    # Walls nearer in direction (degrees) ...
    wall_merge_angle: ClassVar[float] = 10.0
    # ... and in offset (metres) than this are one wall.
    wall_merge_distance: ClassVar[float] = 0.15
    # Points farther from their neighbours than so many standard deviations are dropped.
    outlier_deviations: ClassVar[float] = 3.0
    dbscan_eps: float = Field(0.04, gt=0, description="DBSCAN radius in metres (A.7); grows where points are sparse.")
    dbscan_min_points: int = Field(8, ge=1, description="DBSCAN core size (A.7).")
    # Clusters with a smaller share of the points are dropped.
    dbscan_keep: ClassVar[float] = 0.01
    trim: float = Field(
        0.01,
        ge=0,
        lt=0.25,
        description="Share of the points left out at either end of a box (0: raw extremes).",
    )
    # Gap (metres, beyond the error of depth) that still counts as touching.
    contact: ClassVar[float] = 0.045
    # A gap to a wall that is not seen counts as filled by the object up to so many metres.
    max_hidden_depth: ClassVar[float] = 0.8
    # A gap is real if at least this share of it is seen to be empty.
    free_space_share: ClassVar[float] = 0.35

    own: dict[str, dict[str, Any]] = OWN

    def unread(self) -> set[str]:
        """The noise model, if there is no noise."""
        return {"noise"} if self.depth_noise == "none" else set()

    def tolerance(self, noise: float) -> float:
        """Gap in metres that counts as touching where depth errs by so many metres."""
        return self.contact + noise
