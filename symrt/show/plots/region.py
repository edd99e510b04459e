"""The pairs of two parameters that keep a picture inside, and the pixels that stop them (step 5 of the paper)."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Bool, Float
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap, PowerNorm
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Rectangle
from matplotlib.text import Text
from matplotlib.ticker import MaxNLocator

from symrt.feedback.joint.pairs import JointRegion
from symrt.feedback.reasons import Reason
from symrt.show.plots.style import ABOVE, FEASIBLE, GREY, INK, NAME, Drawing, caption, headline, literal, wrapped
from symrt.spectra.palette import Palette
from symrt.spectra.reference import Reference
from symrt.spectra.shading import preview
from symrt.system import LinearSystem

FILL = "#bfe3d5"
"""Pale green for feasible pairs, on which lines and names stand out."""
OUTSIDE = LinearSegmentedColormap.from_list("outside", ["#fdf3ec", "#f6c9a8", "#e58a50", "#b9500f"])
LEVELS = (0.001, 0.01, 0.05, 0.2, 0.5)
"""Shares outside at which a contour is drawn."""
EXPLAINED = 5
"""Largest number of reasons at the edge that are explained."""
CLEAR = 18
"""Least distance, in points, from the middle of a mark to that of a contour's label."""
SHORTEST = 0.03
"""Least share of the edge's length of a reason that is explained."""


@dataclass(frozen=True, eq=False)
class Stop:
    """A stretch of the region's edge: the reason that stops the parameters there, its marked place, and its length."""

    reason: Reason
    place: tuple[float, float]
    length: float


@literal
def joint_region_figure(
    found: JointRegion, system: LinearSystem, palette: Palette, reference: Reference | None = None
) -> Drawing:
    """The feasible pairs of two parameters, with the reasons at their edge; beyond it, the share of pixels outside.

    Drawn with them are the pair given, the ranges found one by one as a dashed rectangle, and the box in which both
    may move freely; beside them the picture, with the pixels that stop the parameters.

    Parameters
    ----------
    found
        The result of `joint_region`.
    system, palette, reference
        The picture, as given to `joint_region`.

    Examples
    --------
    >>> from symrt.feedback import Scale, joint_region
    >>> from symrt.device import load_device
    >>> from symrt.gamut import device_gamut
    >>> device = load_device("dye3-endura-premier")
    >>> system = LinearSystem.of("0.25*sun*ice.diffuse + 0.25*sun*sea.diffuse", white={"sun": 0.5})
    >>> palette = Palette(device.bands, {"sun": 2, "ice.diffuse": 0.5, "sea.diffuse": 0.5})
    >>> found = joint_region(system, palette, device_gamut(device), Scale("ice"), Scale("sea"), cap=False)
    >>> joint_region_figure(found, system, palette).get_suptitle()
    'Which pairs keep the picture inside: scale of ice × scale of sea'
    """
    # The share outside, the feasible pairs on top of it, the ranges one by one and the safe box.
    figure = Drawing(figsize=(12.0, 7.4), facecolor="white")
    headline(figure, f"Which pairs keep the picture inside: {found.one} × {found.other}")
    axes = figure.add_axes((0.065, 0.2, 0.5, 0.7))
    levels = _shade(figure, axes, found)
    _fill(axes, found)
    _frame_separate(axes, found)
    _frame_box(axes, found)

    # The pair given, and a number at each reason.
    stops = _stops(found)
    _mark_given(axes, found)
    _number(axes, [stop.place for stop in stops])

    # Limits come before labels are cleared from marks: they fix the positions on paper.
    (low, high), (bottom, top) = found.within
    axes.set(xlim=(low, high), ylim=(bottom, top), xlabel=str(found.one), ylabel=str(found.other))
    _clear(axes, levels, [found.given, *(stop.place for stop in stops)])
    axes.set_xticks(_ticks(low, high, 6))
    axes.set_yticks(_ticks(bottom, top, 6))
    axes.spines[["top", "right"]].set_visible(False)

    # The picture and the reasons beside the region, and the foot.
    _draw_picture(figure, system, palette, reference, stops)
    _explain(figure, stops)
    _legend(figure, found)
    caption(figure, _words(found))
    return figure


def _shade(figure: Figure, axes: Axes, found: JointRegion) -> list[Text]:
    """Shade the pairs by the share of the picture outside, and return the labels of its contours."""
    share = found.outside.T
    norm = PowerNorm(0.5, 0.0, max(0.01, float(share.max())))
    mesh = axes.pcolormesh(
        found.values, found.across, share, cmap=OUTSIDE, norm=norm, shading="gouraud", rasterized=True, zorder=0
    )

    # Contours at the levels that occur.
    levels, written = [level for level in LEVELS if share.min() < level < share.max()], []
    if levels:
        lines = axes.contour(found.values, found.across, share, levels=levels, colors=[GREY], linewidths=0.6, zorder=1)
        written = axes.clabel(lines, fmt=lambda level: f"{level:.1%}".replace(".0%", "%"), fontsize=7.5, colors=INK)

    # The scale of colours.
    strip = figure.add_axes((0.575, 0.2, 0.012, 0.7))
    ticks = _ticks(0.0, norm.vmax or 1.0, 4)
    bar = figure.colorbar(mesh, cax=strip, ticks=ticks, format=lambda level, _: f"{100 * level:.3g}%")
    bar.outline.set_visible(False)
    strip.tick_params(labelsize=7.5, length=2)
    strip.set_title("outside", fontsize=8, loc="left", pad=4)
    return list(written)


