"""`roomkin config`: write config/schema.json and docs/config.md in a clone; `show [FILE ...]`: print all keys.

`show` prints the default run with what the files change, later ones over earlier ones.
"""

import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from roomkin.stages.config.packages import find_packages


def show(files: Sequence[str]) -> int:
    """Print the whole config of a run with these files; a mistake is a line. Returns the exit code."""
    from roomkin.stages.config.model import read_files
    from roomkin.stages.config.reference import write_yaml
    from roomkin.stages.contracts.errors import InputError

    try:
        print(write_yaml(read_files([Path(file) for file in files])), end="")
    except InputError as error:
        print(f"error: {error} [{error.code}]", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    if {"-h", "--help"}.intersection(sys.argv[1:]):
        sys.exit(print(__doc__))
    if sys.argv[1:2] == ["show"]:
        sys.exit(show(sys.argv[2:]))
    if sys.argv[1:] or not Path("config/schema.json").is_file():
        sys.exit(__doc__)
    for package in find_packages().values():
        if package.facts:
            subprocess.run([sys.executable, "-m", *package.facts.split()], check=True)
    from roomkin.stages.config.reference import write

    write(Path.cwd())
