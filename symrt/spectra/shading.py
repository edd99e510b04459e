"""Shade a linear system with a palette: step 3 of the paper, equation (2), ``p = G Γ``.

Γ holds the product of the spectra that an interaction met, taken per wavelength.  Only then is it projected to a basis,
``G (Γ Bᵀ)``: products of coordinates are not coordinates of products.
"""

import time
import warnings
from collections.abc import Iterator, Mapping, Sequence
from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Bool, Float, UInt8
from scipy import sparse

from symrt.arrays import Spectrum
from symrt.errors import require
from symrt.interactions import Interaction
from symrt.spectra.bands import Bands, Number, coordinates
from symrt.spectra.display import check_exposure, display_matrix, to_rgb8
from symrt.spectra.hats import hats
from symrt.spectra.image import SpectralImage
from symrt.spectra.misspelt import misspelt
from symrt.spectra.palette import Palette, did_you_mean
from symrt.spectra.powers import Power, power_of
from symrt.spectra.reference import Reference, whites
from symrt.symbols import Symbol
from symrt.system import LinearSystem
from symrt.tails import Shares, Tail

Gamma = Float[np.ndarray, "interaction band"]
Vectors = Float[np.ndarray, "component band"]
ROWS = 1 << 15
SMALLEST = float(np.finfo(float).tiny)
"""Bounds what products lose that underflow."""
WHOLE = 1 + 2.0**-48
"""A share of all light, and a few roundings of its terms more."""


@runtime_checkable
class HasVectors(Protocol):
    """A basis: anything with orthonormal rows in ``vectors``."""

    @property
    def vectors(self) -> Vectors:
        """Orthonormal spectra."""


def shade(
    system: LinearSystem,
    palette: Palette,
    *,
    parameters: Mapping[str, Number] | None = None,
    basis: Vectors | HasVectors | None = None,
    dtype: type[np.floating] = np.float64,
) -> SpectralImage:
    """Give every light and reflectance its spectrum.

    Parameters
    ----------
    parameters
        A value for each parameter that the system kept free.
    basis
        Orthonormal spectra, (component × band), or something whose ``vectors`` they are: the image then holds
        coordinates.
    dtype
        float64, or float32 to halve the memory.

    Raises
    ------
    ValueError
        If the palette lacks a symbol, or a parameter has no value: all of them are named.

    Examples
    --------
    >>> from symrt.spectra.bands import RGB
    >>> system = LinearSystem.of("0.5*sun*red.diffuse", "0", white={"sun": 0.5})
    >>> shade(system, Palette(RGB, {"sun": 2, "red.diffuse": [0.8, 0.1, 0]})).values.tolist()
    [[[0.8, 0.1, 0.0], [0.0, 0.0, 0.0]]]
    """
    start = time.perf_counter()
    check_names(system, palette)
    spectra = gamma(system.interactions, palette) * node_weights(system, parameters or {})[:, None]
    vectors = None if basis is None else _vectors(basis, palette.bands)
    cut_off = None if system.tail is None else tail_bound(system.tail, palette)
    vanished = _vanished(system.interactions, spectra, palette)
    if vanished.any():
        # Products of many reflectances may underflow to 0: what is lost is less than the smallest number, and is told.
        cut_off = np.maximum(np.zeros(len(vanished)) if cut_off is None else cut_off, np.where(vanished, SMALLEST, 0.0))
    if vectors is not None:
        spectra = spectra @ vectors.T
        cut_off = None if cut_off is None else _in_basis(vectors, cut_off)
    _check_range(system, spectra, np.finfo(dtype))
    values = system.times(spectra.astype(dtype, copy=False))
    return SpectralImage(
        values=values.reshape(system.height, system.width, spectra.shape[1]),
        bands=palette.bands if vectors is None else coordinates(len(vectors)),
        whites={} if vectors is not None else whites(system, palette),
        cut_off=cut_off,
        seconds=time.perf_counter() - start,
    )


def _vanished(interactions: Sequence[Interaction], spectra: Gamma, palette: Palette) -> Bool[np.ndarray, " band"]:
    """Bands in which the product of some interaction is 0 although none of its factors is."""
    vanished = np.zeros(len(palette.bands), dtype=bool)
    for row in np.flatnonzero((spectra == 0).any(axis=1)).tolist():
        names = interactions[row].names
        if not interactions[row].nodes and all(name in palette for name in names):
            factors = np.array([*(palette[name] for name in names), *hats([interactions[row]], palette.bands)])
            vanished |= (spectra[row] == 0) & (factors > 0).all(axis=0)
    return vanished


