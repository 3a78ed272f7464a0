"""Numbers as text."""

import math
from collections.abc import Mapping
from typing import Any

NOT_RUN = "not run"
NOTHING = "–"


def number(value: Any, digits: int) -> str:
    """A number with fixed digits; empty for a missing one."""
    return "" if value is None or value != value or math.isinf(value) else f"{value:.{digits}f}"


def spread(mean: Any, std: Any, digits: int) -> str:
    """'mean ± std', without the part that is missing."""
    middle, width = number(mean, digits), number(std, digits)
    return f"{middle} ± {width}" if middle and width else middle


def percent(mean: Any, std: Any = None) -> str:
    """A rate in percent, '92 %' or '92 ± 4 %'. Only exact rates read 0 or 100: 320 of 321 is '99.7 %'."""
    if mean is None or mean != mean:
        return ""
    value = 100 * mean
    exact = value in (0, 100)
    digits = next((digits for digits in (0, 1) if exact or round(value, digits) not in (0, 100)), None)
    if digits is None:
        return "> 99.9 %" if mean > 0.5 else "< 0.1 %"
    return f"{spread(value, None if std is None else 100 * std, digits)} %"


def span(low: float, high: float) -> str:
    """An interval of rates in percent, '48–74', rounded outwards; with signs if it reaches below zero."""
    ends = math.floor(round(100 * low, 9)), math.ceil(round(100 * high, 9))
    return f"{ends[0]:+d} to {ends[1]:+d}".replace("-", "−") if low < 0 else f"{ends[0]}–{ends[1]}"


def interval(row: Mapping[str, Any], prefix: str = "") -> str:
    """That of a row, its ends in the columns `<prefix>low` and `<prefix>high`."""
    return f"[{span(row[f'{prefix}low'], row[f'{prefix}high'])}]"


def points(difference: float) -> str:
    """A difference of rates in percentage points, '+13 points'."""
    return f"{100 * difference:+.0f} points".replace("-", "−").replace("+0 ", "0 ").replace("−0 ", "0 ")


def distance_from_twin(encoder: str) -> str:
    """'distance from the twin (hog features)'; without an encoder, as it is known."""
    return "distance from the twin" + f" ({encoder} features)" * bool(encoder)


def cell(value: str, remark: str = "", published: str = "") -> str:
    """A table cell, a line each: our value, a remark (its interval, its n), the paper's value."""
    return "\n".join(part for part in (value, remark, published and f"paper {published}") if part)
