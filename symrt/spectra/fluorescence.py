"""Fluorescence: paints that take light in at some wavelengths and give it back at others (step 3 of the paper).

A dye takes in a share v of the light at each wavelength, its *excitation*, and gives that energy back as its
*emission* u, whatever the wavelength that it took in [1]_:

    L'(λ') = Σ_dyes u(λ') ∫ v(λ) L(λ) dλ,        v in [0, 1],        u in 1/nm,  ∫ u dλ' = 1

At bands of widths Δ it is a matrix, Donaldson's without its diagonal [2]_, which light as a row is multiplied by:

    L' = L M,        M_ij = Σ_dyes v_i Δ_i u_j

References
----------
.. [1] M. Kasha, "Characterization of electronic transitions in complex molecules", Discussions of the Faraday Society
   9, 1950, pp. 14-19: molecules emit from their lowest excited state, by whichever light it was reached.
.. [2] R. Donaldson, "Spectrophotometry of fluorescent pigments", British Journal of Applied Physics 5, 1954,
   pp. 210-214.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from symrt.arrays import Spectrum
from symrt.errors import shown
from symrt.spectra.bands import Bands, Number, resample
from symrt.spectra.library import spectrum as library_spectrum

SpectrumLike = (
    Float[np.ndarray, " _"] | Int[np.ndarray, " _"] | Sequence[float | int | np.number] | float | int | np.number | str
)
"""An array or list with one value a band, a number for all bands, or a name such as ``macbeth/dark skin``."""
Matrix = Float[np.ndarray, "band band"]
WHOLE = 1 + 1e-12
"""All of the light, and the roundings of a sum over bands."""


@dataclass(frozen=True, eq=False)
class Fluorescence:
    """A fluorescent dye as one gives it to a palette; a list of them is a paint with several.

    Parameters
    ----------
    excitation
        The share of the energy that arrives at each wavelength that the dye takes in, from 0 to 1.
    emission
        The spectrum of the energy that it gives back, of any size: its sum over the bands, times their widths, is made
        1.
    efficiency
        The share of the energy taken in that is given back.  A quantum yield Q counts photons: the efficiency is Q
        times the mean excitation wavelength, divided by the mean emission wavelength.
    per_nm
        True if the emission is in 1/nm as it stands, because a part of it lies beyond the bands.

    Examples
    --------
    A dye that takes in half of the blue light and gives all of its energy back as green:

    >>> from symrt.spectra.bands import Bands
    >>> dye = Fluorescence(excitation=[0.5, 0, 0], emission=[0, 1, 0])
    >>> np.array([8.0, 1.0, 1.0]) @ Donaldson.of(dye, Bands((450.0, 550.0, 650.0))).matrix
    array([0., 4., 0.])
    """

    excitation: SpectrumLike
    emission: SpectrumLike
    efficiency: Number = 1.0
    per_nm: bool = False


FluorescenceLike = Fluorescence | Sequence[Fluorescence] | Matrix
"""A dye, several, or the matrix itself: a row for each band that light arrives in, a column for each it leaves in."""


@dataclass(frozen=True, eq=False)
class Donaldson:
    """A fluorescent reflectance at a palette's bands.

    Parameters
    ----------
    matrix
        The share of the radiance in one band, its row, that leaves in another, its column: ``light @ matrix``.
    dyes
        Excitation, efficiency included, and emission in 1/nm of each dye; empty where the matrix was given as such.
    """

    bands: Bands
    matrix: Matrix
    dyes: tuple[tuple[Spectrum, Spectrum], ...] = ()

    @classmethod
    def of(cls, given: FluorescenceLike, bands: Bands) -> "Donaldson":
        """A fluorescent reflectance at some bands.

        Raises
        ------
        ValueError
            If it is neither dyes nor a matrix, or has numbers that no dye has.
        """
        # A matrix as it stands.
        if isinstance(given, np.ndarray):
            matrix = np.array(given, dtype=float)
            if matrix.shape != (len(bands), len(bands)):
                raise ValueError(f"a matrix of {given.shape} for {bands!r}: give a row and a column for each band")
            _check_numbers(matrix, "the matrix")
            return cls(bands, _frozen(matrix))

        # Dyes, each of which adds the product of its two spectra.
        several = [given] if isinstance(given, Fluorescence) else given
        if not isinstance(several, list | tuple) or not several:
            raise ValueError(f"{shown(given)}: give Fluorescence(excitation=…, emission=…), several, or a matrix")
        if wrong := [one for one in several if not isinstance(one, Fluorescence)]:
            raise ValueError(f"{shown(wrong[0])} is no dye: give Fluorescence(excitation=…, emission=…)")
        return cls.mixed(bands, tuple(_dye(one, bands) for one in several))

    @classmethod
    def mixed(cls, bands: Bands, dyes: tuple[tuple[Spectrum, Spectrum], ...]) -> "Donaldson":
        """The sum of some dyes, as excitation and emission in 1/nm."""
        matrix = np.zeros((len(bands), len(bands)))
        for excitation, emission in dyes:
            matrix += np.outer(excitation * bands.widths, emission)
        return cls(bands, _frozen(matrix), dyes)

    def on(self, bands: Bands, name: str) -> "Donaldson":
        """The same at other wavelengths, linearly interpolated, never extrapolated; no energy is made by it."""
        nm = np.array(self.bands.centres)
        if self.dyes:
            found = []
            for excitation, emission in self.dyes:
                taken, given = (resample(nm, one, bands, name) for one in (excitation, emission))
                found.append((_frozen(taken), _frozen(given / max(1.0, float(given @ bands.widths)))))
            return Donaldson.mixed(bands, tuple(found))

        # As a density in both wavelengths; no row gives back more than the rows beside it did.
        density = self.matrix / self.bands.widths[:, None]
        rows = np.array([resample(nm, row, bands, name) for row in density])
        matrix = np.array([resample(nm, column, bands, name) for column in rows.T]).T * bands.widths[:, None]
        share, most = sent_on(matrix, bands), resample(nm, sent_on(self.matrix, self.bands), bands, name)
        return Donaldson(bands, _frozen(matrix * np.minimum(1.0, most / np.where(share > 0, share, 1.0))[:, None]))

    def faults(self) -> Iterator[str]:
        """Sentences about what no paint does: give back more than arrives, or at shorter wavelengths on the whole."""
        share = sent_on(self.matrix, self.bands)
        if share.max() > WHOLE:
            band = int(share.argmax())
            yield (
                f"gives back {share[band]:.4g} of the energy that arrives at {self.bands.labels[band]}: lower its "
                "excitation or efficiency; unphysical=True permits it"
            )
        if self.bands.kind != "wavelength" or not self.matrix.any():
            return
        nm = np.array(self.bands.centres)
        taken, given = share * self.bands.widths, self.matrix.sum(axis=0) * self.bands.widths
        before, after = float(nm @ taken / taken.sum()), float(nm @ given / given.sum())
        # Light that stays in its band is no shorter than it was, whatever the sums are rounded to.
        if after < before * (1 - 1e-9):
            yield (
                f"takes in light at {before:.4g} nm and gives it back at {after:.4g} nm, on average: dyes give it back "
                "at longer wavelengths (Stokes); swap the two, or unphysical=True permits it"
            )


def sent_on(factor: Spectrum | Matrix, bands: Bands) -> Spectrum:
    """The share of the energy arriving in each band that a reflectance sends on, to that band or, a matrix, to all.

    Examples
    --------
    >>> from symrt.spectra.bands import RGB
    >>> sent_on(np.array([[0.0, 0.25, 0.5], [0.0, 0.0, 1.0], [0.0, 0.0, 0.0]]), RGB)
    array([0.75, 1.  , 0.  ])
    """
    return factor if factor.ndim == 1 else factor @ bands.widths / bands.widths


def passed(light: Float[np.ndarray, "column band"], matrix: Matrix) -> Float[np.ndarray, "column band"]:
    """Light, a row each, times a matrix; a row's sum has the same bits whatever rows stand beside it.

    Examples
    --------
    >>> passed(np.array([[8.0, 1.0]]), np.array([[0.0, 0.5], [0.0, 0.0]]))
    array([[0., 4.]])
    """
    found = np.zeros_like(light)
    for band in np.flatnonzero(matrix.any(axis=1)).tolist():
        found += light[:, band, None] * matrix[band]
    return found


def times(light: Float[np.ndarray, "column band"], factor: Spectrum | Matrix) -> Float[np.ndarray, "column band"]:
    """Light, a row each, times a spectrum or a matrix.

    Examples
    --------
    >>> times(np.array([[8.0, 1.0]]), np.array([0.5, 1.0]))
    array([[4., 1.]])
    """
    return light * factor if factor.ndim == 1 else passed(light, factor)


def gathered(start: Float[np.ndarray, "light band"], again: Matrix) -> Float[np.ndarray, "light band"]:
    """The sum of light and of what it becomes at each further bounce, ``start (1 − again)⁻¹``; infinite without end.

    The sum ends where some positive spectrum becomes less in every band [1]_; that one is checked, not believed.

    References
    ----------
    .. [1] A. Berman and R. J. Plemmons, "Nonnegative Matrices in the Mathematical Sciences", SIAM 1994, chapter 6.

    Examples
    --------
    >>> gathered(np.array([[1.0, 0.0]]), np.array([[0.5, 0.25], [0.0, 0.5]]))
    array([[2., 1.]])
    """
    rest = np.eye(len(again)) - again
    try:
        less = np.linalg.solve(rest, np.ones(len(again)))
        total = np.linalg.solve(rest.T, start.T).T
    except np.linalg.LinAlgError:
        return np.full(start.shape, np.inf)
    ends = bool((less > 0).all()) and bool((again @ less < less * (1 - 1e-12)).all())
    return np.maximum(total, start) if ends else np.full(start.shape, np.inf)


def _dye(given: Fluorescence, bands: Bands) -> tuple[Spectrum, Spectrum]:
    """Excitation, efficiency included, and emission in 1/nm of a dye, or the reason why there is none."""
    excitation = _numbers(given.excitation, bands, "excitation", reflectance=True)
    emission = _numbers(given.emission, bands, "emission", reflectance=False)
    if excitation.max() > 1:
        at = bands.labels[int(excitation.argmax())]
        raise ValueError(f"excitation is {excitation.max():g} at {at}: a share of what arrives, from 0 to 1")
    try:
        efficiency = float(given.efficiency)
    except (TypeError, ValueError):
        efficiency = np.nan
    if isinstance(given.efficiency, bool | str) or not 0 <= efficiency <= 1:
        raise ValueError(f"efficiency = {shown(given.efficiency)}: the share of the energy given back, from 0 to 1")

    # All of the emission lies in the bands, or as much as is told.
    whole = float(emission @ bands.widths)
    if whole == 0:
        raise ValueError("emission is 0 at all bands: give the spectrum that the dye shines with, or leave the dye out")
    if given.per_nm and whole > WHOLE:
        raise ValueError(f"emission sums to {whole:.4g} over the bands: in 1/nm it is 1 at most; or leave out per_nm")
    return _frozen(efficiency * excitation), _frozen(emission if given.per_nm else emission / whole)


def _numbers(value: SpectrumLike, bands: Bands, what: str, *, reflectance: bool) -> Spectrum:
    given = library_spectrum(value, bands, reflectance=reflectance) if isinstance(value, str) else value
    try:
        array = np.array(given, dtype=float)
    except (TypeError, ValueError, OverflowError):
        raise ValueError(f"{what} = {shown(given)}: give numbers, one a band or one for all") from None
    if array.ndim == 0:
        array = np.full(len(bands), array)
    if array.shape != (len(bands),):
        raise ValueError(f"{what} has {array.size} values for {bands!r}: give one a band, or one number for all")
    _check_numbers(array, what)
    return array


def _check_numbers(array: Float[np.ndarray, "..."], what: str) -> None:
    if not np.isfinite(array).all():
        raise ValueError(f"{what} is {array[~np.isfinite(array)][0]}: give finite numbers")
    if (array < 0).any():
        raise ValueError(f"{what} is {array.min():g}: no light is negative")


def _frozen(array: np.ndarray) -> np.ndarray:
    array.flags.writeable = False
    return array
