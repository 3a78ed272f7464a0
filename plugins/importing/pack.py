"""pack.yaml: what all models of a user's folder share, proposed by `import` and corrected by the user."""

from collections.abc import Iterable, Mapping
from pathlib import Path

import yaml
from pydantic import ValidationError

from roomkin.plugins.importing.evidence import Shared
from roomkin.plugins.importing.proposal import ProposedFile
from roomkin.stages.contracts.categories import known_categories
from roomkin.stages.contracts.errors import InputError, fault_of, line_of
from roomkin.stages.contracts.files import read_text, write_text

HEAD = """\
# What the models share; change it and run import again. null: each model by itself.
# up, front: an axis of their files; unit: metres. categories: what names say, and what that is here.
"""


class Pack(ProposedFile):
    """By suffix, what the models of a kind of file share; and the category for what their names say."""

    kinds: dict[str, Shared] = {}
    categories: dict[str, str] = {}


def read_pack(path: Path) -> Pack:
    """The file, or nothing if there is none.

    Raises:
        InputError: it is broken.
    """
    if not path.is_file():
        return Pack()
    try:
        return Pack.model_validate(yaml.safe_load(read_text(path, "or delete it")) or {})
    except ValidationError as error:
        first = error.errors()[0]
        raise InputError(
            path, f"{'.'.join(map(str, first['loc']))}: {first['msg']}.", "or delete it", code="E-PACK-BROKEN"
        ) from None
    except yaml.YAMLError as error:
        where, what = line_of(path, error), f"is no YAML: {fault_of(error)}."
        raise InputError(where, what, "or delete it", code="E-PACK-BROKEN") from None


def complete_pack(pack: Pack, proposed: Mapping[str, Shared], categories: Iterable[str]) -> Pack:
    """The pack, completed. What a person wrote in it counts."""
    pack = pack if pack.by_hand else Pack()
    stated = {category: category for category in sorted(set(categories))}
    whole = Pack(kinds={**proposed, **pack.kinds}, categories={**stated, **pack.categories})
    return whole if pack != Pack() else whole.add_checksum()


def write_pack(path: Path, pack: Pack, counts: Mapping[str, str]) -> None:
    """Write the file.

    Args:
        counts: by suffix, how many models tell what.
    """
    lines = [HEAD + "kinds:"]
    for kind, shared in pack.kinds.items():
        lines += [f"  # {counts[kind]}"] if kind in counts else []
        values = yaml.safe_dump(shared.model_dump(), default_flow_style=True, sort_keys=False, width=1000)
        lines.append(f"  {kind}: {values.strip()}")
    lines.append("categories:" if pack.categories else "categories: {}")
    for name, category in pack.categories.items():
        entry = yaml.safe_dump({name: category}, width=1000).strip()
        lines.append(f"  {entry}{'' if category in known_categories() else '  # none of ours'}")
    lines += [f"guess: {pack.guess}"] if pack.guess else []
    write_text(path, "\n".join(lines) + "\n")