def check_names(system: LinearSystem, palette: Palette) -> None:
    """Refuse arguments that were swapped, or not yet made, and warn of entries of a palette that seem misspelt.

    Raises
    ------
    TypeError
        That says which argument is what, and what makes the right one.
    """
    require("system", system, LinearSystem, "render(scene)")
    require("palette", palette, Palette, "one of load_palettes(path)")
    for name, meant in misspelt(system, palette).items():
        warnings.warn(f"the palette's {name!r} is nothing in this scene: did you mean {meant!r}?", stacklevel=3)


def gamma(interactions: Sequence[Interaction], palette: Palette) -> Gamma:
    """Γ: for each interaction the product, per band, of its light and of every reflectance it met, with repetition.

    A transmittance counts with the length of the way as its power.

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
    # The last row is of ones, for interactions of fewer factors.
    rows = [palette[name] if name in palette else np.zeros(len(palette.bands)) for name in symbols]
    spectra = np.array([*rows, *(power_of(palette, power) for power in powers), np.ones(len(palette.bands))])
    number = {factor: k for k, factor in enumerate((*symbols, *powers))}
    places = np.full((len(factors), max(map(len, factors), default=1)), len(number))
    for row, names in zip(places, factors, strict=True):
        row[: len(names)] = [number[name] for name in names]
    product = spectra[places[:, 0]]
    for column in places.T[1:]:
        product *= spectra[column]
    return product * hats(interactions, palette.bands) if any(i.window for i in interactions) else product


def check_symbols(symbols: Sequence[str], palette: Palette) -> None:
    """Refuse a palette that lacks a symbol which is not an alternative's."""
    missing = [name for name in symbols if name not in palette and not Symbol.of(name).alternative]
    if missing:
        raise ValueError(
            f"the palette lacks {did_you_mean(missing, palette)}: name every light and reflectance of the system, for "
            f"example palette.add({{{missing[0]!r}: 0.5}})"
        )


def node_weights(system: LinearSystem, parameters: Mapping[str, Number]) -> Float[np.ndarray, " interaction"]:
    """The weight of each column at the given values of the free parameters: a product of Lagrange weights."""
    if unknown := [name for name in parameters if name not in system.parameters]:
        free = ", ".join(system.parameters) or "none"
        raise ValueError(f"not a free parameter: {did_you_mean(unknown, system.parameters)}; free are: {free}")
    if missing := [
        f"{n.parameter} in [{n.low:g}, {n.high:g}]" for n in system.parameters.values() if n.parameter not in parameters
    ]:
        raise ValueError(f"give a value for {', '.join(missing)}: shade(…, parameters={{name: value}})")
    weights = {name: nodes.weights(float(parameters[name])) for name, nodes in system.parameters.items()}
    return np.array([np.prod([weights[name][j] for name, j in i.nodes]) for i in system.interactions], dtype=float)