def _clear(axes: Axes, written: Sequence[Text], places: Sequence[tuple[float, float]]) -> None:
    """Hide a contour's label where a mark lies on it."""
    for text in written:
        away = axes.transData.transform([*places, text.get_position()]) * 72 / axes.figure.dpi
        text.set_visible(bool(np.hypot(*(away[:-1] - away[-1]).T).min() > CLEAR))


def _ticks(low: float, high: float, most: int) -> list[float]:
    return [float(tick) for tick in MaxNLocator(most).tick_values(low, high) if low <= tick <= high]


def _fill(axes: Axes, found: JointRegion) -> None:
    """Fill the feasible pairs, between neighbouring lines that agree in the number of their intervals."""
    # The ends of each line's intervals, nan where a line has fewer than others.
    count = max((len(line) for line in found.intervals), default=0)
    ends = np.full((count, 2, len(found.values)), np.nan)
    for k, line in enumerate(found.intervals):
        for n, interval in enumerate(line):
            ends[n, :, k] = interval

    # Each run of neighbouring lines, filled and outlined.
    for low, high in ends:
        there: Bool[np.ndarray, " line"] = np.isfinite(low)
        axes.fill_between(found.values, low, high, where=there, color=FILL, lw=0, zorder=2)
        for run in np.split(np.flatnonzero(there), np.flatnonzero(np.diff(np.flatnonzero(there)) > 1) + 1):
            x = found.values[run]
            if len(run):
                outline = np.concatenate([low[run], high[run][::-1], low[run][:1]])
                around = np.concatenate([x, x[::-1], x[:1]])
                axes.plot(around, outline, color=FEASIBLE, lw=1.8, zorder=4, solid_joinstyle="round")


def _frame_separate(axes: Axes, found: JointRegion) -> None:
    for a, b in found.separate[0].intervals:
        for c, d in found.separate[1].intervals:
            axes.add_patch(Rectangle((a, c), b - a, d - c, fill=False, edgecolor=INK, lw=1.1, ls=(0, (5, 3)), zorder=5))


def _frame_box(axes: Axes, found: JointRegion) -> None:
    if found.box is None:
        return
    (a, b), (c, d) = (found.box.box[name] for name in _names(found))
    look: dict[str, Any] = {"facecolor": FEASIBLE, "alpha": 0.35, "lw": 0, "zorder": 3}
    axes.add_patch(Rectangle((a, c), b - a, d - c, **look))
    axes.add_patch(Rectangle((a, c), b - a, d - c, fill=False, edgecolor="#00604a", lw=1.2, zorder=4.5))


def _names(found: JointRegion) -> tuple[str, str]:
    return getattr(found.one, "name", ""), getattr(found.other, "name", "")


def _mark_given(axes: Axes, found: JointRegion) -> None:
    x, y = found.given
    axes.plot([x], [y], marker="o", ms=7, mfc="white", mec=INK, mew=1.3, ls="none", zorder=9, clip_on=False)
    axes.annotate("as given", (x, y), (8, 6), textcoords="offset points", fontsize=9, **NAME)


def _stops(found: JointRegion) -> list[Stop]:
    """The longest stretches of the edge that one pixel and band stop, from left to right."""
    # Along the lower and the upper edge, half the way to each neighbour belongs to a point's reason.
    (low, high), (bottom, top) = found.within
    stretches: dict[Reason, list[tuple[float, float]]] = {}
    lengths: dict[Reason, float] = {}
    for side in (0, 1):
        edge = [
            (value, line[-side][side], reasons[-side][side])
            for value, line, reasons in zip(found.values, found.intervals, found.reasons, strict=True)
            if line
        ]
        for k, (x, y, reason) in enumerate(edge):
            if reason.side == "range":
                continue
            near = edge[max(0, k - 1) : k + 2]
            steps = [np.hypot((u - x) / (high - low), (v - y) / (top - bottom)) / 2 for u, v, _ in near]
            stretches.setdefault(reason, []).append((x, y))
            lengths[reason] = lengths.get(reason, 0.0) + float(sum(steps))

    # An upright edge is met by no line; the range of the one alone, with the other as given, ends on it.
    alone, (_, y) = found.separate[0], found.given
    for ends, reasons in zip(alone.intervals, alone.reasons, strict=True):
        for x, reason in zip(ends, reasons, strict=True):
            if reason.side != "range" and reason not in lengths and bottom <= y <= top:
                stretches[reason], lengths[reason] = [(x, y)], 0.25

    # The longest, unless they are very short.
    whole = sum(lengths.values())
    longest = sorted(lengths, key=lambda reason: -lengths[reason])[:EXPLAINED]
    stops = [
        Stop(reason, _middle(stretches[reason], found), lengths[reason])
        for reason in longest
        if lengths[reason] >= SHORTEST * whole
    ]
    return sorted(stops, key=lambda stop: stop.place)


