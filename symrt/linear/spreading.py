"""Spread numbers over powers of transmittances: a few nodes stand for all lengths of paths in glass (step 2).

The lengths of one path in one glass are added up first, so that it has one power of each glass's transmittance.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float, Int

from symrt.interactions import Interaction
from symrt.lengths import Lengths

Index = Int[np.ndarray, " entry"]


@dataclass(frozen=True, eq=False)
class Spread:
    """Entries after each was shared out to nodes.

    Parameters
    ----------
    origin
        For each the entry that it is a part of.
    which
        The number of its column in `columns`.
    share
        The weight of its nodes, of which there is one for each glass that it went through.
    """

    columns: tuple[Interaction, ...]
    origin: Index
    which: Index
    share: Float[np.ndarray, " entry"]


def spread(
    columns: Sequence[Interaction],
    which: Index,
    inside: Mapping[str, Float[np.ndarray, " entry"]],
    lengths: Mapping[str, Lengths],
    *,
    bounding: bool = False,
) -> Spread:
    """Share out entries to columns with powers of the transmittances that they met on the way.

    Parameters
    ----------
    which
        For each entry the number of its column.
    inside
        The length that each entry went in each glass; 0 where it did not.
    bounding
        True to put all of an entry where its power is largest, so that it bounds what it stands for.

    Examples
    --------
    >>> found = spread(
    ...     [Interaction("sun")],
    ...     np.array([0, 0]),
    ...     {"wine.transmittance": np.array([0.0, 1.5])},
    ...     {"wine.transmittance": Lengths(20)},
    ... )
    >>> [str(column) for column in found.columns]
    ['sun', 'sun*wine.transmittance**1.413', 'sun*wine.transmittance**1.585']
    >>> found.origin.tolist(), found.which.tolist(), found.share.round(3).tolist()
    ([0, 1, 1], [0, 1, 2], [1.0, 0.494, 0.506])
    """
    origin, number, share = np.arange(which.size), np.zeros(which.size, dtype=np.int64), np.ones(which.size)
    powers: list[tuple[tuple[str, float], ...]] = [()]
    for name in sorted(inside):
        # Entries that went through this glass are shared out; the others stay as they are.
        length = inside[name][origin]
        through, others = np.flatnonzero(length > 0), np.flatnonzero(length <= 0)
        if not through.size:
            continue
        if bounding:
            nodes, weights = lengths[name].below(length[through])[None], np.ones((1, through.size))
        else:
            nodes, weights = lengths[name].weights(length[through])
        distinct, place = np.unique(nodes, return_inverse=True)

        # Number the combinations of nodes, and keep those that occur.
        after = number[through] * (distinct.size + 1) + 1 + place.reshape(nodes.shape)
        number = np.concatenate([number[others] * (distinct.size + 1), after.ravel()])
        origin = np.concatenate([origin[others], np.tile(origin[through], len(nodes))])
        share = np.concatenate([share[others], (share[through] * weights).ravel()])
        kept, number = np.unique(number, return_inverse=True)
        combined = (divmod(k, distinct.size + 1) for k in kept.tolist())
        powers = [powers[old] + (((name, float(distinct[k - 1])),) if k else ()) for old, k in combined]

    # The columns that occur, of all with all powers.
    kept, number = np.unique(which[origin] * len(powers) + number, return_inverse=True)
    found = (divmod(k, len(powers)) for k in kept.tolist())
    return Spread(tuple(replace(columns[k], powers=powers[p]) for k, p in found), origin, number, share)
