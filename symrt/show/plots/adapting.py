"""Figures of a picture that is brought into a gamut, by one means after another or pixel by pixel (step 5)."""

from collections.abc import Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from symrt.feedback.joint.adapted import Adapted
from symrt.feedback.pixelwise import Mapped
from symrt.show.plots.panels import picture_panel
from symrt.show.plots.style import (
    ABOVE,
    FEASIBLE,
    HAIR,
    INK,
    NAME,
    Drawing,
    caption,
    headline,
    literal,
    text_width,
    wrapped,
)
from symrt.spectra.display import to_rgb8
from symrt.spectra.image import SpectralImage
from symrt.spectra.palette import Palette
from symrt.spectra.reference import Reference, as_asked
from symrt.spectra.shading import shade
from symrt.spectra.viewing import linear_rgb
from symrt.system import LinearSystem

WIDTH, PICTURE, BARS, ROW = 13.0, 3.4, 1.6, 0.42
"""Inches: width of the figure, of a picture in it, of one criterion's bars, and height of one means' row."""
LETTERS = 24
"""Letters in a line of a means' name."""


@literal
def adapted_figure(
    found: Adapted, system: LinearSystem, palette: Palette, reference: Reference | None = None
) -> Drawing:
    """The picture given, the one accepted, and the values of the three criteria that each means tried reached.

    If none was accepted, the picture of the last means is shown, and named so.

    Parameters
    ----------
    found
        The result of `adapt` for this system and palette.
    reference
        The white and the exposure given to `adapt`.

    Examples
    --------
    >>> from symrt.device import load_device
    >>> from symrt.feedback import Scale, adapt
    >>> from symrt.gamut import device_gamut
    >>> device = load_device("dye3-endura-premier")
    >>> system = LinearSystem.of("0.25*sun*sea.diffuse", "0.5*sun*sea.diffuse", white={"sun": 0.5})
    >>> palette = Palette(device.bands, {"sun": 2, "sea.diffuse": 0.95})
    >>> found = adapt(system, palette, device_gamut(device, "envelope"), [Scale("sea")])
    >>> adapted_figure(found, system, palette).get_suptitle()
    'Into the gamut by the simplest means: reached'
    """
    # The figure's width follows from the longest name of a means.
    reference = as_asked(reference)
    last = found.accepted or found.steps[-1]
    names = [wrapped(step.means, LETTERS) for step in found.steps]
    left = 0.45 + 2 * (PICTURE + 0.15) + max(text_width(name, 7.5) for name in names)
    width = left + 3 * BARS + 0.55
    figure = Drawing(figsize=(width, _height(system, ROW * len(found.steps))), facecolor="white")
    headline(figure, f"Into the gamut by the simplest means: {found.verdict}")

    # The pictures, the bars and the caption.
    after = shade(system, last.palette) if last.mapped is None else last.mapped
    name = "accepted" if found.accepted else "not accepted"
    _draw_before_and_after(figure, system, palette, reference, after, f"{name}: {last.means}")
    _draw_steps(figure, found, left, names)
    text = (
        f"Asked: {found.criteria} (vertical lines). Green: met; vermilion: lacking. Inside: share of the object "
        f"pixels; ΔE2000: mean from the picture given; lightness: mean L* as a share of its. Against {found.note}."
    )
    caption(figure, wrapped(text, int(14 * width)))
    return figure


@literal
def mapped_figure(found: Mapped, system: LinearSystem, palette: Palette, reference: Reference | None = None) -> Drawing:
    """The picture given, the one whose pixels were moved, and the distance that each moved.

    Parameters
    ----------
    found
        The result of `map_pixels` for this system and palette.
    reference
        The white and the exposure given to `map_pixels`.

    Examples
    --------
    >>> from symrt.device import load_device
    >>> from symrt.feedback import map_pixels
    >>> from symrt.gamut import device_gamut
    >>> device = load_device("dye3-endura-premier")
    >>> system = LinearSystem.of("0.25*sun*sea.diffuse", "0.5*sun*sea.diffuse", white={"sun": 0.5})
    >>> palette = Palette(device.bands, {"sun": 2, "sea.diffuse": 0.95})
    >>> mapped_figure(map_pixels(system, palette, device_gamut(device, "envelope")), system, palette).get_suptitle()
    'Pixels moved into the gamut one by one: 50.0%'
    """
    # The picture before and after.
    reference = as_asked(reference)
    figure = Drawing(figsize=(WIDTH, _height(system, 0.0)), facecolor="white")
    headline(figure, f"Pixels moved into the gamut one by one: {found.share:.1%}")
    _draw_before_and_after(figure, system, palette, reference, found.image, "moved")

    # The distances, with a colour bar; where nothing moved, its scale ends at 1 and not at 0.
    colours = {"cmap": "magma", "vmin": 0, "vmax": found.moved.max() or 1.0}
    place = (0.55 + 2 * PICTURE, 0.8, PICTURE, _tall(system))
    axes = picture_panel(figure, place, found.moved, "how far each moved", **colours)
    box = axes.get_position()
    bar = figure.colorbar(axes.images[0], cax=figure.add_axes((box.x1 + 0.012, box.y0, 0.012, box.height)))
    bar.set_label("RMS change of reflectance", fontsize=9)
    bar.outline.set_visible(False)

    text = (
        f"{found.share:.2%} of the object pixels moved, by at most {found.moved.max():.3g} RMS; against {found.note}."
    )
    caption(figure, wrapped(text, 185))
    return figure


