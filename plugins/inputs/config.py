"""Config section `photo`: one RGB picture -> an input folder, by pretrained networks (paper 2.1, A.2, A.7)."""

from pathlib import Path
from typing import Any, ClassVar, Literal

from pydantic import Field

from plugins.inputs.known_cameras import FIELD_OF_VIEW
from stages.contracts.section import Section


class PhotoSection(Section):
    """From a picture to boxes, masks and depth. Weights are folders with config.json and model.safetensors."""

    by: Literal["auto", "networks", "lines"] = Field(
        "auto",
        description="What finds things and their places. networks: Grounding DINO, SAM 2, Depth Anything (A.2, A.7). "
        "lines: MobileSAM and COCO's network, and places and sizes by the picture's lines, outlines and usual sizes "
        "(package single_view). auto: networks where all their weights are, else lines.",
    )
    detector: str = Field("weights/grounding_dino", description="Weights of Grounding DINO: a box for every label.")
    segmenter: str = Field("weights/sam2", description="Weights of SAM 2: a mask for every box.")
    depth_anything: str = Field("weights/depth_anything_v2", description="Weights of Depth-Anything V2, metric.")
    captions: Literal["labels", "vlm"] = Field(
        "labels",
        description="Source of the labels to detect. labels: the key `labels`. vlm: a vision-language model lists "
        "them, then names every detected object and counts its doors and drawers.",
    )
    labels: list[str] = Field(
        [], description="Labels to detect if no language model is used; []: the categories of the library."
    )
    mounting: Literal["geometry", "vlm"] = Field(
        "vlm",
        description="What decides which objects hang, stand, or touch which wall (A.2). vlm: the language model of "
        "`captions: vlm`, geometry where it has no usable answer.",
    )
    box_threshold: float = Field(0.3, gt=0, lt=1, description="Least score of a box (official code: 0.3).")
    # Of two masks that overlap by more (over their union), the better box's is kept.
    overlap: ClassVar[float] = 0.7
    # Least share of the picture that an object covers.
    min_share: ClassVar[float] = 0.0005
    field_of_view: float | None = Field(
        None,
        ge=FIELD_OF_VIEW[0],
        le=FIELD_OF_VIEW[1],
        description="Degrees over the picture's width. null: by EXIF, lines in the picture, or a usual camera, "
        "with a note in the log.",
    )
    lens: str | None = Field(
        None,
        description="Calibration of the camera (JSON, YAML as OpenCV, ROS, Kalibr write them): the picture is made "
        "straight first, and its focal length is known.",
    )

    def networks(self) -> dict[str, str]:
        """Folders of the networks that are used, by their keys, in the order of their use."""
        return {name: getattr(self, name) for name in ("detector", "segmenter", "depth_anything")}

    def asks_networks(self) -> bool:
        """Whether the networks whose weights are folders find what a picture shows."""
        there = all(Path(folder, "model.safetensors").is_file() for folder in self.networks().values())
        return self.by == "networks" or (self.by == "auto" and there)

    def list_unread(self) -> set[str]:
        """What the way to captions does not need."""
        return {"labels"} if self.captions == "vlm" else {"vlm", "mounting"}


class PhotoConfig(PhotoSection):
    """The section, and that of the language model of `captions: vlm`: what `inputs estimate` reads."""

    vlm: dict[str, Any] = {}
