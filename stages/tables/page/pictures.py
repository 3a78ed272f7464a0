"""Pictures for the page: loaded, made smaller, and written into the HTML itself."""

import base64
import io
from dataclasses import dataclass, field
from pathlib import Path

from PIL import Image, UnidentifiedImageError

from stages.contracts.errors import InputError


def load(path: Path, width: int) -> Image.Image:
    """The picture as RGB (transparency on white), no wider than `width` pixels.

    Raises:
        InputError: the file is missing or no picture.
    """
    try:
        with Image.open(path) as opened:
            picture = opened.convert("RGBA")
    except FileNotFoundError:
        raise InputError(path, "no such picture.") from None
    except (UnidentifiedImageError, OSError, SyntaxError, ValueError) as error:
        raise InputError(path, f"is not a readable picture ({error.__class__.__name__}).", "make it again") from None
    canvas = Image.new("RGBA", picture.size, "white")
    canvas.alpha_composite(picture)
    picture = canvas.convert("RGB")
    if picture.width > width:
        height = max(1, round(picture.height * width / picture.width))
        picture = picture.resize((width, height), Image.Resampling.LANCZOS)
    return picture


@dataclass(frozen=True)
class Picture:
    """A picture inside the page."""

    source: str
    width: int
    height: int
    alt: str


@dataclass
class Album:
    """Makes pictures for one page, all under the same limits."""

    width: int
    quality: int
    size: int = field(default=0, init=False)

    def add(self, path: Path, alt: str) -> Picture:
        """The picture as a WebP data URI."""
        picture = load(path, self.width)
        buffer = io.BytesIO()
        picture.save(buffer, "WEBP", quality=self.quality, method=4)
        data = base64.b64encode(buffer.getvalue()).decode("ascii")
        self.size += len(data)
        return Picture(f"data:image/webp;base64,{data}", picture.width, picture.height, alt)

    def maybe(self, path: Path, alt: str) -> Picture | None:
        """The picture if the file is there."""
        return self.add(path, alt) if path.is_file() else None
