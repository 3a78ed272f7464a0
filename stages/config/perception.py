"""Config section `perception`: from a picture to an input folder (paper 2.1, A.2 first half, A.7)."""

from pathlib import Path
from typing import Any, Literal

from pydantic import Field

from roomkin.stages.config.recordings import DegreesWide
from roomkin.stages.config.weights import NETWORKS
from roomkin.stages.contracts.section import KWARGS_BY_NAME, Section

GROUNDING = "grounding"  # the proposer whose weights are folders


class OutlineSection(Section):
    """What finds and names the things of a picture. Weights are folders with config.json and model.safetensors."""

    proposers: list[str] = Field(
        ["ssd", "mobile_sam"],
        min_length=1,
        json_schema_extra={"kind": "proposers"},
        description="What proposes outlines, of which one choice is made. ssd: COCO's things, mobile_sam: anything; "
        "both want weights (`make weights`). pieces: by depth alone, in their place where those lack. grounding: "
        "Grounding DINO and SAM 2 (`detector`, `segmenter`). Or yours.",
    )
    kwargs: dict[str, Any] = KWARGS_BY_NAME
    sure: float = Field(
        0.5,
        ge=0,
        le=1,
        description="Least probability of the kin of a thing's first name (a sofa of .3, an armchair of .3: a seat of "
        ".6); else it is left out, and told on the page.",
    )
    detector: str = Field("weights/grounding_dino", description="Weights of Grounding DINO: a box for every label.")
    segmenter: str = Field("weights/sam2", description="Weights of SAM 2: a mask for every box.")
    box_threshold: float = Field(
        0.3, gt=0, lt=1, description="Least score of a box of Grounding DINO (official code: 0.3)."
    )
    labels: list[str] = Field(
        [], description="Labels to detect if no language model is used; []: the categories of the library."
    )

    def list_unread(self) -> set[str]:
        """What the chosen proposers do not need."""
        return set() if GROUNDING in self.proposers else {"detector", "segmenter", "box_threshold", "labels"}


class SeeSection(OutlineSection):
    """The same of a picture whose depth is known, and who captions its things."""

    captions: Literal["labels", "vlm"] = Field(
        "labels",
        description="Source of the labels to detect in a picture whose depth is known or measured. labels: the key "
        "`labels`. vlm: a vision-language model lists them, names every found thing, counts its doors and drawers.",
    )
    mounting: Literal["geometry", "vlm"] = Field(
        "vlm",
        description="What decides which objects hang, stand, or touch which wall (A.2). vlm: the language model of "
        "`captions: vlm`, geometry where it has no usable answer.",
    )

    def list_unread(self) -> set[str]:
        """What the chosen proposers and the way to captions do not need."""
        return super().list_unread() | ({"labels"} if self.captions == "vlm" else {"vlm", "mounting"})


class CameraSection(Section):
    """What is told of the camera of a picture without depth."""

    field_of_view: DegreesWide | None = Field(
        None,
        description="Degrees over the width of a picture without depth. null: by EXIF, lines in the picture, or a "
        "usual camera, with a note in the log.",
    )
    lens: str | None = Field(
        None,
        description="Calibration of its camera (JSON, YAML as OpenCV, ROS, Kalibr write them): the picture is made "
        "straight first, and its focal length is known.",
    )


class DrawOptions(OutlineSection, CameraSection):
    """What `draw` reads."""

    heights: dict[str, float] = Field(
        {}, description="Heights that you know, metres: of the `camera`, of things by label: {fridge: 1.8}."
    )


class MeasureOptions(CameraSection):
    """What `measure` reads."""

    depth_anything: str = Field("weights/depth_anything_v2", description="Weights of Depth-Anything V2, metric.")


class PerceptionSection(SeeSection, DrawOptions, MeasureOptions):
    """From a picture to an input folder: camera, ground and walls, outlines, names, boxes."""

    by: Literal["auto", "networks", "lines"] = Field(
        "auto",
        description="What finds a picture without depth its places. networks: Grounding DINO, SAM 2, Depth Anything "
        "(A.2, A.7). lines: `proposers`, and places and sizes by the picture's lines, outlines and usual sizes. "
        "auto: networks where all their weights are, else lines.",
    )

    def networks(self) -> dict[str, str]:
        """Folders of the networks of `by: networks`, by their keys, in the order of their use."""
        return {name: getattr(self, name) for name in NETWORKS}

    def list_lacking(self) -> list[str]:
        """The keys of those of which there are no weights."""
        return [name for name, folder in self.networks().items() if not Path(folder, "model.safetensors").is_file()]

    def asks_networks(self) -> bool:
        """Whether the networks whose weights are folders look at pictures without depth."""
        return self.by == "networks" or (self.by == "auto" and not self.list_lacking())

    def for_measured(self) -> "PerceptionSection":
        """The section for pictures whose depth is a network's: Grounding DINO proposes."""
        return self.model_copy(update={"proposers": [GROUNDING]})


class SeeOptions(SeeSection):
    """What `see` reads: the section, and that of the language model of `captions: vlm`."""

    vlm: dict[str, Any] = {}
