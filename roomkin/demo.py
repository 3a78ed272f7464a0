"""Command `demo`: a first look."""

from pathlib import Path

from roomkin.workflow import run_snakemake

CONFIG = Path(__file__).with_name("demo.yaml")


def run(*, cores: int = 2) -> None:
    """Furnish a room, photograph it, find cousins of what stands there, and make scenes of them, in the folder demo/.

    Two minutes; no picture, no network and no GPU are needed. demo/results/report/scenes/room_1.html shows it.

    Args:
        cores: jobs at a time; each takes up to 2 GB.
    """
    run_snakemake(cores, "--directory", "demo", "--configfile", str(CONFIG), "--", "pages")
