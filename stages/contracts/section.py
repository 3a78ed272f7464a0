"""Base of every config section."""

from collections.abc import Iterator
from typing import Annotated, Any, Self, get_args, get_origin

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, ValidationInfo, field_validator


class Section(BaseModel):
    """A section of config.yaml. Unknown keys, NaN and infinity are errors; values are frozen after validation."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    @field_validator("*", mode="before")
    @classmethod
    def _as_written(cls, value: Any, info: ValidationInfo) -> Any:
        """YAML's yes, no, on and off are no numbers; a null takes a free key out, which an overlay may ask for."""
        annotation = cls.model_fields[str(info.field_name)].annotation
        if isinstance(value, bool | list | dict):
            kinds = set(_list_kinds(annotation))
            truth = next((each for each in _list_leaves(value) if isinstance(each, bool)), None)
            if truth is not None and kinds & {int, float} and bool not in kinds:
                raise ValueError(f"is {truth} (YAML's yes and no, too), not a number")
        return _without_nulls(value, annotation)

    def list_unread(self) -> set[str]:
        """Keys that nothing reads as the others stand: a change of them runs nothing again."""
        return set()

    def keep_deciding(self) -> Self:
        """What decides on results; where and how they are got is left at its default."""
        return self


def _list_kinds(annotation: Any) -> Iterator[Any]:
    """All types inside an annotation."""
    yield annotation
    for argument in get_args(annotation):
        yield from _list_kinds(argument)


def _list_leaves(value: Any) -> Iterator[Any]:
    """The values inside mappings and lists."""
    if isinstance(value, dict | list):
        for item in value.values() if isinstance(value, dict) else value:
            yield from _list_leaves(item)
    else:
        yield value


def _without_nulls(value: Any, annotation: Any) -> Any:
    """A mapping of free keys without those that are null; none at all for null."""
    if get_origin(annotation) is not dict or get_args(annotation)[1] is Any or not isinstance(value, dict | None):
        return value
    inner = get_args(annotation)[1]
    return {key: _without_nulls(item, inner) for key, item in (value or {}).items() if item is not None}


KWARGS: Any = Field({}, description="Options of the implementation that is named above, by its class `Options`.")
KWARGS_BY_NAME: Any = Field({}, description="Options of implementations, by their names and their classes `Options`.")


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
