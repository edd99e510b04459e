"""Figures of an image in a gamut: feasible ranges with their reasons, pixels outside, shares (step 5 of the paper)."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from jaxtyping import Bool, Float, UInt8
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.ticker import FuncFormatter, NullFormatter

from symrt.arrays import Spectrum
from symrt.feedback.along import along_ends
from symrt.feedback.asking import darker_than_black, inside_all
from symrt.feedback.limits import Limits, limits
from symrt.feedback.lines import line_of
from symrt.feedback.parameters import Blend
from symrt.feedback.reasons import Feasible
from symrt.gamut.interface import ConvexGamut
from symrt.gamut.recipes import InkGamut
from symrt.show.plots.style import (
    ABOVE,
    BELOW,
    FEASIBLE,
    HAIR,
    INK,
    Drawing,
    caption,
    caption_height,
    headline,
    literal,
    wrapped,
)
from symrt.spectra.palette import Palette
from symrt.spectra.reference import Reference, as_asked
from symrt.spectra.shading import preview
from symrt.system import LinearSystem

REST = "#8fcfb9"
"""Pale green for values that are feasible for the rest of the image only."""
PLATE = {"facecolor": "white", "edgecolor": "none", "pad": 1.0}
LETTERS = 25
"""Letters in a line of a parameter's name."""
Mask = Bool[np.ndarray, "height width"]
TESTED = 4000
"""Largest number of pixels that are tested against a hull, or inks, for a map."""
ROW = 0.62
"""Height of one parameter's row in inches."""
LEAST = 0.01
"""Beginning of the logarithmic axis for ranges from 0."""


@literal
def ranges_figure(
    ranges: Sequence[Feasible],
    system: LinearSystem,
    palette: Palette,
    gamut: ConvexGamut | InkGamut,
    reference: Reference | None = None,
) -> Drawing:
    """Feasible ranges as bars, and beside each the spectrum of the pixel that stops it, against the gamut's bound."""
    # The figure's height follows from its rows and its caption.
    asked = limits(system, palette, gamut, reference)
    text = wrapped(_ranges_words(ranges, asked), 175)
    height = ROW * len(ranges) + caption_height(text) + 1.4
    figure = Drawing(figsize=(12.0, height), facecolor="white")
    headline(figure, f"Feasible ranges: {gamut.model}")

    # Bars on the left, and beside each its spectrum and reason.
    foot, body = (caption_height(text) + 0.65) / height, ROW * len(ranges) / height
    bars = figure.add_axes((0.17, foot, 0.36, body))
    _draw_ranges(bars, ranges)
    for row, found in enumerate(ranges):
        top = foot + body * (1 - row / len(ranges))
        axes = figure.add_axes((0.56, top - 0.9 * body / len(ranges), 0.13, 0.8 * body / len(ranges)))
        _draw_reason(figure, axes, found, _binding(found, asked, system, palette, reference), asked)

    caption(figure, text)
    return figure


def _ranges_words(ranges: Sequence[Feasible], asked: Limits) -> str:
    bounds = ", in the gamut's bounds (shaded)" if _band_by_band(asked).any() else ""
    blends = (
        "A scale of 1 is as given; a blend is as given at 0 and wholly replaced at 1. "
        if any(isinstance(found.parameter, Blend) for found in ranges)
        else ""
    )
    begins = f"The logarithmic axis begins at {LEAST}. " if min(found.within[0] for found in ranges) < LEAST else ""
    return (
        "Bars: values that keep the picture inside (pale: that keep the rest of it inside). Curves: reflectance of the "
        f"pixel that stops the range at its upper end{bounds}. {blends}{begins}Against {asked.note}."
    )


