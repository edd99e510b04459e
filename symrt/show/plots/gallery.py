"""The figure of a gallery of scenes."""

from collections.abc import Sequence

from symrt.show.gallery import Exhibit
from symrt.show.plots.panels import picture_panel
from symrt.show.plots.style import GREY, Drawing, headline, literal, wrapped

WIDTH, GAP, TEXT, HEAD = 3.9, 0.2, 0.62, 0.75
"""Inches: width of a picture, the gap beside it, the room for the words below it, and for those above all."""
LETTERS = 62
"""Letters in a line below a picture."""


@literal
def gallery_figure(exhibits: Sequence[Exhibit], columns: int = 4) -> Drawing:
    """Scenes in rows, each with its name, its title, and the effects that it called for.

    Examples
    --------
    >>> from symrt.show.gallery import exhibits
    >>> len(gallery_figure(list(exhibits(["first"], width=16, progress=False))).axes)
    1
    """
    # Pictures of one width, rows as tall as their tallest.
    rows = [exhibits[first : first + columns] for first in range(0, len(exhibits), columns)]
    tall = [WIDTH * max(one.picture.shape[0] / one.picture.shape[1] for one in row) for row in rows]
    across = GAP + min(columns, len(exhibits)) * (WIDTH + GAP)
    figure = Drawing(figsize=(across, HEAD + sum(tall) + len(rows) * (TEXT + 0.3)), facecolor="white")
    headline(figure, "Each scene, and only the effects it calls for")

    # Each picture with its words.
    top = HEAD
    for row, height in zip(rows, tall, strict=True):
        for column, one in enumerate(row):
            left = GAP + column * (WIDTH + GAP)
            own = WIDTH * one.picture.shape[0] / one.picture.shape[1]
            picture_panel(figure, (left, top, WIDTH, own), one.picture, one.name)
            effects = ", ".join(one.effects) or "light and shadow alone"
            words = f"{wrapped(one.title, LETTERS)}\n{wrapped(f'{effects} · {one.palette}, {one.bands}', LETTERS)}"
            place = left / across, 1 - (top + own + 0.06) / figure.get_figheight()
            figure.text(*place, words, fontsize=8, color=GREY, va="top", linespacing=1.35)
        top += height + TEXT + 0.3
    return figure
