"""How files of this package are checked."""

from plugins.films.contract import read_films

CHECKS = {"films": read_films}