def _draw_ranges(axes: Axes, ranges: Sequence[Feasible]) -> None:
    """Draw the ranges looked at as lines, and the feasible intervals on them as bars, on a logarithmic axis."""
    # Values of 0 are drawn at the axis' end, since they have no logarithm.
    rows = np.arange(len(ranges))
    low, high = min(found.within[0] for found in ranges), max(found.within[1] for found in ranges)
    left = max(low, LEAST)
    for row, found in zip(rows, ranges, strict=True):
        first, last = max(found.within[0], left), found.within[1]
        axes.plot([first, last], [row, row], color=HAIR, lw=1.0, zorder=1)
        intervals = () if found.none_inside else found.intervals
        for a, b in intervals:
            colour = FEASIBLE if found.verdict == "complete" else REST
            begin, end = max(a, left), max(b, left)
            axes.barh(row, end - begin, left=begin, height=0.5, color=colour, zorder=2)

        # The upper end in figures.
        value = f"{intervals[-1][1]:.3g}" if intervals else "no pixel is inside" if found.intervals else "none"
        place: dict[str, Any] = {"xytext": (4, 0), "textcoords": "offset points", "va": "center", "bbox": PLATE}
        at = max(intervals[-1][1], left) if intervals else first
        axes.annotate(value, (at, row), fontsize=8.5, color=INK, zorder=4, **place)

    # The axes, with a name for each row.
    axes.axvline(1.0, color=INK, lw=0.8, ls=(0, (2, 2)), zorder=3)
    axes.set(xscale="log", xlim=(left, 1.35 * high), ylim=(len(ranges) - 0.5, -0.5))
    axes.set_yticks(rows, [wrapped(str(found.parameter), LETTERS) for found in ranges], fontsize=9)
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.tick_params(axis="y", length=0)
    axes.spines[["top", "right", "left"]].set_visible(False)
    axes.set_xlabel("value of the parameter (dashed: 1)", fontsize=9)


def _binding(
    found: Feasible, asked: Limits, system: LinearSystem, palette: Palette, reference: Reference | None = None
) -> Spectrum | None:
    """The reflectance of the pixel that stops a range above, if one does; 0 where the reference does not light it."""
    reason = found.reasons[-1][1] if found.reasons else None
    if reason is None or reason.x is None or reason.y is None or found.none_inside:
        return None
    seen = as_asked(reference)
    white = seen.white(system, palette)
    shown = np.divide(seen.exposure, white, out=np.zeros(len(white)), where=~asked.masked)
    pixel = np.array([reason.y * found.width + reason.x])
    line = line_of(system, palette, found.parameter).seen(np.diag(shown), pixel)
    return line.at(found.intervals[-1][1])[0]


def _band_by_band(asked: Limits) -> Bool[np.ndarray, " slab"]:
    """True for slabs that bound a single band from above; a hull has none, nor has a solid of colours."""
    return (asked.upper.bands >= 0) & np.isfinite(asked.upper.upper)


def _draw_reason(figure: Figure, axes: Axes, found: Feasible, spectrum: Spectrum | None, asked: Limits) -> None:
    """Draw the spectrum that stops a range, small, and write the reason beside it."""
    # The reason in words.
    box = axes.get_position()
    reason = found.reasons[-1][1] if found.reasons else None
    left_out = len(found.untouched_outside) + len(found.unfixable)
    words = wrapped("no value keeps it inside" if reason is None else str(reason), 56)
    more = found.verdict + (f", {left_out} of {found.objects} pixels left out" if left_out else "")
    if found.none_inside:
        words, more = "no value brings one inside", f"all {found.objects} pixels asked about are outside"
    text: dict[str, Any] = {
        "x": box.x1 + 0.012,
        "y": (box.y0 + box.y1) / 2,
        "va": "center",
        "fontsize": 8,
        "linespacing": 1.3,
    }
    figure.text(s=f"{words}\n{more}", color=INK, **text)

    # The spectrum against the gamut's bounds, with a dot at the band that stops it.
    axes.set_axis_off()
    if spectrum is None or reason is None:
        return
    x, single = np.array(asked.bands.centres), _band_by_band(asked)
    bounded, most = asked.upper.bands[single], asked.upper.upper[single]
    axes.fill_between(x[bounded], most, color="#e9edf2", lw=0)
    axes.plot(x[~asked.masked], spectrum[~asked.masked], color=INK, lw=1.1)
    if reason.band is not None:
        k = asked.bands.labels.index(reason.band)
        axes.plot(x[k], spectrum[k], marker="o", ms=4, color=ABOVE)
    axes.set(xlim=(x[0] - 6, x[-1] + 6), ylim=(0, 1.08 * max(most.max(initial=0.0), spectrum.max())))


