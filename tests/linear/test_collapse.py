"""Step 2 against its own paper trail: every coefficient is what SymPy makes of the pixel's expression (paper §4)."""

from dataclasses import replace

import numpy as np
import pytest
import sympy
from scenes_for_tests import camera, every_scene, hall_of_mirrors, mirrors, small, two_materials

import symrt as rt
from symrt.linear import collapse as collapse_module
from symrt.reflection import diffuse, mirror, n_dot_v, parameter, reflectance
from symrt.reflection.symbols import Light, Reflectance, n_dot_l


@pytest.mark.parametrize("name", every_scene())
def test_the_array_path_is_the_literal_pipeline(name):
    # Paper §4: expression trees per pixel, partially evaluated into linear expressions.
    size = {"tinted": 10, "prism": 10, "cornell": 12}.get(name, 24)
    tree = rt.trace(small(name, size))
    system = rt.collapse(tree)
    literal = rt.coefficient_matrix(rt.expressions(tree), size, size, system.white)
    if system.lengths:
        # Its columns have the lengths in glass as they are; of a few nodes pixels are too bright, as much as is told.
        spectra = {name: 0.9 - 0.6 * k / len(literal.symbols) for k, name in enumerate(literal.symbols)}
        palette = rt.Palette(rt.RGB, spectra)
        clear = rt.shade(system, palette.replace(dict.fromkeys(system.lengths, 1.0))).values
        above = rt.shade(system, palette).values - rt.shade(literal, palette).values
        assert above.min() >= -1e-14 * clear.max()
        assert np.all(above <= sum(lengths.error for lengths in system.lengths.values()) * clear + 1e-14)
        assert above.max() > 1e-4
        return
    assert literal.interactions == system.interactions
    assert (literal.G != 0).nnz == system.G.nnz
    np.testing.assert_allclose(literal.G.toarray(), system.G.toarray(), rtol=1e-13)


def test_a_users_own_expressions_collapse_too():
    sun, red, blue = Light("sun"), Reflectance("ball.diffuse"), Reflectance("wall.mirror")
    own = rt.Formula(sun * (red + blue) ** 2 * n_dot_l, {"n_dot_l": 0.5})
    system = rt.coefficient_matrix([own, rt.Formula(sympy.Integer(0))], 2, 1, {"sun": 1.0})
    assert [str(i) for i in system.interactions] == [
        "sun*ball.diffuse**2",
        "sun*ball.diffuse*wall.mirror",
        "sun*wall.mirror**2",
    ]
    assert system.G.toarray().tolist() == [[0.5, 1.0, 0.5], [0.0, 0.0, 0.0]]


@pytest.mark.parametrize(
    ("expression", "says"),
    [
        (Reflectance("a.diffuse"), "0 lights"),
        (Light("sun") * Light("sky"), "2 lights"),
        (Light("sun") / (1 + Reflectance("a.diffuse")), "not a product of powers"),
    ],
)
def test_what_is_not_linear_in_one_light_is_refused(expression, says):
    with pytest.raises(ValueError, match=says):
        rt.linear_form(expression)


def test_a_changed_exponent_costs_a_collapse_and_no_trace(monkeypatch):
    scene = two_materials(exponent=20)
    tree = rt.trace(scene)
    changed = rt.collapse(rt.trace(two_materials(exponent=60)))
    monkeypatch.setattr("symrt.tracing.tracer.nearest", None)
    again = rt.collapse(tree, values={"shiny.exponent": 60})
    assert again.interactions == changed.interactions
    assert np.array_equal(again.G.data, changed.G.data)
    assert again.models == changed.models


@pytest.mark.parametrize("value", [6.0, 20.0, 33.3, 70.0])
def test_a_free_exponent_gives_every_exponent_by_one_collapse(value):
    tree = rt.trace(two_materials(exponent=20))
    free = rt.collapse(tree, free={"shiny.exponent": (5, 80)})
    fixed = rt.collapse(tree, values={"shiny.exponent": value})
    palette = rt.Palette(
        bands=rt.wavelengths(500, 600, 50), spectra={s: 0.5 if "." in s else 2.0 for s in fixed.symbols}
    )
    found = rt.shade(free, palette, parameters={"shiny.exponent": value}).values
    # Nodes are chosen for 1e-6 of a power; the lobe's factor (s + 2)/2π, the light and the specular 0.5 multiply it.
    np.testing.assert_allclose(found, rt.shade(fixed, palette).values, atol=1e-6 * 82 / (2 * np.pi) * 2.0 * 0.5)
    assert any(interaction.nodes for interaction in free.interactions)


def test_unknown_parameters_are_named_with_those_there_are():
    tree = rt.trace(two_materials(exponent=20))
    for call in ({"values": {"shiny.gloss": 3}}, {"free": ["shiny.gloss"]}):
        with pytest.raises(ValueError, match=r"shiny\.gloss.*shiny\.exponent"):
            rt.collapse(tree, **call)


def test_an_alternative_material_brings_its_own_model_to_the_same_points():
    scene = two_materials(exponent=20)
    system = rt.collapse(rt.trace(scene, alternatives={"dull": ["shiny"]}))
    swapped = rt.collapse(rt.trace(two_materials(exponent=20, swap=True)))
    dull = {str(i): g for i, g in zip(system.interactions, system.G.T.toarray(), strict=True)}
    other = {str(i): g for i, g in zip(swapped.interactions, swapped.G.T.toarray(), strict=True)}
    # What dull's points send as shiny is what they send in the scene in which they are shiny.
    on_dull_points = dull["sun*dull.diffuse"] > 0
    np.testing.assert_allclose(
        dull["sun*dull>shiny.specular"][on_dull_points], other["sun*shiny.specular"][on_dull_points], rtol=1e-13
    )


