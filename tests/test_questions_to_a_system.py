"""What a system answers for itself, held against loops over its dense matrix."""

import itertools
import json
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import sparse

from symrt.feedback import split
from symrt.interactions import Interaction
from symrt.nodes import Nodes
from symrt.saving import load_system, save_system
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


EXPONENT, INDEX = Nodes("brass.exponent", 5.0, 80.0, 3), Nodes("glass.index", 1.25, 1.75, 2, "linear")


def at_nodes(matrix):
    """Columns at the nodes of two parameters, of one, and at none: the glass at both, the brass at one, and the sea."""
    both = [(("brass.exponent", j), ("glass.index", k)) for j in range(3) for k in range(2)]
    columns = [Interaction("sun", ("glass.mirror",), nodes) for nodes in both]
    columns += [Interaction("sky", ("brass.specular",), (("brass.exponent", j),)) for j in range(3)]
    columns += [Interaction("sun", ("sea.diffuse",))]
    parameters = {"brass.exponent": EXPONENT, "glass.index": INDEX}
    lights = {"sun": 1.0, "sky": 1.0}
    order = sorted(range(len(columns)), key=columns.__getitem__)
    named = tuple(columns[k] for k in order)
    return LinearSystem(sparse.csr_array(matrix[:, order]), named, 1, len(matrix), lights, {}, parameters)


@given(seeds)
def test_a_column_is_signed_where_a_number_in_it_is_negative(seed):
    system = some_system(seed)
    negative = {i for i, column in zip(system.interactions, system.G.toarray().T, strict=True) if min(column) < 0}
    assert dict(system.signed) == dict.fromkeys(negative, "a negative term")


def test_columns_that_are_free_may_turn_negative():
    system = at_nodes(np.full((1, 10), 0.5))
    expected = {("glass", "interpolation in brass.exponent, glass.index"), ("brass", "interpolation in brass.exponent")}
    assert {(i.met[0].split(".")[0], why) for i, why in system.signed.items()} == expected


@pytest.mark.parametrize("index", [1.25, 1.5, 1.75])
@pytest.mark.parametrize("exponent", [5.0, 20.0, 30.0, 80.0])
def test_a_settled_column_is_signed_where_its_weights_made_it_negative(exponent, index):
    # Lagrange's weights, in the logarithm of the exponent and in the index, in exact numbers from the nodes.
    matrix = np.random.default_rng(3).integers(1, 9, (6, 10)) / 8
    by_hand = []
    for nodes, place in ((EXPONENT, np.log), (INDEX, float)):
        value = Fraction(float(place(exponent if nodes is EXPONENT else index)))
        points = [Fraction(float(place(v))) for v in nodes.values]
        by_hand.append([float(_lagrange(points, j, value)) for j in range(len(points))])
    glass = sum(matrix[:, 2 * j + k] * a * b for j, a in enumerate(by_hand[0]) for k, b in enumerate(by_hand[1]))
    brass = sum(matrix[:, 6 + j] * a for j, a in enumerate(by_hand[0]))
    settled = at_nodes(matrix).at({"brass.exponent": exponent, "glass.index": index})
    assert {i.met[0] for i in settled.signed} == {
        name for name, column in (("glass.mirror", glass), ("brass.specular", brass)) if column.min() < -1e-15
    }
    # One after the other is the same record.
    for order in (("brass.exponent", "glass.index"), ("glass.index", "brass.exponent")):
        step = at_nodes(matrix)
        for name in order:
            step = step.at({name: exponent if name == "brass.exponent" else index})
        assert step.interpolated == settled.interpolated
        assert step.signed == settled.signed


def _lagrange(points, j, value):
    others = [p for k, p in enumerate(points) if k != j]
    return np.prod([(value - p) / (points[j] - p) for p in others])


def test_the_reason_is_the_weights_only_where_nothing_was_negative_before():
    matrix = np.zeros((2, 10))
    matrix[0, :9] = [0, 0, 1, 1, 0, 0, 0, 1, 0]
    beyond = at_nodes(-matrix).at({"brass.exponent": 30.0, "glass.index": 1.5})
    assert set(beyond.signed.values()) == {"a negative term"}
    assert beyond.interpolated == {}


def interpolated():
    matrix = np.zeros((2, 10))
    matrix[:, 6] = matrix[:, 9] = 1.0  # the brass, at the largest exponent's node alone: its weight is negative at 10
    system = at_nodes(matrix).at({"brass.exponent": 10.0, "glass.index": 1.5})
    assert {str(i): why for i, why in system.signed.items()} == {
        "sky*brass.specular": "interpolation in brass.exponent"
    }
    return system


def test_the_record_goes_with_rows_with_regions_and_through_a_file(tmp_path):
    system = interpolated()
    assert system.rows(np.array([1])).signed == system.signed
    parted = split(system, "brass", np.array([[True, False]]), "gold")
    assert {str(i) for i in parted.signed} == {"sky*brass.specular", "sky*gold.specular"}
    assert set(parted.signed.values()) == {"interpolation in brass.exponent"}
    save_system(tmp_path / "a.npz", system)
    assert load_system(tmp_path / "a.npz").interpolated == system.interpolated
    assert load_system(tmp_path / "a.npz").signed == system.signed


def test_a_file_of_a_system_without_the_record_is_as_it_was(tmp_path):
    save_system(tmp_path / "a.npz", LinearSystem.of("0.5*sun - 0.1*sky"))
    with np.load(tmp_path / "a.npz", allow_pickle=False) as file:
        assert "interpolated" not in json.loads(file["header"].tobytes())
    assert load_system(tmp_path / "a.npz").signed == LinearSystem.of("0.5*sun - 0.1*sky").signed


@pytest.mark.parametrize(
    "record",
    [
        *(
            [[9, ["brass.exponent"]]],
            [[-1, ["brass.exponent"]]],
            [[0.0, ["brass.exponent"]]],
            [["0", ["brass.exponent"]]],
        ),
        *([[0, []]], [[0, ["a b"]]], [[0, ["brass"]]], [[0, "brass.exponent"]], [[0, ["brass.exponent"] * 2]]),
        *([[0, ["a.b"]], [0, ["a.c"]]], [[0, ["brass.exponent\n"]]], {"0": ["a.b"]}, None, 1, [[True, ["a.b"]]]),
    ],
)
def test_a_record_that_was_tampered_with_is_refused(tmp_path, record):
    save_system(tmp_path / "a.npz", interpolated())
    with np.load(tmp_path / "a.npz", allow_pickle=False) as file:
        arrays = {name: file[name] for name in file.files}
    header = json.loads(arrays.pop("header").tobytes()) | {"interpolated": record}
    del header["digest"]
    text = np.frombuffer(json.dumps(header).encode(), dtype=np.uint8)
    np.savez(tmp_path / "b.npz", allow_pickle=False, header=text, **arrays)
    with pytest.raises(ValueError, match=r"b\.npz: not a whole symrt system") as caught:
        load_system(tmp_path / "b.npz")
    assert str(caught.value).isprintable()
