"""The gamut and the segments of materials in it: Figure 1 of the paper.

The body is a shadow, so that spectra inside the gamut are drawn inside it, but for a hull's tolerance.  Segments are
clipped by the whole gamut, whatever three components are drawn.
"""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from jaxtyping import Float
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from symrt.device.printing import Device
from symrt.gamut.gamuts import AnyGamut
from symrt.gamut.intersections import AnyIntersection
from symrt.gamut.slabs import Gamut
from symrt.show.body import body_of
from symrt.show.plots.panels import Paper, Points, draw_directions, panel, panel_title
from symrt.show.plots.style import (
    GREY,
    HAIR,
    INK,
    NAME,
    Drawing,
    caption,
    caption_height,
    headline,
    literal,
    wrapped,
)
from symrt.show.records import inside_proves
from symrt.show.segments import Segment, Segments, Span, segments_of
from symrt.show.solid import View, facets, spread
from symrt.spectra.bands import Number
from symrt.spectra.palette import Palette

STEPS = 32
"""Number of pieces in which a segment is drawn, each in its own colour."""
LEADER: dict[str, Any] = {"arrowstyle": "-", "color": HAIR, "lw": 0.6, "shrinkA": 2, "shrinkB": 3}
GIVEN: dict[str, Any] = {"ls": "none", "marker": "o", "ms": 5, "mfc": "white", "mec": INK, "mew": 0.9}
"""Style of the mark at the reflectance that the palette gives."""
LEGEND, SYMBOL = 0.04, 0.225
"""Shares of the figure's height: of the legend, and up to the top of the small axes between the panels."""

Place = tuple[float, float]


@literal
def gamut_figure(
    gamut: AnyGamut | AnyIntersection,
    palette: Palette,
    materials: Sequence[str] | None = None,
    *,
    light: str | None = None,
    within: tuple[Number, Number] = (0.01, 3.0),
    exposure: Number = 1.0,
    components: tuple[int, int, int] = (0, 1, 2),
) -> Drawing:
    """The gamut's body in three components, with segments of scaled and of blended materials: the paper's Figure 1.

    Parameters
    ----------
    gamut
        A printer's gamut of any model, or an intersection of several; `body_of` gives the body that is drawn.
    palette
        Source of each material's diffuse reflectance: that of a surface which faces the reference light, unshadowed.
    materials
        Names of materials; all that have a diffuse reflectance if not given.
    light
        The reference light, under which colours are seen: a light of the palette, the first that shines if not given,
        or ``"equal-energy"`` or an illuminant.
    within
        The range of the scales.
    components
        The three coordinates drawn, the first upright; (0, 1, 2) has the neutral axis upright, as in the paper.

    Examples
    --------
    >>> from symrt.device import load_device
    >>> from symrt.gamut import device_gamut
    >>> gamut = device_gamut(load_device("dye3-endura-premier"), "envelope")
    >>> palette = Palette(gamut.bands, {"sun": "illuminant/D65", "sea.diffuse": "macbeth/blue sky"})
    >>> gamut_figure(gamut, palette).get_suptitle()
    'Spectral gamut, 3 of 36 components: envelope of dye3-endura-premier, black clipped'
    """
    found = segments_of(gamut, palette, materials, light=light, within=within, exposure=exposure)
    return segments_figure(found, components)


