"""Command `picture`: from a picture of the user's to scenes."""

import sys
from pathlib import Path

from roomkin.stages.config.packages import load_command
from roomkin.stages.contracts.errors import file_missing
from roomkin.workflow import run_snakemake


def run(
    image: Path,
    /,
    *,
    depth: Path | None = None,
    intrinsics: Path | None = None,
    config: tuple[Path, ...] = (),
    cores: int = 2,
) -> None:
    """Find what a picture shows and where, its cousins in the library, and make simulated scenes of them.

    Works in this folder, and goes on where it stopped: results/report/scenes/<name>.html shows picture and scenes, and
    what is doubtful; `roomkin correct <name>` puts it right: with that page it ends where there is
    a browser. Weights of networks are fetched once, 300 MB.

    Args:
        image: photograph (JPEG, PNG, HEIC), or a folder that is a recording with depth.
        depth: of the same view: PNG, TIFF, EXR, NPY, NPZ; without it lines and usual sizes tell how far things are.
        intrinsics: camera.json or the calibration file that came with it; without it by EXIF or lines in the picture.
        config: what differs from config.yaml; later files win.
        cores: jobs at a time; each takes up to 2 GB.
    """
    named = {"image": image, "depth": depth, "camera": intrinsics}
    for path in config:  # a list, which is not looked over before
        if not path.exists():
            raise file_missing(path)
    load_command("perception", "fetch")()
    then = (lambda: load_command("annotator", "after")(image)) if sys.stdout.isatty() else None  # somebody sits there
    files = ["--configfile", *map(str, config)] if config else []
    given = [f"{key}={_as_text(path)}" for key, path in named.items() if path]
    run_snakemake(cores, "photo", *files, "--config", *given, then=then)


def _as_text(path: Path) -> str:
    """A path as Snakemake's YAML must have it to be text, whatever is in it."""
    return " '" + str(path).replace("'", "''") + "' "
