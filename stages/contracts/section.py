"""Base of every config section."""

from typing import Annotated, Any, Self

from pydantic import AfterValidator, BaseModel, ConfigDict, Field
from pydantic_core import PydanticCustomError


class Section(BaseModel):
    """A section of config.yaml. Unknown keys, NaN and infinity are errors; values are frozen after validation."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    def list_unread(self) -> set[str]:
        """Keys that nothing reads as the others stand: a change of them runs nothing again."""
        return set()

    def list_judges(self) -> set[str]:
        """Judges that the judge with this section asks in turn."""
        return set()

    def keep_deciding(self) -> Self:
        """The keys that decide on results; where and how they are got is left at its default."""
        return self


KWARGS: Any = Field({}, description="Options of the implementation that is named above, by its class `Options`.")
KWARGS_BY_NAME: Any = Field({}, description="Options of implementations, by their names and their classes `Options`.")


UNFIT = "unfit"  # kind of error of a value that says itself how it is mended


def unfit(what: str, mend: str) -> PydanticCustomError:
    """The error of a value, for people: what is wrong with it, and how to mend it."""
    return PydanticCustomError(UNFIT, "{what}", {"what": what, "mend": mend})


def check_range(span: tuple[float, float]) -> tuple[float, float]:
    """Refuse a range whose upper bound comes first."""
    if span[0] > span[1]:
        raise ValueError(f"{span[0]:g} is above {span[1]:g}; write the lower one first")
    return span


Positive = Annotated[float, Field(gt=0)]
NotNegative = Annotated[float, Field(ge=0)]
Range = Annotated[tuple[Positive, Positive], AfterValidator(check_range)]  # the lower bound first
Count = Annotated[int, Field(ge=0)]
SEEDS = 2**53  # JSON and tables hold no larger ones exactly
Seed = Annotated[int, Field(ge=0, lt=SEEDS)]
Rank = Annotated[int, Field(ge=1)]
