"""Films of demonstrations and rollouts."""

from dataclasses import dataclass
from pathlib import Path

from plugins.films.contract import Film
from plugins.films.contract import read_films as read_list
from plugins.report.album import Album, Animation
from stages.contracts.archives import unpack
from stages.tables.order import title
from stages.tables.text import percent


@dataclass(frozen=True)
class FilmedAsset:
    """What was filmed on one asset: the first film is shown, the others on demand."""

    role: str
    films: list[tuple[str, Animation]]


def caption(film: Film) -> str:
    """'success after 23 steps' or 'failure, opened 12 % in 100 steps'."""
    if film.success:
        return f"success after {film.steps} steps"
    return f"failure, opened {percent(max(0.0, film.opened))} in {film.steps} steps"


def read_films(archive: Path | None, whose: str, album: Album) -> list[FilmedAsset]:
    """The films of a films.zip, by asset, in their order.

    Raises:
        InputError: the list of films is broken, or a film is missing.
    """
    if archive is None:
        return []
    folder = unpack(archive, "make the films again")
    cells: dict[str, FilmedAsset] = {}
    for film in read_list(folder / "films.json").films:
        alt = f"{whose} on {title(film.role)}: {caption(film)}"
        moving = album.film(folder / film.file, alt)
        cells.setdefault(film.role, FilmedAsset(film.role, [])).films.append((caption(film), moving))
    return list(cells.values())
