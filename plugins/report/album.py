"""Pictures for a page, scaled down and embedded in the HTML."""

import base64
import io
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from PIL import Image

from roomkin.stages.contracts.errors import InputError, explain
from roomkin.stages.contracts.images import read_narrow

THUMBNAIL = 150  # pixels: small pictures of objects and assets


class Picture(NamedTuple):
    """A picture inside the page."""

    source: str
    width: int
    height: int
    alt: str


class Animation(NamedTuple):
    """A film, and the still picture shown where nothing should move."""

    film: Picture
    still: Picture


def _embed_picture(data: bytes, size: tuple[int, int], alt: str) -> Picture:
    return Picture(f"data:image/webp;base64,{base64.b64encode(data).decode('ascii')}", *size, alt)


@dataclass(frozen=True)
class Album:
    """Makes pictures for one page, no wider than `width` pixels, as WebP of one quality."""

    width: int
    quality: int

    def add(self, path: Path | None, alt: str) -> Picture | None:
        """The picture of a file, if the run has it."""
        return self.put(read_narrow(path, self.width), alt) if path else None

    def put(self, picture: Image.Image, alt: str) -> Picture:
        """A picture that is small enough."""
        buffer = io.BytesIO()
        picture.save(buffer, "WEBP", quality=self.quality, method=4)
        return _embed_picture(buffer.getvalue(), picture.size, alt)

    def thumbnail(self, picture: Image.Image | None, alt: str) -> Picture | None:
        """A small picture, if there is one."""
        if picture is None:
            return None
        small = picture.copy()
        small.thumbnail((THUMBNAIL, THUMBNAIL), Image.Resampling.LANCZOS)
        return self.put(small, alt)

    def film(self, path: Path, alt: str) -> Animation:
        """An animated WebP as it is, and its last frame.

        Raises:
            InputError: the file is missing or no film.
        """
        try:
            with Image.open(path) as film:
                film.seek(getattr(film, "n_frames", 1) - 1)
                last = film.convert("RGB")
        except (OSError, SyntaxError, ValueError) as error:
            what = f"is not a readable film ({explain(error)})."
            raise InputError(path, what, "make it again", code="E-FILM-UNREADABLE") from None
        return Animation(_embed_picture(path.read_bytes(), last.size, alt), self.put(last, alt))