def test_schlick_reflection_is_affine_in_its_reflectance_and_never_expanded():
    f0 = reflectance("f0")
    away = (1 - n_dot_v) ** 5
    glossy = rt.Model(direct=diffuse * n_dot_l / sympy.pi, ambient=diffuse, reflected=away + (1 - away) * f0)
    system = rt.collapse(rt.trace(mirrors(model=glossy, depth=2)))
    names = {str(i) for i in system.interactions}
    assert {"sun*ball.diffuse", "sun*floor.diffuse*ball.f0", "sun*floor.diffuse"} <= {
        n.replace("ball.f0*floor.diffuse", "floor.diffuse*ball.f0") for n in names
    }


def test_two_terms_at_each_bounce_do_not_double_the_work():
    # Unmerged, 40 bounces would be 2⁴⁰ paths.
    glossy = rt.Model(direct=diffuse * n_dot_l / sympy.pi, reflected=0.25 + reflectance("f0") / 2)
    along = rt.Camera(position=(0, 0, 0), target=(0, 0, -1), width=2, height=2, field_of_view=0.2)
    both = [rt.Material(name, model=glossy) for name in ("front", "back")]
    scene = replace(hall_of_mirrors(40, tilt=0.0), camera=along, materials=both)
    system = rt.render(scene, tolerance=0, progress=False)
    assert max(i.degree for i in system.interactions) == 41
    tree = rt.trace(replace(scene, depth=3))
    literal = rt.coefficient_matrix(rt.expressions(tree), 2, 2, system.white)
    assert literal.interactions == rt.collapse(tree).interactions
    np.testing.assert_allclose(rt.collapse(tree).G.toarray(), literal.G.toarray(), rtol=1e-13)


def test_what_mirrors_by_nothing_is_no_mirror():
    none = (mirror + 1) * n_dot_v - mirror * n_dot_v - n_dot_v
    scene = mirrors(model=rt.Model(direct=diffuse * n_dot_l, reflected=none))
    assert "mirrors" not in rt.plan(scene)
    assert rt.render(scene, progress=False).object_pixels.any()


def test_a_negative_exponent_is_refused_by_name():
    with pytest.raises(ValueError, match=r"shiny: .*must not be negative"):
        rt.collapse(rt.trace(two_materials(exponent=20)), values={"shiny.exponent": -5})


def test_a_function_that_numpy_lacks_is_named():
    odd = rt.Model(direct=diffuse * sympy.besselj(0, n_dot_l))
    with pytest.raises(ValueError, match="besselj"):
        rt.render(mirrors(model=odd), progress=False)


def test_a_model_without_a_finite_value_says_where():
    grazing = rt.Model(direct=diffuse / n_dot_v)
    scene = mirrors(model=grazing, depth=0)
    tree = rt.trace(scene)
    level = tree.levels[0]
    broken = replace(level, points=tuple(replace(p, view={k: v * 0 for k, v in p.view.items()}) for p in level.points))
    with pytest.raises(ValueError, match=r"not finite at .*n_dot_v"):
        rt.collapse(replace(tree, levels=(broken,)))


def test_a_parameter_of_ones_own_model_reaches_the_coefficients():
    dim = rt.Model(direct=diffuse * n_dot_l * parameter("share") / sympy.pi)
    bright, half = (rt.collapse(rt.trace(mirrors(model=dim, depth=0, share=s))) for s in (1.0, 0.5))
    column = [str(i) for i in bright.interactions].index("sun*ball.diffuse")
    np.testing.assert_array_equal(half.G.toarray()[:, column], bright.G.toarray()[:, column] / 2)


def test_rows_are_pixels_from_the_top_left_and_columns_sorted():
    system = rt.collapse(rt.trace(small("first", 16)))
    assert system.G.shape == (256, len(system.interactions))
    assert list(system.interactions) == sorted(system.interactions)
    assert collapse_module is not None
    assert system.G.has_sorted_indices


def test_fluorescent_paint_that_sends_rays_on_through_tinted_glass_is_refused():
    # Its light goes through the glass either before the paint or behind it, and columns do not tell.
    glowing = rt.Model(reflected=mirror + reflectance("fluorescence"))
    scene = rt.Scene(
        camera=camera(8),
        shapes=[
            rt.Sphere(centre=(0, 0, 0), radius=1, material="wine"),
            rt.Rectangle(centre=(0, 0, -2), edge_u=(9, 0, 0), edge_v=(0, 9, 0), material="sheet"),
            rt.Rectangle(centre=(0, 0, 9), edge_u=(-9, 0, 0), edge_v=(0, 9, 0), material="wall"),
        ],
        materials=[
            rt.Material("wine", model=["glass", "absorption"], index=1.3),
            rt.Material("sheet", model=glowing),
            rt.Material("wall", model="lambert"),
        ],
        lights=[rt.PointLight("lamp", position=(0, 3, 5))],
    )
    with pytest.raises(ValueError, match=r"sheet\.fluorescence sends light on .* force=\{'absorption': False\}"):
        rt.collapse(rt.trace(scene))
    assert rt.collapse(rt.trace(scene, force={"absorption": False})).reflectances


def test_a_product_with_a_matrix_has_an_order_that_no_formula_tells():
    with pytest.raises(ValueError, match="coat\\*fluorescence is a product with fluorescence"):
        rt.Model(direct=reflectance("fluorescence") * reflectance("coat"))
