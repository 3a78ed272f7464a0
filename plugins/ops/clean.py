"""Command `clean`: delete what runs wrote, and nothing that a person made."""

import shutil
from pathlib import Path

from stages.contracts import InputError
from stages.contracts.corrections import CORRECTIONS
from stages.contracts.hand import MADE, PROJECT, find_hand_file, is_by_hand

WRITTEN = ("results", "logs", ".snakemake")  # by a run, in its folder; and tables of times in benchmarks/


def run(*, folder: Path = Path()) -> None:
    """Delete results, logs, times and Snakemake's memory of runs. Corrections and drawings stay, in hand/.

    Args:
        folder: the folder of the runs; `make demo` has one of its own in it.

    Raises:
        InputError: there is work of a person's in results/ that has no place in hand/; nothing is deleted.
    """
    places = [folder, folder / "demo"]
    found = [path for place in places for path in list_hand_work(place / "results")]
    for path in found:
        if MADE.fullmatch(path.parent.as_posix()):
            find_hand_file(path.parent, path.name, str)
    if left := [str(path) for path in found if path.exists()]:
        what = f"a person made {', '.join(left)}."
        raise InputError(folder / "results", what, "move it away, then clean", code="E-HAND-WORK")
    for place in places:
        for name in WRITTEN:
            shutil.rmtree(place / name, ignore_errors=True)
        for table in (place / "benchmarks").glob("*/*.tsv"):
            table.unlink()


def list_hand_work(results: Path) -> list[Path]:
    """Each corrections.json and project.json, or such of another picture, that a person made; checksums are hidden."""
    ours = (Path(CORRECTIONS).stem, Path(PROJECT).stem)
    found = [path for path in sorted(results.rglob("*.json")) if path.name.split(".")[0] in ours and is_by_hand(path)]
    return [path for path in found if not any(part.startswith(".") for part in path.relative_to(results).parts)]
