"""Pages of studies: long tables are folded, no row and no note is lost."""

import pytest

from roomkin.plugins.studies.study import FOLDED, fold_table, split_totals
from roomkin.stages.tables.text import TextTable, markdown


def table(rows: int, notes: list[str]) -> TextTable:
    return TextTable("t", "A caption.", ["Scene", "Value"], [[f"room {k}", str(k)] for k in range(rows)], notes=notes)


@pytest.mark.parametrize("notes", [[], ["One note."], ["One note.", "Another note."]])
def test_a_long_table_is_folded_between_its_caption_and_its_notes(notes: list[str]) -> None:
    short, long = table(FOLDED, notes), table(FOLDED + 1, notes)
    assert fold_table(short) == markdown(short)
    before, inside = fold_table(long).split("<details")
    inside, after = inside.split("</details>")
    assert before == "**A caption.**\n\n" and f"<summary>{FOLDED + 1} rows</summary>\n\n| Scene" in inside
    assert inside.count("\n| room") == FOLDED + 1 and after.strip() == "\n\n".join(notes)


def test_totals_come_first_and_every_row_stays() -> None:
    whole = table(3, ["A note."])
    whole.rows.append(["total", "9"])
    totals, rooms = split_totals(whole)
    assert totals.rows == [["total", "9"]] and totals.notes == ["A note."]
    assert [row[0] for row in rooms.rows] == ["room 0", "room 1", "room 2"]
    assert split_totals(table(2, [])) == [table(2, [])]
