"""Snakemake with our rules, in the folder where the user is."""

import os
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

from roomkin.stages.contracts.errors import InputError
from roomkin.stages.plugins import PACKAGES

HOME = PACKAGES.parent  # of Snakefile, rules and config


def run_snakemake(cores: int, *words: str, then: Callable[[], None] | None = None) -> None:
    """Become Snakemake, so that it gets what is typed and its exit code is ours.

    Args:
        cores: jobs at a time.
        words: targets and options.
        then: what follows a run that ended well; Snakemake then runs beside this process.

    Raises:
        InputError: it is not in this environment.
    """
    program = Path(sys.executable).with_name("snakemake")
    if not program.is_file():
        mend = "pip install 'roomkin[workflow]'"
        raise InputError(program, "is not there, and this command needs Snakemake.", mend, code="E-COMMAND-MISSING")
    line = [str(program), "--snakefile", str(HOME / "Snakefile"), "--cores", str(cores), *words]
    sys.stdout.flush()
    if then is None:
        os.execv(program, line)
    else:
        before = signal.signal(signal.SIGINT, lambda *_: None)  # Ctrl-C is Snakemake's, which gets it, too
        code = subprocess.run(line).returncode
        signal.signal(signal.SIGINT, before)
        if code:
            sys.exit(code if code > 0 else 128 - code)
        then()
