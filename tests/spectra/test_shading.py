"""Laws of shading, held against plain loops over pixels, exact rationals and a bare sparse product."""

from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np
import pytest
from scipy import sparse

from symrt.interactions import Interaction
from symrt.nodes import Nodes
from symrt.spectra.bands import RGB, Bands, wavelengths
from symrt.spectra.certificate import tail_bound
from symrt.spectra.palette import Palette
from symrt.spectra.products import gamma
from symrt.spectra.shading import preview, shade
from symrt.spectra.viewing import to_rgb
from symrt.system import LinearSystem
from symrt.tails import Tail

BANDS = wavelengths(380, 730, 10)
INTERACTIONS = (
    Interaction("sky", ("sea.diffuse",)),
    Interaction("sun", ()),
    Interaction("sun", ("brass.mirror", "brass.mirror", "sea.diffuse")),
    Interaction("sun", ("sea.diffuse",)),
)
SYMBOLS = ("sun", "sky", "sea.diffuse", "brass.mirror")


def make_system(height=4, width=5, interactions=INTERACTIONS, seed=0, **fields):
    rng = np.random.default_rng(seed)
    dense = rng.random((height * width, len(interactions))) * (rng.random((height * width, len(interactions))) < 0.6)
    return LinearSystem(sparse.csr_array(dense), interactions, height, width, {"sun": 0.3, "sky": 1.0}, **fields)


def make_palette(bands=BANDS, seed=1):
    rng = np.random.default_rng(seed)
    return Palette(bands, {name: rng.random(len(bands)) for name in SYMBOLS})


def by_loops(system, palette):
    """Equation (2) of the paper, written out."""
    dense = system.G.toarray()
    values = np.zeros((system.height, system.width, len(palette.bands)))
    for y in range(system.height):
        for x in range(system.width):
            for coefficient, interaction in zip(dense[y * system.width + x], system.interactions, strict=True):
                term = coefficient * palette[interaction.light]
                for name in interaction.met:
                    term = term * palette[name]
                values[y, x] += term
    return values


@pytest.mark.parametrize("bands", [BANDS, RGB, Bands((550.0,))])
def test_shading_is_equation_2_in_any_number_of_bands(bands):
    system, palette = make_system(), make_palette(bands)
    image = shade(system, palette)
    np.testing.assert_allclose(image.values, by_loops(system, palette), rtol=1e-12, atol=0)
    assert image.bands == bands
    assert image.seconds > 0


@pytest.mark.parametrize("draws", [2_000, pytest.param(100_000, marks=pytest.mark.exhaustive)])
def test_a_product_of_spectra_is_exact_to_an_ulp_a_factor(draws):
    rng = np.random.default_rng(2)
    names = ["a.diffuse", "b.mirror", "c.specular"]
    palette = Palette(Bands((550.0,)), {"sun": 3.7, **{name: rng.random(1) for name in names}})
    exact = {name: Fraction(float(palette[name][0])) for name in palette}
    interactions = [
        Interaction("sun", tuple(rng.choice(names, size=rng.integers(0, 9)).tolist())) for _ in range(draws)
    ]
    for interaction, value in zip(interactions, gamma(interactions, palette)[:, 0], strict=True):
        truth = exact["sun"]
        for name in interaction.met:
            truth *= exact[name]
        assert abs(Fraction(float(value)) - truth) <= interaction.degree * Fraction(float(np.spacing(value)))


def test_no_interactions_is_a_black_image():
    system = LinearSystem(sparse.csr_array((6, 0)), (), 2, 3, {"sun": 1 / np.pi})
    assert not shade(system, Palette(RGB, {"sun": 1.0})).values.any()
    assert not preview(system, Palette(RGB, {"sun": 1.0})).any()


