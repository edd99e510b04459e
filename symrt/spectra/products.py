"""Γ: the products of spectra that interactions met, step 3 of the paper.

They are taken per wavelength, and in the order in which light met its factors wherever one of them is a matrix.
"""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Bool, Float

from symrt.arrays import Spectrum
from symrt.interactions import Interaction
from symrt.spectra.fluorescence import Matrix, passed
from symrt.spectra.hats import hats
from symrt.spectra.palette import Palette, did_you_mean
from symrt.spectra.powers import Power, power_of
from symrt.symbols import Symbol

Gamma = Float[np.ndarray, "interaction band"]


def gamma(interactions: Sequence[Interaction], palette: Palette) -> Gamma:
    """Γ: for each interaction the product, per band, of its light and of every reflectance it met, with repetition.

    A transmittance counts with the length of the way as its power.
    A fluorescent reflectance is a matrix: the light that it meets, changed by what it met before, is multiplied by it.
    A reflectance such as ``sea>ice.diffuse`` that the palette does not name is zero: no blend was asked for.

    Examples
    --------
    >>> from symrt.spectra.bands import RGB
    >>> twice = Interaction("sun", ("red.mirror", "red.mirror"))
    >>> gamma([twice], Palette(RGB, {"sun": 2, "red.mirror": [0.5, 0.1, 0]}))
    array([[0.5 , 0.02, 0.  ]])
    """
    factors: list[tuple[str | Power, ...]] = [(*i.symbols, *i.powers) for i in interactions]
    symbols = sorted({name for i in interactions for name in i.symbols})
    powers = sorted({power for i in interactions for power in i.powers})
    check_symbols(sorted({*symbols, *(name for name, _ in powers)}), palette)
    # The last row, of ones, fills up the interactions that met less than others did; ones stand for matrices, too.
    ones, matrices = np.ones(len(palette.bands)), []
    rows = [palette[name] if name in palette else np.zeros(len(palette.bands)) for name in symbols]
    if palette.fluorescent:
        matrices = [(k, row) for k, row in enumerate(rows) if row.ndim == 2]
        rows = [ones if row.ndim == 2 else row for row in rows]
    spectra = np.array([*rows, *(power_of(palette, power) for power in powers), ones])
    number = {factor: k for k, factor in enumerate((*symbols, *powers))}
    places = np.full((len(factors), max(map(len, factors), default=1)), len(number))
    for row, names in zip(places, factors, strict=True):
        row[: len(names)] = [number[name] for name in names]
    product = spectra[places[:, 0]]
    # Light meets the first reflectance of every interaction, then the second; glass and windows are next to the eye.
    for column in places.T[1:]:
        product *= spectra[column]
        for k, matrix in matrices:
            meeting = column == k
            product[meeting] = passed(product[meeting], matrix)
    return product * hats(interactions, palette.bands) if any(i.window for i in interactions) else product


def check_symbols(symbols: Sequence[str], palette: Palette) -> None:
    """Refuse a palette that lacks a symbol which is not an alternative's."""
    missing = [name for name in symbols if name not in palette and not Symbol.of(name).alternative]
    if missing:
        raise ValueError(
            f"the palette lacks {did_you_mean(missing, palette)}: name every light and reflectance of the system, for "
            f"example palette.add({{{missing[0]!r}: 0.5}})"
        )


def light_left(names: Sequence[str], palette: Palette) -> Bool[np.ndarray, " band"]:
    """True where light is left behind a light's spectrum and reflectances, in their order."""
    left = np.ones(len(palette.bands), dtype=bool)
    for name in names:
        some = known(name, palette) > 0
        left = left & some if some.ndim == 1 else left @ some
    return left


def vanished(interactions: Sequence[Interaction], spectra: Gamma, palette: Palette) -> Bool[np.ndarray, " band"]:
    """Bands in which the product of some interaction is 0 although light is left in it."""
    found = np.zeros(len(palette.bands), dtype=bool)
    for row in np.flatnonzero((spectra == 0).any(axis=1)).tolist():
        names = interactions[row].names
        if not interactions[row].nodes and all(name in palette for name in names):
            left = light_left(names, palette) & (hats([interactions[row]], palette.bands)[0] > 0)
            found |= (spectra[row] == 0) & left
    return found


def known(name: str, palette: Palette) -> Spectrum | Matrix:
    """A reflectance; of a material that no pixel shows it may be anything, of an alternative it is zero."""
    return palette[name] if name in palette else np.full(len(palette.bands), 1.0 - Symbol.of(name).alternative)
