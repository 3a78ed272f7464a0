"""What a result says of itself: where it comes from (digests), and the doubts that a person can mend."""

import re
from enum import Enum, unique
from string import Formatter
from typing import Any, Literal

from pydantic import ConfigDict, Field

from roomkin.stages.contracts.files import Contract
from roomkin.stages.contracts.types import Fraction, Seed, Text


class Provenance(Contract):
    """The same of all four give the same bytes. Digests are the first 12 hex digits of SHA-256.

    Files that were made together with an input go by it: masks beside objects.json, features of patches beside those
    of whole views.
    """

    seed: Seed | None = Field(None, description="of the random numbers behind it, its own or its inputs'; null: none")
    options: Text = Field(description="digest of the command's options")
    inputs: Text = Field(description="digest of the files that the command was given")
    code: Text = Field(description="digest of the command's code and of all that it imports")


Cause = Literal["affordance", "camera", "place", "size", "name", "mounting"]
BRING = "choose another model on the correction page, or bring one (docs/your-models.md)"
# What a person can do about each.
MEND: dict[Cause, str] = {
    "camera": "check the unit of depth and the intrinsics, or give one known length",
    "affordance": BRING,
    "place": "move it on the correction page, or name and say what carries it",
    "size": "type a length that you know: its own on the correction page, or one of the picture if all are off",
    "name": f"call it otherwise; or {BRING}",
    "mounting": "say on the correction page how it is held",
}


class Doubt(Contract):
    """The causes of doubts, in words; `MEND` has what helps against each cause."""

    model_config = ConfigDict(frozen=True)

    cause: Cause
    what: Text
    chance: Fraction = Field(0.5, description="that it is right: that the thing is wrong; 0.5: nobody knows")

    def __str__(self) -> str:
        return f"{self.what}: {MEND[self.cause]}"


@unique
class DoubtKind(Enum):
    """All that may be doubted.

    Attributes:
        cause: what may be wrong.
        text: of the doubt, a format.
        wrong: the chance that the thing is wrong; chosen, where no figure of docs/results is named; None: all but the
            share in its text.
        limit: beyond which, or out of which, it is doubted, where that is no key of the config.
    """

    CAMERA_HEIGHT = ("camera", "{what}", 0.9, (0.3, 3.0))  # m above floor or table: as people hold one
    # Degrees between image-up and what the floor faces; with more, a wall was mostly taken for the floor.
    CAMERA_TILT = ("camera", "the camera is tilted by {tilt:.0f} degrees: is that so, or is depth wrong?", 0.9, 75.0)
    UNIT = ("camera", "{what}", 0.9)  # of depth
    DEPTH = ("camera", "depth in doubt: {what}", 0.9)  # as reading it told
    # Doors and drawers of the model are not those that were stated (A.7): it is wrong, if these are right.
    OPENINGS = ("affordance", "{what}", 0.9)
    # Of 15 such things 15 had the wrong carrier (open.csv.xz).
    UNNAMED = ("place", "nothing that was named carries it: held in the air where it was seen", 1.0)
    BEYOND_WALL = ("place", "is seen beyond {wall}: past its end or through an opening, else in a mirror", 0.7)
    # m: a place is right to 5 cm (open.md). Of 9 such things no place was right (open.csv.xz).
    BEHIND_WALL = ("place", "reaches {depth:.0f} cm behind {wall}", 1.0, 0.05)
    # A share of its pixels, chosen: with less, what is known may be of something else.
    DEPTH_UNKNOWN = ("place", "depth is known on {share:.0f} % of its pixels: its place is not certain", 0.6, 0.5)
    # m: a place is right to 5 cm (open.md).
    PUSHED = ("place", "pushed {distance:.0f} cm out of a collision", 0.6, 0.05)
    # m: the 68 things of the default run's stable scenes move 0.04 mm at most.
    SHIFTED = ("place", "moved {distance:.1f} cm when physics ran", 0.6, 0.01)
    UNSTABLE = ("place", "{what}", 1.0)  # as physics shows
    # Calibrated (open.md).
    PLACE_UNSURE = ("place", "its place is right to 5 cm with a chance of {share:.0f} %", None, 0.5)
    # Times the usual extents of its category: finds a picture whose scale is wrong; of things in pictures of right
    # scale these are wrong as often as others: of 843 the size of 531 is (open.csv.xz).
    UNUSUAL_SIZE = ("size", "{what}", 0.6, 1.25)
    # The chance that every extent is within 10 % or 3 cm: of 86 surer ones 52 were right, of 100 others 23 (open.md).
    SIZE_UNSURE = (
        "size", "its size is right within 10 % or 3 cm with a chance of {share:.0f} % (width ±{width:.0f} %, "
        "depth ±{depth:.0f} %, height ±{height:.0f} %)", None, 0.5,
    )  # fmt: skip
    # m by which the model is deeper than its box, chosen: more than boxes of clouds are off.
    JUTS = ("size", "reaches {distance:.0f} cm before the front that the picture shows", 0.8, 0.15)
    STRETCHED = ("size", "no cousin has its size: this one is stretched {times:.1f} times", 0.7)
    # Points, where nothing was fitted: `generation.trim` leaves out 1.5 of so many at either end.
    FEW_POINTS = ("size", "only {points} points in its cloud", 0.7, 300)
    APART = ("size", "its mask lies in two places {distance:.0f} cm apart: one thing or two?", 0.7)
    # Of 267 such things the size of 192 is wrong (open.csv.xz).
    CUT_OFF = ("size", "cut off by the picture's border", 0.7)
    LABEL = ("name", "{what}", 0.7)
    # The first name's probability: of 59 things that were surer 54 were right, of 395 others 161 (masks.md).
    NAME = ("name", "called {name} by looks, size and place, {share:.0f} % sure; else {others}", None, 0.9)
    SURFACE = ("name", "is flat, and nothing lies behind it: the floor or a wall?", 0.7)
    NO_FIT = ("name", "no model fits what is seen of it: ordered by name, doors and drawers, size and place alone", 0.7)
    MOUNTING_UNCLEAR = ("mounting", "{note}: mounting by geometry", 0.5)
    MOUNTING_DIFFERS = ("mounting", "geometry finds another mounting: {found}", 0.5)

    def __init__(
        self, cause: Cause, text: str, wrong: float | None, limit: float | tuple[float, float] | None = None
    ) -> None:
        self.cause, self.text, self.wrong, self.limit = cause, text, wrong, limit

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
        chance = round(1 - values["share"] / 100, 4) if self.wrong is None else self.wrong
        return Doubt(cause=self.cause, what=self.text.format(**values), chance=chance)

    def read(self, doubt: Doubt) -> dict[str, str] | None:
        """The values of a doubt's text, in words; None: it is of another kind."""
        parts = Formatter().parse(self.text)
        pattern = "".join(re.escape(words) + (f"(?P<{name}>.+)" if name else "") for words, name, *_ in parts)
        found = re.fullmatch(pattern, doubt.what) if doubt.cause == self.cause else None
        return found and found.groupdict()


def sort_by_chance(doubts: list[Doubt]) -> list[Doubt]:
    """What is likeliest first, each once."""
    return sorted(dict.fromkeys(doubts), key=lambda one: -one.chance)