@pytest.mark.parametrize("light", ["sun", "sky"])
def test_shading_is_linear_in_every_light(light):
    system, palette = make_system(), make_palette()
    a, b = np.random.default_rng(3).random((2, 36))
    images = [shade(system, palette.replace({light: s})).values for s in (a, b, 2 * a + 3 * b, np.zeros(36))]
    np.testing.assert_allclose(images[2] + 4 * images[3], 2 * images[0] + 3 * images[1], rtol=1e-12, atol=1e-15)


def test_shading_is_homogeneous_of_the_degree_of_each_interaction():
    system, palette = make_system(interactions=INTERACTIONS[2:3]), make_palette()
    half = palette.replace({"brass.mirror": palette["brass.mirror"] / 2})
    np.testing.assert_array_equal(shade(system, half).values, shade(system, palette).values / 4)


def test_three_bands_are_three_columns_of_thirty_six():
    system, palette = make_system(), make_palette()
    few = shade(system, palette.on(Bands((450.0, 550.0, 600.0)))).values
    np.testing.assert_array_equal(few, shade(system, palette).values[:, :, [7, 17, 22]])


def test_coordinates_are_the_projection_of_the_shaded_spectra():
    system, palette = make_system(), make_palette()
    vectors = np.linalg.qr(np.random.default_rng(4).standard_normal((36, 5)))[0].T

    @dataclass(frozen=True)
    class Basis:
        vectors: np.ndarray

    expected = shade(system, palette).values @ vectors.T
    for basis in (vectors, Basis(vectors)):
        image = shade(system, palette, basis=basis)
        np.testing.assert_allclose(image.values, expected, rtol=0, atol=1e-13)
        assert image.bands.kind == "coordinate"
        assert image.bands.labels == ("c0", "c1", "c2", "c3", "c4")


def test_a_product_of_coordinates_would_not_be_the_coordinates_of_the_product():
    # The paper's §4 lets λ index basis spectra; multiplying coordinates is not what that means.
    vectors = np.linalg.qr(np.random.default_rng(5).standard_normal((36, 36)))[0].T
    palette = make_palette()
    one = Interaction("sun", ("sea.diffuse",))
    right = gamma([one], palette) @ vectors.T
    wrong = (vectors @ palette["sun"]) * (vectors @ palette["sea.diffuse"])
    assert np.abs(right - wrong).max() > 0.1


@pytest.mark.parametrize(
    ("basis", "reason"),
    [
        (np.eye(35), r"the basis is \(35, 35\)"),
        (2 * np.eye(36), "not orthonormal"),
        (np.full((1, 36), np.nan), "orthonormal"),
    ],
)
def test_a_basis_that_is_none_is_refused(basis, reason):
    with pytest.raises(ValueError, match=reason):
        shade(make_system(), make_palette(), basis=basis)


def test_float32_is_float64_rounded_within_single_precision():
    system, palette = make_system(40, 50), make_palette()
    single, double = shade(system, palette, dtype=np.float32).values, shade(system, palette).values
    assert single.dtype == np.float32
    # Four terms of products: each adds at most a few units of 2**-24.
    np.testing.assert_allclose(single, double, rtol=8 * 2.0**-24, atol=0)


def test_every_missing_symbol_is_named_at_once_with_the_nearest_one():
    palette = Palette(RGB, {"sun": 1.0, "sea.difuse": 0.5, "sky": 1.0})
    with pytest.raises(ValueError, match="did you mean") as caught:
        shade(make_system(), palette)
    message = str(caught.value)
    assert "'brass.mirror'" in message
    assert "'sea.diffuse' (did you mean 'sea.difuse'?)" in message
    assert "palette.add(" in message


def test_symbols_that_no_pixel_needs_are_fine():
    system, palette = make_system(), make_palette()
    more = palette.add({"moon": 1.0, "cheese.diffuse": 0.5})
    np.testing.assert_array_equal(shade(system, more).values, shade(system, palette).values)


