"""Faults of files and arguments, one line each: the file, the key, the rule and the remedy.

Both sides of the waist are given files and arguments, so this stands at the bottom of the house.
"""

import difflib
import inspect
import unicodedata
from collections.abc import Iterable, Sequence
from functools import wraps
from typing import TypeVar

UNSEEN = frozenset({"Cc", "Cf", "Cs", "Co", "Cn", "Zl", "Zp"})
"""Unicode's categories of what controls a terminal, turns or hides letters, ends a line, or is no letter at all."""


SYNONYMS = {
    "center": "centre",
    "texture": "material",
    "color": "material",
    "colour": "material",
    "fov": "field_of_view",
    "look_at": "target",
    "lookat": "target",
    "origin": "position",
    "location": "position",
}
"""Names that other programs and other spellings have for our keys."""

Record = TypeVar("Record", bound=type)


def hinting(record: Record) -> Record:
    """Make a record's class say which keyword was meant, where it is given one that it does not have.

    Examples
    --------
    >>> from dataclasses import dataclass
    >>> @hinting
    ... @dataclass(frozen=True)
    ... class Ball:
    ...     centre: float
    >>> Ball(center=1.0)
    Traceback (most recent call last):
    TypeError: Ball has no 'center': did you mean 'centre'?
    """
    plain = record.__init__  # type: ignore[misc]  # a class's own
    known = [name for name in inspect.signature(plain).parameters if name != "self"]

    @wraps(plain)
    def checked(self: object, *values: object, **named: object) -> None:
        for name in named:
            if name not in known:
                raise TypeError(f"{record.__name__} has no {name!r}: {suggestion(name, known)}")
        plain(self, *values, **named)

    record.__init__ = checked  # type: ignore[misc]
    return record


class SceneError(ValueError):
    r"""A scene or palette file that cannot be used; `faults` has one line for each thing that is wrong with it.

    Examples
    --------
    >>> SceneError("a.toml: camera.width = 0: too small\na.toml: lights: none").faults
    ('a.toml: camera.width = 0: too small', 'a.toml: lights: none')
    """

    @property
    def faults(self) -> tuple[str, ...]:
        """Each fault, a line."""
        return tuple(str(self).splitlines())


def refuse(faults: Iterable[str]) -> None:
    """Raise a ValueError with all the faults, a line each; do nothing if there are none.

    Examples
    --------
    >>> refuse([])
    >>> refuse(["radius = -1: it must be more than 0"])
    Traceback (most recent call last):
    ValueError: radius = -1: it must be more than 0
    """
    lines = list(faults)
    if lines:
        raise ValueError("\n".join(lines))


def require(name: str, value: object, kind: type | tuple[type, ...], remedy: str) -> None:
    """Refuse an argument of another kind than a function takes, and say what makes one that it takes.

    Examples
    --------
    >>> require("palette", "macbeth", dict, "load_palettes(path)")
    Traceback (most recent call last):
    TypeError: palette is a str, 'macbeth': give load_palettes(path)
    """
    if isinstance(value, type):
        raise TypeError(f"{name} is the class {value.__name__}: give {remedy}")
    if not isinstance(value, kind):
        found = type(value).__name__
        article = "an" if found[0] in "aeiou" else "a"
        raise TypeError(f"{name} is {article} {found}, {shown(value)}: give {remedy}")


def require_list(name: str, values: object, example: str) -> None:
    """Refuse one thing, or a mapping, where a function takes a list.

    Examples
    --------
    >>> require_list("scales", 3, "[Scale('brass')]")
    Traceback (most recent call last):
    TypeError: scales is 3: give a list, such as [Scale('brass')]
    """
    if isinstance(values, str) or not isinstance(values, Sequence):
        what = f"the class {values.__name__}" if isinstance(values, type) else shown(values)
        raise TypeError(f"{name} is {what}: give a list, such as {example}")


def shown(value: object) -> str:
    r"""A value as it may stand in a one-line message: on one line, and cut when it is long.

    Examples
    --------
    >>> shown("two\nlines"), shown(10**5000), shown((0, 1.5, 0))
    ("'two\\nlines'", 'an integer of more than 40 digits', '[0, 1.5, 0]')
    """
    if isinstance(value, int) and not isinstance(value, bool) and abs(value) >= 10**40:
        return "an integer of more than 40 digits"
    if isinstance(value, dict):
        return "a table"
    if isinstance(value, list | tuple):
        items = ", ".join(shown(item) if not isinstance(item, list | tuple) else "[…]" for item in value[:6])
        return f"[{items}{', …' if len(value) > 6 else ''}]"
    text = repr(value[:60] if isinstance(value, str) else value)
    return text if len(text) <= 70 else text[:66] + "…"


def plain(text: str, keep: str = "") -> str:
    r"""A text without characters that a terminal obeys, or that turn or hide others: they are shown as escapes.

    Parameters
    ----------
    keep
        Characters that may stay, such as the ends of lines.

    Examples
    --------
    >>> print(plain("sun\x1b]0;owned\x07"), plain("two\nlines"), plain("two\nlines", keep="\n"))
    sun\x1b]0;owned\x07 two\nlines two
    lines
    """
    return "".join(
        c.encode("unicode_escape").decode() if c not in keep and unicodedata.category(c) in UNSEEN else c for c in text
    )


def require_plain(what: str, text: str) -> None:
    r"""Refuse a text that is to stand in a line, a table or a figure and holds more than what is seen of it.

    Examples
    --------
    >>> require_plain("title", "a\x1b[2Jprinter")
    Traceback (most recent call last):
    ValueError: title is 'a\x1b[2Jprinter': no control characters: give one line of text
    """
    if plain(text) != text:
        raise ValueError(f"{what} is {shown(text)}: no control characters: give one line of text")


def suggestion(word: str, known: Iterable[str]) -> str:
    """A remedy for a word that is not known: the nearest known one, or all of them.

    Examples
    --------
    >>> suggestion("raduis", ["centre", "radius"])
    "did you mean 'radius'?"
    >>> suggestion("x", ["centre", "radius"])
    "there are 'centre', 'radius'"
    """
    known = list(known)
    near = [SYNONYMS[word]] if SYNONYMS.get(word) in known else difflib.get_close_matches(word[:64], known, n=1)
    if near:
        return f"did you mean {near[0]!r}?"
    return f"there are {', '.join(map(repr, known))}" if known else "there are none"
