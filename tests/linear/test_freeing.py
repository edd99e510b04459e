"""Parameters that stay free: the error asked for is kept, the error told is a bound, and both kinds settle."""

from dataclasses import replace

import mpmath
import numpy as np
import pytest
import sympy
from scenes_for_tests import camera, mirrors

import symrt as rt
from symrt.feedback.along import check_settled
from symrt.linear.enclosures import Box, enclosed, real
from symrt.linear.freeing import freed
from symrt.linear.remainders import first_order_bound, interpolation_bound
from symrt.reflection import diffuse, lobe, n_dot_l, n_dot_v, parameter, r_dot_v, specular
from symrt.reflection.symbols import Factor, Parameter, log_lobe_values
from symrt.tracing.raytree import MaterialRecord

THETA = parameter("theta")
POWER = (THETA + 2) / (2 * sympy.pi) * lobe(r_dot_v, THETA) * n_dot_l
FORMULAS = {
    "a power of a cosine": (POWER, (10.0, 160.0)),
    "a cosine's own power": (n_dot_v**THETA, (0.5, 4.0)),
    "a wave": (sympy.sin(3 * THETA) * n_dot_l, (-1.0, 1.0)),
    "a quotient": (n_dot_l / (1 + THETA * n_dot_v), (0.25, 4.0)),
    "a root": (sympy.sqrt(THETA + n_dot_v) * n_dot_l, (0.5, 2.0)),
    "a fade": (sympy.exp(-THETA * n_dot_l) + sympy.log(2 + THETA) * n_dot_v, (-1.0, 2.0)),
}


def exactly(formula):
    """A formula at 30 digits: a function of the parameter and the cosines, from the floats as they are."""
    plain = formula.replace(lambda part: part.func.__name__ == "Lobe", lambda part: r_dot_v ** part.args[1])
    function = sympy.lambdify([THETA, n_dot_l, n_dot_v, r_dot_v], plain, "mpmath")

    def value(theta, cosines):
        with mpmath.workdps(30):
            return function(mpmath.mpf(theta), *(mpmath.mpf(cosine) for cosine in cosines))

    return value


def draws(ends, count=100):
    random = np.random.default_rng(8)
    for _ in range(count):
        yield float(random.uniform(*ends)), random.uniform(size=3).tolist()


@pytest.mark.parametrize(("formula", "ends"), FORMULAS.values(), ids=FORMULAS)
def test_the_error_of_nodes_is_a_bound(formula, ends):
    model = rt.Model(direct=formula * specular)
    materials, exact = {"desk": MaterialRecord(model, {"theta": sum(ends) / 2})}, exactly(formula)
    for error in (1e-2, 1e-5):
        nodes = freed(materials, {"desk.theta": ends}, error)["desk.theta"]
        assert nodes.error <= error
        assert nodes.scale == ("log" if ends[0] > 0 else "linear")
        for theta, cosines in draws(ends, 50):
            parts = [exact(value, cosines) for value in nodes.values]
            found = sum(w * p for w, p in zip(nodes.weights(theta), parts, strict=True))
            assert abs(found - exact(theta, cosines)) <= nodes.error


@pytest.mark.parametrize(("formula", "ends"), FORMULAS.values(), ids=FORMULAS)
def test_what_first_order_leaves_out_is_bounded(formula, ends):
    around = sum(ends) / 2
    low, high = around - 0.3 * (around - ends[0]), around + 0.3 * (ends[1] - around)
    materials = {"desk": MaterialRecord(rt.Model(direct=formula * specular), {"theta": around})}
    nodes = freed(materials, {"desk.theta": ("first order", low, high)})["desk.theta"]
    worst, exact = 0.0, exactly(formula)
    plain = formula.replace(lambda part: part.func.__name__ == "Lobe", lambda part: r_dot_v ** part.args[1])
    slope = exactly(sympy.diff(plain, THETA))
    for theta, cosines in draws((low, high)):
        left_out = abs(exact(around, cosines) + slope(around, cosines) * (theta - around) - exact(theta, cosines))
        assert left_out <= nodes.error_at(theta)
        worst = max(worst, float(left_out / nodes.error))
    assert worst <= 1
    # At some cosines the curve bends as much as is told, up to the width of the boxes.
    assert worst > 0.01


