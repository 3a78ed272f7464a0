"""A question to a chat endpoint (text and pictures in order, digest, messages), and the checked answer in the reply."""

import base64
import json
from collections.abc import Sequence
from hashlib import sha256
from typing import Any, NamedTuple, TypeVar

import cv2
import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, TypeAdapter, ValidationError

from roomkin.stages.contracts.errors import first_error
from roomkin.stages.contracts.types import Count

LONGEST = 20_000  # characters of an answer
COUNTED = TypeAdapter(Count)
A = TypeVar("A", bound=BaseModel)
Picture = NDArray[np.uint8]  # (H, W, 3), red first
TOKENS = 1000  # of a picture or an answer, where nobody counts
DETAIL = "auto"  # how closely the model looks at a picture: it decides


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


class Prompt(NamedTuple):
    """A question to any model; the text also says in words what answer is wanted."""

    system: str
    parts: Sequence[str | Picture]

    def as_record(self) -> list[str]:
        """System text, texts and the pictures' hashes: what the ledger keeps."""
        return [self.system, *(part if isinstance(part, str) else picture_hash(part) for part in self.parts)]

    def digest(self) -> str:
        """Digest of what is asked; equal for two models that are asked the same."""
        return digest(self.as_record())

    def tokens(self) -> int:
        """About how many tokens it has."""
        texts = [self.system, *(part for part in self.parts if isinstance(part, str))]
        return sum(map(len, texts)) // 3 + TOKENS * (len(self.parts) + 1 - len(texts))

    def messages(self, image_size: int) -> list[dict[str, Any]]:
        """As the protocol has it; pictures as data URLs."""
        content: list[dict[str, Any]] = []
        for part in self.parts:
            if isinstance(part, str):
                content.append({"type": "text", "text": part})
            else:
                url = {"url": data_url(part, image_size), "detail": DETAIL}
                content.append({"type": "image_url", "image_url": url})
        return [{"role": "system", "content": self.system}, {"role": "user", "content": content}]


def digest(value: Any) -> str:
    """Digest of plain data."""
    return sha256(json.dumps(value, sort_keys=True, ensure_ascii=False).encode()).hexdigest()


def picture_hash(picture: Picture) -> str:
    """Hash of the pixels, whatever a file of them would look like."""
    shape = "x".join(map(str, picture.shape))
    return f"sha256:{sha256(shape.encode() + np.ascontiguousarray(picture).tobytes()).hexdigest()}"


def data_url(picture: Picture, longest: int) -> str:
    """A PNG in a URL, reduced to `longest` pixels on its longer side."""
    scale = longest / max(picture.shape[:2])
    if scale < 1:
        width, height = (max(1, round(side * scale)) for side in picture.shape[1::-1])
        picture = cv2.resize(picture, (width, height), interpolation=cv2.INTER_AREA).astype(np.uint8, copy=False)
    _, png = cv2.imencode(".png", np.ascontiguousarray(picture[..., ::-1]))
    return f"data:image/png;base64,{base64.b64encode(png.tobytes()).decode()}"


def draw_box(rgb: Picture, box: Sequence[float]) -> Picture:
    """The picture (H, W, 3) with a red box (x0, y0, x1, y1), as far as it lies in the picture."""
    shown = rgb.copy()
    height, width = rgb.shape[:2]
    x0, y0, x1, y1 = np.clip(np.rint(box).astype(int), 0, [width - 1, height - 1] * 2).tolist()
    cv2.rectangle(shown, (x0, y0), (x1, y1), (255, 0, 0), max(2, round(max(rgb.shape) / 300)))
    return shown
