"""Contracts of the `assets` stage: one `asset.json` per asset folder, one `library.json` per library."""

from typing import Literal

from pydantic import Field

from stages.contracts.files import Contract

Vector = tuple[float, float, float]
Symmetry = Literal["none", "half_turn", "quarter_turn", "full"]
Placement = Literal["floor", "object", "wall"]


class Joint(Contract):
    """One joint of an articulated asset. Angles in radians, lengths in metres."""

    name: str
    type: Literal["revolute", "prismatic"]
    role: Literal["door", "drawer"]
    parent: str
    link: str = Field(description="child link that the joint moves")
    axis: Vector = Field(description="unit axis in the joint frame, as in the URDF")
    lower: float
    upper: float
    handle_link: str | None = Field(None, description="link that carries the handle; null: no protruding handle")
    handle: str | None = Field(None, description="handle style: bar, knob, recessed, ...")


class Recipe(Contract):
    """How a procedural asset was made, so that it can be made again at another size."""

    generator: str
    parameters: dict[str, float | int | str | bool | list[float] | list[int] | list[str] | list[list[str]]]


class Asset(Contract):
    """`asset.json`: one model a_i = (category t_i, geometry) of the library (paper A.1).

    The asset frame is the URDF root frame: z up, front towards +x. `box_min` and `box_max` bound
    the visual geometry in that frame with every joint at its lower limit (closed), in metres.
    """

    version: Literal[1] = 1
    id: str
    category: str = Field(description="lower-case words joined by underscores, e.g. bottom_cabinet")
    urdf: str = Field("model.urdf", description="path of the URDF relative to this file")
    box_min: Vector
    box_max: Vector
    mass: float
    joints: list[Joint] = []
    doors: int = 0
    drawers: int = 0
    symmetry: Symmetry = Field(
        "none", description="rotational symmetry about z; all but none are left out of orientation scores"
    )
    placement: Placement = "floor"
    recipe: Recipe | None = None
    licence: str
    provenance: str
    checksum: str = Field(description="sha256 over the names and bytes of all other files of the folder")

    @property
    def size(self) -> Vector:
        """Extents (x, y, z) of the closed box in metres."""
        return tuple(high - low for low, high in zip(self.box_min, self.box_max, strict=True))  # type: ignore[return-value]

    @property
    def articulated(self) -> bool:
        """Whether it has doors or drawers (paper A.7)."""
        return self.doors + self.drawers > 0


class LibraryEntry(Contract):
    """One line of the library's index: what matching needs without opening the asset."""

    id: str
    category: str
    folder: str = Field(description="asset folder relative to library.json")
    doors: int
    drawers: int
    checksum: str


class Library(Contract):
    """`library.json`: the index of a library, sorted by id."""

    version: Literal[1] = 1
    assets: list[LibraryEntry]


class SnapshotShard(Contract):
    """Sidecar of a snapshot shard: N_snap yaw views and one representative per asset (paper A.1).

    The HDF5 file beside it holds `rgb` (A, V, H, W, 3) uint8 and `depth` (A, V, H, W) uint16 in thousandths
    of the asset's largest extent (0: background), V = len(yaws) + 1; view v < len(yaws) shows the asset turned
    by `yaws[v]` about z, and the last view is the representative. At yaw 0 the front faces the camera.
    """

    version: Literal[1] = 1
    assets: list[str]
    yaws: list[float]
    representative_yaw: float
    image_size: int
    intrinsics: list[list[float]] = Field(description="3x3 camera matrix in pixels")
    elevation: float | None = Field(
        None, description="angle of the camera above the horizontal, radians; lets matching compare normals upright"
    )