@literal
def segments_figure(found: Segments, components: tuple[int, int, int] = (0, 1, 2)) -> Drawing:
    """Segments drawn in a gamut's body in three components, as in `gamut_figure`.

    Examples
    --------
    >>> from symrt.device import load_device
    >>> from symrt.gamut import device_gamut
    >>> gamut = device_gamut(load_device("dye3-endura-premier"), "envelope")
    >>> palette = Palette(gamut.bands, {"sun": "illuminant/D65", "sea.diffuse": "macbeth/blue sky"})
    >>> segments_figure(segments_of(gamut, palette), (1, 2, 3)).axes[0].texts[-1].get_text()
    "Each material's reflectance, scaled by 0.01 … 3.00"
    """
    # The gamut's body in both panels.
    body = body_of(found.gamut, components)
    figure = Drawing(figsize=(12.0, 7.2), facecolor="white")
    headline(figure, _title(found.gamut))
    paper = Paper(View(), body.vectors, components)
    foot = _segments_caption(found, body.what, components)
    legend = max(0.095, caption_height(foot) / figure.get_figheight())
    left, right = (panel(figure, body.solid, paper, side) for side in (0, 1))

    # Scaled materials on the left, blended ones on the right.
    for axes, segments, width in ((left, found.scaled, 3.4), (right, found.blended, 2.0)):
        # The shorter lie above the longer, so that none is hidden behind another of nearly its direction.
        for order, segment in enumerate(sorted(segments, key=lambda one: -_length(one, paper))):
            _draw_segment(axes, segment, paper, width, 4 + order / 1000)

    # The materials as given, and names.
    given = [(segment.names[0], _place(segment, 1.0, paper)) for segment in found.scaled]
    for axes in (left, right):
        axes.plot([x for _, (x, _) in given], [y for _, (_, y) in given], **GIVEN, zorder=5)
    _label(left, [_scale_label(segment, paper) for segment in found.scaled], (legend + LEGEND, SYMBOL))
    _label(right, given, (SYMBOL, 0.0))

    # Titles, the small axes between the panels, and the foot.
    panel_title(left, "a", _scales_title(found.scaled))
    panel_title(right, "b", _blends_title(found.blended))
    draw_directions(figure.add_axes((0.455, 0.10, 0.09, 0.13)), paper)
    _legend(figure, legend)
    caption(figure, foot)
    return figure


@literal
def solids_figure(gamut: Gamut) -> Drawing:
    """A gamut in three components: its shadow, which covers all of it, and its slice, where the others are zero.

    Examples
    --------
    >>> from symrt.device import load_device
    >>> from symrt.gamut import device_gamut
    >>> solids_figure(device_gamut(load_device("dye3-endura-premier"))).get_suptitle()
    'Spectral gamut, 3 of 36 components: unit gamut (0 … 1), black clipped'
    """
    figure = Drawing(figsize=(12.0, 7.2), facecolor="white")
    headline(figure, _title(gamut))
    paper = Paper(View(), gamut.basis.vectors[:3])
    solids = (("shadow", gamut.shadow(3).polyhedron()), ("slice", gamut.slice(3).polyhedron()))
    for side, (name, solid) in enumerate(solids):
        axes = panel(figure, solid, paper, side)
        panel_title(axes, "ab"[side], f"Its {name}: volume {solid.volume:.3g}, {len(facets(solid))} sides")
    draw_directions(figure.add_axes((0.455, 0.10, 0.09, 0.13)), paper)
    text = "The shadow is the projection of all of the gamut, the slice its cut where every other component is zero. "
    caption(figure, wrapped(text + _inside_text(gamut), 175))
    return figure


def _title(gamut: AnyGamut | AnyIntersection) -> str:
    return f"Spectral gamut, 3 of {len(gamut.bands)} components: {gamut.name}"


def _segments_caption(found: Segments, what: str, components: tuple[int, int, int]) -> str:
    first, second, third = (f"c{i} (the neutral axis)" if i == 0 else f"c{i}" for i in components)
    text = (
        f"Body: {what} on {first}, {second} and {third}. Materials: diffuse reflectance facing the reference light, "
        f"{found.light}; exposure {found.exposure:g}. Clipped by the whole gamut, not by the three components drawn, "
        "so that a segment may end inside the body; no physical cap. "
    )
    return wrapped(text + _inside_text(found.gamut), 175)


def _inside_text(gamut: AnyGamut | AnyIntersection) -> str:
    return f"{' '.join(map(device_text, gamut.devices))} Being inside is {inside_proves(gamut)}."


def device_text(device: Device) -> str:
    """A sentence on a device: its title, "measured" if it is not modelled, and its extrapolated bands."""
    bands = [label for label, guessed in zip(device.bands.labels, device.extrapolated, strict=True) if guessed]
    guessed = f"; extrapolated at {', '.join(bands)}" if bands else ""
    how = "" if device.modelled else ", measured"
    return f"Device: {device.title}{how}{guessed}."


def _draw_segment(axes: Axes, segment: Segment, paper: Paper, width: float, order: float) -> None:
    """Draw the parts inside as bands in the segment's colours, rimmed with ink, and the parts outside dashed."""
    for part in segment.inside:
        points, colours = _pieces(segment, part, paper)
        axes.plot(*points.T, color=INK, lw=width + 1.1, solid_capstyle="round", zorder=order)
        pieces = np.stack([points[:-1], points[1:]], axis=1)
        axes.add_collection(
            LineCollection(list(pieces), colors=colours, linewidths=width, zorder=order, capstyle="round")
        )
    for part in segment.outside:
        points, _ = _pieces(segment, part, paper)
        for colour, weight in ((INK, 1.9), (segment.colours.mean(axis=0), 1.0)):
            dashes = (0, (6 / weight, 3.5 / weight))
            axes.plot(*points.T, color=colour, lw=weight, ls=dashes, dash_capstyle="butt", zorder=3)


