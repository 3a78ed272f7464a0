"""A question: text and pictures in their order, its digest, and the messages that a chat endpoint gets."""

import base64
import json
from collections.abc import Sequence
from hashlib import sha256
from typing import Any, NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

Picture = NDArray[np.uint8]  # (H, W, 3), red first
TOKENS = 1000  # of a picture or an answer, where nobody counts
DETAIL = "auto"  # how closely the model looks at a picture: it decides


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
