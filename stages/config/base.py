"""Base of every config section."""

from pydantic import BaseModel, ConfigDict


class Section(BaseModel):
    """A section of config.yaml. An unknown key is an error; values are frozen after validation."""

    model_config = ConfigDict(extra="forbid", frozen=True)
