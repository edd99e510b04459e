"""Values in the header of a file, each taken for what it should be, or refused."""

from collections.abc import Iterator
from typing import Any

from symrt.errors import shown


def text_of(value: Any) -> str:
    """A text."""
    if not isinstance(value, str):
        raise ValueError(f"{shown(value)} is not a text")  # noqa: TRY004 -- what a file says
    return value


def number_of(value: Any) -> float:
    """A number, as a float."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ValueError(f"{shown(value)} is not a number")  # noqa: TRY004 -- as above
    return float(value)


def count_of(value: Any) -> int:
    """A whole number from 0 that an array's index holds."""
    if type(value) is not int or not 0 <= value < 1 << 31:
        raise ValueError(f"{shown(value)} is not a whole number from 0")
    return value


def size_of(value: Any) -> int:
    """A whole number from 0, however large."""
    if type(value) is not int or value < 0:
        raise ValueError(f"{shown(value)} is not a whole number from 0")
    return value


def list_of(value: Any) -> list[Any]:
    """A list."""
    if not isinstance(value, list):
        raise ValueError(f"{shown(value)} is not a list")  # noqa: TRY004 -- as above
    return value


def table_of(value: Any) -> Iterator[tuple[str, Any]]:
    """The items of a table."""
    if not isinstance(value, dict):
        raise ValueError(f"{shown(value)} is not a table")  # noqa: TRY004 -- as above
    yield from value.items()
