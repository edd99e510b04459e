"""Shade a linear system with a palette: step 3 of the paper, equation (2), ``p = G Γ``.

Γ holds the product of the spectra that an interaction met, taken per wavelength.  Only then is it projected to a basis,
``G (Γ Bᵀ)``: products of coordinates are not coordinates of products.
"""

import time
import warnings
from collections.abc import Mapping
from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float, UInt8

from symrt.arrays import Spectrum
from symrt.errors import require
from symrt.spectra.bands import Bands, Number, coordinates
from symrt.spectra.certificate import row_blocks, tail_bound
from symrt.spectra.display import check_exposure, display_matrix, to_rgb8
from symrt.spectra.image import SpectralImage
from symrt.spectra.misspelt import misspelt
from symrt.spectra.palette import Palette, did_you_mean
from symrt.spectra.products import gamma, vanished
from symrt.spectra.reference import Reference, whites
from symrt.system import LinearSystem

Vectors = Float[np.ndarray, "component band"]
ROWS = 1 << 15
SMALLEST = float(np.finfo(float).tiny)
"""Bounds what products lose that underflow."""


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
    missing = None if basis is not None else _missing(system, spectra)
    lost = vanished(system.interactions, spectra, palette)
    if lost.any():
        # Products of many reflectances may underflow to 0: what is lost is less than the smallest number, and is told.
        cut_off = np.maximum(np.zeros(len(lost)) if cut_off is None else cut_off, np.where(lost, SMALLEST, 0.0))
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
        missing=missing,
        seconds=time.perf_counter() - start,
    )


def _missing(system: LinearSystem, spectra: Float[np.ndarray, "interaction band"]) -> Spectrum | None:
    """An estimate of the most that a pixel misses of gathered light: bounce by bounce it falls off as it did before."""
    gathered = {} if system.tail is None else system.tail.gathered
    most = max(map(len, gathered.values()), default=0)
    sums = np.array([[*(s := gathered.get(i, ())), *[0.0] * (most - len(s))] for i in system.interactions])
    if most < 2 or not sums.any():
        return None

    # The light of the last two bounces in the whole picture, and of the last one in each pixel.
    before, last = sums[:, -2] @ spectra, sums[:, -1] @ spectra
    whole = sums.sum(axis=1)
    part = np.divide(sums[:, -1], whole, out=np.zeros(len(whole)), where=whole > 0)
    largest = system.times(spectra * part[:, None]).max(axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(last <= 0, 0.0, np.where(last < before, largest * last / (before - last), np.inf))


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
    codes = [to_rgb8(rows @ colours) for rows in row_blocks(system.G, ROWS)]
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
