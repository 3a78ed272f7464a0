"""Config files, and the command line that names them: mistakes are reported before Snakemake reads them.

Snakemake ends with a traceback, or names no file. `profiles/default`, which it always reads first, calls `check`.
"""

import contextlib
import json
import sys
from collections.abc import Iterator, Sequence
from difflib import get_close_matches
from pathlib import Path
from typing import Any

import yaml

from stages.config.mistakes import check_keys
from stages.contracts.errors import InputError
from stages.contracts.files import read_text
from stages.contracts.yaml_files import fault_of, line_of

ENDINGS = (".yaml", ".yml", ".json")


def check(arguments: Sequence[str] | None = None) -> None:
    """End with one line if a command line of Snakemake, by default this process's, names a config that is none."""
    words = sys.argv[1:] if arguments is None else list(arguments)
    try:
        files = read_option(words, "--configfile") + read_option(words, "--configfiles")
        for file in files:
            if file.endswith(ENDINGS) or Path(file).exists():
                read_file(Path(file))
            else:
                fix = f"put targets before options, or behind --: `snakemake --configfile {files[0]} -- {file}`"
                raise InputError(
                    file, "is no config file; --configfile takes every word behind it.", fix, code="E-WORDS"
                )
        for word in read_option(words, "--config"):
            if "=" not in word:
                fix = f"put targets before options, or behind --: `snakemake --config KEY=VALUE -- {word}`"
                raise InputError(word, "is no KEY=VALUE; --config takes every word behind it.", fix, code="E-WORDS")
        for default in defaults(Path([".", *read_option(words, "-d"), *read_option(words, "--directory")][-1])):
            read_file(default)
    except InputError as error:
        print(f"error: {error} [{error.code}]", file=sys.stderr)
        sys.exit(1)


def read_option(words: Sequence[str], option: str) -> list[str]:
    """The words that an option takes: `--option=a`, or all up to the next option."""
    found: list[str] = []
    takes = False
    for word in words:
        name, sign, value = word.partition("=")
        if word.startswith("-"):
            takes = name == option and not sign
            found += [value] if name == option and sign else []
        elif takes:
            found.append(word)
    return found


def defaults(folder: Path) -> Iterator[Path]:
    """The config that the Snakefile takes in a working directory; none if it takes its own."""
    yield from [path for path in (folder / "config.yaml", folder / "config/config.yaml") if path.exists()][:1]


def read_file(path: Path) -> dict[str, Any]:
    """The mapping that a config file holds, YAML or JSON.

    Raises:
        InputError: it is not there, is no YAML, gives a key twice, or holds no mapping; file and line are named.
    """
    beside = [file.name for file in path.parent.glob("*") if file.suffix in ENDINGS]
    near = get_close_matches(path.name, beside, n=1, cutoff=0.75)
    fix = f"did you mean '{path.with_name(near[0])}'?" if near else "correct the path"
    text = read_text(path, "it should be text in UTF-8 that you may read" if path.exists() else fix)
    content = None
    with contextlib.suppress(ValueError):
        content = json.loads(text)  # which may have tabs
    if content is None:
        try:
            content = yaml.safe_load(text)
        except yaml.YAMLError as error:
            tab = "\t" in str(error) or "\\t" in str(error)
            fix = "indent with spaces: YAML takes no tabs" if tab else "mend this line, or the one above"
            raise InputError(
                line_of(path, error), f"is no YAML: {fault_of(error)}.", fix, code="E-CONFIG-YAML"
            ) from None
    if not isinstance(content, dict):
        kind = "is empty" if content is None else f"holds a {'list' if isinstance(content, list) else 'value'}"
        raise InputError(path, f"{kind}, no `key: value`.", "docs/config.md has all keys", code="E-CONFIG-YAML")
    check_keys(path)
    return content
