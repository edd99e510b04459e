"""A table as text and as HTML: how results show themselves at a prompt and in a notebook."""

import html
from collections.abc import Iterable, Sequence

__all__ = ["html_table", "percent", "text_table"]

Row = Sequence[str]


def text_table(head: Row, rows: Iterable[Row], *, ruled: bool = False) -> str:
    """Rows below their head, each column as wide as its widest cell; with a line under the head if ruled.

    Examples
    --------
    >>> print(text_table(("light", "share"), [("key", "61%"), ("fill", "9%")]))
    light  share
    key    61%
    fill   9%
    """
    every = [head, *rows]
    widths = [max(map(len, column)) for column in zip(*every, strict=True)]
    lines = ["  ".join(map(str.ljust, row, widths)).rstrip() for row in every]
    return "\n".join([lines[0], "-" * max(map(len, lines)), *lines[1:]] if ruled else lines)


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
