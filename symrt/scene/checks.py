"""Checks of a record's values: each yields one line a fault, with key, value, rule and remedy."""

import math
import numbers
from collections.abc import Iterator
from typing import Any

from symrt.errors import shown
from symrt.geometry import Triple
from symrt.symbols import NAME

Number = int | float


def check_number(key: str, value: object) -> Iterator[str]:
    """Check that a value is a finite number.

    Examples
    --------
    >>> list(check_number("radius", float("inf")))
    ['radius = inf: numbers must be finite; write an ordinary number, such as 1.5']
    """
    if isinstance(value, bool) or not isinstance(value, numbers.Real):
        yield f"{key} = {shown(value)}: it must be a number; write it without quotes, such as 1.5"
    elif not _finite(value):
        yield f"{key} = {shown(value)}: numbers must be finite; write an ordinary number, such as 1.5"


def check_whole(key: str, value: object, most: int, least: int = 1) -> Iterator[str]:
    """Check that a value is a whole number from `least` to `most`.

    Examples
    --------
    >>> list(check_whole("width", 0, 32768))
    ['width = 0: it must be a whole number from 1 to 32768']
    """
    whole = isinstance(value, numbers.Integral) and not isinstance(value, bool)
    if not whole or not least <= int(value) <= most:  # type: ignore[call-overload]
        yield f"{key} = {shown(value)}: it must be a whole number from {least} to {most}"


def check_triple(key: str, value: Any, *, direction: bool = False) -> Iterator[str]:
    """Check that a value is three finite numbers, and not all zero if they are a direction.

    Examples
    --------
    >>> list(check_triple("up", (0, 0, 0), direction=True))
    ['up = [0, 0, 0]: a direction must not be zero; write one such as [0, 1, 0]']
    """
    try:
        parts = list(value)
    except TypeError:
        parts = []
    if isinstance(value, str) or len(parts) != 3:
        yield f"{key} = {shown(value)}: it must be three numbers, x, y and z; write them as [0, 1, 0]"
        return
    faults = [fault for i, part in enumerate(parts) for fault in check_number(f"{key}[{i}]", part)]
    yield from faults
    if direction and not faults and not any(float(part) for part in parts):
        yield f"{key} = {shown(parts)}: a direction must not be zero; write one such as [0, 1, 0]"


def check_name(key: str, value: object) -> Iterator[str]:
    """Check that a value is a name that formulas and palettes can use.

    Examples
    --------
    >>> list(check_name("name", "deep_sea")), len(list(check_name("name", "deep sea")))
    ([], 1)
    """
    if not isinstance(value, str) or not NAME.fullmatch(value):
        yield (
            f"{key} = {shown(value)}: a name is a letter, then letters, digits or underscores, at most 64; "
            "rename it, such as 'deep_sea2'"
        )


def floats(value: Triple) -> tuple[float, float, float]:
    """Three numbers of any kind as floats.

    Examples
    --------
    >>> floats((0, 1, 2.5))
    (0.0, 1.0, 2.5)
    """
    x, y, z = (float(part) for part in value)
    return x, y, z


def settle(record: object, **values: object) -> None:
    """Replace fields of a frozen record while it is being made, in ``__post_init__`` only."""
    for name, value in values.items():
        object.__setattr__(record, name, value)


def _finite(value: numbers.Real) -> bool:
    try:
        return math.isfinite(float(value))
    except OverflowError:  # an integer beyond the largest float
        return False