def test_alternatives_weigh_nothing_until_the_palette_names_them():
    plain = make_system()
    more = (*INTERACTIONS, Interaction("sun", ("sea>ice.diffuse",)))
    dense = np.hstack([plain.G.toarray(), np.ones((20, 1))])
    system = replace(plain, G=sparse.csr_array(dense), interactions=more)
    palette = make_palette()
    np.testing.assert_array_equal(shade(system, palette).values, shade(plain, palette).values)
    named = palette.add({"sea>ice.diffuse": 0.25})
    np.testing.assert_allclose(
        shade(system, named).values, shade(plain, palette).values + 0.25 * palette["sun"], rtol=1e-12
    )


def test_a_free_exponent_weighs_the_columns_by_its_nodes():
    # cos^s at the nodes is what a collapse stores; the interpolant between them errs by 2e-4 at J = 8.
    nodes = Nodes("brass.exponent", 5.0, 80.0, 8)
    cosines = np.linspace(0, 1, 20)
    interactions = tuple(Interaction("sun", ("brass.specular",), (("brass.exponent", j),)) for j in range(8))
    powers = sparse.csr_array(np.stack([cosines**s for s in nodes.values], axis=1))
    system = LinearSystem(powers, interactions, 4, 5, {"sun": 1.0}, parameters={"brass.exponent": nodes})
    palette = Palette(RGB, {"sun": 1.0, "brass.specular": 1.0})
    for s in (5.0, 20.0, 33.3, 80.0):
        image = shade(system, palette, parameters={"brass.exponent": s}).values[:, :, 0].ravel()
        np.testing.assert_allclose(image, cosines**s, rtol=0, atol=2e-4)
    with pytest.raises(ValueError, match=r"give a value for brass.exponent in \[5, 80\]"):
        shade(system, palette)
    with pytest.raises(ValueError, match=r"'brass.exponnent' \(did you mean 'brass.exponent'\?\)"):
        shade(system, palette, parameters={"brass.exponnent": 20.0, "brass.exponent": 20.0})
    with pytest.raises(ValueError, match="collapsed for"):
        shade(system, palette, parameters={"brass.exponent": 81.0})


def test_the_certificate_bounds_what_more_bounces_would_have_added():
    # A pixel between two parallel mirrors: Σ_k L m^k; a render of depth d keeps k <= d, the tail is Σ_{k>d}.
    mirror, light, depth = np.array([0.0, 0.5, 0.9]), np.array([1.0, 2.0, 3.0]), 4
    cut = Interaction("sun", ("wall.mirror",) * (depth + 1))
    tail = Tail(sparse.csr_array(np.array([[0.0], [1.0]])), (cut,), (((("wall.mirror",), 1.0),),))
    bound = tail_bound(tail, Palette(RGB, {"sun": light, "wall.mirror": mirror}))
    truth = [Fraction(L) * Fraction(m) ** (depth + 1) / (1 - Fraction(m)) for L, m in zip(light, mirror, strict=True)]
    for b, exact in zip(bound, truth, strict=True):
        assert exact <= Fraction(b)
        assert b <= float(exact) * (1 + 1e-11) + 1e-300


def test_what_three_hundred_mirrors_leave_is_never_certified_as_nothing():
    # 0.05 ** 301 is below the smallest float64.
    cut = Interaction("sun", ("wall.mirror",) * 301)
    tail = Tail(sparse.csr_array(np.ones((1, 1))), (cut,), (((("wall.mirror",), 1.0),),))
    assert tail_bound(tail, Palette(RGB, {"sun": 1.0, "wall.mirror": 0.05})).min() > 0
    assert not tail_bound(Tail(sparse.csr_array((1, 0))), Palette(RGB, {"sun": 1.0})).any()


def test_a_perfect_mirror_has_no_certificate():
    cut = Interaction("sun", ("brass.mirror",))
    tail = Tail(sparse.csr_array(np.ones((20, 1))), (cut,), (((("brass.mirror",), 1.0),),))
    system, palette = make_system(tail=tail), make_palette().replace({"brass.mirror": 1.0})
    image = shade(system, palette)
    assert np.isinf(image.cut_off).all()
    assert "no certificate" in repr(image)
    assert np.isfinite(shade(system, palette.replace({"brass.mirror": 0.5})).cut_off).all()
    assert shade(make_system(), palette).cut_off is None


