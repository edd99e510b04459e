"""Each claim of the paper that we make, by the section that makes it.

"A Spectral Gamut-Mapping Environment with Rendering Parameter Feedback".
"""

from fractions import Fraction

import numpy as np
import pytest
from scenes_for_tests import palettes, small

import symrt as rt
from symrt.feedback import clip
from symrt.spectra import gamma


@pytest.fixture(scope="module")
def scene():
    return small("globe", 64)


@pytest.fixture(scope="module")
def system(scene):
    return rt.render(scene, progress=False)


@pytest.fixture(scope="module")
def palette():
    return palettes("globe")["macbeth"]


@pytest.fixture(scope="module")
def device():
    return rt.load_device("dye3-endura-premier")


@pytest.fixture(scope="module")
def envelope(device):
    return rt.device_gamut(device, "envelope")


def reflectances(system, palette) -> np.ndarray:
    """Pixels as reflectances: radiance over that of the reference white (pixel × band)."""
    image = rt.shade(system, palette)
    return image.values.reshape(-1, len(palette.bands)) / rt.Reference().white(system, palette)


def test_2_1_the_first_basis_vector_is_one_sixth_in_each_of_36_bands(device):
    # The paper: "k = 1/36^(1/2) = 1/6, giving c_0 ∈ [0, 6]"
    basis = rt.device_gamut(device, "unit").basis
    assert basis.vectors.shape == (36, 36)
    assert np.all(basis.vectors[0] == 1 / 6)
    assert basis.coordinates(np.ones((1, 36)))[0, 0] == pytest.approx(6, rel=4 * 2.0**-52)
    assert basis.coordinates(np.zeros((1, 36)))[0, 0] == 0


def test_2_1_the_basis_is_orthonormal_with_all_its_components(device):
    vectors = rt.device_gamut(device, "unit").basis.vectors
    np.testing.assert_allclose(vectors @ vectors.T, np.eye(36), atol=8 * 36 * 2.0**-53)


def test_2_1_the_gamut_is_convex(envelope):
    # The paper: "the spectral gamut formed in this way is guaranteed to be convex"
    draw = np.random.default_rng(3)
    inside = draw.uniform(envelope.lower, envelope.upper, (2, 500, 36))
    t = draw.uniform(0, 1, (500, 1))
    assert envelope.contains((1 - t) * inside[0] + t * inside[1]).all()


def test_3_a_uniform_first_basis_makes_the_neutral_axis_common_to_all_gamuts():
    # The paper: "selecting a uniform first basis spectrum ensures that the neutral axis is common to all gamuts"
    axes = [rt.device_gamut(rt.load_device(name), "unit").basis.vectors[0] for name in rt.devices()[:3]]
    assert all(np.array_equal(axis, axes[0]) for axis in axes)


def test_4_a_pixel_is_a_sum_over_light_and_material_products(system, palette):
    # By the indices of equation (2).
    image = rt.shade(system, palette).values.reshape(-1, 36)
    products = gamma(system.interactions, palette)
    for n in np.flatnonzero(system.object_pixels)[::97]:
        row = slice(system.G.indptr[n], system.G.indptr[n + 1])
        for band in (0, 17, 35):
            exact = sum(
                Fraction(float(g)) * Fraction(float(products[i, band]))
                for g, i in zip(system.G.data[row], system.G.indices[row], strict=True)
            )
            assert image[n, band] == pytest.approx(float(exact), rel=1e-14)


def test_4_many_coefficients_are_zero_and_none_of_them_is_stored(system):
    # The paper: "many coefficients g_{n,i} will be zero ... allowing sparse structure"
    possible = system.G.shape[0] * system.G.shape[1]
    assert system.G.nnz < possible / 10
    assert np.all(system.G.data != 0)


def test_4_the_geometry_matrix_is_independent_of_colour_space_lights_and_materials(scene, system, palette):
    before = system.G.data.tobytes()
    for shown in (palettes("globe")["rgb"], palette, palette.replace(key="illuminant/A")):
        rt.shade(system, shown)
    assert system.G.data.tobytes() == before
    again = rt.render(scene, progress=False)
    assert again.G.data.tobytes() == before


def test_4_three_bands_are_three_columns_of_thirty_six(system, palette):
    whole = rt.shade(system, palette).values
    three = rt.Palette(
        rt.wavelengths(450, 650, 100),
        {name: palette[name][[7, 17, 27]] for name in palette},
        unphysical=palette.unphysical,
    )
    np.testing.assert_array_equal(rt.shade(system, three).values, whole[..., [7, 17, 27]])


def test_4_any_basis_may_index_the_bands(system, palette, device):
    # The paper: "Using the PCA basis changes λ to an index over the basis spectra"
    basis = rt.device_gamut(device, "unit").basis
    coordinates = rt.shade(system, palette, basis=basis).values
    spectra = rt.shade(system, palette).values
    np.testing.assert_allclose(basis.spectra(coordinates.reshape(-1, 36)), spectra.reshape(-1, 36), atol=1e-14)


def test_4_shading_is_linear_in_every_light(system, palette):
    for light in system.lights:
        on = rt.shade(system, palette).values
        off = rt.shade(system, palette.replace({light: 0.0})).values
        double = rt.shade(system, palette.replace({light: 2 * palette[light]})).values
        np.testing.assert_allclose(double - off, 2 * (on - off), rtol=1e-12, atol=1e-15)


