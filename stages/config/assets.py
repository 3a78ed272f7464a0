"""Config section `assets`: the library and its snapshots (paper A.1)."""

from pydantic import Field

from stages.contracts.section import Count, Section

COUNTS = {
    "bottom_cabinet": 56,
    "wall_cabinet": 27,
    "sideboard": 28,
    "wardrobe": 26,
    "chest_of_drawers": 32,
    "fridge": 12,
    "microwave": 12,
    "oven": 12,
    "dishwasher": 10,
    "table": 10,
    "coffee_table": 10,
    "chair": 10,
    "stool": 10,
    "sofa": 10,
    "bed": 10,
    "bookshelf": 10,
    "floor_lamp": 10,
    "table_lamp": 10,
    "television": 10,
    "picture": 10,
    "bowl": 10,
    "mug": 10,
    "plate": 10,
    "cooking_pot": 10,
    "bottle": 10,
    "vase": 10,
    "plant_pot": 10,
    "box": 10,
    "book": 10,
    "armchair": 5,
    "basket": 5,
    "bench": 5,
    "candlestick": 5,
    "clock": 5,
    "desk": 5,
    "jar": 5,
    "kettle": 5,
    "laptop": 5,
    "mirror": 5,
    "nightstand": 5,
    "pan": 5,
    "toaster": 5,
    "trash_can": 5,
    "tv_stand": 5,
    "wall_shelf": 5,
}


class LibraryOptions(Section):
    """The procedural models of the library."""

    counts: dict[str, Count] = Field(
        COUNTS,
        description="Procedural models per category; 0 leaves one out. The paper's BEHAVIOR-1K has over 10,000 assets.",
    )


class OwnOptions(Section):
    """How the user's own models are read."""

    importers: list[str] = Field(
        ["urdf", "mjcf", "glb", "gltf", "obj", "dae", "ply", "stl"],
        json_schema_extra={"kind": "importers"},
        description="Kinds of files that are imported, by suffix (mjcf: .xml); of several in one folder the first.",
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


class AssetsConfig(SnapshotOptions, OwnOptions, LibraryOptions):
    """The asset library: procedural models, the user's own, and their pictures."""

    folders: list[str] = Field(
        [],
        description="Folders with your own models, <folder>/<category>/<model>, each a URDF, GLB or OBJ file or a "
        "folder that holds one (docs/your-models.md).",
    )
    shards: int | None = Field(
        None,
        ge=1,
        description="Jobs that the procedural models are made, photographed and encoded in, and archives that hold "
        "them. null: two, and one more per 300 models beyond 600.",
    )
