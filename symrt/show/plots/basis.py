"""Errors of a device's spectral basis in reflectance and in colour, against the number of its spectra (step 4)."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float
from matplotlib.axes import Axes
from matplotlib.ticker import FuncFormatter, MaxNLocator, NullFormatter

from symrt.gamut.accuracy import BasisReport
from symrt.show.plots.style import ABOVE, BELOW, GREY, HAIR, Drawing, caption, headline, literal, wrapped

FLOOR = 1e-5
"""Size below which errors are rounding, and not drawn."""

Errors = Float[np.ndarray, " component"]
Curve = tuple[str, Errors, Errors]


@literal
def basis_figure(report: BasisReport) -> Drawing:
    """Errors of prints kept to few components, the constant one first or plain, against the number of components.

    Examples
    --------
    >>> from symrt.device import load_device
    >>> from symrt.gamut import basis_report
    >>> len(basis_figure(basis_report(load_device("dye3-endura-premier"))).axes)
    2
    """
    figure = Drawing(figsize=(10.0, 4.6), facecolor="white")
    headline(figure, f"Components that {report.device} needs")
    left, right = figure.add_axes((0.075, 0.235, 0.4, 0.6)), figure.add_axes((0.57, 0.235, 0.4, 0.6))
    _draw(left, "RMS error of the reflectance", [("", report.rms, report.rms_plain)])
    colours: list[Curve] = [
        ("mean, ", report.mean, report.mean_plain),
        ("largest, ", report.largest, report.largest_plain),
    ]
    _draw(right, f"ΔE2000 under {report.light}", colours)
    right.axhline(1.0, color=HAIR, lw=0.8, zorder=0)
    caption(figure, wrapped(f"{report.what()}. {report.summary()}", 150))
    return figure


def _draw(axes: Axes, title: str, curves: Sequence[Curve]) -> None:
    """Draw pairs of curves, the constant component first or plain; all pairs but the last are dashed."""
    for row, (which, first, plain) in enumerate(curves):
        for words, errors, colour in (("constant first", first, BELOW), ("plain", plain, ABOVE)):
            shown = np.flatnonzero(errors > FLOOR)
            line = "-" if row == len(curves) - 1 else (0, (3, 2))
            axes.plot(shown + 1, errors[shown], color=colour, lw=1.3, ls=line, marker="o", ms=3, label=which + words)

    # A logarithmic axis from below the least error drawn.
    least = min(float(errors[errors > FLOOR].min(initial=1.0)) for _, *both in curves for errors in both)
    axes.set(yscale="log", xlim=(0, None), ylim=(least / 2, None))

    axes.set_title(title, loc="left", fontsize=10)
    axes.set_xlabel("components kept", fontsize=9, color=GREY)
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.yaxis.set_minor_formatter(NullFormatter())
    axes.tick_params(labelsize=9)
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(frameon=False, fontsize=9)
