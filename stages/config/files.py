"""Config files, named on a command line: mistakes are told before Snakemake reads them; images of containers.

Snakemake ends with a traceback, or names no file. `profiles/default`, which it always reads first, calls `check`.
"""

import json
import re
import sys
from argparse import ArgumentParser
from collections.abc import Iterator, Sequence
from contextlib import suppress
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import Any

import yaml
from pydantic import Field, field_validator

from roomkin.stages.contracts.errors import InputError, fault_of, line_of
from roomkin.stages.contracts.files import read_text
from roomkin.stages.contracts.section import Section

ENDINGS = (".yaml", ".yml", ".json")


def check(arguments: Sequence[str] | None = None) -> None:
    """End with a line if Snakemake's command line, by default this process's, names no cores or no config."""
    parser = ArgumentParser(add_help=False, allow_abbrev=False)
    parser.add_argument("--configfile", "--configfiles", nargs="*", action="extend", default=[])
    parser.add_argument("--config", nargs="*", action="extend", default=[])
    parser.add_argument("-d", "--directory", default=".", type=Path)
    parser.add_argument("-c", "--cores", nargs="?", default="all")
    words = parser.parse_known_args(arguments)[0]
    try:
        if words.cores and re.fullmatch(r"-?\d+", words.cores) and int(words.cores) < 1:
            what = "is no number of jobs: nothing would ever run."
            raise InputError(f"--cores {words.cores}", what, "--cores 2", code="E-WORDS")
        for file in words.configfile:
            if not file.endswith(ENDINGS) and not Path(file).exists():
                what = "is no config file; --configfile takes every word behind it."
                line = f"snakemake --configfile {words.configfile[0]} -- {file}"
                fix = f"put targets before options, or behind --: `{line}`"
                raise InputError(file, what, fix, code="E-WORDS")
            read_file(Path(file))
        for word in words.config:
            if "=" not in word:
                fix = f"put targets before options, or behind --: `snakemake --config KEY=VALUE -- {word}`"
                raise InputError(word, "is no KEY=VALUE; --config takes every word behind it.", fix, code="E-WORDS")
        for default in defaults(words.directory):
            read_file(default)
    except InputError as error:
        print(f"error: {error} [{error.code}]", file=sys.stderr)
        sys.exit(1)


def defaults(folder: Path) -> Iterator[Path]:
    """The config that the Snakefile takes in a working directory; none if it takes its own."""
    yield from [path for path in (folder / "config.yaml", folder / "config/config.yaml") if path.exists()][:1]


def read_file(path: Path) -> dict[str, Any]:
    """The mapping that a config file holds, YAML or JSON.

    Raises:
        InputError: it is not there, is no YAML, gives a key twice, or holds no mapping; file and line are named.
    """
    text = read_text(path, "it should be text in UTF-8 that you may read" if path.exists() else "")
    try:
        content = json.loads(text)  # which may have tabs
    except ValueError:
        try:
            content = yaml.safe_load(text)
        except yaml.YAMLError as error:
            tab = "\t" in str(error) or "\\t" in str(error)
            fix = "indent with spaces: YAML takes no tabs" if tab else "mend this line, or the one above"
            what = f"is no YAML: {fault_of(error)}."
            raise InputError(line_of(path, error), what, fix, code="E-CONFIG-YAML") from None
    if not isinstance(content, dict):
        kind = "is empty" if content is None else f"holds a {'list' if isinstance(content, list) else 'value'}"
        raise InputError(path, f"{kind}, no `key: value`.", "docs/config.md has all keys", code="E-CONFIG-YAML")
    with suppress(yaml.YAMLError):  # tabs
        _check_keys(path, yaml.compose(text, Loader=yaml.CSafeLoader))
    return content


def _check_keys(path: Path, root: yaml.Node | None) -> None:
    """Refuse a key that is given twice: the last would win without a word."""
    queue = [root]
    for node in queue:
        inner = node.value if isinstance(node, yaml.SequenceNode) else []
        if isinstance(node, yaml.MappingNode):
            lines: dict[str, int] = {}
            for key, value in node.value:
                name, line = str(key.value), key.start_mark.line + 1
                if name in lines and name != "<<":
                    what = f"'{name}' stands in line {lines[name]}, too."
                    raise InputError(f"{path}:{line}", what, "keep one", code="E-CONFIG-KEY-TWICE")
                lines[name] = line
                inner.append(value)
        queue += [each for each in inner if each not in queue]


ROOT = Path(__file__).resolve().parents[2]
LOCAL = "localhost/"  # of images that podman or docker built here


class ContainersConfig(Section):
    """One name for the images of all environment families."""

    image: str = Field(
        LOCAL + "acdc-{family}:{tag}",
        description="Image of a rule. {family}: simulation, learning or report; {tag}: digest of the "
        "Containerfile and of what it copies, so that an old image is not taken for a new one. "
        "For yours in a registry: docker://REGISTRY/acdc-{family}:{tag}.",
    )

    @field_validator("image")
    @classmethod
    def _of_families(cls, image: str) -> str:
        if "{family}" not in image:
            raise ValueError("names no {family}: simulation, learning and report have an image each")
        return image

    @property
    def template(self) -> str:
        """The image as podman and docker name it, with {family} to be filled in."""
        return self.image.replace("{tag}", tag()).removeprefix("docker://")

    def _apptainer(self, family: str) -> str:
        """The value of the directive `container:` of a family's rules: local images are files in images/."""
        image = self.image.replace("{tag}", tag()).replace("{family}", family)
        if not image.startswith(LOCAL):
            return image
        return f"images/{image.removeprefix(LOCAL).replace(':', '-').replace('/', '-')}.sif"

    @property
    def simulation(self) -> str:
        """Of rules that render or simulate."""
        return self._apptainer("simulation")

    @property
    def learning(self) -> str:
        """Of rules that train or match."""
        return self._apptainer("learning")

    @property
    def report(self) -> str:
        """Of rules that only make tables and pages."""
        return self._apptainer("report")


@cache
def tag() -> str:
    """Digest of the Containerfile and of what it copies; "none" where the package is installed without them."""
    recipe = ROOT / "containers/Containerfile"
    text = recipe.read_text() if recipe.is_file() else ""
    files = [recipe, *(ROOT / name for name in re.findall(r"^COPY (\S+)", text, re.MULTILINE))]
    if not all(path.is_file() for path in files):
        return "none"
    digest = sha256()
    for path in files:
        digest.update(f"{path.relative_to(ROOT)} {sha256(path.read_bytes()).hexdigest()}\n".encode())
    return digest.hexdigest()[:12]


if __name__ == "__main__":
    print(ContainersConfig().template)
