"""What may be wrong with an object of a scene and a person can mend. All else that is odd is a note."""

from enum import Enum
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, ConfigDict

from stages.contracts.files import Contract
from stages.contracts.types import Text

Cause = Literal["affordance", "camera", "place", "size", "name", "mounting"]
BRING = "choose another model on the correction page, or bring one (docs/your-models.md)"
# The most important first, and what a person can do about each.
MEND: dict[Cause, str] = {
    "camera": "check the unit of depth and the intrinsics, or give one known length",
    "affordance": BRING,
    "place": "move it on the correction page, or name and say what carries it",
    "size": "type a length that you know: its own on the correction page, or one of the picture if all are off",
    "name": f"call it otherwise; or {BRING}",
    "mounting": "say on the correction page how it is held",
}


class Doubt(Contract):
    """What may be wrong, in words; `MEND` has what helps against each cause."""

    model_config = ConfigDict(frozen=True)

    cause: Cause
    what: Text

    def __str__(self) -> str:
        return f"{self.what}: {MEND[self.cause]}"


class DoubtKind(Enum):
    """All that may be doubted: docs/errors.md has them.

    Attributes:
        code: stays when the words change.
        text: of the doubt, a format.
        compared: what with what.
        limit: beyond which, or out of which, it is doubted, in `unit`; a text: a key of the config.
        source: why there.
    """

    OPENINGS = (
        "D-OPENINGS",
        "affordance",
        "{what}",
        "doors and drawers of the model with those that were stated",
        0,
        "",
        "A.7",
    )
    CAMERA_HEIGHT = (
        "D-CAMERA-HEIGHT", "camera", "{what}", "height of the camera above floor or table with how people hold one",
        (0.3, 3.0), "m", "chosen",
    )  # fmt: skip
    UNNAMED = (
        "D-UNNAMED", "place", "stands on something that was not named, and is held there",
        "its underside with the surfaces beneath it", "generation.stack_tolerance", "m",
    )  # fmt: skip
    BEYOND_WALL = (
        "D-BEYOND-WALL", "place", "is seen beyond {wall}: past its end or through an opening, else in a mirror",
        "its whole box with the plane of a wall", 0, "m",
    )  # fmt: skip
    BEHIND_WALL = (
        "D-BEHIND-WALL", "place", "reaches {depth:.0f} cm behind {wall}",
        "the rear of its box with the plane of a wall",
        0.05, "m", "a place is right to 5 cm: results/open.md",
    )  # fmt: skip
    DEPTH_UNKNOWN = (
        "D-DEPTH-UNKNOWN", "place", "depth is known on {share:.0f} % of its pixels: its place is not certain",
        "its pixels that have depth with all of them", 0.5, "share",
        "chosen: with less, what is known may be of something else",
    )  # fmt: skip
    PUSHED = (
        "D-PUSHED", "place", "pushed {distance:.0f} cm out of a collision",
        "its place before and after the pushes (A.3)",
        0.05, "m", "a place is right to 5 cm: results/open.md",
    )  # fmt: skip
    SHIFTED = (
        "D-SHIFTED", "place", "moved {distance:.1f} cm when physics ran",
        "its place before and after the physics check",
        0.01, "m", "the 68 things of the default run's stable scenes move 0.04 mm at most",
    )  # fmt: skip
    UNSTABLE = ("D-UNSTABLE", "place", "{what}", "the scene before and after the physics check")
    UNUSUAL_SIZE = (
        "D-UNUSUAL-SIZE", "size", "{what}", "its extents with those that library.json has of its category",
        1.25, "times",
        "finds a picture whose scale is wrong; of things in pictures of right scale these are wrong as often as others",
    )  # fmt: skip
    SIZE_UNSURE = (
        "D-SIZE-UNSURE", "size",
        "size is {share:.0f} % sure: depth ±{depth:.0f} %, width ±{width:.0f} %, height ±{height:.0f} %",
        "the chance that every extent is within 10 % or 3 cm, by the spread of the fit", 0.5, "share",
        "of 86 surer ones 52 were right, of 100 others 23: results/open.md",
    )  # fmt: skip
    JUTS = (
        "D-JUTS", "size", "reaches {distance:.0f} cm before the front that the picture shows",
        "the front of the placed model with that of its box, as far as the model is deeper",
        0.15, "m", "chosen: more than boxes of clouds are off",
    )  # fmt: skip
    STRETCHED = (
        "D-STRETCHED", "size", "no cousin has its size: this one is stretched {times:.1f} times",
        "its box with the library's model", "generation.max_stretch", "times",
    )  # fmt: skip
    FEW_POINTS = (
        "D-FEW-POINTS", "size", "only {points} points in its cloud", "points of its cloud, where nothing was fitted",
        300, "points",
        "`generation.trim` leaves out 1.5 points of so many at either end",
    )  # fmt: skip
    CUT_OFF = (
        "D-CUT-OFF",
        "size",
        "cut off by the picture's border",
        "its mask with the border, where nothing was fitted",
        0,
        "pixels",
    )
    LABEL = ("D-LABEL", "name", "{what}", "the words of its label with those that are known")
    NAME = (
        "D-NAME", "name", "called {name} by looks, size and place, {share:.0f} % sure; else {others}",
        "how sure the first of the names is that are proposed", 0.9, "share",
        "of 59 things that were surer 54 were right, of 395 others 161: docs/results/masks.md",
    )  # fmt: skip
    NO_FIT = (
        "D-NO-FIT", "name",
        "no model fits what is seen of it: ordered by name, doors and drawers, size and place alone",
        "its depth and outline with those of every model in its place (the judge geometry)",
    )  # fmt: skip
    MOUNTING_UNCLEAR = (
        "D-MOUNTING-UNCLEAR",
        "mounting",
        "{note}: mounting by geometry",
        "the mounting that was stated with the walls",
    )
    MOUNTING_DIFFERS = (
        "D-MOUNTING-DIFFERS", "mounting", "geometry finds another mounting: {found}",
        "the mounting that was stated with that of its box",
    )  # fmt: skip

    def __init__(
        self,
        code: str,
        cause: Cause,
        text: str,
        compared: str,
        limit: float | tuple[float, float] | str = "",
        unit: str = "",
        source: str = "",
    ) -> None:
        self.code, self.cause, self.text, self.compared = code, cause, text, compared
        self.limit, self.unit, self.source = limit, unit, source

    @property
    def threshold(self) -> float:
        """The limit, where it is one number."""
        assert isinstance(self.limit, float | int)
        return self.limit

    @property
    def bounds(self) -> tuple[float, float]:
        """The limits, where there are two."""
        assert isinstance(self.limit, tuple)
        return self.limit

    def of(self, **values: Any) -> Doubt:
        """A doubt of this kind; `values`: those of its text."""
        return Doubt(cause=self.cause, what=self.text.format(**values))


def _as_doubt(value: Any) -> Any:
    """Scenes of earlier versions have sentences without a cause, most of them of places."""
    return {"cause": "place", "what": value} if isinstance(value, str) else value


AnyDoubt = Annotated[Doubt, BeforeValidator(_as_doubt)]


def sort_by_gravity(doubts: list[Doubt]) -> list[Doubt]:
    """In the order of their causes, each once."""
    return sorted(dict.fromkeys(doubts), key=lambda one: list(MEND).index(one.cause))
