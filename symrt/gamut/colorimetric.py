"""The conventional gamut of colour management: the colours of a device's prints under one viewing light, in step 4.

It is the convex hull of the prints' XYZ, a solid in three dimensions, and so a set of half-spaces of reflectances.
Being inside is necessary for a print of the same colour under that light; under another one the match may break [1]_.
The hull of finitely many prints leaves out colours between them, so that a colour may be outside a face by a
*tolerance*, a share of its own luminance, or of the lightest print's if that is less: ``n · XYZ <= offset + tolerance
min(Y, Y_max)``, which is two half-spaces.  It is never less than the gap by which prints that are not among the samples
miss the hull, which is measured.

References
----------
.. [1] M. C. Stone, W. B. Cowan and J. C. Beatty, "Color Gamut Mapping and the Printing of Digital Color Images", ACM
   TOG 7(4), 1988, pp. 249-292.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float
from scipy.spatial import ConvexHull, HalfspaceIntersection, QhullError

from symrt.arrays import PerPixel, PixelBands
from symrt.device.colorimetry import lab, tristimulus
from symrt.device.printing import Device
from symrt.gamut.clipping import Interval
from symrt.gamut.hull import SEED
from symrt.gamut.interface import ANY, ON_BOUNDARY, WIDER, Slabs, beyond_rounding, check_spectra
from symrt.gamut.mixtures import nearest_mixtures
from symrt.gamut.printed import OfPrinter
from symrt.spectra.bands import Number
from symrt.spectra.library import colour_difference

COLOURS_TRIED = 256
"""Prints that the sampling gap is measured with."""
STEP = 1e-6
"""Of XYZ, in which the direction of a face is looked at."""
DARKEST = 1e-3
"""Luminance of white's 1 below which no share is taken: no print is darker, and of black there are no shares."""
HUES = ("red", "yellow", "green", "blue")
"""Of the axes of a* and b*, from 0° by 90°."""


