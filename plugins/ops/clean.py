"""Command `clean`: delete what runs wrote, and nothing that a person made."""

import shutil
import sys
from pathlib import Path

from roomkin.stages.contracts import InputError
from roomkin.stages.contracts.errors import count, escape_control
from roomkin.stages.contracts.hand import CORRECTIONS, MADE, PROJECT, find_hand_file, is_by_hand

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
    gone = []
    for place in places:
        for path in (place / name for name in WRITTEN if (place / name).exists()):
            files = sum(1 for one in path.rglob("*") if one.is_file())
            shutil.rmtree(path, ignore_errors=True)
            gone.append(f"{path}/ ({count(files, 'file')})")
        for table in (place / "benchmarks").glob("*/*.tsv"):
            table.unlink()
            gone.append(str(table))
    kept = [str(place / "hand/") for place in places if (place / "hand").exists()]
    stays = f"; kept {', '.join(kept)}" if kept else ""
    print(escape_control(f"deleted {', '.join(gone) or 'nothing'}{stays}"), file=sys.stderr)


def list_hand_work(results: Path) -> list[Path]:
    """Each corrections.json and project.json, or such of another picture, that a person made; checksums are hidden."""
    ours = (Path(CORRECTIONS).stem, Path(PROJECT).stem)
    found = [path for path in sorted(results.rglob("*.json")) if path.name.split(".")[0] in ours and is_by_hand(path)]
    return [path for path in found if not any(part.startswith(".") for part in path.relative_to(results).parts)]
