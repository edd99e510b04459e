"""Light by the number of times that diffusers sent it on, and the noise of the paths that gathered it (step 2)."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float, Int

from symrt.estimates import Estimate
from symrt.interactions import Interaction
from symrt.linear.ended import Pairs


@dataclass(frozen=True, eq=False)
class Bounces:
    """What is told of gathered light while a tree is collapsed; of a tree without any, nothing.

    Parameters
    ----------
    columns
        Of each column, its numbers summed over all pixels, after so many bounces.
    halves
        Of each light and each pixel, the mean of one half of the paths less that of the other, halved.
    """

    columns: dict[Interaction, Float[np.ndarray, " bounce"]] = field(default_factory=dict)
    halves: dict[str, Float[np.ndarray, " pixel"]] = field(default_factory=dict)

    def add(
        self,
        columns: Sequence[Interaction],
        which: Int[np.ndarray, " entry"],
        pairs: Pairs,
        value: Float[np.ndarray, " entry"],
    ) -> None:
        """Add numbers of G, each of the column that `which` counts."""
        if pairs.gathered is None or pairs.half is None or not value.size:
            return
        # Each column, by the number of bounces.
        most = int(pairs.gathered.max()) + 1
        sums = np.bincount(which * most + pairs.gathered, weights=value, minlength=most * len(columns))
        for column, added in zip(columns, sums.reshape(len(columns), most), strict=True):
            if added.any():
                self.columns[column] = _longer(self.columns.get(column, np.empty(0)), added)

        # Each light, by the halves of the paths.
        light = columns[0].light
        signed = np.bincount(pairs.pixel, weights=value * pairs.half)
        self.halves[light] = _longer(self.halves.get(light, np.empty(0)), signed)

    def sums(self) -> dict[Interaction, tuple[float, ...]]:
        """Of each column its sum after so many bounces, where there were any."""
        return {column: tuple(sums.tolist()) for column, sums in sorted(self.columns.items())}

    def noise(self, white: Mapping[str, float]) -> dict[str, Estimate]:
        """For each light, the error of pixels that gather it under reflectances of 1, as a share of its white."""
        found = {}
        for light, reference in white.items():
            halves = self.halves.get(light, np.empty(0))
            if halves.any() and reference > 0:
                found[light] = Estimate.of(np.abs(halves[halves != 0]) / reference)
        return found


def _longer(one: Float[np.ndarray, " n"], other: Float[np.ndarray, " m"]) -> Float[np.ndarray, " most"]:
    """The sum of two rows of numbers, the shorter one filled up with zeros."""
    total = np.zeros(max(one.size, other.size))
    total[: one.size] += one
    total[: other.size] += other
    return total
