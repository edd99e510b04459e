"""The waist: systems saved and loaded bit for bit, damaged files refused, and the weights of a free parameter."""

import io
import json
import pickle
import zipfile
from dataclasses import replace
from fractions import Fraction

import mpmath
import numpy as np
import pytest
from scipy import sparse

import symrt.saving as module
from symrt.interactions import Interaction
from symrt.nodes import Nodes
from symrt.saving import load_system, save_system
from symrt.system import LinearSystem
from symrt.tails import Tail

INTERACTIONS = (
    Interaction("sky", ("sea.diffuse",)),
    Interaction("sun", ("brass.mirror", "brass.mirror", "sea>ice.diffuse")),
    Interaction("sun", ("brass.specular",), (("brass.exponent", 0), ("glass.index", 2))),
)


def make_system(seed=0, **fields):
    rng = np.random.default_rng(seed)
    dense = rng.random((20, 3)) * (rng.random((20, 3)) < 0.5) * 10.0 ** rng.uniform(-300, 300, (20, 3))
    given = {
        "G": sparse.csr_array(dense),
        "interactions": INTERACTIONS,
        "height": 4,
        "width": 5,
        "white": {"sun": 1 / np.pi, "sky": 1.0, "moon": 5e-324},
        "models": {"brass": "phong(exponent)", "see": 'Σ ünï ≤ "quoted" \\'},
        "parameters": {
            "brass.exponent": Nodes("brass.exponent", 5.0, 80.0, 8),
            "glass.index": Nodes("glass.index", 1.45, 1.6, 4, "linear"),
        },
        "tail": Tail(
            sparse.csr_array(rng.random((20, 1))),
            (Interaction("sun", ("brass.mirror",) * 5),),
            (((("brass.mirror",), 0.1),),),
        ),
        "seconds": {"trace": 0.1, "collapse": 1 / 3},
    }
    return LinearSystem(**(given | fields))


def assert_same_bits(one, other):
    for a, b in ((one.G, other.G), (one.tail.bound, other.tail.bound)):
        assert a.shape == b.shape
        assert a.data.tobytes() == b.data.tobytes()
        np.testing.assert_array_equal(a.indices, b.indices)
        np.testing.assert_array_equal(a.indptr, b.indptr)
    assert (one.tail.interactions, one.tail.reflected) == (other.tail.interactions, other.tail.reflected)
    for name in ("interactions", "height", "width", "white", "models", "parameters", "seconds"):
        assert getattr(one, name) == getattr(other, name), name


def test_a_saved_system_comes_back_bit_for_bit(tmp_path):
    system = make_system()
    save_system(tmp_path / "a.npz", system)
    assert_same_bits(load_system(tmp_path / "a.npz"), system)
    assert [p.name for p in tmp_path.iterdir()] == ["a.npz"]


def test_saving_twice_gives_the_same_system_again(tmp_path):
    save_system(tmp_path / "a.npz", make_system())
    once = load_system(tmp_path / "a.npz")
    save_system(tmp_path / "a.npz", once)
    assert_same_bits(load_system(tmp_path / "a.npz"), once)


@pytest.mark.parametrize(
    "fields",
    [
        {"G": sparse.csr_array((20, 0)), "interactions": (), "tail": None},
        {"G": sparse.csr_array((0, 3)), "height": 0, "tail": None},
        {"tail": None, "models": {}, "seconds": {}},
        {"white": {}, "G": sparse.csr_array((20, 0)), "interactions": (), "tail": None},
    ],
)
def test_systems_with_nothing_in_a_part_come_back_too(tmp_path, fields):
    system = make_system(**fields)
    save_system(tmp_path / "a.npz", system)
    back = load_system(tmp_path / "a.npz")
    assert back.G.shape == system.G.shape
    assert (back.tail is None) == (system.tail is None)
    assert back.white == system.white


def parts(path):
    """The arrays of a saved system, with its header as a dictionary; its digest, which hides all else, taken out."""
    with np.load(path, allow_pickle=False) as file:
        arrays = {name: file[name] for name in file.files}
    header = json.loads(arrays.pop("header").tobytes())
    del header["digest"]
    return arrays, header