def test_4_shading_is_linear_in_every_material_that_is_met_once(system, palette):
    names = [name for name in system.reflectances if system.blocks({name}).degrees.max() <= 1]
    assert "upland.diffuse" in names
    on = rt.shade(system, palette).values
    for name in names:
        off = rt.shade(system, palette.replace({name: 0.0})).values
        half = rt.shade(system, palette.replace({name: palette[name] / 2})).values
        np.testing.assert_allclose(2 * (half - off), on - off, rtol=1e-12, atol=1e-15)


def test_4_a_specular_exponent_is_collapsed_and_not_free(scene):
    # The paper: "linear in the diffuse and specular components, but not the specular exponent"
    tree = rt.trace(scene)
    sharp, blunt = (rt.collapse(tree, values={"brass.exponent": s}) for s in (200, 5))
    assert sharp.interactions == blunt.interactions
    assert not np.array_equal(sharp.G.toarray(), blunt.G.toarray())


def test_5_scaling_a_material_makes_line_segments_that_clip_to_the_gamut(system, palette, envelope):
    # The paper: "extruding pixel spectral coordinates into line segments for clipping against the convex printer gamut"
    still = reflectances(system, palette.replace({"upland.diffuse": 0.0}))
    moving = reflectances(system, palette) - still
    spans = clip(envelope, still, moving)
    lit = np.flatnonzero((moving > 0).any(axis=1) & ~spans.empty)
    for end in (spans.low, spans.high):
        t = np.clip(end[lit], -1e3, 1e3)
        assert envelope.contains(still[lit] + t[:, None] * moving[lit] * (1 - 1e-12)).all()


def test_5_the_feasible_range_is_where_every_pixel_is_inside(system, palette, envelope):
    found = rt.feasible(system, palette, envelope, rt.Scale("upland"), within=(0.01, 3.0), cap=False)
    kept_out = set(found.untouched_outside) | set(found.unfixable)
    rest = np.array(sorted(set(np.flatnonzero(system.object_pixels)) - kept_out))

    def inside(t):
        scaled = palette.replace({"upland.diffuse": palette["upland.diffuse"] * t})
        return envelope.contains(reflectances(system, scaled)[rest]).all()

    assert inside(found.high * (1 - 1e-12))
    assert not inside(found.high * (1 + 1e-9))


def test_5_a_blend_of_two_materials_is_a_segment_too(system, palette, envelope):
    # The paper: "an affine blend of the material reflectances (akin to paint mixing) again gives a line segment"
    image = []
    for t in (0.0, 0.5, 1.0):
        mixed = (1 - t) * palette["upland.diffuse"] + t * palette["ice.diffuse"]
        image.append(rt.shade(system, palette.replace({"upland.diffuse": mixed})).values)
    np.testing.assert_allclose(image[1], (image[0] + image[2]) / 2, rtol=1e-12)
    found = rt.feasible(system, palette, envelope, rt.Blend("upland", "ice"))
    assert 0 < found.high < 1


def test_5_some_percentage_of_pixels_may_be_left_out(system, palette, envelope):
    # The paper: "or some percentage of out-of-gamut pixels may be allowed"
    highs = [
        rt.feasible(system, palette, envelope, rt.Scale("upland"), allowed_out=share, cap=False).high
        for share in (0.0, 0.02, 0.1)
    ]
    assert highs[0] < highs[1] < highs[2]


def test_5_the_complete_algorithm_ends_in_an_image_that_is_in_gamut(system, palette, envelope):
    # The paper: "Substituting the resulting parameters into the linear system yields a new, in-gamut, image."
    names = sorted({name.partition(".")[0] for name in system.reflectances})
    fit = rt.fit(system, palette, envelope, [rt.Scale(n) for n in names], objective="lightest", within=(0.01, 3.0))
    image = reflectances(system, fit.palette)
    assert envelope.contains(image[system.object_pixels]).all()
    assert image.mean() > 0


def test_figure_3_the_lightest_image_has_a_lighter_africa_and_darker_brass(system, palette, envelope):
    names = sorted({name.partition(".")[0] for name in system.reflectances})
    fit = rt.fit(system, palette, envelope, [rt.Scale(n) for n in names], objective="lightest", within=(0.01, 3.0))
    assert fit.values["upland"] > 1
    assert fit.values["brass"] < 1


def test_6_parameters_are_adjusted_without_rendering_again(scene, palette, envelope, monkeypatch):
    # The paper: "interactive parameter adjustment without re-rendering"
    system = rt.render(scene, progress=False)
    monkeypatch.setattr("symrt.tracing.tracer.nearest", None)
    high = rt.feasible(system, palette, envelope, rt.Scale("key"), cap=False).high
    dimmer = rt.shade(system, palette.replace({"key": high * palette["key"]})).values
    assert 0 < high < 1
    assert np.all(dimmer <= rt.shade(system, palette).values)


def test_6_a_probe_gives_light_and_material_statistics_before_any_rendering(scene):
    met = {(m.light, m.material) for m in rt.probe(scene, rays=1000).meetings}
    assert ("key", "brass") in met
    assert ("key", "upland") in met