def tail_bound(tail: Tail, palette: Palette) -> Spectrum:
    """An upper bound, for each band, on what the depth limit cut off from any pixel; rounded up.

    It is infinite where a material that lights shine on may also mirror everything, a reflectance passes 1, or a
    light's irradiance is unknown.
    """
    spectra = gamma(tail.interactions, palette)
    largest = _most_reflected(tail, palette)
    # Most pixels see no mirror: their empty rows are left out.
    ends = tail.bound.indptr[1:][np.diff(tail.bound.indptr) > 0]
    known = np.isfinite(tail.bound.data)
    reached = _reached(tail, palette)
    unknown = reached[np.unique(tail.bound.indices[~known])].any(axis=0)
    rows = (np.where(known, tail.bound.data, 0.0), tail.bound.indices, np.append(0, ends))
    lit = sparse.csr_array(rows, (len(ends), len(spectra)))
    first = np.zeros(len(palette.bands))
    for block in _row_blocks(lit, ROWS // 8):
        np.maximum(first, (block @ spectra).max(axis=0), out=first)
    first *= 1 + 1e-12
    remaining = np.where(largest < 1, 1 - largest, 1.0)
    # Products may underflow: a bound that is not zero stays so.
    some = reached.any(axis=0)
    bound = np.where(some, np.nextafter(first / remaining, np.inf), 0.0)
    return np.where(unknown | ((largest >= 1) & some), np.inf, bound)


def _reached(tail: Tail, palette: Palette) -> Bool[np.ndarray, "column band"]:
    """True where light is left in a column: no factor is zero, however small the product."""
    names = [set(i.names) for i in tail.interactions]
    left = [np.all([_known(name, palette) > 0 for name in factors], axis=0) for factors in names]
    within = hats(tail.interactions, palette.bands) > 0
    return np.array(left, dtype=bool).reshape(within.shape) & within


def _most_reflected(tail: Tail, palette: Palette) -> Spectrum:
    """The largest share that a material which lights shine on sends on of what rays bring; 0 where none sends any."""
    # Mirrors and glass add nothing as long as they send on no more than they receive.
    shares = [_share(terms, palette) for terms in tail.reflected]
    passed = [np.where(_share(terms, palette) > WHOLE, np.inf, 0.0) for terms in tail.passed]
    # The bounds of what surfaces send on hold for reflectances up to 1.
    above = [np.where(palette[name] > 1, np.inf, 0.0) for name in palette.above_one]
    return np.max([np.zeros(len(palette.bands)), *shares, *passed, *above], axis=0)


def _share(terms: Shares, palette: Palette) -> Spectrum:
    """A sum of products of reflectances, each times a number; no reflectance times a number without a bound is 0."""
    whole = np.ones(len(palette.bands))
    products = [(c, np.prod([whole, *(_known(n, palette) for n in met)], axis=0)) for met, c in terms]
    with np.errstate(invalid="ignore"):
        return np.sum([np.where(product > 0, c * product, 0.0) for c, product in products], axis=0)


def _known(name: str, palette: Palette) -> Spectrum:
    """A reflectance; of a material that no pixel shows it may be anything, of an alternative it is zero."""
    return palette[name] if name in palette else np.full(len(palette.bands), 1.0 - Symbol.of(name).alternative)


def preview(
    system: LinearSystem,
    palette: Palette,
    exposure: Number = 1.0,
    *,
    parameters: Mapping[str, Number] | None = None,
    white: Spectrum | str | None = None,
) -> UInt8[np.ndarray, "height width 3"]:
    """The picture in 8-bit sRGB without its spectra: ``G (Γ C)``, projected before the product.

    Parameters
    ----------
    exposure
        Factor on every radiance.
    parameters
        A value for each parameter that the system kept free.
    white
        The radiance shown as white, as for `to_rgb`.  None: the white that the palette carries, or else the key light's
        *in this palette*, so that a dimmer lamp makes the same picture; to see it dimmer, fix the white with
        ``white=Reference().white(system, brighter_palette)``.

    Examples
    --------
    >>> from symrt.spectra.bands import RGB
    >>> system = LinearSystem.of("0.5*sun*red.diffuse", white={"sun": 0.5})
    >>> preview(system, Palette(RGB, {"sun": 2, "red.diffuse": [1, 0.5, 0]})).tolist()
    [[[255, 188, 0]]]
    """
    check_names(system, palette)
    check_exposure(exposure)
    seen = Reference(white).white(system, palette) if white is None or isinstance(white, str) else white
    spectra = gamma(system.interactions, palette) * node_weights(system, parameters or {})[:, None]
    colours = spectra @ (exposure * display_matrix(palette.bands, seen))
    codes = [to_rgb8(rows @ colours) for rows in _row_blocks(system.G, ROWS)]
    return np.concatenate(codes).reshape(system.height, system.width, 3)


def _check_range(system: LinearSystem, spectra: Float[np.ndarray, "interaction band"], limits: np.finfo) -> None:
    """Refuse radiances that the number format may not hold: an infinite one would make others nan."""
    coefficient = max(system.G.data.max(initial=0.0), -system.G.data.min(initial=0.0))
    product = np.abs(spectra).max(initial=0.0)
    with np.errstate(over="ignore"):
        largest = coefficient * product * len(system.interactions)
    if not largest < limits.max:
        raise ValueError(
            f"radiances may pass {limits.max:.1g}: products of spectra reach {product:.2g} and coefficients "
            f"{coefficient:.2g}; scale the lights down"
        )


def _row_blocks(matrix: sparse.csr_array, size: int) -> Iterator[sparse.csr_array]:
    """Views of some rows at a time: the product of each stays in a core's cache until it is encoded or compared."""
    for first in range(0, matrix.shape[0], size):
        indptr = matrix.indptr[first : first + size + 1]
        part = slice(indptr[0], indptr[-1])
        rows = (matrix.data[part], matrix.indices[part], indptr - indptr[0])
        yield sparse.csr_array(rows, (len(indptr) - 1, matrix.shape[1]))


def _in_basis(vectors: Vectors, bound: Spectrum) -> Float[np.ndarray, " component"]:
    """A bound on each coordinate of a spectrum that is at most `bound`."""
    with np.errstate(invalid="ignore"):
        terms = np.where(vectors == 0, 0.0, np.abs(vectors) * bound)
    return terms.sum(axis=1) * (1 + 1e-12)


def _vectors(basis: Vectors | HasVectors, bands: Bands) -> Vectors:
    vectors = np.asarray(getattr(basis, "vectors", basis), dtype=float)
    if vectors.ndim != 2 or vectors.shape[1] != len(bands):
        raise ValueError(f"the basis is {vectors.shape}, but the palette has {bands!r}: give (component, band)")
    error = np.abs(vectors @ vectors.T - np.eye(len(vectors))).max()
    if not error <= 1e-9:
        raise ValueError(f"the basis is not orthonormal, by {error:.2g}: coordinates would not stand for spectra")
    return vectors