def rewrite(path, arrays, header):
    raw = json.dumps(header).encode() if not isinstance(header, bytes) else header
    np.savez(path, allow_pickle=False, header=np.frombuffer(raw, dtype=np.uint8), **arrays)


def test_a_file_cut_off_anywhere_is_refused(tmp_path):
    save_system(tmp_path / "a.npz", make_system())
    whole = (tmp_path / "a.npz").read_bytes()
    for length in {0, 1, 3, 4, *range(100, len(whole), 97), len(whole) - 1}:
        (tmp_path / "b.npz").write_bytes(whole[:length])
        with pytest.raises(ValueError, match=r"b\.npz"):
            load_system(tmp_path / "b.npz")


def test_a_flipped_bit_is_noticed(tmp_path):
    save_system(tmp_path / "a.npz", make_system())
    whole = (tmp_path / "a.npz").read_bytes()
    with zipfile.ZipFile(io.BytesIO(whole)) as archive:
        infos = {info.filename: info for info in archive.infolist()}
    # Only the bytes of an array have a checksum of their own: flip one in the middle of each.
    for info in infos.values():
        at = info.header_offset + 30 + len(info.filename) + info.compress_size // 2
        damaged = bytearray(whole)
        damaged[at] ^= 1
        (tmp_path / "b.npz").write_bytes(damaged)
        with pytest.raises(ValueError, match=r"b\.npz"):
            load_system(tmp_path / "b.npz")


def damage_header(name, value):
    return lambda arrays, header: (arrays, header | {name: value})


def damage_array(name, change):
    return lambda arrays, header: (arrays | {name: change(arrays[name])}, header)


def with_header(raw):
    return lambda arrays, _: (arrays, raw)


def without(name):
    return lambda arrays, header: ({k: v for k, v in arrays.items() if k != name}, header)


def first(value):
    def change(array):
        array = array.copy()
        array[0] = value
        return array

    return change


@pytest.mark.parametrize(
    "damage",
    [
        damage_header("format", "something else"),
        damage_header("version", 3),
        damage_header("version", "1"),
        damage_header("height", 5),
        damage_header("height", -4),
        damage_header("height", "tall"),
        damage_header("width", 10**30),
        damage_header("interactions", []),
        damage_header("interactions", [["sun", ["a.diffuse"]]] * 3),
        damage_header("interactions", [5, 6, 7]),
        damage_header("interactions", None),
        damage_header("white", {"sun": "0x1.zp0"}),
        damage_header("white", [1.0]),
        damage_header("white", {"sun": "inf"}),
        damage_header("white", {"sun": "nan"}),
        damage_header("models", 3),
        damage_header("parameters", [["a", "0x1p0", "0x1p1", 8, "cubic"]]),
        damage_header("parameters", [["brass.exponent", "0x1p0", "0x1p1", 0, "log"]]),
        damage_header("parameters", [["brass.exponent", "0x1p0", "0x1p1", 10**9, "log"]]),
        damage_header("parameters", [["brass.exponent", "-0x1p0", "0x1p1", 8, "log"]]),
        damage_header("parameters", []),
        damage_header("seconds", {"trace": "fast"}),
        damage_array("G_data", lambda a: a[:-1]),
        damage_array("G_data", lambda a: np.ones(a.size, np.float32)),
        damage_array("G_data", first(np.nan)),
        damage_array("G_data", first(np.inf)),
        damage_array("G_indices", first(3)),
        damage_array("G_indices", first(-1)),
        damage_array("G_indices", lambda a: a.astype(float)),
        damage_array("G_indptr", first(1)),
        damage_array("G_indptr", lambda a: a[:-1]),
        damage_array("G_indptr", lambda a: a[::-1].copy()),
        damage_array("G_indptr", lambda a: a.reshape(3, 7)),
        damage_array("tail_indices", first(1)),
        damage_array("tail_data", first(np.nan)),
        without("G_data"),
        without("tail_indptr"),
        with_header(b"{not json"),
        with_header(b"\xff\xfe"),
        with_header(b"[1, 2]"),
        with_header(b"[" * 100_000),
    ],
)  # fmt: skip
def test_parts_that_contradict_each_other_are_refused(tmp_path, damage):
    save_system(tmp_path / "a.npz", make_system())
    rewrite(tmp_path / "b.npz", *damage(*parts(tmp_path / "a.npz")))
    with pytest.raises(ValueError, match=r"b\.npz.*render the scene and save it again") as caught:
        load_system(tmp_path / "b.npz")
    assert "\n" not in str(caught.value)


