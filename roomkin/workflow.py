"""Snakemake with our rules, in the folder where the user is.

What can be asked for: words of their own, and the commands of stages and packages, read from the code as text.
"""

import ast
import os
import re
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

from roomkin.stages.contracts.errors import InputError
from roomkin.stages.plugins import PACKAGES

COMMANDS = {
    "picture": "a picture of yours: what it shows, scenes of cousins, a page of them",
    "correct": "open the page on which a scene is put right",
    "import": "look at a folder of models of yours, and make them part of the library",
    "score": "scenes of any method against the truth of a set of rooms",
    "demo": "a room of ours, its cousins, scenes to turn, in two minutes",
    "check": "what this machine lacks, and what mends it",
    "completion": "for the Tab key of bash and zsh",
}
ELSEWHERE = {
    "import": ["roomkin.plugins.importing", "import"],
    "check": ["roomkin.plugins.ops.doctor"],
    "score": ["roomkin.plugins.scorecard", "score"],
}


def list_homes() -> dict[str, str]:
    """Python packages with a command line, by the names of their stages and packages."""
    folders = [PACKAGES.parent / "stages", PACKAGES]
    found = [file.parent for folder in folders for file in sorted(folder.glob("*/__main__.py"))]
    return {folder.name: f"roomkin.{folder.parent.name}.{folder.name}" for folder in found}


def list_commands(home: str) -> list[str]:
    """The commands of a package, the keys of `main(package, {"match": ...})`; none: its command line is its own."""
    calls = ast.walk(ast.parse(_read(home, "__main__.py")))
    tables = [node.args[1] for node in calls if isinstance(node, ast.Call) and len(node.args) == 2]
    return [name for table in tables if isinstance(table, ast.Dict) for name in ast.literal_eval(table)]


def describe(home: str) -> str:
    """The first sentence of a package's docstring."""
    text = (ast.get_docstring(ast.parse(_read(home, "__init__.py"))) or "").partition("\n")[0]
    return re.split(r"\.(?: |$)| \(", text.removeprefix(f"Stage `{home.rpartition('.')[2]}`: "))[0]


def _read(home: str, name: str) -> str:
    return Path(PACKAGES.parent, *home.split(".")[1:], name).read_text(encoding="utf-8")


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
