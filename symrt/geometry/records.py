"""What the records of shapes share: numbers as a file writes them, checked and turned into arrays (step 1)."""

from numbers import Real
from typing import Any

import numpy as np
from jaxtyping import Float

from symrt.arrays import Point, length

Triple = tuple[float | int, float | int, float | int]
"""A point or a vector in a record, in scene units."""

LARGEST = 1e60
"""Largest coordinate, length or distance; with it and its inverse, fourth powers neither overflow nor underflow."""


def column(triple: Triple) -> Float[np.ndarray, "3 1"]:
    """A record's point or vector as one column, to stand against many rays.

    Examples
    --------
    >>> column((1, 2, 3)).shape
    (3, 1)
    """
    return np.array(triple, dtype=float).reshape(3, 1)


def finite(owner: str, **values: Any) -> None:
    """Refuse values of a record that are no numbers, or nan, infinite, or so large that their powers overflow.

    Examples
    --------
    >>> finite("sphere", radius=float("inf"))
    Traceback (most recent call last):
    ValueError: sphere: radius = inf: it must be finite
    """
    for name, value in values.items():
        # Plain numbers need no array; nan compares as larger than any.
        parts = value if isinstance(value, tuple) else (value,)
        if all(type(part) in (int, float) and abs(part) <= LARGEST for part in parts):
            continue
        for part in np.asarray(value, dtype=object).ravel():
            if isinstance(part, bool | np.bool) or not isinstance(part, Real):
                raise ValueError(  # noqa: TRY004 -- a bad field is a bad value
                    f"{owner}: {name} = {value!r}: it must be made of numbers; write them as 1.5"
                )
        if not np.all(np.isfinite(value)):
            raise ValueError(f"{owner}: {name} = {value}: it must be finite")
        if np.abs(value).max() > LARGEST:
            raise ValueError(f"{owner}: {name} = {value}: it must be at most {LARGEST}; choose a larger unit of length")


def triples(owner: str, **values: Any) -> None:
    """Refuse points and vectors of a record that are not three numbers.

    Examples
    --------
    >>> triples("box", size=4)
    Traceback (most recent call last):
    ValueError: box: size = 4: it must be three numbers, x, y and z; write them as (0, 1, 0)
    """
    for name, value in values.items():
        if isinstance(value, str) or np.shape(np.asarray(value, dtype=object)) != (3,):
            raise ValueError(
                f"{owner}: {name} = {value!r}: it must be three numbers, x, y and z; write them as (0, 1, 0)"
            )


def positive(owner: str, **values: float | int) -> None:
    """Refuse lengths of a record that are not positive, or so small that their powers underflow.

    Examples
    --------
    >>> positive("sphere", radius=0)
    Traceback (most recent call last):
    ValueError: sphere: radius = 0: it must be greater than 0
    """
    for name, value in values.items():
        if not value > 0:
            raise ValueError(f"{owner}: {name} = {value}: it must be greater than 0")
        if value < 1 / LARGEST:
            raise ValueError(
                f"{owner}: {name} = {value}: it must be at least {1 / LARGEST}; choose a smaller unit of length"
            )


def has_direction(owner: str, **vectors: Triple) -> None:
    """Refuse vectors of a record that are zero, or as good as zero.

    Examples
    --------
    >>> has_direction("plane", normal=(0, 0, 0))
    Traceback (most recent call last):
    ValueError: plane: normal = (0, 0, 0): it must not be zero
    """
    for name, vector in vectors.items():
        if float(length(column(vector))[0]) < 1 / LARGEST:
            raise ValueError(f"{owner}: {name} = {vector}: it must not be zero")


def moved(triple: Triple, by: Point) -> Triple:
    """A record's point, translated.

    Examples
    --------
    >>> moved((1, 2, 3), np.array([1.0, 0.0, 0.0]))
    (2.0, 2.0, 3.0)
    """
    x, y, z = (float(a) + float(b) for a, b in zip(triple, by, strict=True))
    return x, y, z
