"""Fit the model of Yule, Nielsen and Neugebauer to a chart whose ink amounts are known, for step 4 of the paper.

For a given exponent and dot gains the primaries are a linear least-squares problem in R^(1/n).  Overprints that the
chart leaves open stay at what inks that multiply their transmittances would give.  The exponent is searched in one
dimension, then refined together with the gains, to the least root mean square of the reflectances [1]_.

References
----------
.. [1] R. Balasubramanian, "Optimization of the spectral Neugebauer model for printer characterization", Journal of
   Electronic Imaging 8(2), 1999, pp. 156-166.
"""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float
from scipy.optimize import least_squares, minimize_scalar

from symrt.device.colorimetry import lab, tristimulus
from symrt.device.halftone import LARGEST_GAIN, MOST_INKS, Halftone, demichel, spread, unspread
from symrt.device.monitors import Monitor, printer_of
from symrt.device.printing import Device
from symrt.spectra.library import colour_difference

LARGEST_EXPONENT = 100.0
"""Beyond it nothing changes that a chart could show."""
UNDETERMINED = 1e-4
"""Combinations of primaries that show less than this in the prints, of the clearest one's 1, are not fitted."""
FEW = 12
"""Exponents that are tried first."""
EDGE = 1e-9
"""Distance from the bounds of the search at which it begins."""
PARTS = 4
"""Parts that the prints are dealt into, each held out in turn."""
SEED = 0
DARKEST = 1e-4
"""Reflectance from which a logarithm is taken instead of a lower one's."""


@dataclass(frozen=True, eq=False)
class HalftoneFit:
    """A halftone printer fitted to a chart, and how well it tells the chart's own prints.

    Parameters
    ----------
    device
        The chart's device, now with the fitted printer.
    printer
        The model.
    rms
        Root mean square error of the reflectance, over all prints and bands.
    worst_rms
        That of the print it tells worst.
    delta_e, delta_e_95, worst_delta_e
        CIEDE2000: its mean, what 95 % of the prints do not pass, and the largest.
    worst_print
        The number of the print that differs most in colour, from 0.
    held_out
        The root mean square error that 95 % of prints do not pass that were held out while the primaries were fitted.
    undetermined
        Number of combinations of primaries that the chart leaves open, of 2 to the power of the number of inks.
    light
        The illuminant of CIEDE2000.
    """

    device: Device
    printer: Halftone
    rms: float
    worst_rms: float
    delta_e: float
    delta_e_95: float
    worst_delta_e: float
    worst_print: int
    held_out: float
    undetermined: int
    light: str

    def __repr__(self) -> str:
        left = f"; {self.undetermined} overprints not determined by the chart" if self.undetermined else ""
        return (
            f"HalftoneFit({self.printer!r}: RMS {self.rms:.5f}, worst {self.worst_rms:.5f}, held out 95 % within "
            f"{self.held_out:.5f}; ΔE2000 {self.delta_e:.3f}, "
            f"95 % within {self.delta_e_95:.3f}, worst {self.worst_delta_e:.3f} (print {self.worst_print}), under "
            f"{self.light}{left})"
        )


def fit_halftone(device: Device | Monitor, *, dot_gain: bool = True, light: str = "illuminant/D50") -> HalftoneFit:
    """The halftone printer that tells a chart's prints best.

    Parameters
    ----------
    device
        Prints with known amounts of up to 8 inks.
    dot_gain
        True: dots may grow; otherwise the exponent alone accounts for it.
    light
        An illuminant, under which colour differences are taken.

    Raises
    ------
    ValueError
        If it is a monitor, if amounts are not known or not in [0, 1], or if any model fits because the prints are no
        more than its primaries.

    Examples
    --------
    >>> from symrt.device.inks import load_device
    >>> from symrt.spectra.bands import wavelengths
    >>> fit = fit_halftone(load_device("synthetic-cmyk", wavelengths(400, 700, 50)))
    >>> round(fit.printer.exponent, 3), fit.rms < 1e-5
    (2.0, True)
    """
    device = printer_of(device)
    _check(device)
    prior = _multiplied(device)
    gains = len(device.inks) * dot_gain
    inverse = _searched(device, prior, np.zeros(gains))
    low = np.append(1 / LARGEST_EXPONENT, np.full(gains, -LARGEST_GAIN))
    high = np.append(1.0, np.full(gains, LARGEST_GAIN))
    start = np.clip(np.append(inverse, np.zeros(gains)), low + EDGE, high - EDGE)
    best = least_squares(lambda u: _missed(device, prior, u), start, bounds=(low, high), xtol=1e-10, ftol=1e-12).x
    return _judged(device, _fitted(device, prior, best), _held_out(device, best), light)


def _check(device: Device) -> None:
    # Known amounts of inks, as shares of the paper.
    inks = len(device.inks)
    if not 1 <= inks <= MOST_INKS:
        what = "the ink amounts of its prints are not known" if not inks else f"{inks} inks"
        raise ValueError(
            f"{device.name}: {what}; a halftone model needs those of 1 to {MOST_INKS} inks, beside the spectra"
        )
    if not np.all((device.amounts >= 0) & (device.amounts <= 1)):
        raise ValueError(f"{device.name}: amounts are not all in [0, 1]: a halftone's are shares of the paper covered")

    # More prints than unknowns.
    if len(device.samples) < 2 * inks + 2:
        raise ValueError(
            f"{device.name}: {len(device.samples)} prints for {inks} inks: give {2 * inks + 2} or more, else any "
            "model fits"
        )
    told = _determined(demichel(device.amounts))
    if len(device.samples) <= told:
        raise ValueError(
            f"{device.name}: {len(device.samples)} prints, which tell {told} primaries and nothing else, so that any "
            "exponent fits: give more prints, such as ramps of single inks"
        )


