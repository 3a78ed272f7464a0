"""From the reply of a chat endpoint to a checked answer."""

from typing import Any, TypeVar

from pydantic import BaseModel, TypeAdapter, ValidationError

from roomkin.stages.contracts.errors import first_error
from roomkin.stages.contracts.types import Count

LONGEST = 20_000  # characters of an answer
COUNTED = TypeAdapter(Count)
A = TypeVar("A", bound=BaseModel)


class UnusableError(Exception):
    """An answer that says nothing, or nothing that was asked."""


def text_of(reply: dict[str, Any]) -> str:
    """The text of a reply.

    Raises:
        UnusableError: it was cut off, filtered, refused, or is empty.
    """
    try:
        choice = reply["choices"][0]
        message = choice["message"]
        content = message.get("content")
        refusal, reason = message.get("refusal"), choice.get("finish_reason")
    except (KeyError, IndexError, TypeError, AttributeError):
        raise UnusableError("the reply holds no choice with a message") from None
    if refusal:
        raise UnusableError("the model declines to answer")
    if reason == "length":
        raise UnusableError("the answer is cut off at the largest number of tokens")
    if reason == "content_filter":
        raise UnusableError("the server's filter took the answer")
    if isinstance(content, list):
        parts = [part.get("text") for part in content if isinstance(part, dict)]
        content = "".join(part for part in parts if isinstance(part, str))
    if not isinstance(content, str) or not content.strip():
        raise UnusableError("the answer is empty")
    if len(content) > LONGEST:
        raise UnusableError(f"the answer has {len(content)} characters")
    return content


def parse_answer(text: str, answer: type[A]) -> A:
    """The JSON object in a text (in a fence or after thoughts, as some models write), checked by its model.

    Raises:
        UnusableError: there is none, or it is none that was asked for.
    """
    answered = text.rpartition("</think>")[2]
    start, end = answered.find("{"), answered.rfind("}")
    if start < 0 or end < start:
        raise UnusableError("the answer holds no JSON object")
    try:
        return answer.model_validate_json(answered[start : end + 1], strict=True)
    except ValidationError as error:
        raise UnusableError(f"the answer's JSON: {first_error(error)}") from None


def usage_of(reply: dict[str, Any]) -> tuple[int, int] | None:
    """Tokens sent and received, if the server counts."""
    try:
        sent, received = (reply["usage"][name] for name in ("prompt_tokens", "completion_tokens"))
        return COUNTED.validate_python(sent, strict=True), COUNTED.validate_python(received, strict=True)
    except (KeyError, TypeError, ValidationError):
        return None


def response_format(kind: str, answer: type[BaseModel]) -> dict[str, Any] | None:
    """How a request asks the server for JSON; None: only in the words of the prompt."""
    if kind == "json_schema":
        schema = {"name": "answer", "strict": True, "schema": answer.model_json_schema()}
        return {"type": kind, "json_schema": schema}
    return {"type": kind} if kind == "json_object" else None