def shiny(**parameters):
    model = rt.Model(direct=diffuse * n_dot_l / sympy.pi + specular * lobe(r_dot_v, parameter("gloss")) / sympy.pi)
    scene = mirrors(model=model, gloss=20, **parameters)
    return rt.trace(replace(scene, camera=camera(16)))


def test_both_kinds_settle_to_what_a_collapse_with_the_value_gives():
    tree = shiny()
    palette = rt.Palette(
        rt.RGB, {"sun": 3.0, "sky": 0.0, "ball.diffuse": 0.0, "ball.specular": 1.0, "floor.diffuse": 0.3}
    )
    for free, error in (({"ball.gloss": (10, 40)}, 1e-5), ({"ball.gloss": ("first order", 19, 21)}, None)):
        system = rt.collapse(tree, free=free, error=error)
        nodes = system.parameters["ball.gloss"]
        for value in (19.2, 20.0, 20.9):
            exact = rt.shade(rt.collapse(tree, values={"ball.gloss": value}), palette).values
            settled = system.at({"ball.gloss": value})
            assert settled.parameters == {}
            assert settled.signed == {}
            # Irradiance 1 from the sun, whose spectrum is 3.
            np.testing.assert_allclose(rt.shade(settled, palette).values, exact, atol=3 * nodes.error_at(value) + 1e-15)
            seen = rt.shade(system, palette, parameters={"ball.gloss": value}).values
            np.testing.assert_allclose(seen, exact, atol=3 * nodes.error_at(value) + 1e-15)
        assert f"; ball.gloss errs by at most {nodes.error:.2g}" in repr(system)


