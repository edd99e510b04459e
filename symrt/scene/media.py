"""Glasses by name, and the refractive index of a medium at each wavelength (before step 1).

Sellmeier's formula [1]_ has a resonance for each term, Cauchy's [2]_ is what is left of it far from them; λ is in µm:

    n² = 1 + Σ B λ² / (λ² − C)              n = A₀ + A₁/λ² + A₂/λ⁴ + …

References
----------
.. [1] W. Sellmeier, "Zur Erklärung der abnormen Farbenfolge im Spectrum einiger Substanzen", Ann. Phys. 219, 1871.
.. [2] M. Born and E. Wolf, "Principles of Optics", 7th ed., 1999, section 2.3.4.
"""

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from importlib import resources
from itertools import pairwise
from typing import Any

import numpy as np
from jaxtyping import Float

from symrt.errors import shown, suggestion
from symrt.scene.checks import check_number, check_whole
from symrt.windows import even_nodes

MOST_TERMS = 8
"""Largest number of terms of a formula."""
WINDOWS, MOST_WINDOWS = 6, 64
"""Windows of a scene that does not choose them, and the largest number of them."""
SHORTEST, LONGEST = 100.0, 3000.0
"""The wavelengths that a spectrum may have, in nm."""
FIRST, LAST = 380.0, 730.0
"""The wavelengths that a number of windows reaches from and to, in nm: those of palettes of 36 bands."""
LOWEST_INDEX, HIGHEST_INDEX = 0.01, 100.0
"""Refractive indices of no medium of nature's are near them."""


@dataclass(frozen=True)
class Dispersion:
    """A refractive index that changes with the wavelength, by one of two formulas.

    Parameters
    ----------
    name
        The glass, as its maker calls it; empty for numbers of a user's own.
    sellmeier
        Pairs B and C, C in µm².
    cauchy
        A₀, A₁ in µm², A₂ in µm⁴ …
    valid
        The wavelengths that the formula was published for, in nm; of a user's own it is not known.

    Examples
    --------
    >>> crown = Dispersion(cauchy=(1.5, 0.004))
    >>> crown.index(np.array([400.0, 500.0])).round(4)
    array([1.525, 1.516])
    """

    name: str = ""
    sellmeier: tuple[tuple[float, float], ...] = ()
    cauchy: tuple[float, ...] = ()
    valid: tuple[float, float] = (0.0, np.inf)

    def index(self, nm: Float[np.ndarray, " wavelength"]) -> Float[np.ndarray, " wavelength"]:
        """The refractive index at some wavelengths, in nm; nan where the square of it is not above 0."""
        square = (nm / 1000) ** 2
        if self.cauchy:
            powers = square[:, None] ** -np.arange(len(self.cauchy))
            return np.asarray(powers @ np.array(self.cauchy))
        with np.errstate(divide="ignore", invalid="ignore"):
            terms = [strength * square / (square - resonance) for strength, resonance in self.sellmeier]
            return np.asarray(np.sqrt(1 + np.sum(terms, axis=0)))

    def faults(self, first: float, last: float) -> Iterator[str]:
        """Reasons that there is no index at some wavelength between two, in nm."""
        if not self.valid[0] <= first <= last <= self.valid[1]:
            yield (
                f"its index is published for {self.valid[0]:g} … {self.valid[1]:g} nm, and the scene's windows run "
                f"from {first:g} to {last:g} nm: choose them, such as windows = [400, 450, 500, 550, 600, 650, 700]"
            )
            return

        # A resonance of Sellmeier's is a pole of the index.
        poles = [1000 * resonance**0.5 for strength, resonance in self.sellmeier if strength and resonance > 0]
        if inside := [pole for pole in poles if first <= pole <= last]:
            yield (
                f"the index has a pole at {inside[0]:.4g} nm, within the scene's windows, {first:g} … {last:g} nm: "
                "C is in µm², and its root lies outside the spectrum; glass has about 0.01 and 100"
            )
            return

        # Between poles it may fall to nothing.
        nm = np.linspace(first, last, 257)
        index = self.index(nm)
        wrong = ~((index >= LOWEST_INDEX) & (index <= HIGHEST_INDEX))
        if wrong.any():
            at = "not real" if np.isnan(index[wrong][0]) else f"{index[wrong][0]:.4g}"
            yield (
                f"the index at {nm[wrong][0]:.4g} nm is {at}: it must be from {LOWEST_INDEX:g} to {HIGHEST_INDEX:g}; "
                "wavelengths are in µm in both formulas"
            )

    def __str__(self) -> str:
        """The formula as it is written in a scene's file."""
        if self.name:
            return f"glass = {self.name!r}"
        if self.sellmeier:
            return f"sellmeier = {[[strength, resonance] for strength, resonance in self.sellmeier]}"
        return f"cauchy = {list(self.cauchy)}"


def glasses() -> tuple[str, ...]:
    """Names of the glasses, liquids and crystals whose index is known at each wavelength.

    Examples
    --------
    >>> glasses()[:4], glasses()[-4:]
    (('N-BK7', 'N-K5', 'N-SK16', 'F2'), ('fused silica', 'fluorite', 'water', 'diamond'))
    """
    return tuple(_tables())


