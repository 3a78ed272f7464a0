"""`python -m reference`: docs/architecture.md and its pictures, read off the code (`make reference`)."""

import sys
from pathlib import Path

from reference import data, rooms, sections

ARCHITECTURE = """\
# Architecture

A stage is a command line, `roomkin <stage> <command>`, that reads files and writes files. Snakemake calls it
by a rule; it knows nothing of Snakemake, and of other stages only their files. This page is written from the code by
`make reference`.

## From file to file

The rules of the default run, each with the files that it writes. An arrow goes from the maker of a file to its reader;
arrows that follow from others are left out, and so is the report, which reads everything.
[Files between stages](contracts.md) says what is in each file.

![The rules and their files](images/data.svg)

## From folder to folder

The folders of `stages/`. An arrow goes from a folder to one that it imports; what is imported by way of another
has no arrow. Nothing imports upward. `stages/` is the core: what the paper needs, from a picture to its tables.
A folder of `plugins/` is a package beside it, whole: code, section of the config, rules, tests. The core imports no
package and runs without any; `packages` in the [config](config.md) says which are on.

![The folders and their imports](images/rooms.svg)

{table}

## From the paper to the code

Files and functions that follow a section of its appendix, by the first lines of their docstrings.

{sections}
"""


def generate(root: Path) -> dict[str, str]:
    """Contents of the written files by their path."""
    return {
        "docs/architecture.md": ARCHITECTURE.format(table=rooms.table(root), sections=sections.table(root)),
        "docs/images/data.svg": data.picture(root),
        "docs/images/rooms.svg": rooms.picture(root),
    }


if __name__ == "__main__":
    if sys.argv[1:]:
        sys.exit(__doc__)
    for name, text in generate(Path.cwd()).items():
        Path(name).write_text(text, encoding="utf-8")
