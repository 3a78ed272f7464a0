"""Config section `eyes`: what finds and names the things of a picture with depth (paper A.2, first half)."""

from pydantic import Field

from stages.contracts.section import Section


class EyesSection(Section):
    """From a picture with depth to its things: outlines, and probabilities of names."""

    proposers: list[str] = Field(
        ["ssd", "mobile_sam"],
        min_length=1,
        json_schema_extra={"kind": "proposers"},
        description="What proposes outlines, of which one choice is made. ssd: COCO's things, mobile_sam: anything; "
        "both want weights (`make weights`). pieces: by depth alone, in their place where those lack. grounding: "
        "Grounding DINO and SAM 2, by section `photo`. Or yours.",
    )
    sure: float = Field(
        0.5,
        ge=0,
        le=1,
        description="Least probability of a thing's first name; else it is left out and offered on the page.",
    )
