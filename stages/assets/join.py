"""One library of the procedural models and the user's own."""

from collections.abc import Iterable
from itertools import chain
from pathlib import Path

from roomkin.stages.contracts.categories import known_categories
from roomkin.stages.contracts.category import CategoryFacts
from roomkin.stages.contracts.errors import InputError
from roomkin.stages.contracts.files import read_json, write_json
from roomkin.stages.contracts.library import Library, LibraryEntry, LibraryPart


def run(*, own: tuple[Path, ...], out: Path, library: tuple[Path, ...] = ()) -> None:
    """Write library.json beside the indices that it is made of.

    Args:
        own: indices of the user's models; of those that are copies of one another the first by name is taken.
        out: path of library.json.
        library: index of the procedural models, or of what takes their place; none: the user's models alone.
    """
    parts = {path: read_json(LibraryPart, path) for path in (*library, *own)}
    if elsewhere := [path for path in parts if path.parent.resolve() != out.parent.resolve()]:
        fix = "write all indices into one folder"
        raise InputError(elsewhere[0], f"lies in another folder than {out}.", fix, code="E-LIBRARY-ELSEWHERE")
    left_out = [line for part in parts.values() for line in part.left_out]
    theirs = sorted(chain(*(parts[path].assets for path in own)), key=lambda entry: entry.id)
    mine, copies = without_copies(theirs)
    left_out += copies
    for line in left_out:
        print(f"left out: {line}")
    if left_out and not mine:
        raise InputError("assets.folders", f"none of the models can be used. {left_out[0]}", code="E-MODELS-UNUSABLE")
    entries = sorted([*chain(*(parts[path].assets for path in library)), *mine], key=lambda entry: entry.id)
    if not entries:
        fix = "set assets.counts or assets.folders"
        raise InputError("assets", "the library would be empty.", fix, code="E-LIBRARY-EMPTY")
    names = [entry.id for entry in entries]
    if double := next((name for name in names if names.count(name) > 1), None):
        raise InputError("assets.folders", f"two models are called '{double}'.", "rename one", code="E-MODEL-NAME")
    write_json(out, Library(assets=entries, left_out=left_out, categories=merge_categories(parts.values(), entries)))


def merge_categories(parts: Iterable[LibraryPart], entries: list[LibraryEntry]) -> list[CategoryFacts]:
    """What is known of categories, in order of name: all that everybody knows or an index says, and others by the sizes
    of their models."""
    known = dict(known_categories())
    for name in {entry.category for entry in entries} - set(known):
        sizes = [entry.size for entry in entries if entry.category == name and entry.size is not None]
        known[name] = CategoryFacts(name=name, sizes=sizes)
    known |= {row.name: row for part in parts for row in part.categories}
    return [known[name] for name in sorted(known)]


def without_copies(entries: list[LibraryEntry]) -> tuple[list[LibraryEntry], list[str]]:
    """The entries, of those with the same files the first; and the others, in a line each."""
    first: dict[str, LibraryEntry] = {}
    for entry in entries:
        first.setdefault(entry.checksum, entry)
    copies = [entry for entry in entries if first[entry.checksum] is not entry]
    return list(first.values()), [f"{entry.id}: is a copy of {first[entry.checksum].id}" for entry in copies]
