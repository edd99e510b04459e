"""The figure of a fit: the picture before and after, each scale's factor, and the reason that stopped it (step 5)."""

import math
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from symrt.feedback.joint.fitted import Fit
from symrt.show.plots.panels import picture_panel
from symrt.show.plots.style import BELOW, FEASIBLE, INK, Drawing, caption, headline, literal, text_width, wrapped
from symrt.spectra.palette import Palette
from symrt.spectra.reference import Reference, as_asked
from symrt.spectra.shading import preview
from symrt.system import LinearSystem

PICTURE, BARS, REASONS, ROW = 3.4, 1.75, 2.95, 0.52
"""Inches: width of a picture, of the bars and of the reasons, and height of one scale's row."""
LETTERS = 46
"""Letters in a line of a reason."""


@literal
def fit_figure(found: Fit, system: LinearSystem, palette: Palette, reference: Reference | None = None) -> Drawing:
    """The picture given and the fitted one, against the same white, and the factor of every scale.

    Parameters
    ----------
    found
        The result of `fit` for this system and palette.
    reference
        The white and the exposure given to `fit`.

    Examples
    --------
    >>> from symrt.device import load_device
    >>> from symrt.feedback import Scale, fit
    >>> from symrt.gamut import device_gamut
    >>> device = load_device("dye3-endura-premier")
    >>> system = LinearSystem.of("0.25*sun*sea.diffuse", "0.5*sun*sea.diffuse", white={"sun": 0.5})
    >>> palette = Palette(device.bands, {"sun": 2, "sea.diffuse": 0.95})
    >>> found = fit(system, palette, device_gamut(device, "envelope"), [Scale("sea")])
    >>> fit_figure(found, system, palette).get_suptitle()
    'The lexicographic picture inside the gamut'
    """
    # The figure's size follows from the picture's proportions, the number of scales and their longest name.
    reference = as_asked(reference)
    white = reference.white(system, palette)
    tall = min(PICTURE, PICTURE * system.height / system.width)
    body = max(tall, ROW * len(found.values))
    height = body + 1.9
    names = [f"{name}  × {value:.3g}" for name, value in found.values.items()]
    left = 0.5 + 2 * (PICTURE + 0.15) + max(0.9, *(text_width(name, 9) for name in names))
    width = left + BARS + REASONS
    figure = Drawing(figsize=(width, height), facecolor="white")
    headline(figure, f"The {found.objective} picture inside the gamut")

    # The picture before and after.
    for k, (name, colours) in enumerate((("given", palette), ("fitted", found.palette))):
        shown = preview(system, colours, reference.exposure, white=white)
        picture_panel(figure, (0.25 + k * (PICTURE + 0.15), 0.8, PICTURE, tall), shown, name)

    # A bar for each scale, with its reason beside it.
    bars = figure.add_axes((left / width, (height - 0.8 - body) / height, BARS / width, body / height))
    _draw_factors(bars, found, names)
    _write_reasons(figure, bars, found)

    text = (
        f"Bars: factors of the scales (dashed: as given), and what stopped them. {found.share_out:.2%} of the object "
        f"pixels are outside ({found.verdict}), and {found.luminance:.1%} of the mean luminance is kept. "
        f"Against {found.note}."
    )
    caption(figure, wrapped(text, int(14 * width)))
    return figure


def _draw_factors(axes: Axes, found: Fit, names: list[str]) -> None:
    """Draw each factor as a bar from 1, on a logarithmic axis."""
    # A factor of 0 is drawn at the axis' end, since it has no logarithm.
    left = max(found.within[0], 0.01)
    for row, value in enumerate(found.values.values()):
        shown = max(value, left)
        colour = FEASIBLE if value >= 1 else BELOW
        axes.barh(row, abs(shown - 1), left=min(shown, 1.0), height=0.45, color=colour, zorder=2)
        axes.plot(shown, row, marker="|", ms=12, color=INK, zorder=3)
    axes.axvline(1.0, color=INK, lw=0.8, ls=(0, (2, 2)), zorder=1)

    # Limits round all factors; a short axis has ticks between the powers of ten.
    span = [*(max(value, left) for value in found.values.values()), 0.8, 1.25]
    axes.set(xscale="log", xlim=(min(span) / 1.2, 1.2 * max(span)), ylim=(len(found.values) - 0.5, -0.5))
    long = math.log10(max(span) / min(span)) > 1
    axes.xaxis.set_major_locator(LogLocator(subs=(1.0,) if long else (1.0, 2.0, 5.0)))

    axes.set_yticks(range(len(names)), names, fontsize=9)
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.tick_params(axis="y", length=0)
    axes.tick_params(axis="x", labelsize=8.5)
    axes.spines[["top", "right", "left"]].set_visible(False)
    axes.set_xlabel("factor", fontsize=9)


def _write_reasons(figure: Figure, axes: Axes, found: Fit) -> None:
    """Write the reason that stopped each scale beside its bar."""
    box, count = axes.get_position(), len(found.values)
    for row, name in enumerate(found.values):
        y = box.y1 - (row + 0.5) * box.height / count
        text: dict[str, Any] = {"va": "center", "fontsize": 7.5, "color": INK, "linespacing": 1.2}
        figure.text(box.x1 + 0.13 / figure.get_figwidth(), y, wrapped(str(found.reasons[name]), LETTERS), **text)
