"""Config section `assets`: the library and its snapshots (paper A.1)."""

from typing import Any, ClassVar

from pydantic import Field, model_validator

from roomkin.stages.config.categories import CATEGORIES
from roomkin.stages.contracts.section import Count, Section

COUNTS = {name: known.models for name, known in CATEGORIES.items() if known.models}


class LibraryOptions(Section):
    """The procedural models of the library."""

    counts: dict[str, Count] = Field(
        COUNTS,
        description="Procedural models per category; 0 leaves one out. The paper's BEHAVIOR-1K has over 10,000 assets.",
    )
    variations: bool = Field(
        True,
        description="false: no model is a variation of another, each is sampled freely and a family of its own "
        "(docs/assets.md)",
    )


class OwnOptions(Section):
    """How the user's own models are read."""

    importers: list[str] = Field(
        [],
        json_schema_extra={"kind": "importers"},
        description="Kinds of files that are imported, by suffix (mjcf: .xml); of several in one folder the first. "
        "[]: urdf, mjcf, glb, gltf, obj, dae, ply, stl.",
    )


class SnapshotOptions(Section):
    """The pictures of the models."""

    n_snap: int = Field(24, ge=1, le=360, description="Yaw views per asset, N_snap; the paper: 100.")
    image_size: int = Field(192, ge=32, le=2048, description="Side of a snapshot in pixels.")
    # Turn of the asset in its representative snapshot, radians: front and one side are seen.
    representative_yaw: ClassVar[float] = -0.5236
    # Horizontal distance of the snapshot camera, in units of the asset's largest extent.
    camera_distance: ClassVar[float] = 2.3
    # Height of the snapshot camera above the asset's center, in units of its largest extent.
    camera_height: ClassVar[float] = 0.65
    # Field of view of the snapshot camera, radians.
    field_of_view: ClassVar[float] = 0.68


class AssetsConfig(SnapshotOptions, OwnOptions, LibraryOptions):
    """The asset library: procedural models, the user's own, and their pictures."""

    folders: list[str] = Field(
        [],
        description="Folders with your own models, <folder>/<category>/<model>, each a URDF, GLB or OBJ file or a "
        "folder that holds one (docs/your-models.md).",
    )
    own_only: bool = Field(
        False, description="true: the models of `folders` alone, for pictures of yours; `counts` are none then."
    )
    only: bool = Field(
        False,
        description="true: the categories that `counts` names alone, so that none that comes later changes a study.",
    )
    shards: int | None = Field(
        None,
        ge=1,
        description="Jobs that the procedural models are made, photographed and encoded in, and archives that hold "
        "them. null: two, and one more per 300 models beyond 600.",
    )

    @model_validator(mode="before")
    @classmethod
    def _empty_counts(cls, given: Any) -> Any:
        return {**given, "counts": {}} if isinstance(given, dict) and given.get("own_only") is True else given
