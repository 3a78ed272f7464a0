"""Counts and sizes in words for people."""

from collections.abc import Iterable


def count(number: int, noun: str, plural: str = "") -> str:
    """'1 run', '2 runs'; `plural`: where it is not the noun with an s."""
    return f"{number} {noun if number == 1 else plural or f'{noun}s'}"


def describe_size(size: Iterable[float]) -> str:
    """Depth, width and height, metres, as people say them: '80 wide × 60 deep × 90 cm high'."""
    depth, width, height = (f"{100 * extent:.0f}" for extent in size)
    return f"{width} wide × {depth} deep × {height} cm high"
