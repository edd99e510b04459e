"""Figures of gamuts of any model: a body of spectra, prints, or a solid of colours (step 4 of the paper)."""

import numpy as np
from jaxtyping import Float
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection

from symrt.device.colorimetry import VISIBLE, lab, tristimulus
from symrt.gamut.colorimetric import ColorimetricGamut
from symrt.gamut.gamuts import AnyGamut, device_gamut
from symrt.gamut.hull import HullGamut
from symrt.gamut.intersections import AnyIntersection, SlabIntersection
from symrt.gamut.monitor import MonitorGamut
from symrt.gamut.recipes import InkGamut
from symrt.gamut.slabs import Gamut
from symrt.gamut.views import convex_solid
from symrt.show.body import body_of
from symrt.show.plots.gamut import device_text, solids_figure
from symrt.show.plots.panels import Paper, draw_directions, panel, panel_title
from symrt.show.plots.style import GREY, HAIR, INK, Drawing, caption, headline, literal, wrapped
from symrt.show.solid import View
from symrt.spectra.display import display_matrix, encode
from symrt.spectra.library import spectrum

PIECES = 12
"""Number of parts into which each side of a triangle of colours is cut, to be bent into L*a*b*."""
CHROMAS = (40, 80, 120)
"""Chromas at which circles are drawn."""

Colours = Float[np.ndarray, "point 3"]


@literal
def body_figure(gamut: AnyGamut | AnyIntersection) -> Drawing:
    """A gamut of any model in two panels.

    Raises
    ------
    ValueError
        If there is nothing to draw: a monitor for images in RGB is the cube.

    Examples
    --------
    >>> from symrt.device import load_device
    >>> from symrt.gamut import device_gamut
    >>> body_figure(device_gamut(load_device("dye3-endura-premier"), "hull")).get_suptitle().partition(", within")[0]
    "Prints, 3 of 36 components: hull of dye3-endura-premier's prints"
    """
    if isinstance(gamut, Gamut):
        return solids_figure(gamut)
    if isinstance(gamut, HullGamut | InkGamut):
        return prints_figure(gamut)
    if isinstance(gamut, ColorimetricGamut | MonitorGamut):
        return colours_figure(gamut)
    if isinstance(gamut, SlabIntersection) and all(isinstance(part, Gamut) for part in gamut.parts):
        return intersection_figure(gamut)
    raise ValueError(f"{gamut.name}: there is no figure of it; draw the gamuts that it is made of")


@literal
def intersection_figure(gamut: SlabIntersection) -> Drawing:
    """The shadow of an intersection of gamuts, and that of the first of them alone."""
    first = gamut.devices[0]
    shared, own = body_of(gamut), body_of(gamut.parts[0])
    paper = Paper(View(), shared.vectors)
    figure = Drawing(figsize=(12.0, 7.2), facecolor="white")
    headline(figure, f"Spectral gamut, 3 of {len(gamut.bands)} components: what {len(gamut.parts)} gamuts share")
    titles = "What they share", f"Shadow of {gamut.parts[0].name}"
    for side, (solid, title) in enumerate(zip((shared.solid, own.solid), titles, strict=True)):
        panel_title(panel(figure, solid, paper, side), "ab"[side], f"{title}: volume {solid.volume:.3g}")
    draw_directions(figure.add_axes((0.455, 0.10, 0.09, 0.13)), paper)
    devices = " ".join(device_text(device) for device in gamut.devices)
    caption(figure, wrapped(f"What is {gamut.name}. Components are those of {first.name}. {devices}", 175))
    return figure


@literal
def prints_figure(gamut: HullGamut | InkGamut) -> Drawing:
    """The prints of a device in three components, alone and in the shadow of its envelope."""
    # The prints, and the two solids they are drawn in.
    device = gamut.device
    whole, mixed = body_of(device_gamut(device, "envelope")), body_of(gamut).solid
    paper, shadow = Paper(View(), whole.vectors), whole.solid
    places = device.samples @ paper.vectors.T

    # A panel for each solid, with a dot for each print.
    figure = Drawing(figsize=(12.0, 7.2), facecolor="white")
    headline(figure, f"Prints, 3 of {len(device.bands)} components: {gamut.name}")
    colours = encode(device.samples @ display_matrix(device.bands, np.ones(len(device.bands))))
    for side, solid in enumerate((mixed, shadow)):
        axes = panel(figure, solid, paper, side)
        _dot(axes, places, paper.view, colours)

    # Titles and caption.
    share = mixed.volume / shadow.volume
    panel_title(figure.axes[0], "a", f"{len(places)} prints, and all mixtures of them: volume {mixed.volume:.3g}")
    panel_title(
        figure.axes[1], "b", f"The same prints in the envelope's shadow: {share:.0%} of its {shadow.volume:.3g}"
    )
    draw_directions(figure.add_axes((0.455, 0.10, 0.09, 0.13)), paper)
    what = (
        "Being inside means that a mixture of prints comes so near. "
        if isinstance(gamut, HullGamut)
        else "Being inside means that a recipe of the inks is found which prints so near: the prints are some of them. "
    )
    text = f"Each dot is a print, in its own colour. {what}{device_text(device)} Inside is {gamut.label}."
    caption(figure, wrapped(text, 175))
    return figure