def test_a_bound_in_a_basis_bounds_every_coordinate():
    cut = Interaction("sun", ("brass.mirror",))
    tail = Tail(sparse.csr_array(np.ones((20, 1))), (cut,), (((("brass.mirror",), 1.0),),))
    system, palette = make_system(tail=tail), make_palette().replace({"brass.mirror": 0.5})
    vectors = np.linalg.qr(np.random.default_rng(6).standard_normal((36, 4)))[0].T
    limit = shade(system, palette).cut_off
    coordinates = shade(system, palette, basis=vectors).cut_off
    corners = (np.random.default_rng(7).random((200, 36)) * limit) @ vectors.T
    assert np.all(np.abs(corners) <= coordinates)


def test_a_preview_is_the_image_s_own_picture():
    system, palette = make_system(60, 70), make_palette()
    codes = preview(system, palette, exposure=0.8)
    picture = 255 * to_rgb(shade(system, palette), exposure=0.8)
    # The two orders of the product may differ by ulps, so a value at a rounding edge may go either way.
    assert np.abs(codes - picture).max() <= 0.5 + 1e-9


def test_a_preview_made_in_blocks_has_the_bits_of_its_parts():
    system = make_system(300, 200)
    palette = make_palette()
    whole = preview(system, palette)
    top = replace(system, G=system.G[: 200 * 100], height=100)
    np.testing.assert_array_equal(preview(top, palette), whole[:100])


@pytest.mark.parametrize(("light", "dtype"), [(1e300, np.float64), (1e36, np.float32)])
def test_radiances_that_a_number_cannot_hold_are_refused_not_made_infinite(light, dtype):
    system, palette = make_system(), make_palette()
    system = replace(system, G=system.G * 1e10)
    with pytest.raises(ValueError, match="scale the lights down"):
        shade(system, palette.replace(sun=light), dtype=dtype)
    assert np.isfinite(shade(system, palette.replace(sun=light / 1e12), dtype=dtype).values).all()


def test_every_light_s_white_comes_with_the_image():
    image = shade(make_system(), make_palette())
    assert list(image.whites) == ["sun", "sky"]
    np.testing.assert_allclose(image.white, 0.3 * make_palette()["sun"], rtol=1e-15)
    assert shade(make_system(), make_palette(), basis=np.eye(36)).white is None


def test_an_image_without_pixels_has_its_bands():
    empty = LinearSystem(sparse.csr_array((0, len(INTERACTIONS))), INTERACTIONS, 1, 0, {"sun": 0.3})
    assert shade(empty, make_palette()).values.shape == (1, 0, len(BANDS))


def test_a_misspelt_entry_is_named_and_other_scenes_symbols_are_not():
    column = Interaction("sun", ("brass.diffuse",))
    formulas = {"brass": "direct = diffuse*n_dot_l/pi + specular*n_dot_l", "steel": "reflected = mirror"}
    system = LinearSystem(sparse.csr_array([[1.0]]), (column,), 1, 1, {"sun": 1.0}, formulas)
    right = {"sun": 1, "brass.diffuse": 0.5, "brass.specular": 0.1, "steel.mirror": 0.9, "grass.diffuse": 0.2}
    shade(system, Palette(RGB, right))  # no pixel shows the steel, and the grass is another scene's
    for wrong, meant in (("bras.diffuse", "brass.diffuse"), ("brass.spekular", "brass.specular"), ("sunn", "sun")):
        with pytest.warns(UserWarning, match=f"'{wrong}' is nothing in this scene: did you mean '{meant}'"):
            shade(system, Palette(RGB, right | {wrong: 0.5}))