def _tall(system: LinearSystem) -> float:
    return min(PICTURE, PICTURE * system.height / system.width)


def _height(system: LinearSystem, body: float) -> float:
    return max(_tall(system), body) + 1.55


def _draw_before_and_after(
    figure: Drawing, system: LinearSystem, palette: Palette, reference: Reference, after: SpectralImage, name: str
) -> None:
    white, tall = reference.white(system, palette), _tall(system)
    for k, (title, image) in enumerate((("given", shade(system, palette)), (name, after))):
        codes = to_rgb8(linear_rgb(image, reference.exposure, white))
        picture_panel(figure, (0.25 + k * (PICTURE + 0.15), 0.8, PICTURE, tall), codes, title)


def _draw_steps(figure: Drawing, found: Adapted, left: float, names: Sequence[str]) -> None:
    """Draw three panels of bars, a row for each means; the first panel begins `left` inches from the left."""
    # The label, name, values and bound of each criterion.
    asked = found.criteria
    panels = (
        ("inside, %", "inside", [100 * step.inside for step in found.steps], 100 * asked.least_inside),
        ("ΔE2000", "difference", [step.difference for step in found.steps], asked.most_difference),
        (
            "lightness, %",
            "lightness",
            [100 * step.lightness for step in found.steps],
            None if asked.least_lightness is None else 100 * asked.least_lightness,
        ),
    )

    # The panels side by side; the names of the means stand beside the first.
    (width, height), count = figure.get_size_inches(), len(found.steps)
    body = ROW * count
    for k, (label, criterion, values, bound) in enumerate(panels):
        at = left + k * (BARS + 0.2)
        axes = figure.add_axes((at / width, (height - 0.8 - body) / height, BARS / width, body / height))
        lacking = [criterion in asked.lacking(step) for step in found.steps]
        _draw_criterion(axes, values, lacking, bound, label)
        axes.set_yticks(range(count), names if k == 0 else [""] * count, fontsize=7.5)


def _draw_criterion(
    axes: Axes, values: Sequence[float], lacking: Sequence[bool], bound: float | int | None, label: str
) -> None:
    """Draw a bar for each value, in the colour of its verdict, and the bound as a dashed line."""
    axes.barh(range(len(values)), values, height=0.55, color=[ABOVE if short else FEASIBLE for short in lacking])
    for row, value in enumerate(values):
        at: dict[str, Any] = {"xytext": (3, 0), "textcoords": "offset points", "va": "center"}
        axes.annotate(f"{value:.3g}", (value, row), fontsize=7.5, **at, **NAME)
    if bound is not None:
        axes.axvline(bound, color=INK, lw=0.9, ls=(0, (3, 2)))

    # The axis begins at 0, and ends where the longest bar leaves room for its value.
    right = 1.3 * max([*values, bound or 0.0, 1e-9])
    axes.set(xlim=(0, right), ylim=(len(values) - 0.5, -0.5))
    # Steps of 1, 2, 2.5 and 5 make three ticks at least, and the longest of four still stand apart.
    ticks = [tick for tick in MaxNLocator(4, steps=[1, 2, 2.5, 5, 10]).tick_values(0, right) if 0 <= tick <= right]
    axes.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
    axes.tick_params(axis="y", length=0)
    axes.tick_params(axis="x", labelsize=7.5, color=HAIR)
    axes.spines[["top", "right", "left"]].set_visible(False)
    axes.set_xlabel(label, fontsize=8.5)
