"""What a system answers for itself, held against loops over its dense matrix."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import sparse

from symrt.interactions import Interaction
from symrt.system import LinearSystem

LIGHTS, REFLECTANCES = ("sky", "sun"), ("ice.diffuse", "sea.diffuse", "sea.mirror", "sea>ice.diffuse")
COLUMNS = sorted(
    Interaction(light, tuple(sorted(met)))
    for light in LIGHTS
    for n in range(3)
    for met in itertools.combinations_with_replacement(REFLECTANCES, n)
)
groups = st.frozensets(st.sampled_from([*LIGHTS, *REFLECTANCES, "moon"]))


seeds = st.integers(0, 10**6)


def some_system(seed):
    """Few columns, in any pixels, with stored zeros and negative numbers among the coefficients."""
    random = np.random.default_rng(seed)
    columns = [COLUMNS[k] for k in np.flatnonzero(random.random(len(COLUMNS)) < 0.2)]
    pixels = int(random.integers(1, 6))
    numbers = [None, None, 0.0, 0.25, 1.5, -0.5]
    cells = [numbers[k] for k in random.integers(0, 6, pixels * len(columns))]
    kept = [(k // len(columns), k % len(columns), v) for k, v in enumerate(cells) if v is not None]
    rows, places, values = (np.array(part) for part in zip(*kept, strict=True)) if kept else ([], [], [])
    shape = (pixels, len(columns))
    stored = sparse.coo_array((values, (rows, places)), shape=shape, dtype=float).tocsr()
    return LinearSystem(stored, tuple(columns), 1, pixels, dict.fromkeys(LIGHTS, 1.0))


@given(seeds, st.lists(groups, max_size=3))
def test_blocks_are_the_columns_of_the_same_degrees(seed, scales):
    system = some_system(seed)
    blocks = system.blocks(*scales)
    expected = [tuple(sum(s in scale for s in (i.light, *i.met)) for scale in scales) for i in system.interactions]
    assert [tuple(row) for row in blocks.degrees[blocks.of].tolist()] == expected
    assert [tuple(row) for row in blocks.degrees.tolist()] == sorted({(0,) * len(scales), *expected})


@given(seeds, st.data())
def test_the_pixels_of_some_columns_are_those_with_a_coefficient_in_one(seed, data):
    system = some_system(seed)
    size = len(system.interactions)
    columns = np.array(data.draw(st.lists(st.booleans(), min_size=size, max_size=size)), dtype=bool)
    dense = system.G.toarray()
    expected = [any(dense[n, k] != 0 for k in range(size) if columns[k]) for n in range(len(dense))]
    assert system.pixels_of(columns).tolist() == expected
    assert system.object_pixels.tolist() == (dense != 0).any(axis=1).tolist()


@given(seeds)
def test_the_terms_of_a_pixel_are_its_row(seed):
    system = some_system(seed)
    dense = system.G.toarray()
    for n, row in enumerate(dense):
        assert dict(system.terms(n)) == {i: g for i, g in zip(system.interactions, row.tolist(), strict=True) if g}
        assert system.term_counts[n] >= len(system.terms(n))


@given(seeds, st.sampled_from([np.float32, np.float64]), st.data())
def test_pixels_are_the_matrix_times_the_spectra(seed, dtype, data):
    system = some_system(seed)
    # Whole numbers of eighths: sums are exact in both precisions.
    values = np.random.default_rng(data.draw(st.integers(0, 9))).integers(0, 9, (len(system.interactions), 3)) / 8
    chosen = np.array(data.draw(st.lists(st.integers(0, system.width - 1), max_size=4)), dtype=int)
    expected = system.G.toarray() @ values
    for pixels in (slice(None), slice(1, 3), chosen):
        found = system.times(values.astype(dtype), pixels)
        assert found.dtype == dtype
        assert found.tolist() == expected[pixels].tolist()
    assert system.times(values[:, 0].astype(dtype)).tolist() == expected[:, 0].tolist()


def test_a_pixel_that_is_not_there_has_no_terms():
    with pytest.raises(IndexError):
        LinearSystem.of("0.5*sun").terms(1)