def _determined(shares: Float[np.ndarray, "print primary"]) -> int:
    """The number of combinations of primaries that the prints tell apart."""
    return int(np.linalg.matrix_rank(shares, rtol=UNDETERMINED))


def _multiplied(device: Device) -> Float[np.ndarray, "primary band"]:
    """A first guess of the primaries: inks that multiply, fitted to the logarithms of the prints."""
    inks = len(device.inks)
    logs = np.log(np.maximum(device.samples, DARKEST))
    known = np.column_stack([np.ones(len(logs)), device.amounts])
    paper, *each = np.linalg.lstsq(known, logs, rcond=None)[0]
    solid = np.array([[(s >> i) & 1 for i in range(inks)] for s in range(2**inks)], dtype=float)
    return np.exp(np.minimum(paper + solid @ np.array(each), 0))


def _fitted(
    device: Device, prior: Float[np.ndarray, "primary band"], unknowns: Float[np.ndarray, " unknown"]
) -> Halftone:
    """The printer of an exponent's inverse and dot gains, with the primaries that suit the prints best."""
    exponent = float(1 / unknowns[0])
    gain = unknowns[1:] if len(unknowns) > 1 else np.zeros(len(device.inks))
    guessed = Halftone(device.bands, device.inks, prior, exponent, gain)
    shares = demichel(guessed.coverage(device.amounts))
    guess = spread(prior, exponent)
    missed = spread(device.samples, exponent) - shares @ guess
    found = guess + _least_squares(shares, missed)
    return replace(guessed, primaries=unspread(found, exponent))


def _least_squares(
    shares: Float[np.ndarray, "print primary"], wanted: Float[np.ndarray, "print band"]
) -> Float[np.ndarray, "primary band"]:
    """The smallest solution: nothing is changed that the prints do not show, by eigenvalues of the normal equations."""
    values, vectors = np.linalg.eigh(shares.T @ shares)
    shown = values > UNDETERMINED**2 * values[-1]
    return (vectors[:, shown] / values[shown]) @ (vectors[:, shown].T @ (shares.T @ wanted))


def _missed(
    device: Device, prior: Float[np.ndarray, "primary band"], unknowns: Float[np.ndarray, " unknown"]
) -> Float[np.ndarray, " residual"]:
    return (_fitted(device, prior, unknowns).printed(device.amounts) - device.samples).ravel()


def _searched(device: Device, prior: Float[np.ndarray, "primary band"], gain: Float[np.ndarray, " _"]) -> float:
    """The best 1/n without dot gain: among a few first, then between the neighbours of the best of them."""

    def error(inverse: float) -> float:
        return float(np.sum(_missed(device, prior, np.append(inverse, gain)) ** 2))

    few = np.linspace(1 / LARGEST_EXPONENT, 1, FEW)
    best = int(np.argmin([error(inverse) for inverse in few]))
    bounds = (few[max(best - 1, 0)], few[min(best + 1, FEW - 1)])
    return float(minimize_scalar(error, bounds=bounds, method="bounded", options={"xatol": 1e-6}).x)


def _held_out(device: Device, unknowns: Float[np.ndarray, " unknown"]) -> float:
    """The error that 95 % of prints do not pass, each told by primaries that were fitted without it.

    The prints are dealt into a few parts; exponent and gains, which few numbers decide, stay as all prints have them.
    """
    part = np.random.default_rng(SEED).permutation(len(device.samples)) % PARTS
    errors = np.zeros(len(device.samples))
    for k in range(PARTS):
        kept, out = part != k, part == k
        some = replace(device, samples=device.samples[kept], amounts=device.amounts[kept])
        told = _fitted(some, _multiplied(some), unknowns).printed(device.amounts[out])
        errors[out] = np.sqrt(np.mean((told - device.samples[out]) ** 2, axis=1))
    return float(np.percentile(errors, 95))


def _judged(device: Device, printer: Halftone, held_out: float, light: str) -> HalftoneFit:
    # Errors of the spectra, and differences in colour.
    told = printer.printed(device.amounts)
    errors = np.sqrt(np.mean((told - device.samples) ** 2, axis=1))
    colours = [lab(spectra @ tristimulus(device.bands, light), light) for spectra in (told, device.samples)]
    differences = colour_difference(*colours)

    # The fit, with both.
    shares = demichel(printer.coverage(device.amounts))
    return HalftoneFit(
        device=replace(device, printer=printer, model_error=held_out),
        printer=printer,
        rms=float(np.sqrt(np.mean(errors**2))),
        worst_rms=float(errors.max()),
        delta_e=float(differences.mean()),
        delta_e_95=float(np.percentile(differences, 95)),
        worst_delta_e=float(differences.max()),
        worst_print=int(differences.argmax()),
        held_out=held_out,
        undetermined=shares.shape[1] - _determined(shares),
        light=light,
    )
