"""Config section `assets`: the library and its snapshots (paper A.1)."""

from pydantic import Field

from stages.config.base import Count, Section

COUNTS = {
    "bottom_cabinet": 36,
    "wall_cabinet": 27,
    "sideboard": 7,
    "wardrobe": 6,
    "chest_of_drawers": 22,
    "fridge": 4,
    "microwave": 4,
    "oven": 3,
    "dishwasher": 2,
    "table": 5,
    "coffee_table": 4,
    "chair": 6,
    "stool": 3,
    "sofa": 4,
    "bed": 3,
    "bookshelf": 5,
    "floor_lamp": 3,
    "table_lamp": 4,
    "television": 4,
    "picture": 4,
    "bowl": 5,
    "mug": 5,
    "plate": 3,
    "cooking_pot": 3,
    "bottle": 3,
    "vase": 4,
    "plant_pot": 4,
    "box": 4,
    "book": 3,
}


class LibraryOptions(Section):
    """The models of the library: procedural ones, and the user's own."""

    counts: dict[str, Count] = Field(
        COUNTS,
        description="Procedural models per category; 0 leaves one out. The paper's BEHAVIOR-1K has over 10,000 assets.",
    )
    folders: list[str] = Field(
        [],
        description="Folders with your own models, <folder>/<category>/<model>, each a URDF, GLB or OBJ file or a "
        "folder that holds one (docs/assets.md).",
    )
    importers: list[str] = Field(
        ["urdf", "glb", "obj"],
        json_schema_extra={"kind": "importers"},
        description="Kinds of files that are imported, by their suffix; of several in one folder the first.",
    )


class SnapshotOptions(Section):
    """The pictures of the models."""

    n_snap: int = Field(24, ge=1, le=360, description="Yaw views per asset, N_snap; the paper: 100.")
    image_size: int = Field(192, ge=32, le=2048, description="Side of a snapshot in pixels.")
    representative_yaw: float = Field(
        -0.5236, description="Turn of the asset in its representative snapshot, radians: front and one side are seen."
    )
    camera_distance: float = Field(
        2.3, gt=0.8, description="Horizontal distance of the snapshot camera, in units of the asset's largest extent."
    )
    camera_height: float = Field(
        0.65, description="Height of the snapshot camera above the asset's centre, in units of its largest extent."
    )
    field_of_view: float = Field(0.68, gt=0.05, lt=2.5, description="Field of view of the snapshot camera, radians.")


class AssetsConfig(SnapshotOptions, LibraryOptions):
    """The asset library: procedural models, the user's own, and their pictures."""

    shards: int = Field(
        2, ge=1, description="Jobs that the snapshots are cut into; as many as there are cores is best."
    )