@literal
def colours_figure(gamut: ColorimetricGamut | MonitorGamut) -> Drawing:
    """The solid of colours that a device shows, in L*a*b* from the side and from above.

    Raises
    ------
    ValueError
        If the device shows RGB, whose colours are the cube.
    """
    # Cut the solid's triangles into small ones, and bend these into L*a*b*.
    xyz, white, codes = _corners(gamut)
    solid = convex_solid(xyz)
    triangles = _cut(solid.vertices[solid.faces])
    # L*a*b* depends on ratios to the white only, so that any white serves once colours are scaled to it.
    bent = lab(triangles / white * tristimulus(VISIBLE, "illuminant/E").sum(axis=0), "illuminant/E")
    own = encode(triangles.mean(axis=1) @ np.linalg.lstsq(xyz, codes, rcond=None)[0])
    most = 20 * np.ceil(1.05 * np.abs(bent[:, :, 1:]).max() / 20)

    # The solid from the side and from above.
    figure = Drawing(figsize=(12.0, 6.6), facecolor="white")
    headline(figure, f"Colours: {gamut.name}")
    side, above = figure.add_axes((0.06, 0.19, 0.4, 0.64)), figure.add_axes((0.55, 0.19, 0.4, 0.64))
    _draw_colours(side, bent[:, :, [1, 0]], -bent[:, :, 2], own)
    _draw_colours(above, bent[:, :, 1:], bent[:, :, 0], own)
    _ring(above, most)

    # The same scale of a* in both panels.
    side.axvline(0, color=HAIR, lw=0.6, zorder=0)
    side.set(xlim=(-most, most), ylim=(0, 103), xlabel="a*", ylabel="L*")
    above.set(xlim=(-most, most), ylim=(-most, most), xlabel="a*", ylabel="b*", aspect="equal")
    ticks = np.arange(-most + most % 40, most, 40)
    side.set(xticks=ticks, yticks=range(0, 101, 20))
    above.set(xticks=ticks, yticks=ticks)

    # Titles and caption.
    size = f"{_size(triangles, bent):,.0f}"
    for axes, letter, text in (
        (side, "a", f"From the blue side; {size} cubic units of L*a*b*"),
        (above, "b", "From above, white in the middle"),
    ):
        axes.spines[["top", "right"]].set_visible(False)
        axes.tick_params(labelsize=8)
        panel_title(axes, letter, text)
    made = device_text(gamut.device) if isinstance(gamut, ColorimetricGamut) else f"Device: {gamut.monitor.title}."
    caption(figure, wrapped(f"Colours as a screen can show them. Inside is {gamut.label}. {made}", 170))
    return figure


def _dot(axes: Axes, places: Colours, view: View, colours: Colours) -> None:
    """Draw prints as dots in their own colours, the nearer above the farther."""
    order = np.argsort(places @ view.towards)
    x, y = view.project(places[order]).T
    axes.scatter(x, y, s=11, c=colours[order], edgecolors=INK, linewidths=0.25, zorder=4)


def _corners(gamut: ColorimetricGamut | MonitorGamut) -> tuple[Colours, Float[np.ndarray, "3"], Colours]:
    """XYZ of the colours at the corners and of the white, and the corners' linear sRGB against that white."""
    if isinstance(gamut, MonitorGamut):
        if gamut.bands.kind == "rgb":
            raise ValueError(f"{gamut.name}: images in RGB fill the cube of its drive values; there is nothing to draw")
        drive = np.array(np.meshgrid([0.0, 1.0], [0.0, 1.0], [0.0, 1.0])).reshape(3, 8).T
        primaries = gamut.monitor.primaries
        return drive @ primaries.T, primaries.sum(axis=1), drive
    prints, light = gamut.device.samples, spectrum(gamut.light, gamut.bands, reflectance=False)
    codes = (prints * light) @ display_matrix(gamut.bands, light)
    return prints @ gamut.observer, gamut.observer.sum(axis=0), codes


def _draw_colours(
    axes: Axes,
    places: Float[np.ndarray, "piece 3 2"],
    nearness: Float[np.ndarray, "piece 3"],
    own: Float[np.ndarray, "piece 3"],
) -> None:
    """Draw small triangles in their own colours, the nearer above the farther."""
    order = np.argsort(nearness.mean(axis=1))
    axes.add_collection(
        PolyCollection(list(places[order]), facecolors=own[order], edgecolors=own[order], linewidths=0.5, zorder=2)
    )


def _ring(axes: Axes, most: float) -> None:
    """Draw circles of chroma, and the axes of a* and b*."""
    turn = np.linspace(0, 2 * np.pi, 181)
    for chroma in CHROMAS:
        if chroma < most:
            axes.plot(chroma * np.cos(turn), chroma * np.sin(turn), color=HAIR, lw=0.6, zorder=0)
            axes.annotate(f"{chroma}", (-0.74 * chroma, -0.74 * chroma), fontsize=7, color=GREY, zorder=0)
    axes.axhline(0, color=HAIR, lw=0.6, zorder=0)
    axes.axvline(0, color=HAIR, lw=0.6, zorder=0)


def _size(xyz: Float[np.ndarray, "piece 3 3"], bent: Float[np.ndarray, "piece 3 3"]) -> float:
    """The volume in L*a*b* of a convex solid of XYZ; bending leaves outward sides outward."""
    outwards = np.sign(np.linalg.det(xyz - xyz.reshape(-1, 3).mean(axis=0)))
    return float(abs((outwards * np.linalg.det(bent)).sum()) / 6)


def _cut(triangles: Float[np.ndarray, "triangle 3 3"]) -> Float[np.ndarray, "piece 3 3"]:
    """Triangles cut into small ones."""
    n = PIECES
    upright = [(i, j) for i in range(n) for j in range(n - i)]
    corners = [((i, j), (i + 1, j), (i, j + 1)) for i, j in upright]
    corners += [((i + 1, j), (i + 1, j + 1), (i, j + 1)) for i, j in upright if i + j < n - 1]
    weights = np.array([[(n - i - j, i, j) for i, j in piece] for piece in corners]) / n
    return np.einsum("pcw,twx->tpcx", weights, triangles).reshape(-1, 3, 3)
