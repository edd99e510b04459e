"""The physical cap on a material's scale: no surface reflects more than it receives (step 5 of the paper).

The components diffuse, specular and mirror of one material, and all that are fluorescent, may together send on no more
than arrives in any band; every other one, such as a reflectance at normal incidence, not by itself.
"""

from collections import defaultdict
from collections.abc import Collection, Mapping
from typing import NamedTuple

import numpy as np

from symrt.arrays import Spectrum
from symrt.spectra.fluorescence import sent_on
from symrt.spectra.palette import Palette, together
from symrt.symbols import Symbol

BELOW_ONE = 1 - 2.0**-50
ABOVE_ONE = 1 + 2.0**-50
"""Three roundings at most: a sum that is 1 in decimals is not above it."""


class Cap(NamedTuple):
    """The largest physical scale; the material or symbol that reaches 1 there, the band, and the symbols of it."""

    value: float
    symbol: str
    band: str
    symbols: frozenset[str]


UNLIMITED = Cap(np.inf, "", "", frozenset())


def physical_cap(palette: Palette, moved: Collection[str]) -> Cap:
    """The largest factor on the reflectances `moved` that keeps their materials physical; perhaps infinite.

    Examples
    --------
    >>> from symrt.spectra.bands import RGB
    >>> brass = Palette(RGB, {"brass.diffuse": [0.5, 0.4, 0.1], "brass.specular": 0.3})
    >>> found = physical_cap(brass, ("brass.diffuse", "brass.specular"))
    >>> round(found.value, 12), found.symbol, found.band
    (1.25, 'brass', 'red')
    """
    caps = []
    for name, symbols in grouped(palette).items():
        rising = sum((sent_on(palette[s], palette.bands) for s in symbols if s in moved), np.zeros(len(palette.bands)))
        rest = sum(
            (sent_on(palette[s], palette.bands) for s in symbols if s not in moved), np.zeros(len(palette.bands))
        )
        if rising.any():
            # The factor at which moving and resting reflectances first sum to 1.
            room = np.maximum(1 - rest, 0)
            factors = np.divide(room, rising, out=np.full(len(room), np.inf), where=rising > 0) * BELOW_ONE
            band = int(factors.argmin())
            # A material that is physical as given may stay as it is.
            least = 1.0 if _total(palette, symbols).max() <= ABOVE_ONE else 0.0
            caps.append(Cap(max(least, float(factors[band])), name, palette.bands.labels[band], frozenset(symbols)))
    return min(caps, key=lambda found: found.value, default=UNLIMITED)


def above_one(palette: Palette, moved: Collection[str] | None = None) -> tuple[str, ...]:
    """Materials, or single components, that reflect more than they receive in some band; of those moved, if given.

    Examples
    --------
    >>> from symrt.spectra.bands import RGB
    >>> above_one(Palette(RGB, {"brass.diffuse": 0.7, "brass.specular": 0.4, "sea.diffuse": 1}))
    ('brass',)
    """
    groups = {n: g for n, g in grouped(palette).items() if moved is None or not set(g).isdisjoint(moved)}
    return tuple(name for name, symbols in groups.items() if _total(palette, symbols).max() > ABOVE_ONE)


def grouped(palette: Palette) -> Mapping[str, list[str]]:
    """Symbols whose reflectances count together, by the name of their material; single ones by their own."""
    groups = defaultdict(list)
    for name in sorted(palette.reflectances):
        symbol = Symbol.of(name)
        groups[str(symbol.surface) if together(symbol) else name].append(name)
    return groups


def _total(palette: Palette, symbols: list[str]) -> Spectrum:
    return np.sum([sent_on(palette[s], palette.bands) for s in symbols], axis=0)
