"""A resolver for trimesh: the pictures and materials that a mesh file names, confined to the user's folder."""

import warnings
from io import BytesIO
from pathlib import Path
from typing import Any
from urllib.parse import unquote

from PIL import EpsImagePlugin, Image
from trimesh.resolvers import Resolver

from roomkin.stages.articulated.inside import OutsideError, find_inside, is_link_out
from roomkin.stages.contracts.errors import explain

EpsImagePlugin.gs_binary = False  # PostScript is a program, and Pillow would have Ghostscript run it
PICTURES = {".bmp", ".gif", ".jpeg", ".jpg", ".png", ".tga", ".tif", ".tiff", ".webp"}


class MeshResolver(Resolver):  # type: ignore[misc]
    """The files that the mesh file `path` names, looked for beside it and above, up to `folder`.

    trimesh goes on without what cannot be read; `lost` says so, a line each. `made`: files that are made up, by name.
    """

    def __init__(self, path: Path, folder: Path) -> None:
        self.path, self.folder, self.lost, self.made = path, folder, list[str](), dict[str, bytes]()
        self.file_name = path.name  # which trimesh calls nameless meshes by

    def get(self, name: str) -> bytes:
        """The bytes of a file.

        Raises:
            FileNotFoundError: it is not in the folder, or is a picture that cannot be opened.
        """
        if name in self.made:
            return self.made[name]
        found = self.find(name)
        if found is None:
            is_link = any(is_link_out(one, self.path.parent, self.folder) for one in _spellings(name))
            raise self._note_loss(_written(name), f"is {'a link out of' if is_link else 'not in'} {self.folder.name}/")
        data = found.read_bytes()
        if found.suffix.lower() in PICTURES and (fault := fault_of(data)):
            raise self._note_loss(_written(name), fault)
        return data

    def find(self, name: str) -> Path | None:
        """The file of that name; None: it is not in the folder."""
        try:
            found = (find_inside(one, self.path.parent, self.folder) for one in _spellings(name))
            return next(filter(None, found), None)
        except OutsideError:
            return None

    def _note_loss(self, name: str, why: str) -> FileNotFoundError:
        self.lost.append(f"{self.path.name} is shown without '{name[:200]}', which {why}")
        return FileNotFoundError(f"'{name[:200]}' {why}")

    def keys(self) -> list[str]:
        """None are listed."""
        return []

    def write(self, name: str, data: Any) -> None:
        """Nothing is written."""
        raise PermissionError(name)

    def namespaced(self, namespace: str) -> "MeshResolver":
        """The same files."""
        return self


def _spellings(name: str) -> list[str]:
    """A name as it is written, and as it is meant where it is an address."""
    spelt = _written(name).lstrip("/")
    return [spelt, unquote(spelt)]


def _written(name: str) -> str:
    return name.strip().replace("\\", "/")


def fault_of(data: bytes) -> str | None:
    """The reason why a picture cannot be read; None: it can. Pillow says which are too large."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", Image.DecompressionBombWarning)
            with Image.open(BytesIO(data)) as picture:
                picture.load()
    except (Image.DecompressionBombError, Image.DecompressionBombWarning):
        return "is too large"
    except (OSError, ValueError, SyntaxError) as error:
        return f"is no whole picture ({explain(error)})"
    return None
