"""Printing devices: step 4 of the paper begins with the spectra that a device can print.

A print of three dyes in the amounts c_i reflects, by the law of Beer and Lambert,

    r(λ) = r_s + (r_paper − r_s) · 10^(−Σ c_i D_i(λ))

with D_i the density of each dye, scaled to a peak of 1, and r_s what the surface reflects.  The densities are those of
photographic papers; that printers are like them is an assumption, and every device made here says so.
"""

import json
from dataclasses import dataclass
from functools import cache
from importlib import resources
from typing import Any

import numpy as np
from jaxtyping import Bool, Float

from symrt.arrays import Spectrum
from symrt.spectra.bands import Bands, resample
from symrt.spectra.palette import did_you_mean

__all__ = ["Device", "devices", "load_device", "reflectance"]

PAPER_WHITE = 0.90
SURFACE = 0.004
MOST_DYE = 2.2
STEPS = 9
"""Amounts of each dye in the grid of samples, from 0 to `MOST_DYE`."""


@dataclass(frozen=True, eq=False)
class Device:
    """A printer, known by spectra that it prints.

    Parameters
    ----------
    name
        What `load_device` calls it.
    bands
        Wavelengths of its spectra.
    samples
        Reflectances of prints, one a row.
    amounts
        Of each dye in each sample.
    densities
        Spectral density of each dye in the amount 1; its highest point is 1.
    most
        Largest amount of a dye.
    paper, surface
        Reflectance of the bare paper, and of the surface alone.
    extrapolated
        Bands in which some dye was not measured, and its density was held at the nearest one that was.
    title, provenance
        What it is and where its numbers come from.
    modelled
        Whether the samples come from a model and not from measured prints.
    """

    name: str
    bands: Bands
    samples: Float[np.ndarray, "sample band"]
    amounts: Float[np.ndarray, "sample dye"]
    densities: Float[np.ndarray, "dye band"]
    most: float
    paper: float
    surface: float
    extrapolated: Bool[np.ndarray, " band"]
    title: str
    provenance: str
    modelled: bool = True

    @property
    def black(self) -> Spectrum:
        """The lowest reflectance in each band."""
        return self.samples.min(axis=0)

    @property
    def white(self) -> Spectrum:
        """The highest reflectance in each band."""
        return self.samples.max(axis=0)

    def __repr__(self) -> str:
        how = "modelled" if self.modelled else "measured"
        return f"Device({self.name!r}, {how}, {len(self.samples)} prints in {self.bands!r}: {self.title})"


def devices() -> tuple[str, ...]:
    """Names that `load_device` knows.

    Examples
    --------
    >>> "dye3-endura-premier" in devices()
    True
    """
    return tuple(_papers()["papers"])


def load_device(name: str, bands: Bands | None = None) -> Device:
    """A printer by name: dye-sublimation-like, modelled from the dyes of a photographic paper.

    Parameters
    ----------
    name
        One of `devices`.
    bands
        Wavelengths within 380 … 730 nm; the table's own, every 10 nm, if not given.

    Raises
    ------
    ValueError
        If there is no such device, or the densities do not cover the bands.

    Examples
    --------
    >>> device = load_device("dye3-endura-premier")
    >>> device
    Device('dye3-endura-premier', modelled, 729 prints in Bands(36 wavelengths, 380 … 730 nm): dye-sublimation-like,
    modelled from the dyes of Kodak Professional Endura Premier paper)
    >>> device.bands.labels[2], device.extrapolated[:3]
    ('400 nm', array([ True,  True, False]))
    """
    table = _papers()
    if name not in table["papers"]:
        raise ValueError(f"no device {did_you_mean([name], devices())}; there are: {', '.join(devices())}")
    paper = table["papers"][name]
    nm = np.array(table["wavelengths"], dtype=float)
    bands = bands or Bands(tuple(nm.tolist()))
    densities = np.array([resample(nm, _unit_peak(curve), bands, name) for curve in paper["density"].values()])
    one_dye = np.linspace(0, MOST_DYE, STEPS)
    amounts = np.stack(np.meshgrid(*[one_dye] * len(densities), indexing="ij"), axis=-1).reshape(-1, len(densities))
    first = max(first for first, _, _ in paper["native"].values())
    last = min(last for _, last, _ in paper["native"].values())
    centres = np.array(bands.centres)
    return Device(
        name=name,
        bands=bands,
        samples=_printed(amounts, densities, PAPER_WHITE, SURFACE),
        amounts=amounts,
        densities=densities,
        most=MOST_DYE,
        paper=PAPER_WHITE,
        surface=SURFACE,
        extrapolated=(centres < first) | (centres > last),
        title=f"dye-sublimation-like, modelled from the dyes of {paper['title']}",
        provenance=f"{table['what']} {table['source']} Assumed: each dye in amounts 0 … {MOST_DYE} on its curve scaled "
        f"to a peak of 1, paper white {PAPER_WHITE}, surface reflection {SURFACE}.",
    )


def reflectance(device: Device, amounts: Float[np.ndarray, "print dye"]) -> Float[np.ndarray, "print band"]:
    """What the device prints with these amounts of its dyes.

    Raises
    ------
    ValueError
        If an amount is not in the device's range.

    Examples
    --------
    >>> device = load_device("dye3-endura-premier")
    >>> reflectance(device, np.zeros((1, 3)))[0, :2]
    array([0.9, 0.9])
    """
    if amounts.shape[1] != len(device.densities):
        raise ValueError(f"{amounts.shape[1]} amounts a print: {device.name} has {len(device.densities)} dyes")
    wrong = ~((amounts >= 0) & (amounts <= device.most))
    if wrong.any():
        row, dye = np.argwhere(wrong)[0]
        raise ValueError(
            f"print {row}, dye {dye}: the amount {amounts[row, dye]:g} is not in [0, {device.most:g}]; the device "
            "cannot lay it down"
        )
    return _printed(amounts, device.densities, device.paper, device.surface)


def _printed(
    amounts: Float[np.ndarray, "print dye"], densities: Float[np.ndarray, "dye band"], paper: float, surface: float
) -> Float[np.ndarray, "print band"]:
    # As paper − (paper − surface)(1 − 10^−D), so that the bare paper is exact.
    absorbed = -np.expm1(-np.log(10) * (amounts @ densities))
    return paper - (paper - surface) * absorbed


def _unit_peak(curve: list[float]) -> Float[np.ndarray, " sample"]:
    density = np.array(curve, dtype=float)
    return density / density.max()


@cache
def _papers() -> dict[str, Any]:
    return dict(json.loads(resources.files("symrt.data").joinpath("dye_densities_36.json").read_text("utf-8")))
