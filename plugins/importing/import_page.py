"""The page of the command `import`: a picture and a few lines per model, one file."""

import base64
import io
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import get_args

from PIL import Image

from roomkin.plugins.importing.discover import PACK
from roomkin.plugins.importing.evidence import UNITS
from roomkin.plugins.importing.examine import NOTES, Examined
from roomkin.plugins.importing.importers import Axis
from roomkin.plugins.importing.pack import Pack
from roomkin.stages.contracts.categories import known_categories
from roomkin.stages.contracts.files import write_text
from roomkin.stages.tables.markup import environment


def write_page(path: Path, source: Path, models: Sequence[Examined], pack: Pack, counts: Mapping[str, str]) -> None:
    """Write the page; the models in the order of their folders, those that are not used last.

    Args:
        pack: what they share, which the page lets its reader change and save.
        counts: by suffix, how many models tell what.
    """
    page = (
        environment("roomkin.plugins.importing")
        .get_template("import_page.html.jinja")
        .render(
            source=source.name,
            notes=NOTES,
            used=[(model, _place(model, path), _inline(model.picture)) for model in models if model.asset is not None],
            pack=pack,
            counts=counts,
            axes=get_args(Axis),
            units=UNITS,
            known=sorted(known_categories()),
            file=PACK,
            refused=[(model, _place(model, path)) for model in models if model.asset is None],
        )
    )
    write_text(path, page)


def _place(model: Examined, page: Path) -> str:
    return model.folder.relative_to(page.parent).as_posix()


def _inline(picture: Image.Image | None) -> str:
    """A picture as part of the page."""
    if picture is None:
        return ""
    buffer = io.BytesIO()
    picture.save(buffer, "WEBP")
    return "data:image/webp;base64," + base64.b64encode(buffer.getvalue()).decode()
