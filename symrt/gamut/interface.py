"""What every convex gamut of step 4 can be asked, whichever model of the device stands behind it."""

from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Bool, Float

from symrt.arrays import PerPixel, PixelBands, Spectrum
from symrt.spectra.bands import Bands

__all__ = ["ClippingGamut", "ConvexGamut", "clip_halfspaces"]

ROUNDING = 1e-12
"""Of numbers near 1: what is so near to a boundary is on it."""


@runtime_checkable
class ConvexGamut(Protocol):
    """A convex set of reflectances, and what being inside it proves."""

    @property
    def name(self) -> str:
        """The gamut in words."""

    @property
    def label(self) -> str:
        """What being inside proves: ``necessary`` or ``sufficient``, and for what."""

    @property
    def bands(self) -> Bands:
        """Wavelengths of its spectra."""

    def under(self, white: Spectrum) -> "ConvexGamut":
        """The same gamut for reflectances against another white."""

    def contains(self, spectra: PixelBands) -> Bool[np.ndarray, " pixel"]:
        """Whether each spectrum is inside; the boundary is."""

    def violation(self, spectra: PixelBands) -> PerPixel:
        """How far each spectrum is outside; 0 inside."""

    def nearest(self, spectra: PixelBands) -> PixelBands:
        """The spectrum of the gamut that is nearest to each, by root mean square."""

    def support(self, directions: PixelBands) -> PerPixel:
        """The largest inner product of each direction with a spectrum of the gamut; ``inf`` where there is none."""


@runtime_checkable
class ClippingGamut(ConvexGamut, Protocol):
    """A gamut that clips lines itself; those made of slabs are clipped by `symrt.feedback.clip`, certified."""

    def clip(self, origin: PixelBands, direction: PixelBands) -> tuple[PerPixel, PerPixel]:
        """Low and high t between which ``origin + t direction`` is inside; ``inf`` and ``-inf`` where it never is."""


def clip_halfspaces(
    normals: Float[np.ndarray, "face band"],
    offsets: Float[np.ndarray, " face"],
    origin: PixelBands,
    direction: PixelBands,
) -> tuple[PerPixel, PerPixel]:
    """Clip the line ``origin + t direction`` of every pixel to ``normals r <= offsets``.

    Examples
    --------
    >>> clip_halfspaces(np.array([[1.0], [-1.0]]), np.array([2.0, 0.0]), np.array([[1.0]]), np.array([[0.5]]))
    (array([-2.]), array([2.]))
    """
    room = offsets - origin @ normals.T
    rate = direction @ normals.T
    # A line along a face never crosses it: the face allows all of the line or none.
    along = np.abs(rate) <= ROUNDING * np.abs(rate).max(axis=1, keepdims=True)
    with np.errstate(divide="ignore", invalid="ignore"):
        crossing = room / rate
    low = np.where(~along & (rate < 0), crossing, -np.inf).max(axis=1)
    high = np.where(~along & (rate > 0), crossing, np.inf).min(axis=1)
    never = (along & (room < -ROUNDING)).any(axis=1) | (low > high)
    return np.where(never, np.inf, low), np.where(never, -np.inf, high)
