"""The files of this run, as its rules declared them: the page looks at nothing else."""

from collections.abc import Iterable, Iterator
from pathlib import Path

from roomkin.stages.contracts.errors import InputError
from roomkin.stages.tables.rows import sort_key


class RunFiles:
    """Finds declared files by the end of their path, in the fixed layout of `results/`."""

    def __init__(self, paths: Iterable[Path], images: dict[str, Path] | None = None) -> None:
        """`images`: room -> the picture that went in, which lies outside `results/` for the user's own rooms.

        Raises:
            InputError: a declared file is not there.
        """
        self.images = images or {}
        self._paths = sorted({Path(path) for path in paths}, key=lambda path: sort_key(str(path)))
        for path in (*self._paths, *self.images.values()):
            if not path.exists():
                what = "no such file."
                raise InputError(path, what, "run the workflow: snakemake --cores 2 all", code="E-FILE-MISSING")

    def find_all(self, pattern: str) -> list[Path]:
        """Files whose path ends like `pattern` ('*' stands for one name), in natural order."""
        return [path for path in self._paths if path.match(pattern)]

    def find_first(self, pattern: str) -> Path | None:
        """The first such file, None if the run declared none."""
        return next(iter(self.find_all(pattern)), None)

    def names(self, pattern: str, level: int) -> Iterator[str]:
        """Names of the folder `level` above the files that match, each once, in order."""
        yield from dict.fromkeys(path.parents[level].name for path in self.find_all(pattern))
