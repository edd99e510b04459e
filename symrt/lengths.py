"""Lengths of paths in absorbing glass: a few powers of its transmittance stand for all (between steps 2 and 3).

Light that goes d through a material of transmittance T per unit length is left T^d (Beer and Lambert).  In between
nodes at fixed lengths d_j it is ``T^d = Σ_j h_j(d) T^{d_j}``, the same few spectra for all pixels.

Nodes are decimal numbers, as many between 1 and 10 as between 0.1 and 1: T^d with d near 0.01 is to a small T what T^d
with d near 1 is to a large one, so that one number of nodes a decade serves all transmittances and all lengths, and
nodes depend on no scene and no tile.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Literal, get_args

import numpy as np
from jaxtyping import Float

from symrt.errors import shown
from symrt.nodes import Nodes, chebyshev_error

Scheme = Literal["hats", "chebyshev"]
MOST = {"hats": 1000, "chebyshev": 32}
"""Largest number of nodes a decade."""
Spread = tuple[Float[np.ndarray, "node length"], Float[np.ndarray, "node length"]]
"""For each of some lengths its nodes, and their weights."""


@dataclass(frozen=True)
class Lengths:
    """Nodes at which a transmittance is raised to a power, in place of any length between.

    Parameters
    ----------
    a_decade
        Number of nodes from one length to ten times as much.
    scheme
        ``hats``: between two nodes a straight line, which lies above the convex T^d: no weight is negative, and no
        pixel too dark.  ``chebyshev``: a polynomial in ln d through all nodes of a decade; weights may be negative.
    """

    a_decade: int
    scheme: Scheme = "hats"

    def __post_init__(self) -> None:
        if self.scheme not in get_args(Scheme):
            raise ValueError(f"lengths = {shown(self.scheme)}: there are 'hats' and 'chebyshev'")
        if not 2 <= self.a_decade <= MOST[self.scheme]:
            raise ValueError(f"{self.a_decade} nodes a decade: give 2 to {MOST[self.scheme]}")

    @cached_property
    def error(self) -> float:
        """A bound on the error of T^d, for any length and every T in [0, 1].

        Where nodes are a and q a, the line between errs at most by what it does for ``−(4/e²) ln d``, whose second
        derivative ``4/(e d)²`` bounds that of T^d for every T: by ``(4/e²)(m − 1 − ln m)`` with ``m = ln q/(q − 1)``.

        Examples
        --------
        >>> round(Lengths(20).error, 6), round(Lengths(9, "chebyshev").error, 6)
        (0.000901, 0.000256)
        """
        if self.scheme == "chebyshev":
            return chebyshev_error(np.log(10.0), self.a_decade)
        ratio = max(after / before for before, after in pairwise(self._decade))
        m = np.log(ratio) / (ratio - 1)
        return float(4 * np.exp(-2) * (m - 1 - np.log(m)))

    def weights(self, length: Float[np.ndarray, " length"]) -> Spread:
        """The nodes of each length, above 0, and their weights, which sum to 1.

        Examples
        --------
        >>> nodes, weights = Lengths(20).weights(np.array([1.5]))
        >>> nodes.T.tolist(), weights.T.round(3).tolist()
        ([[1.413, 1.585]], [[0.494, 0.506]])
        """
        return self._hats(length) if self.scheme == "hats" else self._chebyshev(length)

    def below(self, length: Float[np.ndarray, " length"]) -> Float[np.ndarray, " length"]:
        """For each length, above 0, a node that is not longer: T raised to it is not less than T^d.

        Examples
        --------
        >>> Lengths(20).below(np.array([1.5, 15.0])).tolist()
        [1.413, 14.13]
        """
        return self._hats(length)[0][0] if self.scheme == "hats" else 10.0 ** _exponents(length)

    @cached_property
    def _decade(self) -> tuple[float, ...]:
        """The nodes of hats from 1 to 10, in so many digits that they stay apart, and are short to read."""
        digits = 1 + len(str(self.a_decade))
        return tuple(float(f"{10 ** (k / self.a_decade):.{digits}e}") for k in range(self.a_decade + 1))

    def _hats(self, length: Float[np.ndarray, " length"]) -> Spread:
        exponents = _exponents(length)
        table = np.array(_decimals(self._decade[:-1], range(int(exponents.min()), int(exponents.max()) + 2)))
        before = np.searchsorted(table, length, side="right") - 1
        low, high = table[before], table[before + 1]
        share = (length - low) / (high - low)
        return np.stack([low, high]), np.stack([1 - share, share])

    def _chebyshev(self, length: Float[np.ndarray, " length"]) -> Spread:
        exponents = _exponents(length)
        nodes = np.empty((self.a_decade, length.size))
        weights = np.empty((self.a_decade, length.size))
        for exponent in np.unique(exponents).tolist():
            own = exponents == exponent
            decade = Nodes("length", float(f"1e{exponent}"), float(f"1e{exponent + 1}"), self.a_decade)
            nodes[:, own] = np.array(decade.values)[:, None]
            weights[:, own] = decade.all_weights(length[own])
        return nodes, weights


def lengths_for(error: float | int, scheme: str = "hats") -> Lengths:
    """The fewest nodes that interpolate every T^d within an error.

    Raises
    ------
    ValueError
        If the error is not above 0, or needs more nodes than there may be.

    Examples
    --------
    >>> lengths_for(1e-3), lengths_for(1e-3, "chebyshev")
    (Lengths(a_decade=20, scheme='hats'), Lengths(a_decade=8, scheme='chebyshev'))
    """
    if scheme not in MOST:
        raise ValueError(f"lengths = {shown(scheme)}: there are 'hats' and 'chebyshev'")
    for count in range(2, MOST[scheme] + 1):
        found = Lengths(count, scheme)  # type: ignore[arg-type]  # one of the two
        if found.error <= error:
            return found
    other = "; lengths = 'chebyshev' needs fewer" if scheme == "hats" else ""
    raise ValueError(f"error = {shown(error)}: more than {MOST[scheme]} nodes a decade of lengths; ask for less{other}")


def _exponents(length: Float[np.ndarray, " length"]) -> np.ndarray:
    """The power of ten that is not above each length."""
    powers = np.floor(np.log10(length)).astype(int)
    # A logarithm may be rounded up to the next whole number.
    exact = np.array(_decimals((1.0,), range(int(powers.min()) - 1, int(powers.max()) + 3)))
    return np.searchsorted(exact, length, side="right") - 1 + int(powers.min()) - 1


def _decimals(mantissas: Sequence[float], exponents: range) -> list[float]:
    """Decimal numbers, ascending, each the float that is nearest to it."""
    return [float(f"{mantissa!r}e{exponent}") for exponent in exponents for mantissa in mantissas]
