"""Pictures for the page: loaded, made smaller, and written into the HTML itself."""

import base64
import io
from dataclasses import dataclass, field
from pathlib import Path

from PIL import Image, UnidentifiedImageError

from stages.contracts.errors import InputError
from stages.contracts.images import read_rgb

STILLS = 4  # frames of a film that stand for it where nothing should move, two by two


def load(path: Path, width: int) -> Image.Image:
    """The picture upright as RGB (transparency on white), no wider than `width` pixels.

    Raises:
        InputError: the file is missing or no picture.
    """
    picture = Image.fromarray(read_rgb(path))
    if picture.width > width:
        height = max(1, round(picture.height * width / picture.width))
        picture = picture.resize((width, height), Image.Resampling.LANCZOS)
    return picture


def _opened(path: Path) -> Image.Image:
    try:
        return Image.open(path)
    except FileNotFoundError:
        raise InputError(path, "no such picture.") from None
    except (UnidentifiedImageError, OSError, SyntaxError, ValueError) as error:
        raise _unreadable(path, error) from None


def _decoded(path: Path, opened: Image.Image) -> Image.Image:
    try:
        return opened.convert("RGBA")
    except (OSError, SyntaxError, ValueError) as error:
        raise _unreadable(path, error) from None


def _unreadable(path: Path, error: Exception) -> InputError:
    return InputError(path, f"is not a readable picture ({error.__class__.__name__}).", "make it again")


@dataclass(frozen=True)
class Picture:
    """A picture inside the page."""

    source: str
    width: int
    height: int
    alt: str


@dataclass(frozen=True)
class Animation:
    """A film and the picture that stands for it where nothing should move."""

    film: Picture
    still: Picture


@dataclass
class Album:
    """Makes pictures for one page, all under the same limits."""

    width: int
    quality: int
    size: int = field(default=0, init=False)

    def add(self, path: Path, alt: str) -> Picture:
        """The picture of a file."""
        return self.put(load(path, self.width), alt)

    def maybe(self, path: Path | None, alt: str) -> Picture | None:
        """The picture, if the run has the file."""
        return self.add(path, alt) if path else None

    def put(self, picture: Image.Image, alt: str, size: int = 0) -> Picture:
        """A picture as WebP, fitted into a square of `size` pixels if that is given."""
        if size and max(picture.size) > size:
            picture = picture.copy()
            picture.thumbnail((size, size), Image.Resampling.LANCZOS)
        buffer = io.BytesIO()
        picture.save(buffer, "WEBP", quality=self.quality, method=4)
        return self._written(buffer.getvalue(), picture.size, alt)

    def film(self, path: Path, alt: str) -> Animation:
        """An animated WebP as it is, and four of its frames."""
        with _opened(path) as opened:
            count = getattr(opened, "n_frames", 1)
            width, height = opened.size
            stills = Image.new("RGB", (width, height), "white")
            for place in range(STILLS):
                opened.seek(round(place * (count - 1) / (STILLS - 1)))
                frame = (
                    _decoded(path, opened).convert("RGB").resize((width // 2, height // 2), Image.Resampling.LANCZOS)
                )
                stills.paste(frame, ((place % 2) * (width - width // 2), (place // 2) * (height - height // 2)))
        return Animation(
            self._written(path.read_bytes(), (width, height), alt), self.put(stills, f"{alt}: four moments")
        )

    def _written(self, data: bytes, size: tuple[int, int], alt: str) -> Picture:
        text = base64.b64encode(data).decode("ascii")
        self.size += len(text)
        return Picture(f"data:image/webp;base64,{text}", *size, alt)
