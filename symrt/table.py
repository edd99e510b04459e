"""Tables and sentences as text, and tables as HTML: how results show themselves at a prompt and in a notebook."""

import html
import re
import textwrap
from collections.abc import Iterable, Sequence
from itertools import zip_longest

from symrt.errors import plain

Row = Sequence[str]
WIDTH = 80
"""Columns of a terminal that has not been made wider."""
TOGETHER = re.compile(r"(?<=\d,) (?=\d)|(?<=\d) (?=(?:%|nm|s)(?!\w))|(?<=…) (?=\S)|(?<=\S) (?=…)")
"""Spaces at which no line ends: in (210, 140), 730 nm, 1 %, 0.01 … 3."""
HARD = "\N{NO-BREAK SPACE}"


def text_table(head: Row, rows: Iterable[Row], *, ruled: bool = False) -> str:
    """Rows below their head, with a line under the head if ruled; cells of columns that are too wide are broken.

    Columns are as wide as their widest cells, and together at most 80 wide, if their words allow it.

    Examples
    --------
    >>> print(text_table(("light", "share"), [("key", "61%"), ("fill", "9%")]))
    light  share
    key    61%
    fill   9%
    """
    every = [[plain(cell, keep="\n") for cell in row] for row in (head, *rows)]
    widths = _widths(list(zip(*every, strict=True)))
    lines: list[list[str]] = []
    for row in every:
        cells = [_broken(cell, width) for cell, width in zip(row, widths, strict=True)]
        parts = zip_longest(*cells, fillvalue="")
        lines.append(["  ".join(map(str.ljust, part, widths)).rstrip() for part in parts])
    first, *body = lines
    rule = ["-" * max(len(part) for one in lines for part in one)] if ruled else []
    return "\n".join([*first, *rule, *(part for one in body for part in one)])


def _widths(columns: Sequence[Row]) -> list[int]:
    """Widths of columns: what their widest cells need, the widest made narrower until all fit beside each other."""
    widths = [max(map(len, column)) for column in columns]
    least = [max(len(word) for cell in column for word in TOGETHER.sub(HARD, cell).split(" ")) for column in columns]
    room = WIDTH - 2 * (len(columns) - 1)
    # What names a row stays whole as long as the other columns can give way.
    for columns_asked in (range(1, len(columns)), range(1)):
        while sum(widths) > room and (loose := [k for k in columns_asked if widths[k] > least[k]]):
            widths[max(loose, key=widths.__getitem__)] -= 1
    return widths


def sentences(lines: Iterable[str]) -> str:
    """Sentences below each other, each broken between words where it is more than 80 wide.

    Examples
    --------
    >>> print(sentences(["One.", "A limit is where the first pixel meets a bound, such as pixel (53, 11) at 730 nm."]))
    One.
    A limit is where the first pixel meets a bound, such as pixel (53, 11) at
    730 nm.
    """
    return "\n".join(part for line in lines for part in _broken(line, WIDTH))


def _broken(text: str, width: int) -> list[str]:
    """A text in lines that are no wider, if its words allow it."""
    kept = TOGETHER.sub(HARD, text)
    lines = textwrap.wrap(kept, width, break_long_words=False, break_on_hyphens=False) or [""]
    return [line.replace(HARD, " ") for line in lines] if len(text) > width else [text]


def html_table(head: Row, rows: Iterable[Row]) -> str:
    """The same for a notebook; what cells hold is text, never markup.

    Examples
    --------
    >>> html_table(("name",), [("a < b",)])
    '<table><tr><th>name</th></tr><tr><td>a &lt; b</td></tr></table>'
    """
    cells = [f"<tr>{''.join(f'<td>{html.escape(cell)}</td>' for cell in row)}</tr>" for row in rows]
    return f"<table><tr>{''.join(f'<th>{html.escape(cell)}</th>' for cell in head)}</tr>{''.join(cells)}</table>"


def percent(share: float) -> str:
    """A share that looks like all, or none, only if it is.

    Examples
    --------
    >>> percent(0.1234), percent(0.99999), percent(0.0001)
    ('12.3%', '> 99.9%', '< 0.1%')
    """
    if 0 < share < 0.001:
        return "< 0.1%"
    return "> 99.9%" if 0.999 < share < 1 else f"{share:.1%}"


def duration(seconds: float) -> str:
    """A time in a unit that is not much larger.

    Examples
    --------
    >>> duration(0.0123), duration(75.0), duration(7300.0)
    ('0.012 s', '75 s', '2 hours')
    """
    for size, word in ((3600, "hours"), (60, "minutes")):
        if seconds >= 2 * size:
            return f"{two_digits(seconds / size)} {word}"
    return f"{two_digits(seconds)} s"


def two_digits(number: float) -> str:
    """A number with two digits, or all of those before the point.

    Examples
    --------
    >>> two_digits(0.0123), two_digits(1234.5)
    ('0.012', '1234')
    """
    return f"{number:.0f}" if number >= 10 else f"{number:.2g}"
