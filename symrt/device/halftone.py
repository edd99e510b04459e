"""Halftone printers, by the model of Yule, Nielsen and Neugebauer: devices for step 4 of the paper.

Dots of inks that overlap at random leave areas of bare paper, of each ink alone, and of each overprint: the *Neugebauer
primaries* P_S.  Demichel's equations give the share w_S of each, and

    R(λ) = (Σ_S w_S P_S(λ)^(1/n))^n,        w_S = Π_{i ∈ S} a_i Π_{i ∉ S} (1 − a_i)

where Yule and Nielsen's exponent n stands for light that spreads in the paper between the dots [1]_, [2]_, [3]_.  Dots
grow when they are printed: a nominal coverage c becomes a = c + 4 g c (1 − c), with g the *dot gain* at one half.

References
----------
.. [1] H. E. J. Neugebauer, "Die theoretischen Grundlagen des Mehrfarbendrucks", Z. wiss. Photographie 36, 1937.
.. [2] J. A. C. Yule and W. J. Nielsen, "The penetration of light into paper and its effect on halftone reproduction",
   TAGA Proceedings 3, 1951, pp. 65-76.
.. [3] J. A. S. Viggiano, "Modeling the color of multi-colored halftones", TAGA Proceedings, 1990, pp. 44-62.
"""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from symrt.device.dyes import PAPER_WHITE, SURFACE, dye_printer, guessed_bands
from symrt.device.printing import Device
from symrt.spectra.bands import Bands, resample

MOST_INKS = 8
LARGEST_GAIN = 0.25
"""With more, a + 4 g a (1 − a) would not rise with a all the way."""
INKS = {"synthetic-cmyk": "CMYK", "synthetic-cmykog": "CMYKOG"}
DYES = "dye3-endura-premier"
SOLID = {"C": 1.5, "M": 1.4, "Y": 1.3, "K": 1.7, "O": 1.5, "G": 1.5}
"""Peak density of each synthetic ink, printed solid."""
EXPONENT = 2.0
GAIN = 0.03
LEVELS = {"CMYK": 6, "CMYKOG": 3}
"""Amounts of each ink in the grid of samples."""

Amounts = Float[np.ndarray, "print ink"]
Prints = Float[np.ndarray, "print band"]


@dataclass(frozen=True, eq=False)
class Halftone:
    """A printer of up to eight inks in dots.

    Parameters
    ----------
    bands
        Wavelengths of the primaries.
    inks
        Names of the inks.
    primaries
        Reflectance of each Neugebauer primary; row S has ink i where bit i of S is set, so that row 0 is the paper.
    exponent
        Yule and Nielsen's n, 1 or more; ``inf`` is the limit, the geometric mean.
    gain
        Dot gain of each ink at a nominal coverage of one half, between -1/4 and 1/4.
    most
        Largest nominal coverage.

    Examples
    --------
    Half of the paper under black ink, light not spreading in it:

    >>> printer = Halftone(Bands((500.0,)), ("K",), np.array([[0.9], [0.1]]), exponent=1.0, gain=np.zeros(1))
    >>> printer.printed(np.array([[0.5]]))
    array([[0.5]])
    """

    bands: Bands
    inks: tuple[str, ...]
    primaries: Float[np.ndarray, "primary band"]
    exponent: float
    gain: Float[np.ndarray, " ink"]
    most: float = 1.0

    def __post_init__(self) -> None:
        if not 1 <= len(self.inks) <= MOST_INKS:
            raise ValueError(f"{len(self.inks)} inks: the model has 1 to {MOST_INKS}; leave some out")
        if self.primaries.shape != (2 ** len(self.inks), len(self.bands)) or self.gain.shape != (len(self.inks),):
            raise ValueError(
                f"primaries {self.primaries.shape} and gains {self.gain.shape} for {len(self.inks)} inks in "
                f"{len(self.bands)} bands: give a row for each of the {2 ** len(self.inks)} overprints, one gain an ink"
            )
        if not (self.exponent >= 1 and np.all(np.abs(self.gain) <= LARGEST_GAIN)):
            raise ValueError(f"exponent {self.exponent}, gains {self.gain}: n is 1 or more, a gain within ±1/4")
        if not np.all(self.primaries >= 0):
            raise ValueError("a primary is below 0 or nan: no reflectance is")

    def printed(self, amounts: Amounts) -> Prints:
        """Reflectance of prints, whatever the amounts; `reflectance` checks them first."""
        return unspread(demichel(self.coverage(amounts)) @ spread(self.primaries, self.exponent), self.exponent)

    def coverage(self, amounts: Amounts) -> Amounts:
        """The shares of paper that nominal coverages become in print."""
        return amounts + 4 * self.gain * amounts * (1 - amounts)

    def on(self, bands: Bands) -> "Halftone":
        """The same printer at other wavelengths, its primaries linearly interpolated."""
        nm = np.array(self.bands.centres)
        return replace(self, bands=bands, primaries=np.array([resample(nm, p, bands, "inks") for p in self.primaries]))

    def __repr__(self) -> str:
        gains = ", ".join(f"{ink} {gain:+.3f}" for ink, gain in zip(self.inks, self.gain, strict=True))
        return f"Halftone({len(self.inks)} inks, n = {self.exponent:.3f}, dot gain {gains}, {self.bands!r})"


