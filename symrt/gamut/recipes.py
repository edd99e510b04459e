"""The reflectances that a printer can really print, those for which a recipe of inks is found: a gamut for step 4.

``distance(r) = min_a ‖R(a) − r‖ / √K`` over amounts 0 <= a <= most, with R the printer's forward model.  The minimum is
sought by the method of Levenberg and Marquardt [1]_, within bounds, from a few of the device's prints that are nearest.
A recipe that is found proves that the print exists, as far as the model tells the printer; one that is not found proves
nothing for certain.  The set is not convex: a line may enter it more than once, and there is no support.

References
----------
.. [1] D. W. Marquardt, "An Algorithm for Least-Squares Estimation of Nonlinear Parameters", J. SIAM 11(2), 1963.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from symrt.arrays import PerPixel, PixelBands
from symrt.device.printing import Device, Printer
from symrt.gamut.hull import TOLERANCE
from symrt.gamut.interface import check_spectra
from symrt.gamut.looking import looked_for
from symrt.gamut.printed import OfPrinter
from symrt.spectra.bands import Number

STARTS = 4
"""Prints from which each recipe is sought."""
DESCENT_STEPS = 60
MOVED = 1e-7
"""Share of the largest amount by which an ink is moved to see what it does."""
DAMPED = 1e-3
MOST_DAMPED = 1e12
"""A step damped more than this goes nowhere: the search is over."""
SOUGHT_AT_ONCE = 1024
EDGE = 1e-9

Recipes = Float[np.ndarray, "pixel ink"]


@dataclass(frozen=True, eq=False)
class InkGamut(OfPrinter):
    """Reflectances that a printer's model comes near to with some amounts of its inks.

    Parameters
    ----------
    device
        A device with a printer, shipped or fitted.
    tolerance
        Root mean square difference up to which a spectrum counts as printed.

    Examples
    --------
    >>> from symrt.device.inks import load_device
    >>> gamut = ink_gamut(load_device("dye3-endura-premier"))
    >>> gamut.contains(np.array([[0.9] * 36, [0.95] * 36]))
    array([ True, False])
    """

    device: Device
    tolerance: float

    model = "inks"

    @property
    def label(self) -> str:
        """The claim that being inside proves: none where the model's own error is larger than the tolerance."""
        if self.tolerance < self.device.model_error:
            return (
                f"neither sufficient nor necessary: the printer's model misses prints held out from its fit by up to "
                f"{self.device.model_error:.4f} RMS (95 %), more than the tolerance"
            )
        return "sufficient, within the fit of the printer's model"

    @property
    def name(self) -> str:
        """The gamut in words."""
        return f"what the inks of {self.device.name} print, within {self.tolerance:.4f} RMS"

    def distance(self, spectra: PixelBands) -> PerPixel:
        """Root mean square difference from the nearest print that is found."""
        return _rms(recipes(self.device, spectra)[1] - spectra)

    def contains(self, spectra: PixelBands) -> Bool[np.ndarray, " pixel"]:
        """Whether a recipe for each spectrum is found."""
        return self.violation(spectra) == 0

    def violation(self, spectra: PixelBands) -> PerPixel:
        """The distance of each spectrum from the nearest print found in excess of the tolerance; 0 inside."""
        excess = self.distance(spectra) - self.tolerance
        return np.where(excess <= EDGE, 0.0, excess)

    def nearest(self, spectra: PixelBands) -> PixelBands:
        """Each spectrum, or, if it is outside, the nearest print that is found."""
        prints = recipes(self.device, spectra)[1]
        inside = _rms(prints - spectra) <= self.tolerance + EDGE
        return np.where(inside[:, None], spectra, prints)

    def clip(
        self, origin: PixelBands, direction: PixelBands, within: tuple[Number, Number] = (0.0, 1.0)
    ) -> list[list[tuple[float, float]]]:
        """For each line ``origin + t direction`` the intervals of t inside, between two values of t.

        Stretches shorter than 1/64 of the range may be missed.
        """
        found: list[list[tuple[float, float]]] = [[] for _ in origin]
        parts = looked_for(lambda i, t: self.contains(origin[i] + t[:, None] * direction[i]), len(origin), within)
        for pixel, low, high in zip(*parts, strict=True):
            found[pixel].append((float(low), float(high)))
        return found

    def __repr__(self) -> str:
        modelled = " (modelled)" if self.device.modelled else ""
        also = ", not necessary" if self.label.startswith("sufficient") else ""
        return f"InkGamut({self.name}{modelled}; inside is {self.label}{also})"


