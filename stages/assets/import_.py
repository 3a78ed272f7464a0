"""Verb `import`: look at a folder of models, say what each is taken for, and write a folder that the library takes."""

import tempfile
from collections.abc import Iterable
from pathlib import Path

from stages.assets.discover import PAGE, Found, discover, numbered_names
from stages.assets.examine import Examined, examine
from stages.assets.import_page import write_page
from stages.assets.imports import IMPORTERS, by_suffix, snake_case
from stages.assets.portrait import Portraits
from stages.contracts.errors import InputError


def run(folder: Path, /, *, out: Path) -> None:
    """Look at the models of a folder; `assets.folders: [<out>]` then uses them.

    Writes <out>/<category>/<name>/ per model: a URDF in the file's own frame and unit, and asset.json, which you can
    correct: run it again and it counts. <out>/index.html shows and tells what each is taken for.

    Args:
        folder: with <category>/<model> or PartNet-Mobility's <number>/; it stays as it is.
        out: folder to write.
    """
    if not folder.is_dir():
        raise InputError(folder, "is not a folder.")
    inside, outside = sorted([folder.resolve(), out.resolve()], key=lambda path: -len(path.parts))
    if inside.is_relative_to(outside):
        raise InputError("--out", f"{out} and {folder} lie in one another.", "give a folder beside it")
    kinds = by_suffix(IMPORTERS)
    found = discover(folder, list(kinds))
    if not found:
        raise InputError(folder, "holds no models.", "expected <folder>/<category>/<model>, docs/assets.md")
    with tempfile.TemporaryDirectory() as scratch:
        portraits = Portraits()
        models: list[Examined] = []
        for number, (one, place) in enumerate(zip(found, places(found), strict=True)):
            work = Path(scratch) / str(number)
            model = examine(one, kinds[one.path.suffix.lower()], out / place, work, models)
            if model.asset is not None:
                model.picture = portraits.take(work / model.asset.id)
            models.append(model)
            print(model.text(), flush=True)
    write_page(out / PAGE, folder, models)
    taken = sum(model.asset is not None for model in models)
    print(f"{taken} of {len(models)} models can be used: assets: {{folders: [{out}]}}. Look at {out / PAGE}")
    if not taken:
        raise InputError(folder, "none of its models can be used.", "see above")


def places(found: Iterable[Found]) -> list[str]:
    """<category>/<name> of every model; names that are taken get a number."""
    return numbered_names([f"{snake_case(one.category)}/{snake_case(one.name)}" for one in found], [])
