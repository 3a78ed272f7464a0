"""The package as the core knows it, and its config section."""

import re
from typing import Any, Literal
from urllib.parse import urlsplit

from pydantic import Field, field_validator

from roomkin.stages.config.packages import Package
from roomkin.stages.contracts.section import NotNegative, Section, unfit

VARIABLE = "[A-Za-z_][A-Za-z0-9_]*"  # name of one of the environment
OURS = {"model", "messages", "response_format", "stream", "n"}  # of a request
ABOUT = "The language model that sees, for the judge `vlm` and for `perception.captions: vlm` (docs/vlm.md)."


class VlmConfig(Section):
    """An OpenAI-compatible chat endpoint, and the ledger of what it was asked."""

    url: str = Field(
        "https://api.openai.com/v1",
        description="Where it is: .../chat/completions is asked. vLLM: http://localhost:8000/v1, "
        "Ollama: http://localhost:11434/v1.",
    )
    model: str = Field("gpt-4o-2024-08-06", min_length=1, description="Its name there; a dated one can be repeated.")
    key_env: str = Field(
        "OPENAI_API_KEY",
        json_schema_extra={"pattern": f"^({VARIABLE})?$"},
        description="Environment variable that holds the key; empty: the server asks for none. The key itself is "
        "written nowhere.",
    )
    options: dict[str, Any] = Field(
        {"temperature": 0, "max_tokens": 500},
        description="Sent with every request, as they are; null: not sent. "
        "Some models want max_completion_tokens in the place of max_tokens.",
    )
    image_size: int = Field(512, ge=32, description="Longest side of the pictures sent; larger ones are reduced.")
    ledger: str = Field(
        "ledger", min_length=1, description="Folder of all calls, a file each; shared by jobs, kept between runs."
    )
    mode: Literal["record", "replay"] = Field(
        "record",
        description="record: ask what the ledger does not know. replay: nothing is asked; what is missing is an error.",
    )
    choices: int = Field(
        1,
        ge=1,
        description="Cousins that it chooses, and turns, one call for each; those after them follow by distance "
        "(Table 2 uses the first; official: all).",
    )
    stand_in: str = Field(
        "",
        description="A judge that answers in the model's place where `key_env` names no key, e.g. geometry: it is "
        "asked the same questions of the same candidates, and the ledger and the tables say so. Empty: nobody.",
    )
    timeout: float = Field(120.0, gt=0, description="Seconds without a word of the server until a request is given up.")
    price_input: NotNegative = Field(2.5, description="Price of a million tokens sent ...")
    price_output: NotNegative = Field(10.0, description="... and received, in any currency.")
    max_calls: int | None = Field(
        2000, ge=0, description="Requests in the whole ledger, at most: then the job stops. null: any number."
    )
    max_cost: float | None = Field(10.0, ge=0, description="Likewise their cost. null: any.")

    def list_judges(self) -> set[str]:
        """The stand-in, which answers where there is no key."""
        return {self.stand_in} - {""}

    def keep_deciding(self) -> "VlmConfig":
        """The keys that decide on the answers; where and how they are got is left at its default."""
        return VlmConfig(**self.model_dump(include={"model", "options", "image_size", "choices", "stand_in"}))

    @field_validator("key_env")
    @classmethod
    def _check_variable(cls, name: str) -> str:
        if name and not re.fullmatch(VARIABLE, name):  # it may be the key: it is not shown
            mend = "e.g. OPENAI_API_KEY; the key itself is written nowhere"
            raise unfit("is no name of an environment variable", mend)
        return name

    @field_validator("url")
    @classmethod
    def _check_url(cls, url: str) -> str:
        try:
            parts = urlsplit(url)
            host, secret = parts.hostname, parts.username or parts.password or parts.query
        except ValueError:
            raise ValueError("is no URL") from None
        if parts.scheme not in ("http", "https") or not host:
            raise ValueError("begins with neither http:// nor https:// and a host")
        if secret:
            raise ValueError("holds a user, password or query; a key belongs into the environment, see key_env")
        return url.rstrip("/")

    @field_validator("options")
    @classmethod
    def _check_options(cls, options: dict[str, Any]) -> dict[str, Any]:
        if taken := sorted(OURS & set(options)):
            raise ValueError(f"sets {', '.join(taken)}, which the client sets itself")
        return {name: value for name, value in options.items() if value is not None}


def list_models_asked(config: Any) -> list[VlmConfig]:
    """The language models that variants of matching ask, and that which captions the user's pictures."""
    options = map(config.matching_of, config.experiment.variants)
    asked = [each.vlm for each in options if "vlm" not in each.list_unread()]
    captions = config.perception.captions == "vlm" and {*config.experiment.views} & {*config.experiment.rooms}
    return [*asked, config.vlm] if captions else asked


def keys(config: Any) -> list[str] | None:
    """The variables of their keys; None: nothing is asked."""
    asked = [model.key_env for model in list_models_asked(config) if model.mode == "record"]
    return asked or None


PACKAGE = Package(
    section="vlm",
    judges=True,
    sections={"vlm": (VlmConfig, Field(VlmConfig(), description=ABOUT))},
    outside=lambda config: [model.ledger for model in list_models_asked(config)],
    keys=keys,
)
