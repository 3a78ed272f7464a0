"""Other people's rooms: fetch models, render pictures, reconstruct them, score what came out (docs/results/open.md).

    python -m benchmarks.open_rooms fetch DIR          models of other projects (1 GB); needs Node
    python -m benchmarks.open_rooms render DIR         71 pictures; needs Mitsuba 3: pip install mitsuba==3.9.1
    python -m benchmarks.open_rooms run DIR            through the stages; --masks unaided: without a hand
    python -m benchmarks.open_rooms score DIR          docs/results/open.md and open.csv.xz
    python -m benchmarks.open_rooms make DIR           fetch, render, and DIR/rooms: a data set for any method
    python -m benchmarks.open_rooms submit DIR         what `run` made of a set, as a submission for `roomkin score`
    python -m benchmarks.open_rooms gallery DIR        docs/results/gallery.md and its pictures, of what was scored

Each goes on where it was stopped.
"""

import argparse
import sys
from pathlib import Path

from benchmarks.open_rooms import packs
from benchmarks.open_rooms.fetch import fetch
from benchmarks.open_rooms.pictures import MASKS
from roomkin.stages.contracts import InputError


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("command", choices=["fetch", "render", "run", "score", "make", "submit", "gallery"])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--half", choices=[*packs.HALVES, *packs.MIXED, ""], default="", help="only this half")
    parser.add_argument("--only", default="", help="only pictures with this in their name")
    parser.add_argument("--samples", type=int, default=12, help="per pixel, of `render`")
    parser.add_argument("--learning", type=int, default=0, help="of `render`: so many others of each kind")
    parser.add_argument(
        "--library", type=Path, default=Path("results"), help="results folder with library and features"
    )
    parser.add_argument("--masks", nargs="+", choices=MASKS, default=["drawn", "exact"])
    parser.add_argument("--rows", nargs="+", default=["geometry", "no-image", "hog"], help="who chooses models")
    parser.add_argument("--out", type=Path, default=Path("docs/results"), help="of `score` and `submit`")
    parser.add_argument("--version", default="this", help="of the code that ran, which `score` and `submit` name")
    asked = parser.parse_args()
    halves = [asked.half] if asked.half else list(packs.HALVES)
    try:
        if asked.command == "fetch":
            fetch(asked.folder / "packs")
        elif asked.command == "render":
            render(asked.folder, halves, asked.only, asked.samples, asked.learning)
        elif asked.command == "make":
            from benchmarks.open_rooms.publish import check_manifest, publish

            fetch(asked.folder / "packs")
            render(asked.folder, halves, asked.only, asked.samples)
            publish(asked.folder, halves)
            print("\n".join(check_manifest(asked.folder)))
        elif asked.command == "run":
            from benchmarks.open_rooms.run import run

            run(asked.folder, asked.library, asked.half, asked.only, tuple(asked.masks), tuple(asked.rows))
        elif asked.command == "submit":
            from benchmarks.open_rooms.submit import submit

            for half in halves:
                for masks in asked.masks:
                    out = asked.out / f"{half}_{masks}.json"
                    submit(asked.folder, asked.library, half, masks, out, asked.version)
        elif asked.command == "gallery":
            from benchmarks.open_rooms.gallery import gallery

            gallery(asked.folder, asked.library, asked.out)
        else:
            from benchmarks.open_rooms.score import score

            score(asked.folder, asked.library, asked.out, asked.version)
    except InputError as error:
        sys.exit(str(error))


def render(folder: Path, halves: list[str], only: str, samples: int, learning: int = 0) -> None:
    """Render what is not there yet; only this imports Mitsuba."""
    from benchmarks.open_rooms.pictures import make

    for half in halves:
        make(folder, half, only, samples, learning)


if __name__ == "__main__":
    main()
