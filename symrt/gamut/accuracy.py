"""Errors of a device's prints in reflectance and in colour against the number of basis spectra kept: step 4.

A print kept to its first k components differs from itself by a root mean square of reflectance, and in colour by a
CIEDE2000 under a viewing light.  Both are told for the basis whose first spectrum is constant and for plain principal
components: with all components kept nothing is lost by the constant one, with few of them a little [1]_.  A spectrum
that is kept to few components may leave [0, 1]; its colour is taken as it is.

References
----------
.. [1] The paper, §2.1: "we may substitute an ideal uniform reflectance with no loss in accuracy, provided all
   dimensions are retained".
"""

from dataclasses import dataclass
from html import escape

import numpy as np
from jaxtyping import Float

from symrt.device.colorimetry import lab, tristimulus
from symrt.device.monitors import Monitor, printer_of
from symrt.device.printing import Device
from symrt.gamut.basis import Samples, uniform_first
from symrt.spectra.bands import Number
from symrt.spectra.library import colour_difference

ROWS_SHOWN = 8
"""Numbers of components in the table; then the one from which nothing is missing."""
BASIS_COLUMNS = ("components", "RMS", "plain", "mean ΔE2000", "plain", "largest ΔE2000", "plain")

Errors = Float[np.ndarray, " component"]


@dataclass(frozen=True, eq=False)
class BasisReport:
    """Errors of a device's prints kept to their first k components, k = 1 … K.

    Parameters
    ----------
    device
        The printer's name.
    modelled
        True if its prints come from a model, false if they were measured.
    light
        The viewing light of colour differences.
    prints
        Number of prints.
    rank
        Number of components after the constant one that the prints determine.
    cosine
        Of the angle between the first principal component and the constant spectrum.
    rms, rms_plain
        Root mean square error of the reflectance: constant spectrum first, and plain principal components.
    mean, mean_plain
        Mean CIEDE2000 over the prints.
    largest, largest_plain
        Largest CIEDE2000 of a print.
    """

    device: str
    modelled: bool
    light: str
    prints: int
    rank: int
    cosine: float
    rms: Errors
    rms_plain: Errors
    mean: Errors
    mean_plain: Errors
    largest: Errors
    largest_plain: Errors

    def enough(self, delta_e: Number = 1.0) -> tuple[int, int]:
        """The number of components from which on no print is off by more: constant first, and plain."""
        if not delta_e >= 0:
            raise ValueError(f"delta_e = {delta_e}: a colour difference is 0 or more")
        # None is too few, and all of them miss nothing but rounding.
        first, plain = (np.append(True, errors[:-1] > delta_e) for errors in (self.largest, self.largest_plain))
        return int(np.flatnonzero(first)[-1]) + 1, int(np.flatnonzero(plain)[-1]) + 1

    def rows(self) -> list[tuple[str, ...]]:
        """The table's cells, its head first: a few numbers of components, and that which determines all."""
        last = min(self.rank + 1, len(self.rms))
        columns = (self.rms, self.rms_plain, self.mean, self.mean_plain, self.largest, self.largest_plain)
        shown = [*range(1, min(ROWS_SHOWN, last) + 1), *([last] if last > ROWS_SHOWN else [])]
        return [BASIS_COLUMNS, *((str(k), *(f"{column[k - 1]:.3g}" for column in columns)) for k in shown)]

    def summary(self) -> str:
        """The rank, and the number of components that suffices, in a sentence."""
        first, plain = self.enough()
        return (
            f"Rank {self.rank} after the constant spectrum; the first principal component is {self.cosine:.4f} "
            f"constant. No print is off by more than ΔE2000 = 1 under {self.light} from {first} components on, plain "
            f"from {plain}."
        )

    def what(self) -> str:
        """The prints in words: their number, their kind and their device."""
        return f"{self.prints} {'modelled' if self.modelled else 'measured'} prints of {self.device}"

    def __str__(self) -> str:
        rows = self.rows()
        widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
        lines = ["  ".join(map(str.rjust, row, widths)) for row in rows]
        title = f"{self.what()} kept to few components, the constant one first or plain:"
        return "\n".join([title, lines[0], "-" * len(lines[0]), *lines[1:], self.summary()])

    def _repr_html_(self) -> str:
        head, *rows = self.rows()
        cells = "".join(f"<th>{escape(name)}</th>" for name in head)
        body = "".join("<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in rows)
        caption = f"<caption>{escape(self.what())} kept to few components</caption>"
        return f"<table>{caption}<tr>{cells}</tr>{body}</table><p>{escape(self.summary())}</p>"


def basis_report(device: Device | Monitor, light: str = "illuminant/D50") -> BasisReport:
    """Errors of a device's prints against the number of basis spectra, in reflectance and in colour.

    Parameters
    ----------
    device
        Printer or chart.
    light
        The illuminant under which colours differ.

    Raises
    ------
    ValueError
        If it is a monitor, which has no prints.

    Examples
    --------
    >>> from symrt.device.inks import load_device
    >>> report = basis_report(load_device("dye3-endura-premier"))
    >>> report.rms[:2].round(3), report.largest[:2].round(1)
    (array([0.166, 0.097]), array([41.9, 44.2]))
    >>> print(report.summary())
    Rank 30 after the constant spectrum; the first principal component is 0.9351 constant. No print is off by more than
    ΔE2000 = 1 under illuminant/D50 from 9 components on, plain from 9.
    """
    # Take the prints' basis with the constant spectrum first, and the plain principal components.
    device = printer_of(device)
    basis, observer = uniform_first(device.samples), tristimulus(device.bands, light)
    # The triangle has the samples' right singular vectors; signs do not matter here.
    plain = np.linalg.svd(np.linalg.qr(device.samples, mode="r"), full_matrices=True).Vh

    # Compare the colours of prints kept to their first components with those of the prints.
    seen = [_differences(device.samples, vectors, observer, light) for vectors in (basis.vectors, plain)]
    return BasisReport(
        device=device.name,
        modelled=device.modelled,
        light=light,
        prints=len(device.samples),
        rank=basis.rank,
        cosine=basis.cosine,
        rms=basis.rms,
        rms_plain=basis.rms_plain,
        mean=seen[0].mean(axis=1),
        mean_plain=seen[1].mean(axis=1),
        largest=seen[0].max(axis=1),
        largest_plain=seen[1].max(axis=1),
    )


def _differences(
    samples: Samples,
    vectors: Float[np.ndarray, "component band"],
    observer: Float[np.ndarray, "band 3"],
    light: str,
) -> Float[np.ndarray, "component sample"]:
    """CIEDE2000 between each print and its first k components, k = 1 … K."""
    # XYZ is linear: what each component adds to the colour is summed up, one component after the other.
    added = (samples @ vectors.T).T[:, :, None] * (vectors @ observer)[:, None, :]
    kept = lab(np.cumsum(added, axis=0), light)
    whole = np.broadcast_to(lab(samples @ observer, light), kept.shape)
    return colour_difference(kept.reshape(-1, 3), whole.reshape(-1, 3)).reshape(kept.shape[:2])
