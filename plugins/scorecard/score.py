"""Command `score`: a submission against the truth of a set of rooms."""

from pathlib import Path

import numpy as np
import pandas as pd

from roomkin.plugins.scorecard.card import HEADING, compare, make_frame, make_line, table
from roomkin.plugins.scorecard.page import write_page
from roomkin.plugins.scorecard.reading import read_submission
from roomkin.plugins.scorecard.scoring import RoomRow, ThingRow, score_submission
from roomkin.plugins.scorecard.truth import Cells, Submission, list_rooms
from roomkin.stages.contracts.errors import InputError, explain
from roomkin.stages.contracts.files import write_atomically, write_text
from roomkin.stages.evaluation.scoring import GRID_CELLS

SHAPES = "shapes.npz"


def run(
    submission: Path,
    /,
    *,
    rooms: str,
    data: Path = Path("rooms"),
    out: Path = Path("scorecard"),
    against: Path | None = None,
    pictures: bool = True,
) -> None:
    """Score scenes of any method, and print a line for the table of all.

    Args:
        submission: a JSON file, or a folder with method.json and a file or folder for every room.
        rooms: the set, e.g. fourth.
        data: folder of the rooms, as `python -m benchmarks.open_rooms make` wrote it.
        out: folder of things.csv (a row per thing), rooms.csv, row.md and the page index.html.
        against: another submission, with which this one is compared thing by thing.
        pictures: draw the page.
    """
    folders = list_rooms(data, rooms)
    shapes = read_shapes(folders[0].parent / SHAPES)
    names = [folder.name for folder in folders]
    read = read_submission(submission, names)
    things, of_rooms = score_one(read, folders, shapes)
    parts = [table(HEADING, [make_line(read.about, things, of_rooms)])]
    if against:
        other = read_submission(against, names)
        theirs, _ = score_one(other, folders, shapes)
        parts.append(f"{read.about.method} less {other.about.method}:\n\n{compare(things, theirs)}")
    write_csv(out / "things.csv", things)
    write_csv(out / "rooms.csv", of_rooms)
    write_text(out / "row.md", "\n".join(parts))
    if pictures:
        write_page(out, read, folders, things, of_rooms, parts)
    print("\n".join(parts))
    for room, why in read.unread.items():
        print(f"{room}: not read, all of it counts as missed: {why}")
    lacking = [name for name in names if name not in read.rooms and name not in read.unread]
    if lacking:
        print(f"not in the submission, all of them count as missed: {', '.join(lacking)}")
    print(f"Open {out / ('index.html' if pictures else 'row.md')}")


def score_one(read: Submission, folders: list[Path], shapes: dict[str, Cells]) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Tables of things and of rooms."""
    things, rooms = score_submission(read, folders, shapes)
    return make_frame(things, ThingRow), make_frame(rooms, RoomRow)


def read_shapes(path: Path) -> dict[str, Cells]:
    """What is filled of the true models' boxes, by model; empty: the data set has no such file.

    Raises:
        InputError: it is broken.
    """
    if not path.is_file():
        return {}
    count, shape = GRID_CELLS**3, (GRID_CELLS,) * 3
    try:
        with np.load(path, allow_pickle=False) as file:
            return {name: np.unpackbits(file[name], count=count).reshape(shape).astype(bool) for name in file.files}
    except (OSError, ValueError, KeyError) as error:
        what = f"cannot be read ({explain(error)})."
        raise InputError(path, what, "make it again", code="E-FILE-UNREADABLE") from None


def write_csv(path: Path, rows: pd.DataFrame) -> None:
    """Write a table."""
    with write_atomically(path) as file:
        rows.to_csv(file, index=False)