class Bomb:
    def __reduce__(self):
        return (exec, ("raise SystemExit('a pickle was run')",))


@pytest.mark.parametrize("name", ["G_data", "header", "extra"])
def test_a_pickle_is_never_run(tmp_path, name):
    save_system(tmp_path / "a.npz", make_system())
    arrays, header = parts(tmp_path / "a.npz")
    arrays["header"] = np.frombuffer(json.dumps(header).encode(), dtype=np.uint8)
    with (tmp_path / "b.npz").open("wb") as file:
        np.savez(file, **(arrays | {name: np.array([Bomb()], dtype=object)}))
    with pytest.raises(ValueError, match=r"b\.npz"):
        load_system(tmp_path / "b.npz")
    (tmp_path / "c.npz").write_bytes(pickle.dumps(Bomb()))
    with pytest.raises(ValueError, match=r"c\.npz"):
        load_system(tmp_path / "c.npz")


def test_a_zip_bomb_is_not_unpacked(tmp_path, monkeypatch):
    monkeypatch.setattr(module, "LARGEST", 1 << 16)
    save_system(tmp_path / "a.npz", make_system())
    assert load_system(tmp_path / "a.npz").height == 4
    with zipfile.ZipFile(tmp_path / "a.npz", "a", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("zeros.npy", bytes((1 << 16) + 1))
    with pytest.raises(ValueError, match=r"zeros\.npy' claims more than"):
        load_system(tmp_path / "a.npz")


def test_a_file_that_is_not_there_or_something_else_is_refused(tmp_path):
    with pytest.raises(ValueError, match="no such file; save a system"):
        load_system(tmp_path / "a.npz")
    (tmp_path / "a.npz").write_text("hello", encoding="utf-8")
    with pytest.raises(ValueError, match="not a whole symrt system"):
        load_system(tmp_path / "a.npz")
    with (tmp_path / "a.npz").open("wb") as file:
        np.savez(file, other=np.ones(3))
    with pytest.raises(ValueError, match="not a whole symrt system"):
        load_system(tmp_path / "a.npz")


def test_a_failed_save_keeps_the_old_file_and_leaves_nothing_half_written(tmp_path, monkeypatch):
    save_system(tmp_path / "a.npz", make_system())
    before = (tmp_path / "a.npz").read_bytes()

    def full_disk(file, **_):
        file.write(b"half")
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(np, "savez_compressed", full_disk)
    with pytest.raises(OSError, match="No space left"):
        save_system(tmp_path / "a.npz", make_system())
    assert (tmp_path / "a.npz").read_bytes() == before
    assert [p.name for p in tmp_path.iterdir()] == ["a.npz"]


def test_a_matrix_of_another_shape_is_no_system():
    with pytest.raises(ValueError, match="4 × 6 pixels and 3 interactions"):
        replace(make_system(), width=6)


def exact_lagrange(nodes, value):
    """ℓ_j(x) = Π_{m≠j} (x − x_m)/(x_j − x_m), in exact rationals of the float nodes."""
    x, weights = Fraction(value), []
    for j, node in enumerate(nodes):
        weight = Fraction(1)
        for m, other in enumerate(nodes):
            if m != j:
                weight *= (x - Fraction(other)) / (Fraction(node) - Fraction(other))
        weights.append(float(weight))
    return np.array(weights)


@pytest.mark.parametrize("count", [1, 2, 3, 4, 8, 16])
def test_linear_weights_are_lagrange_s(count):
    nodes = Nodes("glass.index", 1.45, 1.6, count, "linear")
    for value in np.random.default_rng(count).uniform(1.45, 1.6, 40):
        exact = exact_lagrange(nodes.values, float(value))
        # The barycentric weights are those of the ideal nodes, the oracle uses the rounded ones: 1e-9 apart, J = 16.
        np.testing.assert_allclose(nodes.weights(float(value)), exact, rtol=0, atol=1e-9)


@pytest.mark.parametrize("count", [3, 8, 12])
def test_logarithmic_weights_are_lagrange_s_in_the_logarithm(count):
    low, high = 5.0, 80.0
    nodes = Nodes("brass.exponent", low, high, count)
    with mpmath.workdps(50):
        logs = [
            (mpmath.log(low) + mpmath.log(high)) / 2
            + (mpmath.log(high) - mpmath.log(low)) / 2 * mpmath.cos((2 * j + 1) * mpmath.pi / (2 * count))
            for j in range(count)
        ]
        for theta, log in zip(nodes.values, logs, strict=True):
            assert theta == pytest.approx(float(mpmath.exp(log)), rel=1e-14)
        for value in np.random.default_rng(count).uniform(low, high, 40):
            x = mpmath.log(float(value))
            for j, weight in enumerate(nodes.weights(float(value))):
                exact = mpmath.mpf(1)
                for m in range(count):
                    if m != j:
                        exact *= (x - logs[m]) / (logs[j] - logs[m])
                assert abs(weight - exact) < 1e-12


@pytest.mark.parametrize("scale", ["linear", "log"])
def test_weights_sum_to_one_and_single_out_a_node(scale):
    nodes = Nodes("brass.exponent", 5.0, 80.0, 8, scale)
    for value in (5.0, 7.3, 33.3, 80.0):
        assert nodes.weights(value).sum() == pytest.approx(1.0, abs=1e-14)
    for j, value in enumerate(nodes.values):
        np.testing.assert_array_equal(nodes.weights(value), np.eye(8)[j])


# Measured when the nodes were chosen: s in [5, 80]: J = 8 2e-4, J = 12 3e-6; [1, 200]: J = 16 5e-5.
@pytest.mark.parametrize(("low", "high", "count", "error"), [(5, 80, 8, 2e-4), (5, 80, 12, 3e-6), (1, 200, 16, 5e-5)])
def test_powers_of_a_cosine_are_interpolated_to_the_stated_error(low, high, count, error):
    nodes = Nodes("brass.exponent", float(low), float(high), count)
    cosines = np.linspace(0, 1, 2001)
    stored = np.stack([cosines**s for s in nodes.values])
    worst = max(
        np.abs(nodes.weights(float(s)) @ stored - cosines**s).max()
        for s in np.geomspace(low, high, 200).clip(low, high)
    )
    # The errors are stated to one digit.
    assert float(f"{worst:.0e}") == error


@pytest.mark.parametrize("value", [4.999, 80.001, -1.0, float("nan"), float("inf")])
def test_nothing_is_extrapolated_beyond_the_nodes(value):
    with pytest.raises(ValueError, match=r"the system was collapsed for \[5\.0, 80\.0\]"):
        Nodes("brass.exponent", 5.0, 80.0, 8).weights(value)


def test_an_interaction_says_its_degrees():
    interaction = Interaction("sun", ("a.diffuse", "b.mirror", "b.mirror"))
    assert interaction.degree == 3
    assert interaction.symbols == ("sun", "a.diffuse", "b.mirror", "b.mirror")
    assert str(interaction) == "sun*a.diffuse*b.mirror**2"


def test_a_system_names_its_symbols():
    system = make_system()
    assert system.lights == ("sun", "sky", "moon")
    assert system.reflectances == ("brass.mirror", "brass.specular", "sea.diffuse", "sea>ice.diffuse")
    assert system.symbols[:2] == ("sun", "sky")
    np.testing.assert_array_equal(system.object_pixels, (system.G.toarray() != 0).any(axis=1))


def test_a_pixel_of_stored_zeros_is_as_dark_as_an_empty_one():
    stored = sparse.csr_array((np.array([0.0, 0.5, 0.0, 0.0]), np.array([0, 0, 0, 1]), np.array([0, 1, 2, 4, 4])))
    columns = (Interaction("a", ()), Interaction("b", ()))
    assert LinearSystem(stored, columns, 1, 4, {"a": 1.0}).object_pixels.tolist() == [False, True, False, False]