def demichel(coverage: Amounts) -> Float[np.ndarray, "print primary"]:
    """The share of paper that shows each Neugebauer primary, in the order of `Halftone.primaries`.

    Examples
    --------
    >>> demichel(np.array([[0.5, 0.2]]))
    array([[0.4, 0.4, 0.1, 0.1]])
    """
    shares = np.ones((len(coverage), 1))
    for covered in coverage.T[:, :, None]:
        shares = np.hstack([shares * (1 - covered), shares * covered])
    return shares


def spread(reflectances: Prints, exponent: float) -> Prints:
    """R^(1/n), which adds up area by area, or log R in the limit; R below 0, an instrument's noise, counts as 0."""
    positive = np.maximum(reflectances, 0)
    if np.isinf(exponent):
        with np.errstate(divide="ignore"):
            return np.log(positive)
    return positive ** (1 / exponent)


def unspread(sums: Prints, exponent: float) -> Prints:
    """Reflectance of what `spread` made add up."""
    return np.exp(sums) if np.isinf(exponent) else np.maximum(sums, 0) ** exponent


def synthetic_devices() -> tuple[str, ...]:
    """Names of the halftone printers that are made up.

    Examples
    --------
    >>> synthetic_devices()
    ('synthetic-cmyk', 'synthetic-cmykog')
    """
    return tuple(INKS)


def synthetic_device(name: str, bands: Bands | None = None) -> Device:
    """A made-up halftone printer: no such machine was measured, every number in it is assumed.

    Cyan, magenta and yellow absorb like the dyes of a photographic paper, black like a neutral grey; orange and green
    absorb all below 555 nm, and all outside 485 … 580 nm, with soft edges.  Overprints multiply transmittances.

    Examples
    --------
    >>> synthetic_device("synthetic-cmyk").samples.shape
    (1296, 36)
    """
    # Densities of the inks on paper, each alone.
    inks = INKS[name]
    dyes = dye_printer(DYES)
    curves = _curves(dyes.bands, dyes.densities)
    density = np.array([SOLID[ink] * curves[ink] for ink in inks])

    # Overprints of them, and the printer that mixes these.
    solids = np.array([[(s >> i) & 1 for i in range(len(inks))] for s in range(2 ** len(inks))], dtype=float)
    printer = Halftone(
        bands=dyes.bands,
        inks=tuple(inks),
        primaries=SURFACE + (PAPER_WHITE - SURFACE) * 10 ** -(solids @ density),
        exponent=EXPONENT,
        gain=np.full(len(inks), GAIN),
    )
    printer = printer.on(bands) if bands else printer

    # Prints of every combination of a few amounts.
    levels = np.linspace(0, 1, LEVELS[inks])
    amounts = np.stack(np.meshgrid(*[levels] * len(inks), indexing="ij"), axis=-1).reshape(-1, len(inks))
    return Device(
        name=name,
        bands=printer.bands,
        samples=printer.printed(amounts),
        amounts=amounts,
        inks=printer.inks,
        extrapolated=guessed_bands(DYES, printer.bands),
        title=f"a synthetic halftone printer of {len(inks)} inks",
        provenance=f"Synthetic: no printer was measured. Cyan, magenta and yellow absorb like the dyes of {DYES}, the "
        f"others by formula. Assumed: peak densities {', '.join(f'{i} {SOLID[i]}' for i in inks)}, paper white "
        f"{PAPER_WHITE}, surface {SURFACE}, n = {EXPONENT}, dot gain {GAIN}, overprints multiply.",
        printer=printer,
    )


def _curves(bands: Bands, dyes: Float[np.ndarray, "3 band"]) -> dict[str, Float[np.ndarray, " band"]]:
    """Density of each synthetic ink, at most 1."""
    nm = np.array(bands.centres)

    def below(edge: float) -> Float[np.ndarray, " band"]:
        return np.asarray(1 / (1 + np.exp((nm - edge) / 10)))

    return dict(zip("CMY", dyes, strict=True)) | {
        "K": np.ones(len(nm)),
        "O": below(555.0),
        "G": np.maximum(below(485.0), 1 - below(580.0)),
    }
