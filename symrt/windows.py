"""Windows of wavelengths: the parts of the spectrum that glass bends apart (between steps 2 and 3).

A window is a hat: 1 at its centre, 0 from its neighbours' centres on, and straight in between.  All windows together
sum to 1 at each wavelength, so that what they bring adds up to the whole spectrum.
"""

import re
from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from symrt.errors import shown

NUMBER = r"\d+(?:\.\d+)?(?:[eE][-+]?\d+)?"
WRITTEN = rf"\[\s*(?:{NUMBER})?\s*(?:…|\.\.\.)\s*{NUMBER}\s*(?:…|\.\.\.)\s*(?:{NUMBER})?\s*nm\s*\]"
"""A window within a longer text."""
PARTS = re.compile(rf"\[\s*({NUMBER})?\s*(?:…|\.\.\.)\s*({NUMBER})\s*(?:…|\.\.\.)\s*({NUMBER})?\s*nm\s*\]")


class SpectralWindow(NamedTuple):
    """A part of the spectrum, in nm: it rises from `low` to `centre`, and falls to `high`.

    The first window has nothing below its centre, where `low` is the centre itself; the last has nothing above.

    Examples
    --------
    >>> first, middle, last = windows_of([400, 500, 700])
    >>> str(first), str(middle), str(last)
    ('[… 400 … 500 nm]', '[400 … 500 … 700 nm]', '[500 … 700 … nm]')
    """

    low: float | int
    centre: float | int
    high: float | int

    @staticmethod
    def of(text: str) -> "SpectralWindow":
        """The window that a text names; three dots may stand for ``…``.

        Raises
        ------
        ValueError
            If it is none.

        Examples
        --------
        >>> SpectralWindow.of("[400 ... 500 ... 700 nm]")
        SpectralWindow(low=400.0, centre=500.0, high=700.0)
        """
        found = PARTS.fullmatch(text.strip())
        if found is None or not (found[1] or found[3]):
            raise ValueError(f"{shown(text)}: write a window of wavelengths as [400 … 500 … 600 nm]")
        centre = float(found[2])
        window = SpectralWindow(float(found[1] or centre), centre, float(found[3] or centre))
        if fault := window.fault:
            raise ValueError(f"{shown(text)}: {fault}; write [400 … 500 … 600 nm]")
        return window

    @property
    def fault(self) -> str:
        """The reason that it is no part of a spectrum; empty if it is one."""
        if not all(0 < part < np.inf for part in self):
            return "the wavelengths of a window are numbers above 0"
        if not self.low <= self.centre <= self.high or self.low == self.high:
            return "the wavelengths of a window increase"
        return ""

    def weights(self, nm: Float[np.ndarray, " band"]) -> Float[np.ndarray, " band"]:
        """The share of the window at some wavelengths, in nm.

        Raises
        ------
        ValueError
            If some are beyond the first window, or the last: nothing is known of them.

        Examples
        --------
        >>> SpectralWindow(400, 500, 700).weights(np.array([400.0, 450.0, 500.0, 650.0, 800.0]))
        array([0.  , 0.5 , 1.  , 0.25, 0.  ])
        """
        beyond = (nm < self.centre) & (self.low == self.centre) | (nm > self.centre) & (self.high == self.centre)
        if beyond.any():
            first = self.low == self.centre
            raise ValueError(
                f"{nm[beyond][0]:g} nm: glass was traced {'from' if first else 'to'} {self.centre:g} nm only; choose "
                "narrower bands, or trace with windows over all of them, windows = [360, …, 780]"
            )
        # Ends that coincide with the centre have no slope, and nothing lies on their side.
        rising = (nm - self.low) / (self.centre - self.low or 1.0)
        falling = (self.high - nm) / (self.high - self.centre or 1.0)
        share = np.where(nm < self.centre, rising, np.where(nm > self.centre, falling, 1.0))
        return np.maximum(share, 0.0)

    def __str__(self) -> str:
        low = f"{_number(self.low)} " if self.low < self.centre else ""
        high = f"{_number(self.high)} " if self.high > self.centre else ""
        return f"[{low}… {_number(self.centre)} … {high}nm]"


EVERYWHERE: tuple[()] = ()
"""The window of light that no glass has bent apart: all of the spectrum."""


def windows_of(nodes: Sequence[float | int]) -> tuple[SpectralWindow, ...]:
    """The windows around increasing wavelengths, in nm, each from the one before to the next.

    Examples
    --------
    >>> windows_of([400, 700])
    (SpectralWindow(low=400.0, centre=400.0, high=700.0), SpectralWindow(low=400.0, centre=700.0, high=700.0))
    """
    at = [float(nm) for nm in nodes]
    lows, highs = [at[0], *at[:-1]], [*at[1:], at[-1]]
    return tuple(SpectralWindow(*parts) for parts in zip(lows, at, highs, strict=True))


def even_nodes(count: int, first: float | int, last: float | int) -> tuple[float, ...]:
    """So many wavelengths at about even steps, whole nanometres.

    Examples
    --------
    >>> even_nodes(4, 380, 730)
    (380.0, 497.0, 613.0, 730.0)
    """
    nodes = tuple(float(nm) for nm in np.rint(np.linspace(first, last, count)))
    if any(here >= there for here, there in pairwise(nodes)):
        raise ValueError(f"{count} windows from {first:g} to {last:g} nm: fewer, or they are narrower than 1 nm")
    return nodes


def _number(nm: float | int) -> str:
    """A wavelength with as many digits as it takes to read it back."""
    short = f"{nm:g}"
    return short if float(short) == nm else repr(float(nm))
