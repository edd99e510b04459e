"""Printers of transparent dyes, by the law of Beer and Lambert: a device for step 4 of the paper.

A print of dyes in the amounts c_i reflects

    r(λ) = r_s + (r_paper − r_s) · 10^(−Σ c_i D_i(λ))

with D_i the density of each dye, scaled to a peak of 1, and r_s what the surface reflects.  The densities are those of
photographic papers; that printers are like them is an assumption, and every device made here says so.
"""

import json
from dataclasses import dataclass, replace
from functools import cache
from importlib import resources
from typing import Any

import numpy as np
from jaxtyping import Bool, Float

from symrt.device.printing import Device
from symrt.spectra.bands import Bands, resample

PAPER_WHITE = 0.90
SURFACE = 0.004
MOST_DYE = 2.2
STEPS = 9
"""Amounts of each dye in the grid of samples, from 0 to `MOST_DYE`."""


@dataclass(frozen=True, eq=False)
class Dyes:
    """A printer of transparent dyes on white paper.

    Parameters
    ----------
    bands
        Wavelengths of the densities.
    inks
        Names of the dyes.
    densities
        Spectral density of each dye in the amount 1; its highest point is 1.
    most
        Largest amount of a dye.
    paper, surface
        Reflectance of the bare paper, and of the surface alone.
    """

    bands: Bands
    inks: tuple[str, ...]
    densities: Float[np.ndarray, "ink band"]
    most: float = MOST_DYE
    paper: float = PAPER_WHITE
    surface: float = SURFACE

    def __post_init__(self) -> None:
        if self.densities.shape != (len(self.inks), len(self.bands)):
            raise ValueError(f"densities are {self.densities.shape}: give one row a dye and one column a band")
        if not 0 <= self.surface <= self.paper < np.inf:
            raise ValueError(
                f"paper {self.paper}, surface {self.surface}: a paper reflects no less than its surface alone, and "
                "that no less than 0"
            )

    def printed(self, amounts: Float[np.ndarray, "print ink"]) -> Float[np.ndarray, "print band"]:
        """Reflectance of prints, whatever the amounts; `reflectance` checks them first."""
        # As paper − (paper − surface)(1 − 10^−D), so that the bare paper is exact.
        absorbed = -np.expm1(-np.log(10) * (amounts @ self.densities))
        return self.paper - (self.paper - self.surface) * absorbed

    def on(self, bands: Bands) -> "Dyes":
        """The same dyes at other wavelengths, their densities linearly interpolated."""
        nm = np.array(self.bands.centres)
        densities = [resample(nm, d, bands, ink) for d, ink in zip(self.densities, self.inks, strict=True)]
        return replace(self, bands=bands, densities=np.array(densities))


def dye_devices() -> tuple[str, ...]:
    """Names of the papers whose dyes are known.

    Examples
    --------
    >>> "dye3-endura-premier" in dye_devices()
    True
    """
    return tuple(_papers()["papers"])


def dye_printer(name: str) -> Dyes:
    """The printer of a paper's dyes, at the wavelengths of their table.

    Examples
    --------
    >>> dye_printer("dye3-endura-premier").inks
    ('cyan', 'magenta', 'yellow')
    """
    table = _papers()
    curves = table["papers"][name]["density"]
    bands = Bands(tuple(float(nm) for nm in table["wavelengths"]))
    return Dyes(bands, tuple(curves), np.array([_unit_peak(curve) for curve in curves.values()]))


def dye_device(name: str, bands: Bands | None = None) -> Device:
    """A dye-sublimation-like printer, modelled from the dyes of a photographic paper.

    Examples
    --------
    >>> dye_device("dye3-endura-premier").samples.shape
    (729, 36)
    """
    table = _papers()
    paper = table["papers"][name]

    # The printer of the paper's dyes, at the bands asked for.
    printer = dye_printer(name)
    printer = printer.on(bands) if bands else printer

    # Every combination of a few amounts of each dye.
    one_dye = np.linspace(0, MOST_DYE, STEPS)
    amounts = np.stack(np.meshgrid(*[one_dye] * len(printer.inks), indexing="ij"), axis=-1)
    amounts = amounts.reshape(-1, len(printer.inks))
    return Device(
        name=name,
        bands=printer.bands,
        samples=printer.printed(amounts),
        amounts=amounts,
        inks=printer.inks,
        extrapolated=guessed_bands(name, printer.bands),
        title=f"dye-sublimation-like, modelled from the dyes of {paper['title']}",
        provenance=f"{table['what']} {table['source']} Assumed: each dye in amounts 0 … {MOST_DYE} on its curve scaled "
        f"to a peak of 1, paper white {PAPER_WHITE}, surface reflection {SURFACE}.",
        printer=printer,
    )


def guessed_bands(name: str, bands: Bands) -> Bool[np.ndarray, " band"]:
    """Bands in which some dye of a paper was not measured.

    Examples
    --------
    >>> from symrt.spectra.bands import wavelengths
    >>> guessed_bands("dye3-endura-premier", wavelengths(390, 410, 10))
    array([ True, False, False])
    """
    native = _papers()["papers"][name]["native"].values()
    centres = np.array(bands.centres)
    return (centres < max(first for first, _, _ in native)) | (centres > min(last for _, last, _ in native))


def _unit_peak(curve: list[float]) -> Float[np.ndarray, " sample"]:
    density = np.array(curve, dtype=float)
    return density / density.max()


@cache
def _papers() -> dict[str, Any]:
    return dict(json.loads(resources.files("symrt.data").joinpath("dye_densities_36.json").read_text("utf-8")))
