"""Bands: what the last axis of a spectrum or an image counts, in step 3 of the paper.

The same G serves any last axis: wavelengths in nm, linear sRGB, or coordinates in a basis.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Float

from symrt.arrays import Spectrum

Number = float | int
Kind = Literal["wavelength", "rgb", "coordinate"]
SHORTEST, LONGEST = 100.0, 3000.0


@dataclass(frozen=True)
class Bands:
    """The last axis of a spectrum.

    Parameters
    ----------
    centres
        Wavelengths in nm, increasing; for the other kinds the position 0, 1, 2 …
    kind
        The axis that they lie on.

    Examples
    --------
    >>> Bands((450.0, 550.0, 600.0))
    Bands(3 wavelengths, 450 … 600 nm)
    """

    centres: tuple[Number, ...]
    kind: Kind = "wavelength"

    def __post_init__(self) -> None:
        if not self.centres:
            raise ValueError("no bands: a spectrum needs at least one")
        if self.kind == "wavelength":
            check_wavelengths(np.array(self.centres, dtype=float), "bands")

    @property
    def labels(self) -> tuple[str, ...]:
        """A text to write beside each band."""
        if self.kind == "rgb":
            return ("red", "green", "blue")
        return tuple(f"{c:g} nm" if self.kind == "wavelength" else f"c{c:g}" for c in self.centres)

    @property
    def widths(self) -> Spectrum:
        """The part of the axis, in nm, that each band stands for; a band at either end counts as wide as its step."""
        centres = np.array(self.centres)
        if self.kind != "wavelength" or len(self) == 1:
            return np.ones(len(self))
        edges = (centres[1:] + centres[:-1]) / 2
        first, last = 2 * centres[0] - edges[0], 2 * centres[-1] - edges[-1]
        return np.diff(np.concatenate([[first], edges, [last]]))

    def __len__(self) -> int:
        return len(self.centres)

    def __repr__(self) -> str:
        if self.kind == "wavelength":
            return f"Bands({len(self)} wavelengths, {self.centres[0]:g} … {self.centres[-1]:g} nm)"
        return "RGB" if self.kind == "rgb" else f"Bands({len(self)} coordinates)"


RGB = Bands((0.0, 1.0, 2.0), "rgb")
"""Linear sRGB: red, green, blue, not gamma-encoded."""


def wavelengths(first: Number, last: Number, step: Number) -> Bands:
    """Evenly spaced wavelengths in nm, the last one included.

    Examples
    --------
    >>> wavelengths(380, 730, 10)
    Bands(36 wavelengths, 380 … 730 nm)
    """
    if not (np.all(np.isfinite([first, last, step])) and step > 0 and last >= first):
        raise ValueError(f"wavelengths({first}, {last}, {step}): give first <= last and a step above 0, in nm")
    check_wavelengths(np.unique(np.array([first, last], dtype=float)), f"wavelengths({first}, {last}, {step})")
    steps = (last - first) / step
    if steps > 100_000 or abs(steps - round(steps)) > 1e-9 * max(1.0, steps):
        raise ValueError(f"wavelengths({first}, {last}, {step}): {last} is not a whole number of steps from {first}")
    return Bands(tuple(float(first + step * i) for i in range(round(steps) + 1)))


def coordinates(count: int) -> Bands:
    """The axis of an image in a basis of `count` spectra.

    Examples
    --------
    >>> coordinates(2).labels
    ('c0', 'c1')
    """
    return Bands(tuple(float(i) for i in range(count)), "coordinate")


def resample(
    nm: Float[np.ndarray, " sample"], values: Float[np.ndarray, " sample"], bands: Bands, name: str = "spectrum"
) -> Spectrum:
    """A tabulated spectrum at the centres of `bands`, linearly interpolated, never extrapolated.

    Linear because it keeps a reflectance in [0, 1]; smoother rules overshoot at steps.

    Raises
    ------
    ValueError
        If the table is not in increasing nm, or does not cover the bands.

    Examples
    --------
    >>> resample(np.array([400.0, 500.0]), np.array([0.2, 0.4]), Bands((450.0,)))
    array([0.3])
    """
    if bands.kind != "wavelength":
        raise ValueError(f"{name} is tabulated over wavelengths, but the bands are {bands!r}: use wavelengths(…)")
    check_wavelengths(nm, name)
    low, high = bands.centres[0], bands.centres[-1]
    if not (nm[0] <= low and high <= nm[-1]):
        raise ValueError(
            f"{name} covers {nm[0]:g} … {nm[-1]:g} nm, but the bands run from {low:g} to {high:g} nm: nothing is "
            "extrapolated; give data for the rest or choose narrower bands"
        )
    return np.interp(np.array(bands.centres), nm, values)


def check_wavelengths(nm: Float[np.ndarray, " sample"], name: str) -> None:
    """Refuse wavelengths that are not increasing nanometres, and say what they look like instead."""
    # Numbers, in nanometres.
    if nm.size == 0:
        raise ValueError(f"{name}: no wavelengths")
    if not np.all(np.isfinite(nm)):
        raise ValueError(f"{name}: wavelength {nm[~np.isfinite(nm)][0]} is not a number of nanometres")
    if nm.max() < 1e-5:
        raise ValueError(f"{name}: wavelengths {nm[0]:g} … {nm[-1]:g} look like metres: multiply by 1e9 for nm")
    if nm.max() < 10:
        raise ValueError(f"{name}: wavelengths {nm[0]:g} … {nm[-1]:g} look like micrometres: multiply by 1000 for nm")
    outside = (nm < SHORTEST) | (nm > LONGEST)
    if outside.any():
        raise ValueError(f"{name}: {nm[outside][0]:g} nm is not in [{SHORTEST:g}, {LONGEST:g}]: wavelengths are in nm")

    # Increasing.
    wrong = np.flatnonzero(np.diff(nm) <= 0)
    if wrong.size:
        before, after = nm[wrong[0]], nm[wrong[0] + 1]
        what = "appears twice" if before == after else f"comes before {after:g} nm"
        raise ValueError(f"{name}: {before:g} nm {what}: wavelengths must increase; sort them and drop duplicates")
