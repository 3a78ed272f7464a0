"""Part types: one table says what moves and how, and nothing else in the core names them."""

import ast
from pathlib import Path
from typing import get_args

import pytest
from pydantic import ValidationError

from roomkin.stages.contracts.files import as_json
from roomkin.stages.contracts.library import Asset, Joint, LibraryEntry
from roomkin.stages.contracts.parts import FRONTS, PARTS, PartType

STAGES = Path(__file__).resolve().parents[2] / "stages"
# The table; the tasks about a part; the target of the usual config; words of parts that are no things by themselves.
NAMING = {"contracts/parts.py", "tasks/door.py", "tasks/drawer.py", "config/experiment.py", "contracts/category.py"}


def button(**changes: object) -> Joint:
    given = {"name": "press", "type": "prismatic", "part_type": "button", "parent": "body", "link": "cap"}
    return Joint.model_validate(given | {"axis": (-1, 0, 0), "lower": 0.0, "upper": 0.01} | changes)


def test_the_core_names_doors_and_drawers_in_one_place() -> None:
    found = set()
    for file in STAGES.rglob("*.py"):
        constants = (node.value for node in ast.walk(ast.parse(file.read_text())) if isinstance(node, ast.Constant))
        if set(constants) & {*FRONTS}:
            found.add(str(file.relative_to(STAGES)))
    assert found <= NAMING


def test_the_table_has_a_row_for_every_part_type() -> None:
    assert set(PARTS) == set(get_args(PartType)) > set(FRONTS)
    assert all(0 < low < high for part in PARTS.values() for low, high in [part.motion])


def test_a_button_is_no_front() -> None:
    about = {"id": "box_0", "category": "box", "box_min": (0, 0, 0), "box_max": (1, 1, 1), "mass": 1, "licence": "",
             "provenance": "", "checksum": "", "joints": [button()], "buttons": 1}  # fmt: skip
    asset = Asset.model_validate(about)
    assert not asset.articulated and asset.panels == []
    for wrong, why in (({"drawers": 1}, "drawers: says 1, but 0 joints"), ({"buttons": 0}, "buttons: says 0, but 1")):
        with pytest.raises(ValidationError, match=why):
            Asset.model_validate(about | wrong)


def test_files_name_buttons_where_there_are_some_alone() -> None:
    about = {"id": "a", "category": "box", "archive": "a.zip", "doors": 0, "drawers": 0, "checksum": ""}
    for count, said in ((0, False), (2, True)):
        entry = LibraryEntry.model_validate(about | {"buttons": count})
        assert ('"buttons"' in as_json(entry)) is said and LibraryEntry.model_validate_json(as_json(entry)) == entry


def test_files_say_role() -> None:
    text = as_json(button())
    assert '"role": "button"' in text and "part_type" not in text
    assert Joint.model_validate_json(text) == button()
