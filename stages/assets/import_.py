"""Verb `import`: look at a folder of models, say what each is taken for, and write a folder that the library takes."""

import sys
import tempfile
from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path

from stages.assets.convention import NOTHING, shared
from stages.assets.discover import PAGE, Found, discover, is_model, is_part, numbered_names, single
from stages.assets.examine import Examined, examine
from stages.assets.import_page import write_page
from stages.assets.imports import IMPORTERS, by_suffix, in_one_line, snake_case
from stages.assets.portrait import Portraits
from stages.contracts.errors import InputError

FOREIGN = {".3ds", ".blend", ".fbx", ".sdf", ".skp", ".usd", ".usda", ".usdc", ".usdz", ".wrl", ".xacro"}


def run(folder: Path, /, *, out: Path) -> None:
    """Look at the models of a folder; `assets.folders: [<out>]` then uses them.

    Writes <out>/<category>/<name>/ per model: a URDF in the file's own frame and unit, and asset.json, which you can
    correct: run it again and it counts. <out>/index.html shows and tells what each is taken for.

    Args:
        folder: with models, <category>/<model> or PartNet-Mobility's <number>/, or one model's file; it stays as it is.
        out: folder to write.
    """
    kinds = by_suffix(IMPORTERS)
    found = models_of(folder, out, list(kinds))
    common = shared(found, kinds)
    with tempfile.TemporaryDirectory() as scratch:
        portraits = Portraits()
        models: list[Examined] = []
        for number, (one, place) in enumerate(zip(found, places(found), strict=True)):
            work = Path(scratch) / str(number)
            kind = one.path.suffix.lower()
            model = examine(one, kinds[kind], out / place, work, models, common.get(kind, NOTHING))
            if model.asset is not None:
                try:
                    with in_one_line(one.path):
                        model.picture = portraits.take(work / model.asset.id)
                except InputError as error:
                    model.asset = None
                    model.doubts.append(f"no picture can be taken of it: {error.what}")
            models.append(model)
            print(model.text(), flush=True)
    write_page(out / PAGE, folder, models)
    taken = sum(model.asset is not None for model in models)
    print(f"{taken} of {len(models)} models can be used: assets: {{folders: [{out}]}}. Look at {out / PAGE}")
    if not taken:
        raise InputError(folder, "none of its models can be used.", "see above")


def models_of(given: Path, out: Path, kinds: Sequence[str]) -> list[Found]:
    """The models that are to be looked at: those of a folder, or a file.

    Raises:
        InputError: there are none, or `out` is in the folder.
    """
    if given.is_file():
        if not is_model(given, kinds):
            raise InputError(given, "is no model.", f"one of {', '.join(kinds)}, or a folder of them")
        if is_part(given):
            raise InputError(given, "is a part that MJCF models include.", "give the file that includes it")
        return [single(given)]
    if not given.is_dir():
        raise InputError(given, "is not there.", "a folder of models, or a model's file")
    inside, outside = sorted([given.resolve(), out.resolve()], key=lambda path: -len(path.parts))
    if inside.is_relative_to(outside):
        raise InputError("--out", f"{out} and {given} lie in one another.", "give a folder beside it")
    if found := discover(given, kinds):
        if left_out := unread(given):
            print(f"{given}: {left_out}", file=sys.stderr)
        return found
    parts = [path for path in given.rglob("*") if is_model(path, kinds)]
    if parts:
        what = f"holds no model, only parts of models ({parts[0].name} and such)."
        raise InputError(given, what, "give the folder or the file of the model that they are part of")
    fix = "docs/assets.md says how they may lie"
    raise InputError(given, f"holds no models ({', '.join(kinds)}).", unread(given) or fix)


def unread(folder: Path) -> str:
    """How many models there are of kinds that are not read, and what to do; empty: none."""
    found = Counter(path.suffix.lower() for path in folder.rglob("*") if path.suffix.lower() in FOREIGN)
    counts = ", ".join(f"{count} {kind}" for kind, count in sorted(found.items()))
    return f"files of kinds that are not read ({counts}): export them as URDF, MJCF or GLB" if found else ""


def places(found: Iterable[Found]) -> list[str]:
    """<category>/<name> of every model; names that are taken get a number."""
    return numbered_names([f"{snake_case(one.category)}/{snake_case(one.name)}" for one in found], [])
