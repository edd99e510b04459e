"""Windows of wavelengths as symbols of a system: they sum to 1, are written and read, saved, shaded and refused."""

import math
from dataclasses import replace

import numpy as np
import pytest
from feedback import synthetic
from hypothesis import given
from hypothesis import strategies as st
from scipy import sparse

import symrt as rt
from symrt.interactions import Interaction
from symrt.linear import coefficient_matrix
from symrt.spectra.shading import gamma
from symrt.windows import SpectralWindow, even_nodes, windows_of

NODES = [380.0, 438.5, 512.25, 600.0, 730.0]
WINDOWS = windows_of(NODES)
BANDS = rt.wavelengths(380, 730, 10)
PALETTE = rt.Palette(BANDS, {"sun": np.linspace(2, 1, 36), "sky": 0.5, "wall.diffuse": np.linspace(0.1, 0.9, 36)})
TEXT = " + ".join(f"{k + 1}*sun*wall.diffuse*{window}" for k, window in enumerate(WINDOWS))


@given(st.lists(st.floats(101, 2999), min_size=2, max_size=40, unique=True))
def test_windows_sum_to_one_wherever_they_are_known(nodes):
    nodes = sorted(nodes)
    nm = np.unique(np.concatenate([nodes, np.linspace(nodes[0], nodes[-1], 301)]))
    weights = np.array([window.weights(nm) for window in windows_of(nodes)])
    assert weights.min() >= 0
    assert np.abs(weights.sum(axis=0) - 1).max() <= 4e-16
    at_nodes = np.array([window.weights(np.array(nodes)) for window in windows_of(nodes)])
    np.testing.assert_array_equal(at_nodes, np.eye(len(nodes)))


@given(st.lists(st.floats(101, 2999), min_size=2, max_size=6, unique=True))
def test_a_window_is_read_as_it_is_written(nodes):
    for window in windows_of(sorted(nodes)):
        column = Interaction("sun", ("sea.diffuse", "sea.mirror", "sea.mirror"), window=window)
        system = rt.LinearSystem.of(f"0.5*{column}")
        assert system.interactions == (column,)
        assert SpectralWindow.of(str(window).replace("…", "...")) == window


def test_even_nodes_are_whole_and_reach_both_ends():
    for count in range(2, 65):
        nodes = even_nodes(count, 380, 730)
        assert (nodes[0], nodes[-1], len(set(nodes))) == (380.0, 730.0, count)
        assert all(nm == int(nm) for nm in nodes)


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("sun*[400 … 500 nm]", "write a sum of terms"),
        ("sun*[… 500 … nm]", r"\[… 500 … nm\]': write a window of wavelengths as \[400 … 500 … 600 nm\]"),
        ("sun*[600 … 500 … 700 nm]", "the wavelengths of a window increase"),
        ("sun*[… 400 … 500 nm]*[400 … 500 … nm]", "2 windows of wavelengths in a term"),
        ("[… 400 … 500 nm]", "0 lights in a term"),
    ],
)
def test_what_is_no_window_is_refused(text, fault):
    with pytest.raises(ValueError, match=fault):
        rt.LinearSystem.of(text)


def test_a_window_is_of_no_degree_and_scaled_by_nothing():
    system = rt.LinearSystem.of(TEXT + " + sky*wall.diffuse")
    assert {i.degree for i in system.interactions} == {1}
    assert system.symbols == ("sun", "sky", "wall.diffuse")
    blocks = system.blocks({"sun"}, {"wall.diffuse"})
    assert blocks.degrees.tolist() == [[0, 0], [0, 1], [1, 1]]


def test_gamma_is_the_product_within_the_window():
    system = rt.LinearSystem.of(TEXT + " + 0.25*sky")
    nm = np.array(BANDS.centres)
    by_hand = np.interp(nm, NODES, np.arange(1.0, 6.0)) * PALETTE["sun"] * PALETTE["wall.diffuse"] + 0.25 * 0.5
    np.testing.assert_allclose(rt.shade(system, PALETTE).values[0, 0], by_hand, rtol=1e-14)
    whole = gamma([Interaction("sun", ("wall.diffuse",))], PALETTE)[0]
    parts = gamma([Interaction("sun", ("wall.diffuse",), window=window) for window in WINDOWS], PALETTE)
    np.testing.assert_allclose(parts.sum(axis=0), whole, rtol=1e-15)


