"""What all figures share: ink, captions, and a figure as a file."""

import textwrap
from io import BytesIO
from typing import Any

from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke

__all__ = [
    "ABOVE",
    "BELOW",
    "FEASIBLE",
    "GREY",
    "HAIR",
    "INK",
    "NAME",
    "Drawing",
    "caption",
    "headline",
    "png",
    "wrapped",
]

INK, GREY, HAIR = "#1a1a1a", "#5f646b", "#9aa3b0"
ABOVE, BELOW, FEASIBLE = "#D55E00", "#0072B2", "#009E73"
"""Vermilion, blue and bluish green of Okabe and Ito's set, which colour-blind readers can tell apart."""
NAME: dict[str, Any] = {"color": INK, "zorder": 8, "path_effects": [withStroke(linewidth=2.5, foreground="white")]}
"""How a name is written over lines: with a white rim."""


class Drawing(Figure):
    """A figure that shows itself in a notebook, with or without matplotlib's own machinery for that."""

    def _repr_png_(self) -> bytes:
        return png(self, dpi=96)


def png(figure: Figure, dpi: int = 160) -> bytes:
    """A figure as the bytes of a PNG file.

    Examples
    --------
    >>> png(Figure(figsize=(1, 1)))[1:4]
    b'PNG'
    """
    buffer = BytesIO()
    figure.savefig(buffer, format="png", dpi=dpi)
    return buffer.getvalue()


def headline(figure: Figure, text: str) -> None:
    """The figure's name, at its upper left."""
    inch = 1 / figure.get_figheight()
    figure.suptitle(text, x=0.02, y=1 - 0.18 * inch, ha="left", va="top", fontsize=13, weight="bold", color=INK)


def caption(figure: Figure, text: str) -> None:
    """What the figure is measured against and what in it is modelled, at its foot."""
    inch = 1 / figure.get_figheight()
    figure.text(0.02, 0.12 * inch, text, fontsize=8.5, color=GREY, va="bottom", linespacing=1.4)


def wrapped(text: str, width: int) -> str:
    """Text in lines of at most so many letters."""
    return textwrap.fill(text, width)