def _middle(points: Sequence[tuple[float, float]], found: JointRegion) -> tuple[float, float]:
    """The point in the middle of a stretch, measured along it."""
    (low, high), (bottom, top) = found.within
    steps = np.diff(np.array(points) / [high - low, top - bottom], axis=0)
    far = np.append(0.0, np.cumsum(np.hypot(*steps.T)))
    return points[int(np.abs(far - far[-1] / 2).argmin())]


def _number(axes: Axes, places: Sequence[tuple[float, float]], size: float = 10.5) -> None:
    """Draw numbered marks at some places."""
    look: dict[str, Any] = {"fontsize": 7.5, "weight": "bold", "color": "white", "annotation_clip": False}
    for number, place in enumerate(places, 1):
        axes.plot(*place, marker="o", ms=size, mfc=ABOVE, mec="white", mew=1.0, ls="none", zorder=10, clip_on=False)
        axes.annotate(str(number), place, ha="center", va="center_baseline", zorder=11, **look)


def _draw_picture(
    figure: Figure, system: LinearSystem, palette: Palette, reference: Reference | None, stops: Sequence[Stop]
) -> None:
    """Draw the picture, with a numbered mark at each pixel that stops the parameters."""
    picture = figure.add_axes((0.65, 0.47, 0.33, 0.43))
    picture.imshow(preview(system, palette, reference.exposure if reference else 1.0), interpolation="nearest")
    picture.set_axis_off()

    # Numbers stand beside their pixels, away from the others.
    numbered = [(n, stop.reason.x, stop.reason.y) for n, stop in enumerate(stops, 1)]
    places = {n: np.array([x, y], dtype=float) for n, x, y in numbered if x is not None and y is not None}
    mark = {"boxstyle": "circle,pad=0.25", "facecolor": ABOVE, "edgecolor": "white", "lw": 0.8}
    line = {"arrowstyle": "-", "color": "white", "lw": 0.9, "shrinkA": 0, "shrinkB": 2}
    text: dict[str, Any] = {"ha": "center", "va": "center", "fontsize": 7.5, "weight": "bold", "color": "white"}
    for number, (x, y) in places.items():
        picture.plot(x, y, marker="+", ms=7, mew=1.4, color="white", zorder=3)
        offset = 26 * _away(places[number], list(places.values()))
        text |= {"xytext": tuple(offset), "textcoords": "offset points", "bbox": mark, "arrowprops": line}
        picture.annotate(str(number), (x, y), **text)


def _away(place: Float[np.ndarray, "2"], places: Sequence[Float[np.ndarray, "2"]]) -> Float[np.ndarray, "2"]:
    """The direction on paper from the other pixels to a pixel, in which its number stands."""
    # Rows count downwards.  A pixel in the very middle of the others has no direction of its own.
    away = (place - np.mean(places, axis=0)) * (1, -1)
    far = float(np.hypot(*away))
    return away / far if far > 1 else np.array([0.8, 0.6])


def _explain(figure: Figure, stops: Sequence[Stop]) -> None:
    lines = [f"{number}  {stop.reason}" for number, stop in enumerate(stops, 1)]
    if not lines:
        lines = ["No pixel stops them: the ranges asked for end."]
    text = "\n".join(wrapped(line, 66).replace("\n", "\n    ") for line in ["What stops them at the edge:", *lines])
    figure.text(0.65, 0.44, text, fontsize=8.5, va="top", color=INK, linespacing=1.5)


def _legend(figure: Figure, found: JointRegion) -> None:
    share = "" if found.separate_inside is None else f": {_percent(found.separate_inside)} of it inside"
    handles: list[Any] = [Patch(facecolor=FILL, edgecolor=FEASIBLE, lw=1.5, label="all of the picture inside")]
    if found.verdict != "complete":
        handles[0].set_label("all of the rest of the picture inside")
    if found.box is not None:
        handles.append(Patch(facecolor="#7cc5ae", edgecolor="#00604a", label="both move freely (safe box)"))
    handles.append(Line2D([], [], color=INK, lw=1.1, ls=(0, (5, 3)), label=f"ranges one by one{share}"))
    figure.legend(handles=handles, loc="lower left", bbox_to_anchor=(0.055, 0.075), ncols=3, frameon=False, fontsize=9)


def _percent(share: float) -> str:
    """A share in per cent, written as 0 or 100 only if it is that but for rounding."""
    if 0 < share < 0.005:
        return "< 1%"
    return "> 99%" if 0.995 < share < 1 - 1e-6 else f"{share:.0%}"


def _words(found: JointRegion) -> str:
    left_out = len(found.untouched_outside) + len(found.unfixable)
    rest = f" {left_out} of {found.objects} object pixels are outside whatever the pair." if left_out else ""
    text = (
        f"Of all these pairs {_percent(found.share)} keep it inside; certified on {len(found.values)} upright lines, "
        f"joined between them.{rest} Against {found.note}."
    )
    return wrapped(text, 175)
