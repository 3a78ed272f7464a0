"""Mistakes in a YAML file that a person wrote, by line."""

from pathlib import Path

import yaml


def line_of(path: Path, error: yaml.YAMLError) -> str:
    """The file, with the line where reading it stopped if the error knows."""
    mark = getattr(error, "problem_mark", None) or getattr(error, "context_mark", None)
    return f"{path}:{mark.line + 1}" if mark else str(path)


def fault_of(error: yaml.YAMLError) -> str:
    """The error of a parser in one line; with where it began, as what is left open is found out later only."""
    what = getattr(error, "problem", None) or getattr(error, "reason", None) or str(error)
    began, context = getattr(error, "context_mark", None), getattr(error, "context", None)
    since = f", {context} of line {began.line + 1}" if began and context else ""
    return " ".join(f"{what}{since}".split())