def ink_gamut(device: Device, tolerance: Number = TOLERANCE) -> InkGamut:
    """The gamut of everything that a printer's inks print, by its model.

    Parameters
    ----------
    device
        A device with a printer; a chart's gets one from `fit_halftone`.
    tolerance
        Root mean square difference of reflectances that passes for none.

    Examples
    --------
    >>> from symrt.device.inks import load_device
    >>> ink_gamut(load_device("synthetic-cmyk")).label
    "sufficient, within the fit of the printer's model"
    """
    _printer_of(device)
    if not 0 < tolerance <= 1:
        raise ValueError(f"tolerance = {tolerance}: recipes are sought to a root mean square difference above 0, to 1")
    return InkGamut(device, float(tolerance))


def recipes(device: Device, spectra: PixelBands) -> tuple[Recipes, PixelBands]:
    """Amounts of the inks that come nearest to each spectrum, of those that are found, and what they print.

    Examples
    --------
    >>> from symrt.device.inks import load_device
    >>> recipes(load_device("dye3-endura-premier"), np.full((1, 36), 0.9))[0].round(6)
    array([[0., 0., 0.]])
    """
    printer = _printer_of(device)
    check_spectra(spectra, device.bands)
    amounts = np.zeros((len(spectra), len(device.inks)))
    for first in range(0, len(spectra), SOUGHT_AT_ONCE):
        amounts[first : first + SOUGHT_AT_ONCE] = _sought(device, printer, spectra[first : first + SOUGHT_AT_ONCE])
    return amounts, printer.printed(amounts)


def _printer_of(device: Device) -> Printer:
    if device.printer is None:
        remedy = "fit a model to them with fit_halftone" if device.inks else "give a chart with columns of ink amounts"
        raise ValueError(f"{device.name}: known by its samples alone; {remedy}")
    return device.printer


def _sought(device: Device, printer: Printer, spectra: PixelBands) -> Recipes:
    """The best of the recipes that the nearest prints lead to."""
    far = np.sum(device.samples**2, axis=1) - 2 * (spectra @ device.samples.T)
    starts = min(STARTS, len(device.samples))
    nearest = np.argpartition(far, starts - 1, axis=1)[:, :starts].T
    found = [_descended(printer, device.amounts[start], spectra) for start in nearest]
    errors = np.array([_rms(printer.printed(amounts) - spectra) for amounts in found])
    return np.array(found)[errors.argmin(axis=0), np.arange(len(spectra))]


def _descended(printer: Printer, amounts: Recipes, spectra: PixelBands) -> Recipes:
    """The recipe at the bottom of the valley that each one lies in; bounds are kept."""
    amounts = amounts.copy()
    damping = np.full(len(amounts), DAMPED)
    missed = printer.printed(amounts) - spectra
    for _ in range(DESCENT_STEPS):
        # Try a step for every recipe that still moves.
        rows = np.flatnonzero(damping < MOST_DAMPED)
        if not rows.size:
            break
        tried = _stepped(printer, amounts[rows], missed[rows], damping[rows])
        left = printer.printed(tried) - spectra[rows]

        # Take the steps that pay, and damp the next ones less; damp the others more.
        before, after = np.sum(missed[rows] ** 2, axis=1), np.sum(left**2, axis=1)
        better = after < before
        amounts[rows[better]], missed[rows[better]] = tried[better], left[better]
        # What hardly improves any more has arrived.
        arrived = better & (after > before * (1 - EDGE))
        damping[rows] = np.where(arrived, np.inf, damping[rows] * np.where(better, 0.2, 8.0))
    return amounts


def _stepped(printer: Printer, amounts: Recipes, missed: PixelBands, damping: PerPixel) -> Recipes:
    """One damped step of Gauss and Newton; an ink at a bound that wants to pass it stays."""
    # Measure what each ink does, by moving it a little away from the nearer of its bounds.
    move = MOVED * printer.most
    change = np.where(amounts < printer.most / 2, move, -move)
    slopes = np.empty((*amounts.shape, missed.shape[1]))
    here = printer.printed(amounts)
    for ink in range(amounts.shape[1]):
        moved = amounts.copy()
        moved[:, ink] += change[:, ink]
        slopes[:, ink] = (printer.printed(moved) - here) / change[:, ink, None]

    # Hold the inks at a bound that the descent would take beyond it.
    gradient = np.einsum("pib,pb->pi", slopes, missed)
    held = ((amounts <= 0) & (gradient > 0)) | ((amounts >= printer.most) & (gradient < 0))
    slopes[held] = 0

    # Solve the damped normal equations; an ink without effect gets a 1, so that they stay regular.
    square = np.einsum("pib,pjb->pij", slopes, slopes)
    diagonal = np.einsum("pii->pi", square)
    diagonal += damping[:, None] * diagonal + np.where(diagonal > 0, 0, 1)
    step = np.linalg.solve(square, np.where(held, 0, gradient)[:, :, None])[:, :, 0]
    return np.clip(amounts - step, 0, printer.most)


def _rms(differences: PixelBands) -> PerPixel:
    return np.sqrt(np.mean(differences**2, axis=1))