def test_first_order_is_printed_saved_and_named(tmp_path):
    tree = shiny()
    system = rt.collapse(tree, free={"ball.gloss": "first order"})
    nodes = system.parameters["ball.gloss"]
    assert (nodes.low, nodes.high, nodes.around) == (18.0, 22.0, 20.0)
    lit = int(np.argmax(system.G[:, [bool(i.nodes) for i in system.interactions]].sum(axis=1)))
    formula = rt.formula(system, lit % 16, lit // 16)
    assert "*sun*ball.specular*(-20 + ball.gloss)" in formula.text()
    spectra = {"sun": 1.0, "sky": 0.0, "ball.diffuse": 0.4, "ball.specular": 0.3, "floor.diffuse": 0.0}
    value = formula.evaluate(spectra | {"ball.gloss": 21.0})
    palette = rt.Palette(rt.RGB, spectra)
    image = rt.shade(system, palette, parameters={"ball.gloss": 21.0}).values.reshape(256, 3)
    assert value == pytest.approx(image[lit, 0], rel=1e-13)
    assert set(system.signed.values()) == {"first order in ball.gloss"}
    rt.save_system(tmp_path / "free.npz", system)
    again = rt.load_system(tmp_path / "free.npz")
    assert again.parameters == system.parameters
    assert again.signed == system.signed
    with pytest.raises(ValueError, match=r"ball\.gloss free: give values.*system\.at\(.*the model of ball: direct = "):
        check_settled(system)


def test_an_error_that_cannot_be_kept_is_refused_with_the_way_out():
    tree = shiny()
    for free, error, says in (
        ({"ball.gloss": (1e-3, 1e6)}, 1e-9, r"needs more than 64 nodes for error = 1e-09; free a smaller range"),
        ({"ball.gloss": ("first order", 5, 40)}, 1e-6, r"first order errs by at most .*free a smaller range"),
        ({"ball.gloss": ("first order", 25, 40)}, None, r"first order is around its value, 20, which \[25, 40\] must"),
        ({"ball.gloss": "second order"}, None, r"give a range, \(low, high\), 'first order', or"),
        ({"ball.gloss": (10, 40)}, 0.0, r"error = 0\.0: it must be a number above 0"),
    ):
        with pytest.raises(ValueError, match=says):
            rt.collapse(tree, free=free, error=error)


def test_a_formula_without_a_bound_is_no_first_order():
    model = rt.Model(direct=specular * sympy.Abs(THETA - 2) * n_dot_l)
    materials = {"desk": MaterialRecord(model, {"theta": 2.0})}
    with pytest.raises(ValueError, match="no bound is known on what first order leaves out; free it between nodes"):
        freed(materials, {"desk.theta": "first order"})
    with pytest.raises(ValueError, match="needs a bound, and none is known of its formula"):
        freed(materials, {"desk.theta": (1, 3)}, 1e-3)
    # A pole within the range is seen, too.
    assert interpolation_bound([1 / (THETA - 2)], "theta", (1.0, 3.0), {}, log=True)(64) == np.inf
    assert first_order_bound([1 / (THETA - 2)], "theta", 1.5, (1.0, 3.0), {}) == np.inf


def test_two_free_parameters_of_one_formula():
    model = rt.Model(direct=specular * lobe(r_dot_v, THETA) * sympy.exp(-parameter("phi") * n_dot_l))
    materials = {"desk": MaterialRecord(model, {"theta": 20.0, "phi": 1.0})}
    both = freed(materials, {"desk.theta": (10, 40), "desk.phi": (0.5, 2)}, 1e-4)
    random = np.random.default_rng(4)
    for _ in range(100):
        theta, phi = random.uniform(10, 40), random.uniform(0.5, 2)
        x, y = random.uniform(0, 1, 2)
        one, other = both["desk.theta"], both["desk.phi"]
        grid = np.power(x, np.array(one.values))[:, None] * np.exp(-np.array(other.values) * y)
        found = one.weights(theta) @ grid @ other.weights(phi)
        assert abs(found - x**theta * np.exp(-phi * y)) <= one.error + other.error
    with pytest.raises(ValueError, match="where first order stands alone"):
        freed(materials, {"desk.theta": "first order", "desk.phi": (0.5, 2)})


def test_boxes_hold_every_value():
    random = np.random.default_rng(6)
    x, y = Parameter("x"), Factor("n_dot_v")
    for expression in (
        x**2 - 3 * x,
        1 / (x + 2),
        sympy.exp(x) * y,
        sympy.log(x + 3) / (y + 1),
        sympy.sin(5 * x),
        sympy.tanh(x) * y,
        sympy.sqrt(x + 2),
        (x - y) ** 3,
        x**-2 * y,
        lobe(n_dot_v, x + 2),
        sympy.cos(x * y) ** 2,
    ):
        corner = random.uniform(-1, 1, (2, 200)) + 1.2
        wide = random.uniform(0, 0.3, (2, 200))
        box = Box(corner[0], corner[0] + wide[0], corner[1] - 1.2, corner[1] - 1.2 + wide[1])
        share = np.sort(random.uniform(0, 1, (2, 200)), axis=0)
        found = enclosed(expression, {x: box, y: real(*share)}, 200)
        u, v, w = random.uniform(0, 1, (3, 200))
        z = box.low + u * wide[0] + 1j * (box.below + v * wide[1])
        at = share[0] + w * (share[1] - share[0])
        plain = expression.replace(lambda e: e.func.__name__ == "Lobe", lambda e: y ** e.args[1])
        value = sympy.lambdify([x, y], plain, "numpy")(z, at) * np.ones(200)
        assert np.all((found.low <= value.real) & (value.real <= found.high)), expression
        assert np.all((found.below <= value.imag) & (value.imag <= found.above)), expression


def test_powers_have_slopes_in_their_exponent():
    s = parameter("s")
    for times in (1, 2):
        slope = sympy.diff(lobe(r_dot_v, s), s, times)
        for x, exponent in ((0.3, 2.5), (0.99, 40.0), (1e-3, 1.5)):
            with mpmath.workdps(30):
                exact = mpmath.mpf(x) ** exponent * mpmath.log(mpmath.mpf(x)) ** times
            found = log_lobe_values(np.array([1 - x]), exponent, times)[0]
            assert found == pytest.approx(float(exact), rel=1e-11)
            leaves = {s: sympy.Float(exponent), Factor("one_minus_r_dot_v"): sympy.Float(1 - x)}
            assert float(slope.xreplace(leaves).evalf()) == pytest.approx(float(exact), rel=1e-11)
    assert log_lobe_values(np.array([1.0, 0.0]), 2.0, 1).tolist() == [0.0, 0.0]
