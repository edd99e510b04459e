"""Bounds of what a trace cut off, which a system carries beside its G (between steps 2 and 3)."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from scipy import sparse

from symrt.interactions import Interaction

Shares = tuple[tuple[tuple[str, ...], float], ...]
"""Terms of a sum: reflectances, and a number that multiplies them."""


@dataclass(frozen=True, eq=False)
class Tail:
    """An upper bound on the part of each pixel that the depth limit cut off.

    Each column is a light times the reflectances that a cut path was mirrored by.  As long as no reflectance passes 1,
    the missing radiance is at most ``Σ bound · light · Π met / (1 − ρ)`` in each band, where ρ is the largest share
    ``Σ_k c_k Π met_k`` that a material sends on of what rays bring it, a diffuser's albedo included where rays gather
    light for it.  Materials that no light shines on, mirrors and glass, do not count: what they send on comes from
    others, as long as it is no more than they receive.

    Parameters
    ----------
    bound
        (pixel × column); infinite where nothing is known, as of a light of one's own.
    reflected
        Of materials that lights shine on: sums that bound the share that each sends on, as reflectances and numbers.
    passed
        The same of materials that no light shines on.
    fluorescent
        The scene's fluorescent reflectances, which move light from band to band: what was cut off may have met them.
    gathered
        Of columns of G, their coefficients summed over all pixels, by the number of times that diffusers sent the light
        on to each other: from how it falls off what is missing is estimated.
    """

    bound: sparse.csr_array
    interactions: tuple[Interaction, ...] = ()
    reflected: tuple[Shares, ...] = ()
    passed: tuple[Shares, ...] = ()
    fluorescent: tuple[str, ...] = ()
    gathered: Mapping[Interaction, tuple[float, ...]] = field(default_factory=dict)