@dataclass(frozen=True, eq=False)
class ColorimetricGamut(OfPrinter):
    """Reflectances whose colour under a viewing light lies among those of a device's prints.

    Parameters
    ----------
    device
        The printer.
    light
        The viewing light.
    colours
        XYZ of the corners of the solid; a perfect diffuser has Y = 1.
    normals, offsets
        Its faces: inside is where ``normals · XYZ <= offsets``.
    tolerance
        How far outside the hull of the prints a colour may be, in XYZ, as a share of its luminance, or of the lightest
        print's if that is less.
    gap, gap_delta_e
        By how much prints that are not among the samples miss that hull: the same share, and in CIEDE2000; see
        `colorimetric_gamut`.  None if no print could be left out, of a chart of four.

    Examples
    --------
    >>> from symrt.device.inks import load_device
    >>> gamut = colorimetric_gamut(load_device("dye3-endura-premier"))
    >>> gamut.contains(np.array([[0.5] * 36, [0.95] * 36]))
    array([ True, False])
    """

    device: Device
    light: str
    colours: Float[np.ndarray, "corner 3"]
    normals: Float[np.ndarray, "face 3"]
    offsets: Float[np.ndarray, " face"]
    tolerance: float
    gap: float | None
    gap_delta_e: float | None

    model = "colorimetric"

    @property
    def label(self) -> str:
        """The claim that being inside proves."""
        return f"necessary for a colour match under {self.light}, as far as the samples are dense"

    @property
    def name(self) -> str:
        """The gamut in words."""
        gap = "not measured: too few prints"
        if self.gap is not None and self.gap_delta_e is not None:
            gap = f"{self.gap:.2%}, {self.gap_delta_e:.1f} ΔE2000"
        return (
            f"colours of {self.device.name}'s prints under {self.light}, within {self.tolerance:.2%} of Y "
            f"(sampling gap {gap})"
        )

    @property
    def observer(self) -> Float[np.ndarray, "band 3"]:
        """The matrix that takes a reflectance to XYZ under the viewing light."""
        return tristimulus(self.bands, self.light)

    def contains(self, spectra: PixelBands) -> Bool[np.ndarray, " pixel"]:
        """Whether the colour of each spectrum is inside; the boundary is."""
        return self.violation(spectra) == 0

    def violation(self, spectra: PixelBands) -> PerPixel:
        """The distance of each colour beyond the worst face, in XYZ; 0 inside, and within rounding of the boundary."""
        check_spectra(spectra, self.bands)
        worst = ((spectra @ self.observer) @ self.normals.T - self.offsets).max(axis=1)
        return beyond_rounding(worst, spectra, self.observer)

    def nearest(self, spectra: PixelBands) -> PixelBands:
        """The spectrum nearest to each, by root mean square, among those whose colour is inside."""
        check_spectra(spectra, self.bands)
        # In coordinates in which a colour's length is that of the least reflectance with it, nearest is nearest.
        square = self.observer.T @ self.observer
        to_colour = np.linalg.cholesky(square)
        to_length = np.linalg.inv(to_colour)
        nearest = spectra.copy()
        for _ in range(2):  # the second time takes out what rounding left of the first, far away
            rows = np.flatnonzero(~self.contains(nearest))
            xyz = nearest[rows] @ self.observer
            mixtures, _ = nearest_mixtures(self.colours @ to_length.T, xyz @ to_length.T)
            nearest[rows] += (mixtures @ to_colour.T - xyz) @ np.linalg.solve(square, self.observer.T)
        return nearest

    def support(self, directions: PixelBands) -> PerPixel:
        """The largest inner product with a spectrum whose colour is inside; ``inf`` unless colour alone decides it."""
        check_spectra(directions, self.bands, ANY)
        along = np.linalg.lstsq(self.observer, directions.T, rcond=None)[0].T
        missed = np.abs(directions - along @ self.observer.T).max(axis=1)
        decided = missed <= ON_BOUNDARY * np.abs(directions).max(axis=1)
        return np.where(decided, (along @ self.colours.T).max(axis=1), np.inf)

    @property
    def slabs(self) -> Slabs:
        """The half-spaces of reflectances that the solid's faces are."""
        count = len(self.offsets)
        whose = f"{self.device.name}'s colours under {self.light.removeprefix('illuminant/')}"
        words = tuple(f"the {side} side of {whose}" for side in self._sides())
        no = np.zeros(count, dtype=bool)
        outer = self.offsets + WIDER
        return Slabs(self.observer @ self.normals.T, np.full(count, -np.inf), outer, np.full(count, -1), words, no, no)

    def clip(self, origin: PixelBands, direction: PixelBands) -> Interval:
        """The t for which the colour of ``origin + t direction`` is inside."""
        return self.slabs.clip(origin, direction)

    def _sides(self) -> list[str]:
        """A word for each face, ``light`` or ``red``: the direction outwards in L*a*b* from its middle."""
        on_face = np.abs(self.colours @ self.normals.T - self.offsets) <= ON_BOUNDARY
        # The middle of a face is the mean of its corners; a small step along the normal gives its direction in L*a*b*.
        middles = (on_face.T @ self.colours) / np.maximum(on_face.sum(axis=0), 1)[:, None]
        away = lab(middles + STEP * self.normals, self.light) - lab(middles, self.light)

        # Name the lightness where it changes most, otherwise the nearest of four hues.
        hue = np.round(np.degrees(np.arctan2(away[:, 2], away[:, 1])) / 90).astype(int) % 4
        chroma = np.hypot(away[:, 1], away[:, 2])
        return [
            ("light" if lightness > 0 else "dark") if abs(lightness) > strength else HUES[quarter]
            for lightness, strength, quarter in zip(away[:, 0], chroma, hue, strict=True)
        ]

    def __repr__(self) -> str:
        modelled = " (modelled)" if self.device.modelled else ""
        return f"ColorimetricGamut({self.name}{modelled}; inside is {self.label}, not sufficient)"


