"""Base of every config section."""

from typing import Any

from pydantic import BaseModel, ConfigDict, Field


class Section(BaseModel):
    """A section of config.yaml. An unknown key is an error; values are frozen after validation."""

    model_config = ConfigDict(extra="forbid", frozen=True)


OWN: Any = Field({}, description="Options of implementations of your own, by their name; handed on as they are.")
