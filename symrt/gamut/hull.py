"""The convex hull of a device's prints: the gamut of step 4 that follows the device most closely and stays convex.

A spectrum is inside if some mixture of prints, weights w >= 0 of sum 1, comes as near to it as a *tolerance*:
``‖r − Sᵀ w‖ / √K <= tolerance``.  The hull of finitely many prints is thin, and prints that were not measured lie
beside it, so that the tolerance is never less than the gap that sampling leaves, which is measured.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool

from symrt.arrays import PerPixel, PixelBands
from symrt.device.printing import Device
from symrt.gamut.clipping import Interval, check_lines
from symrt.gamut.interface import ANY, check_spectra
from symrt.gamut.mixtures import EXACT, nearest_mixtures
from symrt.gamut.printed import OfPrinter
from symrt.spectra.bands import Number

TOLERANCE = 0.01
"""Root mean square difference of reflectances that passes for none."""
PRINTS_TRIED = 64
"""Prints that the sampling gap is measured with."""
SEED = 0
"""Of the draw of those prints, and of the colours of `symrt.gamut.colorimetric`."""
CUTS = 80
"""Cuts and halvings on each line; each cut leaves about the square of what was missing."""


@dataclass(frozen=True, eq=False)
class HullGamut(OfPrinter):
    """Reflectances that mixtures of a device's prints come near to.

    Parameters
    ----------
    device
        The printer.
    tolerance
        Root mean square difference up to which a spectrum counts as inside.
    gap, gap_95
        The difference by which prints that are not among the samples miss the hull: the median, or the largest where a
        printer's model makes them; and what 95 % of them do not pass.  None of a single print.

    Examples
    --------
    >>> from symrt.device.inks import load_device
    >>> gamut = hull_gamut(load_device("dye3-endura-premier"))
    >>> gamut.contains(np.array([[0.9] * 36, [0.95] * 36]))
    array([ True, False])
    """

    device: Device
    tolerance: float
    gap: float | None
    gap_95: float | None

    model = "hull"
    label = "necessary, as far as the samples are dense"
    """The claim that being inside proves."""

    @property
    def name(self) -> str:
        """The gamut in words."""
        gap = "not measured: one print"
        if self.gap is not None and self.gap_95 is not None:
            gap = f"{self.gap:.4f}, 95 % within {self.gap_95:.4f}"
        return f"hull of {self.device.name}'s prints, within {self.tolerance:.4f} RMS (sampling gap {gap})"

    def distance(self, spectra: PixelBands) -> PerPixel:
        """Root mean square difference from the nearest mixture of prints."""
        check_spectra(spectra, self.bands)
        return np.linalg.norm(spectra - nearest_mixtures(self.device.samples, spectra)[0], axis=1) / self._root

    def contains(self, spectra: PixelBands) -> Bool[np.ndarray, " pixel"]:
        """Whether each spectrum is inside; the boundary is."""
        check_spectra(spectra, self.bands)
        enough = self.tolerance * self._root
        mixtures, _ = nearest_mixtures(self.device.samples, spectra, enough=enough)
        return np.linalg.norm(spectra - mixtures, axis=1) <= enough + EXACT

    def violation(self, spectra: PixelBands) -> PerPixel:
        """The distance of each spectrum from the nearest mixture in excess of the tolerance; 0 inside."""
        excess = self.distance(spectra) - self.tolerance
        return np.where(excess <= EXACT, 0.0, excess)

    def nearest(self, spectra: PixelBands) -> PixelBands:
        """The spectrum of the gamut that is nearest to each: at the tolerance from the nearest mixture."""
        check_spectra(spectra, self.bands)
        mixtures, _ = nearest_mixtures(self.device.samples, spectra)
        away = spectra - mixtures
        length, enough = np.linalg.norm(away, axis=1, keepdims=True), self.tolerance * self._root
        share = enough / np.maximum(length, np.finfo(float).tiny)
        return np.where(length <= enough + EXACT, spectra, mixtures + share * away)

    def support(self, directions: PixelBands) -> PerPixel:
        """The largest inner product of each direction with a spectrum of the gamut."""
        check_spectra(directions, self.bands, ANY)
        prints = (directions @ self.device.samples.T).max(axis=1)
        return prints + self.tolerance * self._root * np.linalg.norm(directions, axis=1)

    def clip(self, origin: PixelBands, direction: PixelBands) -> Interval:
        """The t between which ``origin + t direction`` is inside.

        Cutting planes: a point of the line outside the gamut has a plane between them, beyond which the line is
        outside too.  Cuts at the middle find a point inside or prove that there is none; cuts at the ends, Newton's
        method for the distance, which is convex, close in on the boundary.
        """
        check_lines(origin, direction, np.arange(len(origin)))

        # Bring the directions near length 1, by powers of two: squares of any length neither overflow nor vanish.
        still = ~direction.any(axis=1)
        scale = np.frexp(np.abs(direction).max(axis=1))[1]
        direction = np.ldexp(direction, -scale[:, None])

        # Find a point of each line inside, and then both ends from there.
        low, high = self._ball(origin, direction)
        middle, low, high = self._entered(origin, direction, low, high)
        met = low <= high
        low[met] = self._end(origin[met], direction[met], low[met], middle[met])
        high[met] = self._end(origin[met], direction[met], high[met], middle[met])

        # Undo the scaling.
        with np.errstate(over="ignore"):
            low, high = np.ldexp(low, -scale), np.ldexp(high, -scale)
        # Where a line is so slow that the gamut lies beyond the largest number, no number keeps it inside.
        beyond = met & (np.isposinf(low) | np.isneginf(high))
        largest = np.finfo(float).max
        low[met], high[met] = np.maximum(low[met], -largest), np.minimum(high[met], largest)
        low[beyond], high[beyond] = np.inf, -np.inf

        # A line that does not move is inside for every t, or for none.
        inside = still & self.contains(origin) if still.any() else still
        low = np.where(still, np.where(inside, -np.inf, np.inf), low)
        high = np.where(still, np.where(inside, np.inf, -np.inf), high)
        return Interval(low, high, beyond & ~still)

    def reach(self, origin: PixelBands, direction: PixelBands) -> PerPixel:
        """The largest t <= 1 for which ``origin + t direction`` is inside, from an origin that is: half of a clip.

        Examples
        --------
        >>> from symrt.device.inks import load_device
        >>> hull = hull_gamut(load_device("dye3-endura-premier"))
        >>> hull.reach(np.full((1, 36), 0.5), np.full((1, 36), 1.0)).round(3)
        array([0.41])
        """
        return self._end(origin, direction, np.ones(len(origin)), np.zeros(len(origin)))

    @property
    def _root(self) -> float:
        return float(np.sqrt(len(self.bands)))

    def _ball(self, origin: PixelBands, direction: PixelBands) -> tuple[PerPixel, PerPixel]:
        """The interval of each line in a ball around the gamut; outside it there is nothing to look for."""
        centre = self.device.samples.mean(axis=0)
        radius = np.linalg.norm(self.device.samples - centre, axis=1).max() + self.tolerance * self._root + EXACT
        square = np.where(direction.any(axis=1), np.sum(direction**2, axis=1), 1.0)
        nearest = -np.sum((origin - centre) * direction, axis=1) / square
        apart = np.sum((origin + nearest[:, None] * direction - centre) ** 2, axis=1)
        half = np.sqrt(np.maximum(radius**2 - apart, 0) / square)
        met = (apart <= radius**2) & direction.any(axis=1)
        return np.where(met, nearest - half, np.inf), np.where(met, nearest + half, -np.inf)

    def _entered(
        self, origin: PixelBands, direction: PixelBands, low: PerPixel, high: PerPixel
    ) -> tuple[PerPixel, PerPixel, PerPixel]:
        """A point of each line inside the gamut, and ends beyond it; ``inf`` and ``-inf`` if there is none."""
        low, high = low.copy(), high.copy()
        middle = np.zeros(len(low))
        open_ = low <= high

        # Cut at the middle of what is left of each line, until that is inside or nothing is left.
        for _ in range(CUTS):
            rows = np.flatnonzero(open_)
            if not rows.size:
                break
            middle[rows] = (low[rows] + high[rows]) / 2
            first, last, inside = self._cut(origin[rows], direction[rows], middle[rows])
            low[rows], high[rows] = np.maximum(low[rows], first), np.minimum(high[rows], last)
            open_[rows] = ~inside & (low[rows] <= high[rows])

        # A line that is still open after all steps counts as missed.
        missed = open_ | (low > high)
        low[missed], high[missed] = np.inf, -np.inf
        return middle, low, high

    def _cut(
        self, origin: PixelBands, direction: PixelBands, t: PerPixel
    ) -> tuple[PerPixel, PerPixel, Bool[np.ndarray, " pixel"]]:
        """Ends that a plane between the gamut and a point of each line allows, and whether that point is inside."""
        # The plane stands in the nearest mixture, across the way to it.
        points = origin + t[:, None] * direction
        mixtures, _ = nearest_mixtures(self.device.samples, points)
        normals = points - mixtures

        # The line is clipped by a hull that is a little smaller, so that no end is too far; where there is no tolerance
        # to take that from, a point may be half of what `contains` allows beside it.
        enough = self.tolerance * self._root
        enough = enough - EXACT if enough > 2 * EXACT else enough
        inside = np.linalg.norm(normals, axis=1) <= enough + EXACT / 2

        # Cross the plane: ``normals · (origin + t direction) <= reached``.
        reached = (normals @ self.device.samples.T).max(axis=1) + enough * np.linalg.norm(normals, axis=1)
        room = reached - np.sum(normals * origin, axis=1)
        rate = np.sum(normals * direction, axis=1)
        with np.errstate(divide="ignore", invalid="ignore"):
            crossing = room / rate
        first = np.where(~inside & (rate < 0), crossing, -np.inf)
        last = np.where(~inside & (rate > 0), crossing, np.inf)

        # A line parallel to the plane, outside it, never comes inside.
        parallel = ~inside & (rate == 0)
        return np.where(parallel, np.inf, first), np.where(parallel, -np.inf, last), inside

    def _end(self, origin: PixelBands, direction: PixelBands, outer: PerPixel, inner: PerPixel) -> PerPixel:
        """The last point inside, between one that is and one that may not be."""
        outer, inner = outer.copy(), inner.copy()
        for _ in range(CUTS):
            wide = np.abs(outer - inner) * np.linalg.norm(direction, axis=1) > EXACT
            rows = np.flatnonzero(wide)
            if not rows.size:
                break
            # An outer point that is inside is the end; one that is not moves to the plane before it.
            first, last, inside = self._cut(origin[rows], direction[rows], outer[rows])
            inner[rows] = np.where(inside, outer[rows], inner[rows])
            rising = outer[rows] < inner[rows]
            cut = np.where(rising, np.maximum(outer[rows], first), np.minimum(outer[rows], last))
            outer[rows] = np.where(inside, outer[rows], cut)
        return inner

    def __repr__(self) -> str:
        modelled = " (modelled)" if self.device.modelled else ""
        return f"HullGamut({self.name}{modelled}; inside is {self.label}, not sufficient)"


def hull_gamut(device: Device, tolerance: Number = TOLERANCE) -> HullGamut:
    """The hull of a device's prints, within a tolerance that is never less than the sampling gap.

    Parameters
    ----------
    device
        Printer or chart.
    tolerance
        Root mean square difference of reflectances.

    Examples
    --------
    >>> from symrt.device.inks import load_device
    >>> gamut = hull_gamut(load_device("dye3-endura-premier"), tolerance=0.0)
    >>> gamut.tolerance == gamut.gap, 0.001 < gamut.gap < 0.01
    (True, True)
    """
    if not 0 <= tolerance <= 1:
        raise ValueError(f"tolerance = {tolerance}: a root mean square difference of reflectances is from 0 to 1")
    gap, gap_95 = _sampling_gap(device)
    return HullGamut(device, max(float(tolerance), gap or 0.0), gap, gap_95)


def _sampling_gap(device: Device) -> tuple[float, float] | tuple[None, None]:
    """The distance of further prints from the hull, by root mean square.

    A printer's model prints some anew, and the farthest counts.  Without one each of some prints is taken from the
    chart in turn; since corners of the hull are far from all others, the median counts, and what 95 % do not pass is
    told beside it.  Of a single print nothing is left to compare it with.
    """
    draw = np.random.default_rng(SEED)
    root = np.sqrt(len(device.bands))

    # A model prints new amounts, all inks anywhere between none and their most.
    if device.printer and device.modelled:
        amounts = draw.uniform(0, device.printer.most, (PRINTS_TRIED, len(device.inks)))
        prints = device.printer.printed(amounts)
        misses = np.linalg.norm(prints - nearest_mixtures(device.samples, prints)[0], axis=1) / root
        return float(misses.max()), float(np.percentile(misses, 95))

    # Of a chart, take prints out in turn.
    tried = draw.permutation(len(device.samples))[:PRINTS_TRIED]
    if len(device.samples) < 2:
        return None, None
    distances = [
        np.linalg.norm(s - nearest_mixtures(np.delete(device.samples, i, axis=0), s[None])[0])
        for i, s in zip(tried, device.samples[tried], strict=True)
    ]
    misses = np.array(distances) / root
    return float(np.median(misses)), float(np.percentile(misses, 95))