def colorimetric_gamut(device: Device, light: str = "illuminant/D50", tolerance: Number = 0.0) -> ColorimetricGamut:
    """The colours that a device prints, as they look under a light.

    Parameters
    ----------
    device
        Printer or chart.
    light
        An illuminant of the library.
    tolerance
        How far outside the hull of the prints a colour may be, in XYZ, as a share of its luminance, or of the lightest
        print's if that is less; never less than the sampling gap: what 95 % of prints that are not among the samples do
        not pass, or all that a printer's model makes for the purpose.

    Raises
    ------
    ValueError
        If the prints' colours lie in a plane, or there is no such light.

    Examples
    --------
    >>> from symrt.device.inks import load_device
    >>> colorimetric_gamut(load_device("dye3-endura-premier"), "illuminant/A").label
    'necessary for a colour match under illuminant/A, as far as the samples are dense'
    """
    if not 0 <= tolerance <= 1:
        raise ValueError(f"tolerance = {tolerance}: it is a share of a colour's luminance, from 0 to 1")

    # Enclose the colours of the prints.
    xyz = device.samples @ tristimulus(device.bands, light)
    try:
        hull = ConvexHull(xyz)
    except QhullError:
        raise ValueError(
            f"{device.name}: the colours of its {len(xyz)} prints lie in a plane or a line, or are fewer than four: "
            "a solid needs prints of more colours"
        ) from None

    # Measure the gap that sampling leaves, and move the faces out by it or by the tolerance.
    gap, gap_delta_e = _sampling_gap(device, light, xyz, hull)
    wide = max(float(tolerance), gap or 0.0)
    if wide:
        # Every face gives way by a share of Y, and by no more than at the lightest print: without that what lies
        # inside would have no end upwards.  The corners are where the faces meet then.
        tilted, moved = hull.equations - [0.0, wide, 0.0, 0.0], hull.equations - [0.0, 0.0, 0.0, wide * xyz[:, 1].max()]
        faces = np.vstack([tilted, moved])
        hull = ConvexHull(HalfspaceIntersection(faces, xyz[hull.vertices].mean(axis=0)).intersections)

    # Qhull gives triangles: those of one face share an equation, which is kept once.
    faces = np.unique(hull.equations, axis=0)
    corners = hull.points[hull.vertices]
    return ColorimetricGamut(device, light, corners, faces[:, :3], -faces[:, 3], wide, gap, gap_delta_e)


def _sampling_gap(
    device: Device, light: str, xyz: Float[np.ndarray, "print 3"], hull: ConvexHull
) -> tuple[float, float] | tuple[None, None]:
    """The distance of colours of further prints from the hull, as a share of luminance and in CIEDE2000.

    A printer's model prints some anew, saturated ones among them, and the farthest counts.  Without one each of some
    prints is taken from the chart in turn, and 95 % count: the corners of a gamut are far from all other prints.
    Nothing is known where no other prints are a solid.
    """
    draw = np.random.default_rng(SEED)
    if device.printer and device.modelled:
        # Print new amounts: each ink at none, at its most, or anywhere between.
        most = device.printer.most
        amounts = draw.choice([0.0, most, np.nan], (COLOURS_TRIED, len(device.inks)))
        amounts = np.where(np.isnan(amounts), draw.uniform(0, most, amounts.shape), amounts)
        colours = device.printer.printed(amounts) @ tristimulus(device.bands, light)
        pairs = [(colour, hull) for colour in colours]
        share = 100.0
    else:
        # Take prints of the chart out in turn.
        tried = draw.permutation(len(xyz))[:COLOURS_TRIED]
        # Without a print that is no corner the hull is the same.
        corner = np.isin(tried, hull.vertices)
        pairs = [(xyz[k], _hull_without(xyz, int(k)) if at else hull) for k, at in zip(tried, corner, strict=True)]
        share = 95.0

    # Summarise the misses by a percentile: all of a model's prints, 95 % of a chart's.
    misses = np.array([_missed(colour, left, light) for colour, left in pairs if left is not None])
    if not len(misses):
        return None, None
    distance, difference = np.percentile(misses, share, axis=0)
    return float(distance), float(difference)


def _hull_without(xyz: Float[np.ndarray, "print 3"], k: int) -> ConvexHull | None:
    """The hull of all colours but one; None where they lie in a plane then."""
    try:
        return ConvexHull(np.delete(xyz, k, axis=0))
    except QhullError:
        return None


def _missed(colour: Float[np.ndarray, "3"], hull: ConvexHull, light: str) -> tuple[float, float]:
    """The distance of a colour beyond a hull's worst face, as a share of luminance, and its CIEDE2000 from the hull."""
    beyond = float((hull.equations[:, :3] @ colour + hull.equations[:, 3]).max())
    if beyond <= 0:
        return 0.0, 0.0
    share = beyond / max(DARKEST, min(colour[1], hull.points[:, 1].max()))
    nearest, _ = nearest_mixtures(hull.points[hull.vertices], colour[None])
    return float(share), float(colour_difference(lab(nearest, light), lab(colour[None], light))[0])