def test_formula_code_and_pixel_are_one():
    system = rt.LinearSystem.of(TEXT + " + 0.25*sky")
    formula, pixel = rt.formula(system, 0, 0), rt.shade(system, PALETTE).values[0, 0]
    assert formula.text(terms=1).startswith("5*sun*wall.diffuse*[600 … 730 … nm] + …")
    assert r"3\,\mathrm{sun}\,\mathrm{wall}_{\mathrm{diffuse}}\,\left[438.5 \ldots 512.25 \ldots 600\,\mathrm{nm}" in (
        formula.latex()
    )
    assert formula.symbols == ("sky", "sun", "wall.diffuse")
    names = {}
    exec(formula.code(), names)
    spectra = {name: PALETTE[name] for name in formula.symbols}
    together = formula.evaluate(spectra, nm=np.array(BANDS.centres))
    for k, nm in enumerate(BANDS.centres):
        band = {name: float(values[k]) for name, values in spectra.items()}
        single = formula.evaluate(band, nm=nm)
        coded = names["pixel"](nm=nm, **{name.replace(".", "_"): value for name, value in band.items()})
        for value in (single, coded, together[k]):
            assert abs(value - pixel[k]) <= 4 * math.ulp(pixel[k])
    with pytest.raises(ValueError, match=r"the pixel depends on the wavelength: give nm="):
        formula.evaluate(spectra)
    # The teaching path, SymPy all the way, finds the same columns.
    assert coefficient_matrix([formula], 1, 1, system.white).interactions == system.interactions


def test_systems_with_windows_are_saved_and_those_without_stay_as_they_were(tmp_path):
    system = rt.LinearSystem.of(TEXT + " + 0.25*sky")
    rt.save_system(tmp_path / "s.npz", system)
    again = rt.load_system(tmp_path / "s.npz")
    assert again.interactions == system.interactions
    np.testing.assert_array_equal(again.G.toarray(), system.G.toarray())
    for bad in (
        SpectralWindow(500, 400, 600),
        SpectralWindow(400, 400, 400),
        SpectralWindow(-1, 400, 500),
        SpectralWindow(400, math.nan, 500),
    ):
        with pytest.raises(ValueError, match=r"not saved: a window is \[.*\]: the wavelengths of a window"):
            rt.save_system(
                tmp_path / "bad.npz",
                rt.LinearSystem(system.G[:, [0]], (Interaction("sky", window=bad),), 1, 1, {"sky": 1.0}),
            )


def test_a_palette_without_wavelengths_or_with_others_is_refused():
    system = rt.LinearSystem.of(TEXT)
    for ask in (rt.shade, rt.preview):
        with pytest.raises(ValueError, match=r"the palette's bands are RGB, and glass bends wavelengths apart here: "):
            ask(system, rt.Palette(rt.RGB, {"sun": 1.0, "wall.diffuse": 0.5}))
    for bands, told in ((rt.wavelengths(370, 730, 10), "from 380"), (rt.wavelengths(400, 780, 10), "to 730")):
        with pytest.raises(ValueError, match=rf"\d nm: glass was traced {told} nm only; choose narrower bands, or"):
            rt.shade(system, rt.Palette(bands, {"sun": 1.0, "wall.diffuse": 0.5}))


def twins():
    """A system some of whose columns are in windows, and the same with a fixed reflectance in the place of each."""
    whole, colours, random = synthetic.system(8, 8), synthetic.palette(), np.random.default_rng(5)
    columns, twin, parts = [], [], []
    for k, column in enumerate(whole.interactions):
        own = whole.G[:, [k]].toarray()
        for j, window in enumerate(WINDOWS if k % 3 else ()):
            columns.append(replace(column, window=window))
            twin.append(Interaction(column.light, (*column.met, f"w{j}.mirror")))
            parts.append(own * random.uniform(0, 1, own.shape))
        if not k % 3:
            columns.append(column)
            twin.append(column)
            parts.append(own)
    matrix = np.concatenate(parts, axis=1)
    spectra = {f"w{j}.mirror": window.weights(np.array(BANDS.centres)) for j, window in enumerate(WINDOWS)}
    systems = []
    for names in (columns, twin):
        order = sorted(range(len(names)), key=names.__getitem__)
        interactions = tuple(names[k] for k in order)
        systems.append(rt.LinearSystem(sparse.csr_array(matrix[:, order]), interactions, 8, 8, dict(whole.white)))
    return systems[0], systems[1], colours, colours.add(spectra)


def test_step_five_treats_a_window_as_a_fixed_factor():
    system, twin, colours, with_hats = twins()
    gamut = rt.device_gamut(rt.load_device("dye3-endura-premier"), "envelope")
    np.testing.assert_allclose(rt.shade(system, colours).values, rt.shade(twin, with_hats).values, rtol=1e-13)
    for parameter in (
        rt.Scale("key"),
        rt.Scale("brass"),
        rt.Blend("deep", "ice"),
        rt.Blend("deep", "ice", mixing="kubelka-munk"),
    ):
        one, other = (rt.feasible(s, p, gamut, parameter) for s, p in ((system, colours), (twin, with_hats)))
        np.testing.assert_allclose((one.low, one.high), (other.low, other.high), rtol=1e-9)
        assert one.verdict == other.verdict
    scales = [rt.Scale("key"), rt.Scale("deep")]
    boxes = [rt.safe_box(s, p, gamut, scales).box for s, p in ((system, colours), (twin, with_hats))]
    fits = [rt.fit(s, p, gamut, scales).values for s, p in ((system, colours), (twin, with_hats))]
    for one, other in (boxes, fits):
        assert one.keys() == other.keys()
        for name in one:
            np.testing.assert_allclose(one[name], other[name], rtol=1e-6)
