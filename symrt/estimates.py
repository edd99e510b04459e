"""Estimated errors of what was sampled: they stay with a tree, and with the system that it collapses to."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float


@dataclass(frozen=True)
class Estimate:
    """The estimated error of numbers that were sampled: how much they differ from a coarser sampling.

    Parameters
    ----------
    count
        How many numbers were sampled, those that are exact included.
    rms, largest
        Root of the mean square of their errors, and the largest one.

    Examples
    --------
    >>> print(Estimate.of(np.array([0.0, 0.0, 0.03, 0.04])))
    about 0.025 (rms), 0.04 at most
    """

    count: int
    rms: float
    largest: float

    @classmethod
    def of(cls, errors: Float[np.ndarray, " number"]) -> "Estimate":
        """The estimate of some errors."""
        if not errors.size:
            return cls(0, 0.0, 0.0)
        return cls(errors.size, float(np.sqrt(np.mean(errors**2))), float(errors.max()))

    def joined(self, other: "Estimate") -> "Estimate":
        """The estimate of the numbers of both."""
        count = self.count + other.count
        square = (self.count * self.rms**2 + other.count * other.rms**2) / max(1, count)
        return Estimate(count, float(np.sqrt(square)), max(self.largest, other.largest))

    def __str__(self) -> str:
        return f"about {self.rms:.2g} (rms), {self.largest:.2g} at most"
