"""How files of this package are checked."""

from roomkin.plugins.films.contract import read_films

CHECKS = {"films": read_films}
