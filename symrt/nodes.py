"""Nodes: how a parameter of a formula stays free in a system that is linear (between steps 2 and 3 of the paper)."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Float

MOST_NODES = 256
FIRST_ORDER = "first order"
SCALES = ("linear", "log", FIRST_ORDER)


@dataclass(frozen=True)
class Nodes:
    """Chebyshev nodes that make a nonlinear parameter linear: f(θ) = Σ_j ℓ_j(θ) f(θ_j).

    Or first order, f(θ) = f(θ₀) + f′(θ₀) (θ − θ₀), whose two parts stand in the place of nodes.

    Parameters
    ----------
    scale
        ``log`` for nodes in the logarithm of the parameter, ``linear``, or ``first order``.
    error
        A bound on the error of each coefficient of a formula within the range: of radiance, per unit irradiance, and
        for reflectances of 1.  Infinite if it is not known.
    around
        Of first order: θ₀.

    References
    ----------
    J.-P. Berrut and L. N. Trefethen, "Barycentric Lagrange Interpolation", SIAM Review 46(3), 2004.
    """

    parameter: str
    low: float
    high: float
    count: int
    scale: Literal["linear", "log", "first order"] = "log"
    error: float = np.inf
    around: float | None = None

    def __post_init__(self) -> None:
        given = f"nodes of {self.parameter}: {self.count} in [{self.low}, {self.high}], {self.scale}"
        if not (np.isfinite(self.low) and np.isfinite(self.high) and self.low < self.high):
            raise ValueError(f"{given}: give a finite range, low below high")
        if (self.around is not None) != (self.scale == FIRST_ORDER):
            raise ValueError(f"{given}: first order is around a value, and nothing else is")
        if self.around is not None and not (self.count == 2 and self.low <= self.around <= self.high):
            raise ValueError(f"{given}: first order has two parts, around a value in the range, not {self.around}")
        if not self.error >= 0:
            raise ValueError(f"{given}: an error is 0 or more, not {self.error}")
        if self.scale not in SCALES or (self.scale == "log" and self.low <= 0):
            raise ValueError(f"{given}: the scale is 'linear', 'first order', or 'log' for a range above 0")
        if not 1 <= self.count <= MOST_NODES:
            raise ValueError(f"{given}: give 1 to {MOST_NODES} nodes")

    @property
    def values(self) -> tuple[float, ...]:
        """The nodes θ_j, from high to low."""
        low, high = self._transform(self.low), self._transform(self.high)
        x = np.cos((2 * np.arange(self.count) + 1) * np.pi / (2 * self.count))
        t = (low + high) / 2 + (high - low) / 2 * x
        return tuple(float(v) for v in (np.exp(t) if self.scale == "log" else t))

    def weights(self, value: float) -> Float[np.ndarray, " node"]:
        """The Lagrange weights ℓ_j at a value, which sum to 1 and may be negative; of first order 1 and θ − θ₀.

        Examples
        --------
        >>> Nodes("brass.exponent", 5.0, 80.0, 3).weights(20.0).round(12).tolist()
        [0.0, 1.0, 0.0]
        """
        if not self.low <= value <= self.high:
            raise ValueError(f"{self.parameter} = {value}: the system was collapsed for [{self.low}, {self.high}]")
        if self.around is not None:
            return np.array([1.0, value - self.around])
        return self.all_weights(np.array([value]))[:, 0]

    def error_at(self, value: float) -> float:
        """The bound on the error at a value: first order errs by its share of the square of the distance.

        Examples
        --------
        >>> Nodes("desk.gloss", 1.0, 3.0, 2, "first order", 0.5, 2.0).error_at(2.5)
        0.125
        """
        if self.around is None:
            return self.error
        return self.error * ((value - self.around) / max(self.high - self.around, self.around - self.low)) ** 2

    def all_weights(self, values: Float[np.ndarray, " value"]) -> Float[np.ndarray, "node value"]:
        """The Lagrange weights at each of some values, which are not checked."""
        nodes = np.array([self._transform(v) for v in self.values])
        difference = np.array([self._transform(float(v)) for v in values]) - nodes[:, None]
        met = difference == 0
        k = np.arange(self.count)[:, None]
        signs = (-1.0) ** k * np.sin((2 * k + 1) * np.pi / (2 * self.count))
        terms = signs / np.where(met, 1.0, difference)
        return np.where(met.any(axis=0), met.astype(float), terms / terms.sum(axis=0))

    def _transform(self, value: float) -> float:
        return float(np.log(value)) if self.scale == "log" else float(value)


def chebyshev_error(width: float, count: int) -> float:
    """A bound on the error of ``a^s``, for every a in [0, 1], interpolated in ln s over a range of some width.

    In x = ln s it is ``exp(−σ e^x)`` with σ = −ln a, of size at most 1 wherever the imaginary part of x is at most π/2.
    The largest ellipse about the range that lies there has the sum of semi-axes ρ, in units of half the width, and the
    interpolant of degree n errs by at most ``4 ρ^−n/(ρ − 1)`` [1]_.

    References
    ----------
    .. [1] L. N. Trefethen, "Approximation Theory and Approximation Practice", SIAM, 2013, theorem 8.2.

    Examples
    --------
    >>> round(chebyshev_error(np.log(16), 12), 8)
    5.503e-05
    """
    height = np.pi / width
    ellipse = height + np.sqrt(1 + height**2)
    return float(4 * ellipse ** (1 - count) / (ellipse - 1))