def refractive_index(
    glass: str, nm: Float[np.ndarray, " wavelength"] | Sequence[float | int] | float | int
) -> Float[np.ndarray, " wavelength"] | float:
    """The refractive index of a glass, by its name, at one wavelength or several, in nm.

    Raises
    ------
    ValueError
        If no glass has this name, or its formula was not published for one of the wavelengths.

    Examples
    --------
    The yellow line of helium bends less than the blue line of hydrogen:

    >>> round(refractive_index("N-BK7", 587.56), 5), round(refractive_index("N-BK7", 486.13), 5)
    (1.5168, 1.52238)
    """
    if glass not in _tables():
        raise ValueError(f"no glass is called {shown(glass)}: {suggestion(str(glass), glasses())}")
    medium, at = _tables()[glass], np.atleast_1d(np.asarray(nm, dtype=float))
    low, high = medium.valid
    if outside := [one for one in at.tolist() if not low <= one <= high]:
        raise ValueError(
            f"{glass} at {outside[0]:g} nm: its index is published for {low:g} … {high:g} nm; nothing is extrapolated"
        )
    found = medium.index(at)
    return found if np.ndim(nm) else float(found[0])


def dispersion(glass: Any, sellmeier: Any, cauchy: Any) -> Dispersion | None:
    """The dispersion that a material gives, by a name or by numbers, each of them checked; None if it gives none."""
    if glass is not None:
        return _tables()[glass]
    if sellmeier is not None:
        return Dispersion(sellmeier=tuple((float(strength), float(resonance)) for strength, resonance in sellmeier))
    return None if cauchy is None else Dispersion(cauchy=tuple(map(float, cauchy)))


def dispersion_faults(glass: Any, sellmeier: Any, cauchy: Any, index: Any, refracts: bool) -> Iterator[str]:
    """Faults of what a material gives for its refractive index, a line each, but for a number."""
    # One way, of a model that light goes through.
    told = {"index": index, "glass": glass, "sellmeier": sellmeier, "cauchy": cauchy}
    given = {key: value for key, value in told.items() if value is not None}
    if len(given) > 1:
        ways = ", ".join(f"{key} = {shown(value)}" for key, value in given.items())
        yield f"{ways}: one way to give an index is enough; delete the others"
    if not refracts:
        yield from (
            f"{key} = {shown(value)}: light does not go through this model; write model = 'glass', or delete the key"
            for key, value in given.items()
            if key != "index"
        )

    # A name, the numbers of Sellmeier's formula, or those of Cauchy's.
    if glass is not None and (not isinstance(glass, str) or glass not in _tables()):
        yield f"glass = {shown(glass)}: no glass has this name; {suggestion(str(glass), glasses())}"
    if sellmeier is not None:
        pairs = list(sellmeier) if isinstance(sellmeier, list | tuple) else []
        if not 1 <= len(pairs) <= MOST_TERMS or any(not isinstance(p, list | tuple) or len(p) != 2 for p in pairs):
            yield (
                f"sellmeier = {shown(sellmeier)}: it must be pairs of B and C, C in µm², at most {MOST_TERMS}; write "
                "[[1.0396, 0.006], [0.2318, 0.02], [1.0105, 103.56]]"
            )
            return
        for k, pair in enumerate(pairs):
            yield from (fault for j in (0, 1) for fault in check_number(f"sellmeier[{k}][{j}]", pair[j]))
    if cauchy is not None:
        numbers = list(cauchy) if isinstance(cauchy, list | tuple) else []
        if not 1 <= len(numbers) <= MOST_TERMS:
            yield (
                f"cauchy = {shown(cauchy)}: it must be numbers A₀, A₁ in µm² and so on, at most {MOST_TERMS}; write "
                "[1.5046, 0.0042]"
            )
        for k, number in enumerate(numbers):
            yield from check_number(f"cauchy[{k}]", number)


def window_faults(windows: Any) -> Iterator[str]:
    """Faults of a scene's windows, a number or a list of wavelengths."""
    if not isinstance(windows, list | tuple):
        yield from check_whole("windows", windows, MOST_WINDOWS, least=2)
        return
    faults = [fault for k, nm in enumerate(windows) for fault in check_number(f"windows[{k}]", nm)]
    yield from faults
    if faults:
        return
    if not 2 <= len(windows) <= MOST_WINDOWS:
        yield f"windows = {shown(windows)}: give 2 to {MOST_WINDOWS} wavelengths in nm, or a number of windows"
    elif any(here >= there for here, there in pairwise(windows)):
        yield f"windows = {shown(windows)}: wavelengths must increase; sort them and drop duplicates"
    elif windows[0] < SHORTEST or windows[-1] > LONGEST:
        yield f"windows = {shown(windows)}: wavelengths are in nm, from {SHORTEST:g} to {LONGEST:g}"


def window_nodes(windows: int | Sequence[float | int]) -> tuple[float, ...]:
    """The wavelengths of a scene's windows, in nm.

    Examples
    --------
    >>> window_nodes(6), window_nodes([400, 700])
    ((380.0, 450.0, 520.0, 590.0, 660.0, 730.0), (400.0, 700.0))
    """
    return even_nodes(windows, FIRST, LAST) if isinstance(windows, int) else tuple(map(float, windows))


@cache
def _tables() -> dict[str, Dispersion]:
    text = (resources.files("symrt") / "data" / "glasses.json").read_text(encoding="utf-8")
    found = {}
    for name, table in json.loads(text).items():
        # Some publications give the wavelength of the resonance, the root of C.
        pairs = table.get("B, C") or [(strength, at**2) for strength, at in table["B, √C"]]
        low, high = table["nm"]
        found[name] = Dispersion(name, tuple(map(tuple, pairs)), valid=(float(low), float(high)))
    return found