def _length(segment: Segment, paper: Paper) -> float:
    """The length on paper of a segment's parts inside."""
    return math.fsum(math.dist(*(_place(segment, t, paper) for t in part)) for part in segment.inside)


def _pieces(segment: Segment, part: Span, paper: Paper) -> tuple[Points, Float[np.ndarray, "piece 3"]]:
    """The ends of a part's pieces on paper, and the colour of each piece."""
    t = np.linspace(*part, STEPS + 1)
    points = paper(segment.origin + t[:, None] * segment.direction)
    share = (t[1:, None] + t[:-1, None]) / 2 if len(segment.names) == 2 else np.zeros((STEPS, 1))
    return points, (1 - share) * segment.colours[0] + share * segment.colours[1]


def _scale_label(segment: Segment, paper: Paper) -> tuple[str, Place]:
    """A scaled material's name with the scales inside, and the point that the label belongs to."""
    name, first = segment.names[0], segment.within[0]
    if not segment.inside:
        return f"{name}: none", _place(segment, 1.0, paper)
    if segment.inside == (segment.within,):
        return f"{name}: all", _place(segment, segment.within[1], paper)
    spans = [f"≤ {high:.2f}" if low == first else f"{low:.2f} … {high:.2f}" for low, high in segment.inside]
    return f"{name}: {', '.join(spans)}", _place(segment, segment.inside[-1][1], paper)


def _place(segment: Segment, t: Number, paper: Paper) -> Place:
    x, y = paper(segment.at(t)[None])[0].tolist()
    return x, y


def _label(axes: Axes, labels: list[tuple[str, Place]], floors: tuple[float, float]) -> None:
    """Write names in a column at either side, each joined to its point by a thin line.

    `floors` are shares of the figure's height, above which the left and the right column stay.
    """
    (left, right), (bottom, top) = axes.get_xlim(), axes.get_ylim()
    middle, gap, box = (left + right) / 2, 0.042 * (top - bottom), axes.get_position()
    shown = [(text, _within_panel(point, axes)) for text, point in labels]
    for side, edge, align, floor in ((-1, left, "left", floors[0]), (1, right, "right", floors[1])):
        chosen = [(text, point) for text, point in shown if (point[0] >= middle) == (side > 0)]
        low = bottom + max(0.0, (floor - box.y0) / box.height) * (top - bottom)
        heights = spread(np.array([point[1] for _, point in chosen]), gap, (low + gap / 2, top - gap / 2))
        for (text, point), y in zip(chosen, heights, strict=True):
            place = (edge - side * 0.01 * (right - left), y)
            look = NAME | {"annotation_clip": False, "arrowprops": LEADER}
            axes.annotate(text, point, place, ha=align, va="center", fontsize=8.5, **look)


def _within_panel(point: Place, axes: Axes) -> Place:
    """A point, or the place where the line to it from black leaves the panel."""
    low, high = np.array([axes.get_xlim(), axes.get_ylim()]).T
    place = np.array(point)
    reach = np.divide(np.where(place > 0, high, low), place, out=np.full(2, np.inf), where=place != 0)
    x, y = np.clip(min(1.0, reach.min()) * place, low, high).tolist()
    return x, y


def _scales_title(segments: Sequence[Segment]) -> str:
    low, high = segments[0].within
    return f"Each material's reflectance, scaled by {low:.2f} … {high:.2f}"


def _blends_title(segments: Sequence[Segment]) -> str:
    whole = sum(segment.inside == (segment.within,) for segment in segments)
    return f"Blends of two materials: {whole} of {len(segments)} wholly inside"


def _legend(figure: Figure, bottom: float) -> None:
    inside = Line2D([], [], color=GREY, lw=3.4, solid_capstyle="round", label="inside the gamut")
    given = Line2D([], [], **GIVEN, label="as given (scale 1)")
    outside = Line2D([], [], color=GREY, lw=1.3, ls=(0, (4, 2)), label="outside")
    figure.legend(
        handles=[inside, outside, given],
        loc="lower left",
        bbox_to_anchor=(0.012, bottom),
        ncols=3,
        frameon=False,
        fontsize=9,
    )
