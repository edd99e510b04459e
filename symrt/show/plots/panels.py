"""Panels that several figures share: a solid in three coordinates (Figure 1 of the paper), and a picture."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float, Shaped
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure

from symrt.gamut.views import Polyhedron
from symrt.show.plots.style import HAIR, INK, NAME, component
from symrt.show.solid import Facet, View, facets, facing, outline

BODY, BODY_LIT = np.array([0.74, 0.79, 0.87]), np.array([0.965, 0.975, 0.99])
WIDE = 1.42
"""Width of a panel as a multiple of the body's, with room for names at either side."""
TALL = 1.2
"""Least height of a panel as a multiple of the body's."""

Points = Float[np.ndarray, "point 2"]
Picture = Shaped[np.ndarray, "height width *channel"]


@dataclass(frozen=True, eq=False)
class Paper:
    """A map from spectra to positions on paper: three coordinates, then a view of them."""

    view: View
    vectors: Float[np.ndarray, "3 band"]
    components: tuple[int, int, int] = (0, 1, 2)

    def __call__(self, spectra: Float[np.ndarray, "point band"]) -> Points:
        """Positions of spectra on paper."""
        return self.view.project(spectra @ self.vectors.T)


def panel(figure: Figure, solid: Polyhedron, paper: Paper, side: int) -> Axes:
    """Draw a solid on one half of a figure, with its upright axis."""
    axes, sides = figure.add_axes((0.5 * side, 0.14, 0.5, 0.74)), facets(solid)
    _draw_body(axes, sides, paper.view)
    _frame(axes, figure, outline(sides, paper.view))
    heights = solid.vertices[:, 0]
    _draw_upright_axis(axes, paper, float(heights.min()), float(heights.max()))
    return axes


def _draw_body(axes: Axes, sides: list[Facet], view: View) -> None:
    """Draw a translucent solid: far sides, and near sides as a veil; segments keep their own colour above both."""
    near = facing(sides, view)
    for is_near, order, veil, hair in ((False, 1.0, 1.0, 0.10), (True, 1.5, 0.10, 0.13)):
        shown = [side for side, seen in zip(sides, near, strict=True) if seen == is_near]
        lit = np.array([abs(side.normal @ view.light) for side in shown])[:, None]
        colours = np.hstack([BODY + (BODY_LIT - BODY) * lit, np.full((len(shown), 1), veil)])
        outlines = [view.project(side.corners) for side in shown]
        edges = (0.2, 0.27, 0.4, hair)
        axes.add_collection(
            PolyCollection(outlines, facecolors=colours, edgecolors=[edges], linewidths=0.4, zorder=order)
        )
    axes.fill(*outline(sides, view).T, facecolor="none", edgecolor=HAIR, linewidth=1.0, zorder=1.6)


def _frame(axes: Axes, figure: Figure, contour: Points) -> None:
    """Set the same unit across and up, and the body in the lower middle, with room beside it for names."""
    low, high = contour.min(axis=0), contour.max(axis=0)
    half = (high - low) / 2
    box = axes.get_position()
    width, height = figure.get_size_inches() * (box.width, box.height)
    across = max(2 * WIDE * half[0], TALL * 2 * half[1] * width / height)
    bottom = low[1] - 0.13 * half[1]
    axes.set(
        xlim=(low + half)[0] + across / 2 * np.array([-1, 1]),
        ylim=(bottom, bottom + across * height / width),
        aspect="equal",
    )
    axes.set_axis_off()


def _draw_upright_axis(axes: Axes, paper: Paper, bottom: float, top: float) -> None:
    """Draw the first coordinate with its whole numbers; on the neutral axis black is at 0 and white at √K."""
    ticks = np.arange(math.ceil(bottom), math.floor(top) + 1)
    points = paper.view.project(np.array([[t, 0.0, 0.0] for t in (bottom, *ticks, top)]))
    axes.plot(points[[0, -1], 0], points[[0, -1], 1], color=INK, lw=0.8, zorder=2)
    axes.plot(*points[1:-1].T, ls="none", marker="_", ms=6, mew=0.8, color=INK, zorder=2)
    text: dict[str, Any] = {"textcoords": "offset points", "color": INK, "zorder": 7}
    for tick, point in zip(ticks, points[1:-1], strict=True):
        axes.annotate(str(tick), point, (-7, 0), ha="right", va="center", fontsize=7.5, **text)
    name = component(paper.components[0]) + (", neutral" if paper.components[0] == 0 else "")
    axes.annotate(name, points[-1], (0, 6), ha="center", fontsize=9, **text | NAME | {"zorder": 9})


def draw_directions(axes: Axes, paper: Paper) -> None:
    """Draw one unit along each coordinate."""
    tips = paper.view.project(np.eye(3))
    for name, tip in zip(map(component, paper.components), tips, strict=True):
        arrow = {"arrowstyle": "-|>,head_width=.15,head_length=.3", "color": INK, "lw": 0.8, "shrinkA": 0, "shrinkB": 0}
        axes.annotate("", tip, (0, 0), arrowprops=arrow)
        axes.annotate(name, 1.25 * tip, ha="center", va="center", fontsize=8, color=INK)
    axes.set(xlim=(-1.1, 1.3), ylim=(-0.5, 1.4), aspect="equal")
    axes.set_axis_off()


def panel_title(axes: Axes, letter: str, text: str) -> None:
    """Write a panel's letter and title above it."""
    axes.text(0.04, 1.02, letter, transform=axes.transAxes, fontsize=12, weight="bold", color=INK)
    axes.text(0.085, 1.02, text, transform=axes.transAxes, fontsize=10, color=INK)


def picture_panel(
    figure: Figure, place: tuple[float, float, float, float], picture: Picture, title: str, **drawn: Any
) -> Axes:
    """Draw a picture with its title above it; `place` is left, top, width and height in inches."""
    left, top, width, height = place
    across, tall = figure.get_size_inches()
    axes = figure.add_axes((left / across, (tall - top - height) / tall, width / across, height / tall))
    axes.imshow(picture, interpolation="nearest", **drawn)
    axes.set_title(title, fontsize=10, color=INK, loc="left")
    axes.set(xticks=[], yticks=[])
    axes.set_axis_off()
    return axes
