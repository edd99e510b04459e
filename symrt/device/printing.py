"""Printing devices: step 4 of the paper begins with the spectra that a device can print.

They are measured, or a model of the device makes them: its *printer*, which tells the reflectance of any amounts of
its inks.
"""

from dataclasses import dataclass, replace
from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Bool, Float

from symrt.arrays import Spectrum
from symrt.errors import require_plain
from symrt.spectra.bands import Bands, resample

Amounts = Float[np.ndarray, "print ink"]
Prints = Float[np.ndarray, "print band"]


@runtime_checkable
class Printer(Protocol):
    """A forward model: what is printed by amounts of the inks, each from 0 to `most`."""

    @property
    def bands(self) -> Bands:
        """Wavelengths of what it prints."""

    @property
    def inks(self) -> tuple[str, ...]:
        """Names of its inks."""

    @property
    def most(self) -> float:
        """Largest amount of an ink."""

    def printed(self, amounts: Amounts) -> Prints:
        """Reflectance of amounts that are known to be in range; see `reflectance`."""

    def on(self, bands: Bands) -> "Printer":
        """The same printer at other wavelengths."""


@dataclass(frozen=True, eq=False)
class Device:
    """A printer, known by spectra that it prints.

    Parameters
    ----------
    name
        Its name for `load_device`, or the file that it was read from.
    bands
        Wavelengths of its spectra.
    samples
        Reflectances of prints, one a row.
    amounts
        Of each ink in each sample; no columns where they are not known.
    inks
        Names of the inks, a column of `amounts` each.
    extrapolated
        Bands in which some ink was not measured, and the nearest one that was stands for it.
    title, provenance
        A line that describes it, and the source of its numbers.
    printer
        The model that made the samples, or that was fitted to them; None, there is none.
    modelled
        True: the samples come from a model and not from measured prints.
    model_error
        The error of the printer's model on prints held out from its fit: the root mean square difference that 95 % of
        them do not pass; 0 where the model made the samples, or none was fitted.
    """

    name: str
    bands: Bands
    samples: Prints
    amounts: Amounts
    inks: tuple[str, ...]
    extrapolated: Bool[np.ndarray, " band"]
    title: str
    provenance: str
    printer: Printer | None = None
    modelled: bool = True
    model_error: float = 0.0

    def __post_init__(self) -> None:
        # Texts that a terminal may show.
        for what in ("name", "title", "provenance"):
            require_plain(f"{what} of a device", getattr(self, what))
        for ink in self.inks:
            require_plain("an ink's name", ink)

        # One row a print, one column a band or an ink.
        prints, bands = self.samples.shape
        if bands != len(self.bands) or not prints:
            raise ValueError(f"{self.name}: {prints} samples in {bands} bands for {self.bands!r}: give one row a print")
        if self.amounts.shape != (prints, len(self.inks)):
            raise ValueError(
                f"{self.name}: amounts are {self.amounts.shape}, not ({prints}, {len(self.inks)}): one row a print, "
                "one column an ink"
            )

        # Finite numbers.
        for what, values, of in (
            ("sample", self.samples, self.bands.labels),
            ("amounts of print", self.amounts, self.inks),
        ):
            if not np.isfinite(values).all():
                row, column = (int(k) for k in np.argwhere(~np.isfinite(values))[0])
                raise ValueError(
                    f"{self.name}: {what} {row}, {of[column]}, is {values[row, column]}: give finite numbers"
                )

    @property
    def black(self) -> Spectrum:
        """The lowest reflectance in each band."""
        return self.samples.min(axis=0)

    @property
    def white(self) -> Spectrum:
        """The highest reflectance in each band."""
        return self.samples.max(axis=0)

    def on(self, bands: Bands) -> "Device":
        """The same prints at other wavelengths, linearly interpolated, never extrapolated.

        A model prints its samples anew, from what it knows at those wavelengths.

        Raises
        ------
        ValueError
            If its spectra do not cover the bands.

        Examples
        --------
        >>> from symrt.device.inks import load_device
        >>> from symrt.spectra.bands import wavelengths
        >>> load_device("dye3-endura-premier").on(wavelengths(400, 700, 20)).samples.shape
        (729, 16)
        """
        if bands == self.bands:
            return self
        if self.bands.kind != "wavelength":
            raise ValueError(f"{self.name} is in {self.bands!r}, which have no wavelengths: give spectra of its prints")
        nm = np.array(self.bands.centres)
        printer = self.printer.on(bands) if self.printer else None
        if self.modelled and printer:
            samples = printer.printed(self.amounts)
        else:
            samples = np.array([resample(nm, sample, bands, self.name) for sample in self.samples])
        guessed = resample(nm, self.extrapolated.astype(float), bands, self.name) > 0
        return replace(self, bands=bands, samples=samples, extrapolated=guessed, printer=printer)

    def __repr__(self) -> str:
        how = "modelled" if self.modelled else "measured"
        return f"Device({self.name!r}, {how}, {len(self.samples)} prints in {self.bands!r}: {self.title})"


def reflectance(device: Device | Printer, amounts: Amounts) -> Prints:
    """The reflectance that a device, or the model of one, prints with these amounts of its inks.

    Raises
    ------
    ValueError
        If an amount is not in the printer's range, or the device has no model.

    Examples
    --------
    >>> from symrt.device.inks import load_device
    >>> reflectance(load_device("dye3-endura-premier"), np.zeros((1, 3)))[0, :2]
    array([0.9, 0.9])
    """
    # The model.
    printer = device.printer if isinstance(device, Device) else device
    if printer is None:
        raise ValueError("the device is known by its samples alone: fit a model to them with fit_halftone")

    # Amounts that it can lay down.
    if amounts.shape[1] != len(printer.inks):
        raise ValueError(f"{amounts.shape[1]} amounts a print: the inks are {', '.join(printer.inks)}")
    wrong = ~((amounts >= 0) & (amounts <= printer.most))
    if wrong.any():
        row, ink = np.argwhere(wrong)[0]
        raise ValueError(
            f"print {row}, {printer.inks[ink]}: the amount {amounts[row, ink]:g} is not in [0, {printer.most:g}]; the "
            "device cannot lay it down"
        )
    return printer.printed(amounts)
