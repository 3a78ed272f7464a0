"""Config section `photo`: one RGB picture -> an input folder, by pretrained networks (paper 2.1, A.2, A.7)."""

from typing import Literal

from pydantic import Field

from stages.config.cameras import FIELD_OF_VIEW
from stages.config.matching import PretrainedConfig
from stages.config.vlm import VlmConfig
from stages.contracts.section import Section


class WeightsConfig(PretrainedConfig):
    """Weights of one network, and where `fetch` gets them."""

    source: str = Field("", description="Model id on the hub from which `fetch` fills the folder `path`.")


class FetchOptions(Section):
    """Which networks are used, and where their weights are."""

    depth: Literal["depth_anything", "depth_pro"] = Field(
        "depth_anything", description="Metric depth. depth_pro: slower, sharper, and it tells the field of view."
    )
    detector: WeightsConfig = Field(
        WeightsConfig(path="weights/grounding_dino", source="IDEA-Research/grounding-dino-base"),
        description="Grounding DINO: a box for every label.",
    )
    segmenter: WeightsConfig = Field(
        WeightsConfig(path="weights/sam2", source="facebook/sam2.1-hiera-large"),
        description="SAM 2: a mask for every box.",
    )
    depth_anything: WeightsConfig = Field(
        WeightsConfig(
            path="weights/depth_anything_v2", source="depth-anything/Depth-Anything-V2-Metric-Indoor-Large-hf"
        ),
        description="Depth-Anything V2, metric.",
    )
    depth_pro: WeightsConfig = Field(
        WeightsConfig(path="weights/depth_pro", source="apple/DepthPro-hf"), description="Depth Pro."
    )

    def unread(self) -> set[str]:
        """The depth network that is not used."""
        return {"depth_anything", "depth_pro"} - {self.depth}

    def networks(self) -> dict[str, WeightsConfig]:
        """The networks that are used, by their keys, in the order of their use."""
        return {name: getattr(self, name) for name in ("detector", "segmenter", self.depth)}


class PhotoConfig(FetchOptions):
    """From a picture to boxes, masks and depth."""

    captions: Literal["labels", "vlm"] = Field(
        "labels",
        description="What is looked for. labels: `labels`, all of them. vlm: what a language model that sees lists, "
        "which then names every object again and counts its doors and drawers.",
    )
    labels: list[str] = Field([], description="What is looked for without a language model; []: our categories.")
    mounting: Literal["geometry", "vlm"] = Field(
        "vlm",
        description="Who says what hangs, what stands, and at which wall (A.2). vlm: the language model of `captions: "
        "vlm`, geometry where it has no usable answer.",
    )
    box_threshold: float = Field(0.3, gt=0, lt=1, description="Least score of a box (official code: 0.3).")
    overlap: float = Field(
        0.7, gt=0, le=1, description="Of two masks that overlap by more (over their union), the better box's is kept."
    )
    min_share: float = Field(0.0005, ge=0, lt=1, description="Least share of the picture that an object covers.")
    field_of_view: float | None = Field(
        None,
        ge=FIELD_OF_VIEW[0],
        le=FIELD_OF_VIEW[1],
        description="Degrees over the picture's width. null: Depth Pro's if it is used, else by EXIF, by lines in the "
        "picture, or that of a usual camera; which is said.",
    )
    lens: str | None = Field(
        None,
        description="Calibration of the camera (JSON, YAML as OpenCV, ROS, Kalibr write them): the picture is made "
        "straight first, and its focal length is known.",
    )
    vlm: VlmConfig = Field(VlmConfig(), description="The language model of `captions: vlm`.")

    def unread(self) -> set[str]:
        """The same, and what the way to captions does not need."""
        return super().unread() | ({"labels"} if self.captions == "vlm" else {"vlm", "mounting"})
