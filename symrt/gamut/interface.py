"""The questions that every convex gamut of step 4 answers, whichever model of the device stands behind it."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Bool, Float, Int

from symrt.arrays import PerPixel, PixelBands, Spectrum
from symrt.device.printing import Device
from symrt.gamut.clipping import Interval, check_lines, clip_slabs
from symrt.spectra.bands import Bands

ON_BOUNDARY = 1e-12
"""Of numbers near 1: what is so near to a boundary is on it."""
WIDER = ON_BOUNDARY / 2
"""By which lines are clipped wider where products are rounded: one through the boundary itself is inside."""
ROUNDING = 2.0**-53
"""Largest relative error of one rounding."""
LARGEST_REFLECTANCE = 1e9
"""Of a reflectance; where numbers are larger, rounding may be as large as a gamut."""
ANY = float(np.finfo(float).max)
"""Of a direction."""

Places = Float[np.ndarray, "pixel slab"]


@dataclass(frozen=True, eq=False)
class Slabs:
    """Pairs of parallel planes, ``lower <= r A <= upper``, whose intersection is a gamut.

    Parameters
    ----------
    matrix
        A: one column a slab.
    lower, upper
        Bounds, infinite where a slab is open.
    bands
        The band that each slab bounds alone, -1 where it weighs several.
    words
        The quantity that each slab bounds: ``"560 nm"``, ``"luminance"``, ``"the monitor's red"``.
    dark
        True where the lower bound is that of a device's black, which no parameter can bring shadows above.
    extrapolated
        True where the device was not measured in what the slab bounds.

    Examples
    --------
    >>> none = np.array([False])
    >>> mean = Slabs(np.full((2, 1), 0.5), np.zeros(1), np.ones(1), np.array([-1]), ("the mean",), none, none)
    >>> mean.clip(np.array([[0.0, 0.0]]), np.array([[1.0, 3.0]])).high.round(9)
    array([0.5])
    """

    matrix: Float[np.ndarray, "band slab"]
    lower: Float[np.ndarray, " slab"]
    upper: Float[np.ndarray, " slab"]
    bands: Int[np.ndarray, " slab"]
    words: tuple[str, ...]
    dark: Bool[np.ndarray, " slab"]
    extrapolated: Bool[np.ndarray, " slab"]

    def clip(self, origin: PixelBands, direction: PixelBands) -> Interval:
        """The t for which ``origin + t direction`` is inside, whatever the rounding of the products with A.

        Each product is off by a share of what it would be if nothing cancelled.  A first clip says how large t gets;
        a second one keeps off every bound by as much as the products can be off there.
        """
        check_lines(origin, direction, np.arange(len(origin)))

        # Clip once, to know how large t gets.
        start, rate = origin @ self.matrix, direction @ self.matrix
        first = clip_slabs(self.lower, self.upper, start, rate)
        ends = np.stack([first.low, first.high])
        far = np.abs(np.where(np.isfinite(ends), ends, 0.0)).max(axis=0)

        # Bound the error of each product there: as many roundings as it has terms, of the terms' sizes.
        size, growth = np.abs(origin) @ np.abs(self.matrix), np.abs(direction) @ np.abs(self.matrix)
        # The product with a band alone is exact.
        terms = np.where(of_one_band(self.matrix), 0, len(self.matrix) + 2)
        off = 4 * terms * ROUNDING * (size + far[:, None] * growth)

        # Clip again, the line above each slab's upper bound and below its lower one by that error.
        # A slab that the line does not cross asks for nothing: it was decided by the first clip.
        still = rate == 0
        above, below = (np.where(still, start, start + sign * off) for sign in (1.0, -1.0))
        bounds = np.full(len(self.lower), -np.inf), np.full(len(self.lower), np.inf)
        return clip_slabs(
            np.concatenate([bounds[0], self.lower]),
            np.concatenate([self.upper, bounds[1]]),
            np.hstack([above, below]),
            np.hstack([rate, rate]),
        )


@runtime_checkable
class ConvexGamut(Protocol):
    """A convex set of reflectances, and the claim that being inside it proves."""

    @property
    def model(self) -> str:
        """The kind of gamut, in a word."""

    @property
    def name(self) -> str:
        """The gamut in words."""

    @property
    def label(self) -> str:
        """The claim that being inside proves: ``necessary`` or ``sufficient``, and for what."""

    @property
    def bands(self) -> Bands:
        """Wavelengths of its spectra."""

    @property
    def devices(self) -> tuple[Device, ...]:
        """The printers whose black is the darkest that there is; none for a monitor."""

    def under(self, white: Spectrum) -> "ConvexGamut":
        """The same gamut for reflectances against another white."""

    def contains(self, spectra: PixelBands) -> Bool[np.ndarray, " pixel"]:
        """Whether each spectrum is inside; the boundary is."""

    def violation(self, spectra: PixelBands) -> PerPixel:
        """The distance of each spectrum from the gamut, in its own measure; 0 inside."""

    def nearest(self, spectra: PixelBands) -> PixelBands:
        """The spectrum of the gamut that is nearest to each, by root mean square."""

    def support(self, directions: PixelBands) -> PerPixel:
        """The largest inner product of each direction with a spectrum of the gamut; ``inf`` where there is none."""

    def clip(self, origin: PixelBands, direction: PixelBands) -> Interval:
        """The t between which ``origin + t direction`` is inside."""


@runtime_checkable
class SlabGamut(ConvexGamut, Protocol):
    """A gamut that pairs of parallel planes bound: ranges and fits ask it for every pixel at once."""

    @property
    def slabs(self) -> Slabs:
        """The pairs of planes."""

    def under(self, white: Spectrum) -> "SlabGamut":
        """The same gamut for reflectances against another white."""


def of_one_band(matrix: Float[np.ndarray, "band slab"]) -> Bool[np.ndarray, " slab"]:
    """Slabs that bound a band itself, not a multiple of it, nor several.

    Examples
    --------
    >>> of_one_band(np.array([[1.0, 2.0, 0.5], [0.0, 0.0, 0.5]]))
    array([ True, False, False])
    """
    return (np.count_nonzero(matrix, axis=0) == 1) & (matrix.sum(axis=0) == 1)


def check_spectra(spectra: PixelBands, bands: Bands, largest: float = LARGEST_REFLECTANCE) -> None:
    """Refuse spectra in other bands, and numbers that no reflectance is: nothing is inside or outside then.

    Examples
    --------
    >>> from symrt.spectra.bands import RGB
    >>> check_spectra(np.array([[0.5, np.nan, 0.5]]), RGB)
    Traceback (most recent call last):
    ValueError: spectrum 0 is nan at green: give finite numbers
    """
    if spectra.ndim != 2 or spectra.shape[1] != len(bands):
        raise ValueError(
            f"spectra are {spectra.shape}, and the gamut is in {bands!r}: give a row a spectrum, and a column a band"
        )
    wrong = ~(np.abs(spectra) <= largest)
    if wrong.any():
        row, band = (int(k) for k in np.argwhere(wrong)[0])
        value = spectra[row, band]
        remedy = f"no reflectance is beyond {largest:g}" if np.isfinite(value) else "give finite numbers"
        raise ValueError(f"spectrum {row} is {value} at {bands.labels[band]}: {remedy}")


def beyond_rounding(excess: PerPixel, spectra: PixelBands, matrix: Float[np.ndarray, "band slab"]) -> PerPixel:
    """The excess of products of spectra with a matrix over their bounds; 0 where it is no more than their rounding.

    Examples
    --------
    >>> beyond_rounding(np.array([1e-9, 1e-9]), np.array([[1.0], [1e6]]), np.eye(1))
    array([1.e-09, 0.e+00])
    """
    size = np.abs(spectra).max(axis=1, initial=0.0) * np.abs(matrix).sum(axis=0).max()
    return np.where(excess <= ON_BOUNDARY * np.maximum(size, 1.0), 0.0, excess)


def stacked(slabs: Sequence[Slabs], bands: int) -> Slabs:
    """All slabs of several gamuts: those of their intersection; of none, no slab of so many bands.

    Examples
    --------
    >>> stacked([], 36).matrix.shape
    (36, 0)
    """
    # Of no slabs at all, one without columns still says in how many bands they would be.
    none = np.zeros(0)
    no = np.zeros(0, dtype=bool)
    empty = Slabs(np.zeros((bands, 0)), none, none, np.zeros(0, dtype=int), (), no, no)

    # Every part of the record is strung together.
    every = [empty, *slabs]
    return Slabs(
        np.hstack([one.matrix for one in every]),
        np.concatenate([one.lower for one in every]),
        np.concatenate([one.upper for one in every]),
        np.concatenate([one.bands for one in every]),
        tuple(word for one in every for word in one.words),
        np.concatenate([one.dark for one in every]),
        np.concatenate([one.extrapolated for one in every]),
    )


def clip(gamut: ConvexGamut, origin: PixelBands, direction: PixelBands) -> Interval:
    """Clip the line ``origin + t direction`` of every pixel, in reflectances, to a gamut.

    Examples
    --------
    >>> from symrt.device.inks import load_device
    >>> from symrt.gamut.gamuts import device_gamut
    >>> gamut = device_gamut(load_device("dye3-endura-premier"), "envelope")
    >>> clip(gamut, np.zeros((1, 36)), np.full((1, 36), 0.5)).high.round(3)
    array([1.8])
    """
    return gamut.clip(origin, direction)
