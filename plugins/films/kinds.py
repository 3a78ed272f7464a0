"""`films.json`: the episodes that were filmed, as animated WebP files beside it."""

from pathlib import Path
from typing import Literal

from pydantic import Field, model_validator

from roomkin.stages.contracts.errors import InputError
from roomkin.stages.contracts.files import Contract, read_json
from roomkin.stages.contracts.types import Count, Finite, Id, Seed, check_unique


class Film(Contract):
    """One filmed episode."""

    role: Id = Field(description="role of the asset: twin, cousin_1, ...")
    asset: Id
    seed: Seed = Field(description="of the initial state")
    success: bool
    steps: Count
    opened: Finite = Field(description="fraction of the joint's range at the end")
    file: Id = Field(description="name of the animated WebP beside films.json")


class Films(Contract):
    """`films.json`."""

    version: Literal[1] = 1
    films: list[Film]

    @model_validator(mode="after")
    def _check_files(self) -> "Films":
        check_unique("films: files", [film.file for film in self.films])
        return self


def read_films(path: Path) -> Films:
    """The films of a folder.

    Raises:
        InputError: films.json breaks its contract, or a film that it names is not beside it.
    """
    films = read_json(Films, path)
    for film in films.films:
        if not path.with_name(film.file).is_file():
            what = f"names {film.file}, which is not beside it."
            raise InputError(path, what, "make the films again", code="E-FILE-MISSING")
    return films


CHECKS = {"films": read_films}
