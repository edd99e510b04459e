"""The common style of all figures: ink, captions, and a figure as a file."""

import textwrap
from collections.abc import Callable
from functools import wraps
from io import BytesIO
from typing import Any

from matplotlib import rc_context
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.patheffects import withStroke
from matplotlib.textpath import TextPath

from symrt.spectra.bands import Number
from symrt.spectra.png import srgb_chunks

INK, GREY, HAIR = "#1a1a1a", "#5f646b", "#9aa3b0"
ABOVE, BELOW, FEASIBLE = "#D55E00", "#0072B2", "#009E73"
"""Vermilion, blue and bluish green of Okabe and Ito's set, which colour-blind readers can tell apart."""
NAME: dict[str, Any] = {"color": INK, "zorder": 8, "path_effects": [withStroke(linewidth=2.5, foreground="white")]}
"""Style of names that are written over lines: with a white rim."""

Made = Callable[..., "Drawing"]


def literal(draw: Made) -> Made:
    """Make a function draw all names literally: a ``$`` in an ink's name begins no formula."""

    @wraps(draw)
    def drawn(*given: Any, **named: Any) -> "Drawing":
        with rc_context({"text.parse_math": False}):
            return draw(*given, **named)

    return drawn


def component(number: int) -> str:
    """The letter of a component, with its number below the line.

    Examples
    --------
    >>> component(12)
    'c₁₂'
    """
    return "c" + str(number).translate(str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉"))


class Drawing(Figure):
    """A figure that shows itself in a notebook, with or without matplotlib's own machinery for that."""

    def _repr_png_(self) -> bytes:
        return png(self, dpi=96)


def png(figure: Figure, dpi: int = 160) -> bytes:
    """The bytes of a figure as a PNG file, marked as sRGB.

    Examples
    --------
    >>> png(Figure(figsize=(1, 1)))[1:4]
    b'PNG'
    """
    buffer = BytesIO()
    figure.savefig(buffer, format="png", dpi=dpi, pil_kwargs={"pnginfo": srgb_chunks()})
    return buffer.getvalue()


def headline(figure: Figure, text: str) -> None:
    """Write the figure's name at its upper left: smaller, and in lines, if it is long."""
    inch = 1 / figure.get_figheight()
    room = 0.95 * figure.get_figwidth()
    long = text_width(text, 13, weight="bold") / room
    size = 13 / min(max(1.0, long), 1.3)
    lines = wrapped(text, int(1.25 * len(text) / long)) if long > 1.3 else text
    figure.suptitle(lines, x=0.02, y=1 - 0.18 * inch, ha="left", va="top", fontsize=size, weight="bold", color=INK)


def caption(figure: Figure, text: str) -> None:
    """Write a caption at the figure's foot: its reference, and the data in it that are modelled."""
    inch = 1 / figure.get_figheight()
    figure.text(0.02, 0.12 * inch, text, fontsize=8.5, color=GREY, va="bottom", linespacing=1.4)


def caption_height(text: str) -> float:
    r"""Inches from the foot of a figure to the top of its caption.

    Examples
    --------
    >>> round(caption_height("one line"), 3), round(caption_height("two\nlines"), 3)
    (0.285, 0.451)
    """
    return 0.12 + 8.5 * 1.4 / 72 * (1 + text.count("\n"))


def text_width(text: str, size: Number, weight: str = "normal") -> float:
    r"""The width in inches of a text's longest line, in letters of `size` points.

    Examples
    --------
    >>> text_width("wood", 9) < text_width("wood", 9, weight="bold") < text_width("mountain\nwood", 9)
    True
    """
    font = FontProperties(weight=weight)
    widths = [TextPath((0, 0), line, size=size, prop=font).get_extents().x1 for line in text.split("\n")]
    return float(max(widths)) / 72


def wrapped(text: str, width: int) -> str:
    """A text broken into lines of at most `width` letters."""
    return textwrap.fill(text, width)
