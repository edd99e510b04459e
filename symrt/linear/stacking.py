"""Put systems of some rows of a picture together, each written into its place as it comes (steps 1 and 2)."""

from collections.abc import Iterable
from dataclasses import replace
from itertools import zip_longest

import numpy as np
from scipy import sparse

from symrt.counts import Counts
from symrt.estimates import Estimate
from symrt.interactions import Interaction
from symrt.system import LinearSystem
from symrt.tails import Tail


def stacked(systems: Iterable[LinearSystem], width: int, height: int) -> LinearSystem:
    """One system of many that cover a picture in the order of its pixels; each may be forgotten once it is stacked.

    Examples
    --------
    >>> left, right = LinearSystem.of("0.5*sun*sea.diffuse"), LinearSystem.of("0.25*sun*ice.diffuse")
    >>> stacked([left, right], 2, 1).G.toarray().tolist()
    [[0.0, 0.5], [0.25, 0.0]]
    """
    # Rows are added as they come, and so is what is told beside them.
    matrix, bound = Stack(width * height), Stack(width * height)
    first = None
    cut = Tail(sparse.csr_array((0, 0)))
    spent: dict[str, float] = {}
    errors: dict[str, Estimate] = {}
    counts = Counts()
    noise: dict[str, Estimate] = {}
    gathered: dict[Interaction, list[float]] = {}
    for system in systems:
        if first is None:
            # What all have in common; of the first one's matrices nothing is kept.
            cut = replace(system.tail or cut, bound=cut.bound, interactions=())
            nothing = sparse.csr_array((0, len(system.interactions)))
            first = replace(system, G=nothing, height=0, width=0, tail=None)
        matrix.add(system.G, system.interactions)
        tail = system.tail or Tail(sparse.csr_array((system.height * system.width, 0)))
        bound.add(tail.bound, tail.interactions)
        for column, sums in tail.gathered.items():
            before = gathered.get(column, [])
            gathered[column] = [a + b for a, b in zip_longest(before, sums, fillvalue=0.0)]
        for step, seconds in system.seconds.items():
            spent[step] = spent.get(step, 0.0) + seconds
        counts = counts.joined(system.counts)
        for whole, part in ((errors, system.errors), (noise, system.noise)):
            for light, error in part.items():
                whole[light] = whole[light].joined(error) if light in whole else error
    if first is None:
        raise ValueError("no system was given: give those of all the picture's rows")
    G, interactions = matrix.matrix()  # noqa: N806 -- the equation's own name
    unseen, missing = bound.matrix()
    return replace(
        first,
        G=G,
        interactions=interactions,
        width=width,
        height=height,
        tail=replace(
            cut,
            bound=unseen,
            interactions=missing,
            gathered={column: tuple(sums) for column, sums in sorted(gathered.items())},
        ),
        seconds=spent,
        errors=dict(sorted(errors.items())),
        counts=counts,
        noise=dict(sorted(noise.items())),
    )


class Stack:
    """Rows of several matrices under each other, over the union of their columns, each written into its place.

    Nothing is held twice: what is filled seldom moves, and the numbers of columns are made those of the union where
    they stand.

    Parameters
    ----------
    rows
        Number of rows that there will be.
    """

    def __init__(self, rows: int) -> None:
        self.starts = np.zeros(rows + 1, dtype=np.int64)
        self.data = np.empty(0)
        self.indices = np.empty(0, dtype=np.int32)
        self.filled: list[tuple[int, tuple[Interaction, ...]]] = []
        self.row = 0

    def add(self, matrix: sparse.csr_array, interactions: tuple[Interaction, ...]) -> None:
        """Append the rows of a matrix; its columns stand in canonical order."""
        start = int(self.starts[self.row])
        stop = start + matrix.nnz
        if stop > self.data.size:
            self._make_room(stop, self.row + matrix.shape[0])
        self.data[start:stop] = matrix.data
        self.indices[start:stop] = matrix.indices
        after = self.row + matrix.shape[0]
        self.starts[self.row + 1 : after + 1] = matrix.indptr[1:] + np.int64(start)
        self.row = after
        self.filled.append((stop, interactions))

    def _make_room(self, filled: int, rows: int) -> None:
        """Make room for as many a row as there are in the first rows, and a little more, so that arrays seldom move.

        What stays empty was never written to, costs no memory, and is given back at the end.
        """
        room = min(filled * (self.starts.size - 1) // rows, 64 * filled)
        before = int(self.starts[self.row])
        for name in ("data", "indices"):
            array = getattr(self, name)
            larger = np.empty(room + room // 8, array.dtype)
            larger[:before] = array[:before]
            setattr(self, name, larger)

    def matrix(self) -> tuple[sparse.csr_array, tuple[Interaction, ...]]:
        """The matrix of all rows, and its columns in canonical order; it takes the arrays over, and ends the stack.

        Examples
        --------
        >>> sun, sky = Interaction("sun"), Interaction("sky")
        >>> stack = Stack(2)
        >>> stack.add(sparse.csr_array([[0.5]]), (sun,))
        >>> stack.add(sparse.csr_array([[0.1, 0.25]]), (sky, sun))
        >>> stack.matrix()[0].toarray().tolist()
        [[0.0, 0.5], [0.1, 0.25]]
        """
        if self.row + 1 != self.starts.size:
            raise ValueError(f"{self.row} rows are there, of {self.starts.size - 1}: add the others first")

        # Numbers of the union's columns in place of each matrix's own; both ascend, so that rows stay sorted.
        columns = sorted({interaction for _, interactions in self.filled for interaction in interactions})
        place = {interaction: k for k, interaction in enumerate(columns)}
        start = 0
        for stop, interactions in self.filled:
            if stop > start:
                number = np.array([place[i] for i in interactions], dtype=np.int32)
                self.indices[start:stop] = number[self.indices[start:stop]]
            start = stop
        for array in (self.data, self.indices):
            array.resize(start, refcheck=False)
        shape = (self.row, len(columns))
        return sparse.csr_array((self.data, self.indices, self.starts), shape=shape), tuple(columns)
