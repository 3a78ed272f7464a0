"""Snakemake with our rules, in the folder where the user is."""

import os
import sys
from pathlib import Path

from roomkin.stages.contracts.errors import InputError
from roomkin.stages.plugins import PACKAGES

HOME = PACKAGES.parent  # of Snakefile, rules and config


def run_snakemake(cores: int, *words: str) -> None:
    """Become Snakemake, so that it gets what is typed and its exit code is ours.

    Raises:
        InputError: it is not in this environment.
    """
    program = Path(sys.executable).with_name("snakemake")
    if not program.is_file():
        mend = "pip install 'roomkin[workflow]'"
        raise InputError(program, "is not there, and this command needs Snakemake.", mend, code="E-COMMAND-MISSING")
    sys.stdout.flush()
    os.execv(program, [str(program), "--snakefile", str(HOME / "Snakefile"), "--cores", str(cores), *words])
