"""The ends of paths from the eye: lights, glowing hits, and rays cut off, with the paths that lead to each (step 2)."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from jaxtyping import Float, Int

from symrt.reflection.polynomials import Monomial
from symrt.tracing.raytree import Lit, Points

Index = Int[np.ndarray, " entry"]
Inside = Mapping[str, Float[np.ndarray, " _"]]
"""By the name of its transmittance, the length of the way from the eye to each place in an absorbing material."""


@dataclass(frozen=True, eq=False)
class Pairs:
    """Pairs of a path and of something at its end.

    Parameters
    ----------
    which
        Index of the thing in each pair.
    product
        Index into `products` of the reflectances that the path met.
    pixel
        The pixel that the path comes from, or its row among the halves of pixels, `Film.row`.
    value
        The number that the path carries, times the thing's own.
    inside
        The lengths of the path in absorbing materials.
    window
        The window of wavelengths of the path, −1 for all of them; None where there are none.
    gathered, half
        How often diffusers sent the path on to gather light and, of a path that they did, the half of all paths that it
        belongs to: a number that is positive in one half and negative in the other, and 1 where the halves are as
        large.  None where nothing is gathered.
    """

    which: Index
    product: Index
    pixel: Index
    value: Float[np.ndarray, " entry"]
    products: tuple[Monomial, ...]
    inside: Inside = field(default_factory=dict)
    window: Index | None = None
    gathered: Index | None = None
    half: Float[np.ndarray, " entry"] | None = None

    def of(self, some: Index) -> "Pairs":
        """Some of the pairs."""
        inside = {name: length[some] for name, length in self.inside.items()}
        return replace(
            self,
            which=self.which[some],
            product=self.product[some],
            pixel=self.pixel[some],
            value=self.value[some],
            inside=inside,
            window=None if self.window is None else self.window[some],
            gathered=None if self.gathered is None else self.gathered[some],
            half=None if self.half is None else self.half[some],
        )


@dataclass(frozen=True, eq=False)
class Lighted:
    """Paths that end at points of one material, reached by one sample of a light: `Pairs.which` counts in `lit.point`.

    Parameters
    ----------
    bounded
        True if the sample counts in the tail only, because of an effect that was left out.
    """

    points: Points
    lit: Lit
    pairs: Pairs
    bounded: bool


@dataclass(frozen=True, eq=False)
class Glowing:
    """Paths that end at hits which send light by themselves.

    Parameters
    ----------
    bounded
        True if the light counts in the tail only, because of an effect that was left out.
    """

    light: str
    hit: Int[np.ndarray, " emitting"]
    pairs: Pairs
    bounded: bool


@dataclass(frozen=True, eq=False)
class Lost:
    """Paths that went on by a product of reflectances, `met`, and were not followed."""

    met: Monomial
    pairs: Pairs
