"""Config section `generation`: from cousins to a physically plausible scene (paper A.3, A.7)."""

from typing import ClassVar, Literal

from pydantic import Field

from roomkin.stages.contracts.section import Section
from roomkin.stages.geometry.robust import TRIM


class GenerationConfig(Section):
    """Placing the cousins. The z order, the support rule and the wall rules are the paper's (A.3)."""

    ranks: int = Field(4, ge=1, description="Scenes to make: scene r is built of the r-th cousin of every object.")

    # Orientation (A.3, A.7)
    wall_view: Literal["rear", "first"] = Field(
        "rear",
        description="View of what touches a wall. rear: the best of the matched views that turns its rear to the wall, "
        "as A.3 lays it; of other things the front, where it fits about as well as the rear. first: the best matched "
        "view, as in the paper.",
    )
    snap_articulated: float | None = Field(
        20.0,
        ge=0,
        le=45,
        description="Largest turn of an articulated asset to the axes of its cloud's minimum box (A.7), degrees. 0: "
        "none; null: no limit, as in the paper.",
    )
    snap_other: float | None = Field(
        15.0, ge=0, le=45, description="Largest such turn of any other asset, degrees; null: no limit, as in the paper."
    )
    rectangularity: float = Field(
        0.5,
        ge=0,
        le=1,
        description="Share of the cloud's outline, seen from above, that must run along the box for an asset to be "
        "turned to it: round things have no axes. Paper: 0.",
    )

    # Size
    trim: float = Field(
        TRIM, ge=0, lt=0.25, description="Share of the cloud left out at either end of a measured extent."
    )
    sizes: Literal["fitted", "measured"] = Field(
        "fitted",
        description="fitted: the model's box agrees best with the object's outline and points, with what hides or cuts "
        "it, the walls, the usual sizes of its category and its own proportions. measured: extents are quantiles of "
        "the cloud, as in the paper.",
    )
    max_stretch: float | None = Field(
        2.0,
        ge=1,
        description="Cousins whose size is farther from the library's than by this factor, or whose scales along the "
        "axes are farther apart, are passed over for others that the label means. null: none (paper).",
    )

    # Looks
    finish: Literal["library", "picture"] | None = Field(
        None,
        description="What cousins look like. library: as the library has them. picture: the main color of each is the "
        "one that the picture shows of its object; plants and models of yours keep theirs. null: picture for pictures "
        "of yours, library for rooms.",
    )

    # Support (A.3)
    # Overlap, as share of the smaller footprint, that makes one thing lie on another.
    support_overlap: ClassVar[float] = 0.7
    stack_tolerance: float | None = Field(
        0.15,
        ge=0,
        description="How far (metres) the upper bottom may lie below the lower top; a chair under a table is not on "
        "it. What stands over an edge is moved in; what is farther above all that is beneath it is held there (a shelf "
        "that nobody named). null: none of it, as in the paper.",
    )

    # Collisions (A.3)
    # Overlap of collision shapes that is not a collision, metres. Physics pushes apart what overlaps: 5 mm threw
    # light things over.
    touch: ClassVar[float] = 0.001
    # Longest single push, metres.
    push_limit: ClassVar[float] = 0.5
    # The same where no such push frees anything: what overlaps is thrown over by physics, farther than that; chosen.
    last_push_limit: ClassVar[float] = 1.0
    # Pushes after which collisions that are left are reported as they are.
    push_rounds: ClassVar[int] = 30

    # Physics check
    settle_seconds: float = Field(1.0, ge=0, le=60, description="Simulated time of the settling test; 0: no test.")
    # An object that moves farther in it has fallen, metres ...
    fallen_distance: ClassVar[float] = 0.05
    # ... and so has one that tilts more than so many degrees.
    fallen_tilt: ClassVar[float] = 10.0
