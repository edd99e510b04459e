"""Gather coefficients by pixel and interaction, and assemble them into the sparse matrix G (step 2)."""

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float, Int
from scipy import sparse

from symrt import fast
from symrt.interactions import Interaction


@dataclass(frozen=True, eq=False)
class Entries:
    """Coefficients on their way into G: values, each with its pixel and the number of its interaction's column."""

    columns: dict[Interaction, int] = field(default_factory=dict)
    pixel: list[np.ndarray] = field(default_factory=list)
    column: list[np.ndarray] = field(default_factory=list)
    value: list[np.ndarray] = field(default_factory=list)

    def add(
        self,
        interactions: Iterable[Interaction],
        which: Int[np.ndarray, " entry"] | None,
        pixel: Int[np.ndarray, " entry"],
        value: Float[np.ndarray, " entry"],
    ) -> None:
        """Add values, each to the interaction that `which` numbers; zeros are left out."""
        present = np.count_nonzero(value)
        if not present:
            return
        # The number of each interaction's column, then pixels, columns and values of what is not zero.
        number = np.array([self.columns.setdefault(i, len(self.columns)) for i in interactions], dtype=np.int32)
        which = np.zeros(value.size, np.int64) if which is None else which
        kernels = fast.kernels("symrt.linear.fast.gathering", value.size)
        if kernels and pixel.dtype == which.dtype == np.int64 and value.dtype == np.float64:
            (pixels, columns), values = np.empty((2, present), np.int32), np.empty(present)
            kernels.keep(pixel, which, number, value, pixels, columns, values)
        else:
            there = np.flatnonzero(value)
            pixels, columns, values = pixel[there].astype(np.int32), number[which[there]], value[there]
        self.pixel.append(pixels)
        self.column.append(columns)
        self.value.append(values)


def assemble(entries: Entries, pixels: int) -> tuple[sparse.csr_array, tuple[Interaction, ...]]:
    """The sparse matrix of all entries, its columns in canonical order, those that stayed empty left out.

    Examples
    --------
    >>> entries = Entries()
    >>> entries.add([Interaction("sun", ("sea.diffuse",))], None, np.array([1, 1]), np.array([0.25, 0.5]))
    >>> assemble(entries, 2)[0].toarray().tolist()
    [[0.0], [0.75]]
    """
    # Renumber columns from the order in which they were found to the canonical one.
    order = sorted(entries.columns)
    rank = np.empty(len(order), dtype=np.int32)
    rank[[entries.columns[interaction] for interaction in order]] = np.arange(len(order), dtype=np.int32)

    # Entries of the same pixel and column are added up.
    pixel, column, value = (
        np.concatenate(parts) if parts else np.empty(0, dtype)
        for parts, dtype in ((entries.pixel, np.int32), (entries.column, np.int32), (entries.value, np.float64))
    )
    matrix = sparse.coo_array((value, (pixel, rank[column])), shape=(pixels, len(order))).tocsr()
    matrix.sort_indices()
    return without_empty_columns(matrix, tuple(order))


def without_empty_columns(
    matrix: sparse.csr_array, interactions: tuple[Interaction, ...]
) -> tuple[sparse.csr_array, tuple[Interaction, ...]]:
    """Leave out the columns that no pixel uses."""
    used = np.bincount(matrix.indices, minlength=len(interactions)) > 0
    if used.all():
        return matrix, interactions

    renumbered = (np.cumsum(used) - 1).astype(matrix.indices.dtype)
    kept = sparse.csr_array(
        (matrix.data, renumbered[matrix.indices], matrix.indptr), shape=(matrix.shape[0], used.sum())
    )
    return kept, tuple(i for i, present in zip(interactions, used, strict=True) if present)
