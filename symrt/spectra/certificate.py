"""The certificate: an upper bound on what the depth limit cut off, for one palette (step 3 of the paper)."""

from collections import defaultdict
from collections.abc import Iterator

import numpy as np
from jaxtyping import Bool
from scipy import sparse

from symrt.arrays import Spectrum
from symrt.spectra.fluorescence import Matrix, gathered, passed
from symrt.spectra.hats import hats
from symrt.spectra.palette import Palette
from symrt.spectra.products import Gamma, gamma, known, light_left
from symrt.symbols import Symbol
from symrt.tails import Shares, Tail

ROWS = 1 << 12
"""Rows of a matrix at a time."""
WHOLE = 1 + 2.0**-48
"""A share of all light, and a few roundings of its terms more."""


def tail_bound(tail: Tail, palette: Palette) -> Spectrum:
    """An upper bound, for each band, on what the depth limit cut off from any pixel; rounded up.

    It is infinite where a material that lights shine on may also mirror everything, a reflectance passes 1, or a
    light's irradiance is unknown.
    """
    if tail.fluorescent:
        return _bound_across(tail, palette)
    spectra = gamma(tail.interactions, palette)
    largest = _most_reflected(tail, palette)
    first, reached, unknown = _first(tail, spectra, palette)
    remaining = np.where(largest < 1, 1 - largest, 1.0)
    # Products may underflow: a bound that is not zero stays so.
    some = reached.any(axis=0)
    bound = np.where(some, np.nextafter(first / remaining, np.inf), 0.0)
    return np.where(unknown | ((largest >= 1) & some), np.inf, bound)


def _first(
    tail: Tail, spectra: Gamma, palette: Palette
) -> tuple[Spectrum, Bool[np.ndarray, "column band"], Bool[np.ndarray, " band"]]:
    """The most that any pixel lacks for given spectra of the columns, bands where light is left, and unknown bands."""
    # Most pixels see no mirror: their empty rows are left out.
    ends = tail.bound.indptr[1:][np.diff(tail.bound.indptr) > 0]
    finite = np.isfinite(tail.bound.data)
    reached = _reached(tail, palette)
    unknown = reached[np.unique(tail.bound.indices[~finite])].any(axis=0)
    rows = (np.where(finite, tail.bound.data, 0.0), tail.bound.indices, np.append(0, ends))
    lit = sparse.csr_array(rows, (len(ends), len(spectra)))
    first = np.zeros(len(palette.bands))
    for block in row_blocks(lit, ROWS):
        np.maximum(first, (block @ spectra).max(axis=0), out=first)
    return first * (1 + 1e-12), reached, unknown


def _bound_across(tail: Tail, palette: Palette) -> Spectrum:
    """As `tail_bound` where light moves from band to band: each light summed over all bounces, ``L B (1 − K)⁻¹``."""
    # Each light at the brightest surface, and then from surface to surface.
    lights = sorted({i.light for i in tail.interactions})
    spectra = np.array([palette[name] for name in lights]).reshape(-1, len(palette.bands))
    again = _sent_again(tail, palette)
    total = gathered(passed(spectra, _brightest(tail, palette)), again)
    ends = bool(np.isfinite(total).all() and np.isfinite(again).all())

    # Then through all that the cut paths had met; a sum without end is only asked which bands it reaches.
    shining = total if ends else np.repeat(spectra.any(axis=1).astype(float)[:, None], len(palette.bands), axis=1)
    lit = palette.add(dict(zip(lights, shining, strict=True)))
    first, reached, unknown = _first(tail, gamma(tail.interactions, lit), lit)
    some = reached.any(axis=0)
    return np.where(unknown | (some & (not ends)), np.inf, np.where(some, np.nextafter(first, np.inf), 0.0))


def _brightest(tail: Tail, palette: Palette) -> Matrix:
    """The most that a surface makes of the light on it: all of it in its band, and what some paint gives back."""
    bands = len(palette.bands)
    paints: dict[str, Matrix] = defaultdict(lambda: np.zeros((bands, bands)))
    for name in tail.fluorescent:
        paints[Symbol.of(name).place] += _moved(name, palette)
    return np.eye(bands) + np.max([*paints.values()], axis=0)


def _sent_again(tail: Tail, palette: Palette) -> Matrix:
    """The most that a surface sends on of what rays bring, infinite where a reflectance passes 1."""
    again = np.diag([0.0] * len(palette.bands))
    for terms in (*tail.reflected, *tail.passed):
        # Spectra keep light in its band, and matrices move it.
        matrices = [(met, c) for met, c in terms if any(Symbol.of(name).fluorescent for name in met)]
        share = _share(tuple(term for term in terms if term not in matrices), palette)
        moved = sum((c * _moved(met[0], palette) for met, c in matrices if c > 0), np.zeros(again.shape))
        if terms in tail.reflected or matrices:
            again = np.maximum(again, np.diag(share) + moved)
        elif (share > WHOLE).any():
            # Mirrors and glass add nothing only as long as they send on no more than they receive.
            return np.full(again.shape, np.inf)
    # The bounds of what surfaces send on hold for reflectances up to 1.
    above = set(palette.above_one) - set(palette.fluorescent)
    return np.full(again.shape, np.inf) if above else again


def _moved(name: str, palette: Palette) -> Matrix:
    """A fluorescent reflectance; that of a material which no pixel shows may turn all light into any band's."""
    if name in palette:
        return palette[name]
    energy = palette.bands.widths
    return np.outer(energy, 1 / energy) * (not Symbol.of(name).alternative)


def _reached(tail: Tail, palette: Palette) -> Bool[np.ndarray, "column band"]:
    """True where light is left in a column: no factor is zero, however small the product."""
    left = [light_left(i.names, palette) for i in tail.interactions]
    within = hats(tail.interactions, palette.bands) > 0
    return np.array(left, dtype=bool).reshape(within.shape) & within


def _most_reflected(tail: Tail, palette: Palette) -> Spectrum:
    """The largest share that a material which lights shine on sends on of what rays bring; 0 where none sends any."""
    # Mirrors and glass add nothing as long as they send on no more than they receive.
    shares = [_share(terms, palette) for terms in tail.reflected]
    through = [np.where(_share(terms, palette) > WHOLE, np.inf, 0.0) for terms in tail.passed]
    # The bounds of what surfaces send on hold for reflectances up to 1.
    above = [np.where(palette[name] > 1, np.inf, 0.0) for name in palette.above_one if name not in palette.fluorescent]
    return np.max([np.zeros(len(palette.bands)), *shares, *through, *above], axis=0)


def _share(terms: Shares, palette: Palette) -> Spectrum:
    """A sum of products of reflectances, each times a number; no reflectance times a number without a bound is 0."""
    whole = np.ones(len(palette.bands))
    products = [(c, np.prod([whole, *(known(n, palette) for n in met)], axis=0)) for met, c in terms]
    with np.errstate(invalid="ignore"):
        return np.sum([np.where(product > 0, c * product, 0.0) for c, product in products], axis=0)


def row_blocks(matrix: sparse.csr_array, size: int) -> Iterator[sparse.csr_array]:
    """Views of some rows at a time: the product of each stays in a core's cache until it is encoded or compared."""
    for first in range(0, matrix.shape[0], size):
        indptr = matrix.indptr[first : first + size + 1]
        part = slice(indptr[0], indptr[-1])
        rows = (matrix.data[part], matrix.indices[part], indptr - indptr[0])
        yield sparse.csr_array(rows, (len(indptr) - 1, matrix.shape[1]))
