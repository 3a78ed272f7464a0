"""`roomkin COMMAND`, `roomkin STAGE COMMAND`; each has `--help`."""

import runpy
import sys
from pathlib import Path

from roomkin.stages.cli import main
from roomkin.workflow import COMMANDS, ELSEWHERE, describe, list_homes


def start() -> None:
    """Run the command in `sys.argv`; only what it needs is imported."""
    word, homes = sys.argv[1] if sys.argv[1:] else "", list_homes()
    sys.path.append(str(Path.cwd()))  # as for `python -m`: packages of the user may lie there
    if word not in ELSEWHERE and word not in homes:
        more = "".join(f"  {name:<18} {describe(home)}\n" for name, home in homes.items())
        main("roomkin", COMMANDS, f"\nOf stages and packages, roomkin NAME COMMAND:\n{more}", also=homes)
        return
    module, *words = ELSEWHERE.get(word) or [homes[word]]
    sys.argv = [word, *words, *sys.argv[2:]]
    runpy.run_module(module, run_name="__main__")


if __name__ == "__main__":
    start()