def out_of_gamut_map(
    system: LinearSystem, palette: Palette, gamut: ConvexGamut | InkGamut, reference: Reference | None = None
) -> Drawing:
    """The picture in grey, with the pixels that are outside the gamut, and those darker than its black, in colour."""
    # Colour the picture.
    asked = limits(system, palette, gamut, reference)
    exposure = reference.exposure if reference else 1.0
    bright, dark, side = _outside(system, palette, asked)
    picture = _grey(preview(system, palette, exposure))
    for mask, colour in ((bright, ABOVE), (dark, BELOW)):
        picture[mask] = 0.35 * picture[mask] + 0.65 * np.array(to_rgb(colour))

    # Draw it in its own proportions.
    shape = system.width / system.height
    figure = Drawing(figsize=(7.2, 6.9 / shape + 1.3), facecolor="white")
    axes = figure.add_axes((0.02, 0.75 / figure.get_figheight(), 0.96, 1 - 1.3 / figure.get_figheight()))
    axes.imshow(picture, interpolation="nearest")
    axes.set_axis_off()
    headline(figure, "Pixels outside the gamut")

    # Shares of the object pixels, of which there may be none.
    objects = max(1, int(system.object_pixels.sum()))
    labels = [
        f"{name}: {mask.sum() / objects:.2%}" for name, mask in (("outside", bright), ("darker than black", dark))
    ]
    handles = [Patch(color=colour, label=label) for colour, label in zip((ABOVE, BELOW), labels, strict=True)]
    figure.legend(handles=handles, loc="upper right", bbox_to_anchor=(0.99, 0.995), ncols=2, frameon=False, fontsize=9)
    blocks = f" One pixel in each block of {side} × {side} was asked about." if side > 1 else ""
    caption(figure, wrapped(f"Shares of object pixels.{blocks} Against {asked.note}.", 100))
    return figure


@literal
def curve_figure(found: Feasible) -> Drawing:
    """The share of pixels outside the gamut against the value of a parameter, and the range where it is allowed."""
    text = wrapped(f"{_curve_words(found)} Against {found.note}.", 115)
    foot = caption_height(text) + 0.62
    figure = Drawing(figsize=(8.0, foot + 3.36), facecolor="white")
    axes = figure.add_axes((0.1, foot / (foot + 3.36), 0.86, 2.76 / (foot + 3.36)))

    # The curve over the range.
    low, high = found.within
    inner = found.curve.values[(found.curve.values > low) & (found.curve.values < high)]
    # On both sides of each step, so that the drawn line has its corners where the steps are.
    t = np.unique(np.concatenate([[low], inner, np.nextafter(inner, high), np.linspace(low, high, 64), [high]]))
    axes.plot(t, 100 * found.curve.outside(t), color=INK, lw=1.4)
    for a, b in () if found.none_inside else found.intervals:
        axes.axvspan(a, b, color=FEASIBLE, alpha=0.18, lw=0)
    axes.set(xlim=(low, high), xlabel=str(found.parameter), ylabel="object pixels outside, %")
    axes.set_ylim(bottom=0)
    axes.spines[["top", "right"]].set_visible(False)
    headline(figure, f"How much is outside: {found.parameter}")
    caption(figure, text)
    return figure


def _curve_words(found: Feasible) -> str:
    left_out = len(found.untouched_outside) + len(found.unfixable)
    if found.none_inside:
        return f"No pixel is inside: all {found.objects} asked about are outside whatever the value."
    if found.verdict == "complete":
        return "Shaded: feasible (complete)."
    rest = f"{left_out} of {found.objects} pixels asked about are outside whatever the value"
    return f"Shaded: feasible for the rest ({found.verdict}); {rest}."


def _outside(system: LinearSystem, palette: Palette, asked: Limits) -> tuple[Mask, Mask, int]:
    """Pixels that are outside, those darker than the device's black, and the side of the blocks tested.

    Hulls and inks are tested pixel by pixel, so that one pixel of each block stands for all that are light enough.
    """
    # Pixels darker than black need no test of a solid.
    line, objects = along_ends(system, palette, {}), np.flatnonzero(system.object_pixels)
    darker = darker_than_black(line, asked, objects, 1.0)
    pixels = objects[~darker] if asked.solids else objects

    # One pixel of each block, where a test takes long.
    slow = any(solid.bound is None for solid in asked.solids)
    side = max(1, math.ceil(math.sqrt(len(pixels) / TESTED))) if slow else 1
    y, x = np.divmod(pixels, system.width)
    _, first, block = np.unique(y // side * system.width + x // side, return_index=True, return_inverse=True)

    outside = np.zeros((2, system.height * system.width), dtype=bool)
    outside[0, pixels] = ~inside_all(line, asked, pixels[first], 1.0)[block]
    outside[1, objects[darker]] = True
    bright, dark = outside.reshape(2, system.height, system.width)
    return bright, dark & ~bright, side


def _grey(codes: UInt8[np.ndarray, "height width 3"]) -> Float[np.ndarray, "height width 3"]:
    """A picture in grey, and lighter, so that colours stand out on it."""
    grey = codes.astype(float).mean(axis=-1, keepdims=True) / 255
    return np.repeat(0.25 + 0.75 * grey, 3, axis=-1)
