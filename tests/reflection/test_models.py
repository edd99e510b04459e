"""Laws of models: polynomial in reflectances, energy, and the corners of a lobe."""

import pickle
from fractions import Fraction

import mpmath
import numpy as np
import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad
from sympy import pi

from symrt.reflection import (
    MODELS,
    Model,
    diffuse,
    f82,
    lobe,
    mirror,
    n_dot_h,
    n_dot_l,
    n_dot_v,
    parameter,
    r_dot_v,
    reflectance,
    schlick,
    specular,
    stack,
)
from symrt.reflection.polynomials import monomials
from symrt.reflection.symbols import Factor, Light, Lobe, Parameter, Reflectance, lobe_values


@pytest.mark.parametrize("name", sorted(MODELS))
def test_monomials_add_up_to_the_formula(name):
    for formula in MODELS[name].formulas.values():
        rebuilt = sum(c * sympy.prod([Reflectance(m) for m in met]) for met, c in monomials(formula).items())
        assert sympy.expand(rebuilt - formula) == 0


def test_a_static_power_is_never_expanded():
    f0 = reflectance("f0")
    schlick = (1 - n_dot_v) ** 5 + (1 - (1 - n_dot_v) ** 5) * f0
    assert monomials(schlick) == {(): (1 - n_dot_v) ** 5, ("f0",): 1 - (1 - n_dot_v) ** 5}


def test_products_of_sums_become_monomials_with_repetition():
    split = monomials((diffuse + mirror) ** 2 * n_dot_l)
    assert split == {("diffuse", "diffuse"): n_dot_l, ("diffuse", "mirror"): 2 * n_dot_l, ("mirror", "mirror"): n_dot_l}


@pytest.mark.parametrize(
    ("formula", "says"),
    [
        (diffuse ** sympy.Rational(1, 2), "sqrt(diffuse)"),
        (n_dot_l / (1 + specular), "specular"),
        (sympy.exp(-diffuse), "exp(-diffuse)"),
        (sympy.Symbol("albedo") * n_dot_l, "albedo"),
        (Factor("n_dot_sun") * diffuse, "n_dot_sun"),
        (sympy.Function("f")(n_dot_l) * diffuse, "f(n_dot_l)"),
        (sympy.I * diffuse, "I has no real value"),
    ],
)
def test_a_model_that_is_not_linear_in_products_is_refused_and_the_part_at_fault_is_shown(formula, says):
    with pytest.raises(ValueError, match=r"direct|polynomial") as error:
        Model(direct=formula)
    assert says in str(error.value)


@pytest.mark.parametrize("field", ["direct", "ambient", "reflected"])
def test_a_string_is_never_parsed_into_a_formula(field):
    with pytest.raises(ValueError, match="SymPy expression"):
        Model(**{field: "__import__('os').system('true')"})


@pytest.mark.parametrize("field", ["ambient", "reflected"])
def test_what_needs_no_light_cannot_ask_for_one(field):
    with pytest.raises(ValueError, match="needs a light"):
        Model(**{field: diffuse * n_dot_l})


@pytest.mark.parametrize("name", ["", "2d", "a b", "sea.diffuse", "__import__('os')", "é", "x\n"])
def test_a_symbol_of_ones_own_has_a_plain_name(name):
    for make in (parameter, reflectance):
        with pytest.raises(ValueError, match="not a name"):
            make(name)


def test_symbols_of_one_name_and_different_kinds_stay_apart():
    kinds = [Light("x"), Reflectance("x"), Factor("x"), Parameter("x")]
    assert len(set(kinds)) == 4
    assert len((sum(kinds)).args) == 4


def test_models_survive_being_sent_to_another_process():
    for model in MODELS.values():
        assert pickle.loads(pickle.dumps(model)) == model


def test_a_stack_does_what_each_of_its_models_does():
    both = stack([MODELS["phong_plain"], MODELS["mirror"]])
    assert both.direct == MODELS["phong_plain"].direct
    assert both.reflected == mirror
    assert both.components == {"diffuse", "specular", "mirror"}


@pytest.mark.parametrize("exponent", [0.0, 1.0, 20.0, 1000.0])
def test_phong_never_sends_on_more_than_it_receives_when_light_and_view_are_along_the_normal(exponent):
    # Lafortune and Willems 1994, eq. (11): the normalised lobe integrates to at most 1.
    model = MODELS["phong"].direct.subs({diffuse: 0, specular: 1, parameter("exponent"): exponent})
    along_normal = sympy.lambdify(
        [n_dot_l, Factor("one_minus_r_dot_v")], model, modules=[{"Lobe": lambda x, s: (1 - x) ** s}, "math"]
    )
    # Seen from direction θ, lit along the normal: reciprocity makes this the albedo for a view along the normal.
    albedo = quad(lambda t: 2 * np.pi * np.sin(t) * along_normal(np.cos(t), 1 - np.cos(t)), 0, np.pi / 2)[0]
    assert albedo == pytest.approx(1.0, rel=1e-9)


@given(st.floats(0, 2), st.floats(0, 1e7))
def test_a_lobe_is_within_2_ulp_of_50_digits(one_minus, exponent):
    value = lobe_values(np.array([one_minus]), exponent)[0]
    with mpmath.workdps(50):
        exact = mpmath.power(max(mpmath.mpf(1) - mpmath.mpf(one_minus), 0), mpmath.mpf(exponent))
    assert abs(value - exact) <= 2 * np.spacing(float(exact))


def test_the_corners_of_a_lobe():
    # rows: 1 − cosine; columns: exponent 0, 1, 1e7.  A power of 0 is 1 everywhere, even at a cosine of 0.
    table = {0.0: (1.0, 1.0, 1.0), 1.0: (1.0, 0.0, 0.0), 2.0: (1.0, 0.0, 0.0), -1e-17: (1.0, 1.0, 1.0)}
    for one_minus, row in table.items():
        found = tuple(float(lobe_values(np.array([one_minus]), s)[0]) for s in (0.0, 1.0, 1e7))
        assert found == row


def test_a_lobe_prints_as_a_power_of_its_cosine():
    shown = lobe(r_dot_v, parameter("exponent"))
    assert isinstance(shown, Lobe)
    assert str(shown) == "r_dot_v**exponent"
    assert sympy.latex(shown) == r"(r \cdot v)^{\mathrm{exponent}}"
    assert shown.free_symbols == {Factor("one_minus_r_dot_v"), parameter("exponent")}


def test_only_a_cosine_has_a_lobe():
    with pytest.raises(ValueError, match="one of the cosines"):
        lobe(Factor("one_minus_r_dot_v"), 3)


@pytest.mark.parametrize("exponent", ["__import__('os').getcwd()", 50 * n_dot_l, 50 * diffuse], ids=str)
def test_the_exponent_of_a_lobe_is_a_number_or_has_only_parameters(exponent):
    with pytest.raises(ValueError, match="in parameters alone"):
        lobe(r_dot_v, exponent)


def test_a_model_asks_for_the_factors_in_its_formulas_and_no_others():
    assert MODELS["lambert"].factors == {"n_dot_l"}
    assert MODELS["phong"].factors == {"n_dot_l", "one_minus_r_dot_v"}
    assert Model(reflected=mirror * n_dot_v).factors == {"n_dot_v"}
    assert Model(direct=diffuse / pi).factors == frozenset()


def test_a_float_of_fewer_digits_is_refused_and_a_number_of_numpy_taken_whole():
    with pytest.raises(ValueError, match=r"fewer digits than a float, as NumPy's float32 has.*write float\(x\)"):
        Model(direct=diffuse * n_dot_l * np.float32(0.1) / 3)
    assert Model(reflected=np.float32(0.1)).reflected == sympy.Float(float(np.float32(0.1)))
    assert lobe(r_dot_v, np.float32(40)) == lobe(r_dot_v, 40.0)


def test_a_plain_symbol_of_a_known_name_is_said_to_be_imported():
    with pytest.raises(ValueError, match=r"import it, from symrt\.reflection import n_dot_l"):
        Model(direct=diffuse * sympy.Symbol("n_dot_l"))


AWAY = Factor("one_minus_n_dot_v")


def metal(name: str, cosine: sympy.Rational, **reflectances) -> sympy.Expr:
    """What a metal mirrors at an angle, exactly."""
    spectra = {Reflectance(key): sympy.Rational(value) for key, value in reflectances.items()}
    return MODELS[name].reflected.xreplace({n_dot_v: cosine, AWAY: 1 - cosine, **spectra})


@pytest.mark.parametrize("cosine", ["0", "1/7", "3/10", "99/100", "1"])
@pytest.mark.parametrize("f0", ["0", "1/25", "3/5", "1"])
def test_a_metal_mirrors_by_schlicks_formula(cosine, f0):
    # Schlick 1994, eq. (15): R0 + (1 - R0)(1 - cos θ)^5, in fractions.
    x, r0 = Fraction(cosine), Fraction(f0)
    assert Fraction(str(metal("metal", sympy.Rational(cosine), f0=f0))) == r0 + (1 - r0) * (1 - x) ** 5


def test_the_82_degree_term_vanishes_along_the_normal_and_the_edge_and_meets_f82_in_between():
    for f0, at_82 in (("3/5", "1/2"), ("9/10", "99/100"), ("1/10", "0")):
        assert metal("metal_f82", sympy.Integer(1), f0=f0, f82=at_82) == sympy.Rational(f0)
        assert metal("metal_f82", sympy.Integer(0), f0=f0, f82=at_82) == 1
        meeting = metal("metal_f82", sympy.Rational(1, 7), f0=f0, f82=at_82)
        assert float(meeting) == pytest.approx(float(Fraction(at_82)), abs=4e-16)
    # What Schlick has at 1/7 bends nothing.
    same = schlick(sympy.Float(0.6), n_dot_v).xreplace({AWAY: sympy.Rational(6, 7)})
    bent = f82(sympy.Float(0.6), same, n_dot_v) - schlick(sympy.Float(0.6), n_dot_v)
    assert abs(float(bent.xreplace({n_dot_v: sympy.Rational(1, 3), AWAY: sympy.Rational(2, 3)}))) < 1e-15


def test_the_82_degree_terms_weights_are_those_that_make_a_picture_signed():
    # x (1 - x)^6 is largest at 1/7; the weights of f0 and of the constant fall to -0.13.
    x = np.linspace(0, 1, 2001)
    split = monomials(MODELS["metal_f82"].reflected)
    weights = {met: np.broadcast_to(sympy.lambdify([n_dot_v, AWAY], c)(x, 1 - x), x.shape) for met, c in split.items()}
    assert weights["f82",].argmax() == pytest.approx(2000 / 7, abs=1)
    assert weights["f82",].max() == pytest.approx(1, abs=1e-6)
    assert weights["f82",].min() >= 0
    assert weights["f0",].min() == pytest.approx(-0.1267, abs=1e-4)
    assert weights[()].min() == pytest.approx(-0.1268, abs=1e-4)


def test_a_bent_curve_of_equal_reflectances_is_never_below_0_from_0_12_on():
    x = np.linspace(0, 1, 2001)
    for both, dips in ((0.10, True), (0.12, False), (1.0, False)):
        curve = MODELS["metal_f82"].reflected.xreplace({reflectance(name): sympy.Float(both) for name in ("f0", "f82")})
        least = np.min(sympy.lambdify([n_dot_v, AWAY], curve)(x, 1 - x))
        assert (least < 0) == dips, both


def test_a_rough_metals_highlight_is_blinns_lobe_with_schlicks_edge():
    direct, s = MODELS["rough_metal"].direct, parameter("exponent")
    glossy = MODELS["blinn_phong"].direct.subs({diffuse: 0})
    edge = Factor("one_minus_h_dot_v") ** 5
    f0 = reflectance("f0")
    assert sympy.expand(direct * specular - glossy * (f0 + (1 - f0) * edge)) == 0
    assert MODELS["rough_metal"].parameters == {s.name}
    assert MODELS["rough_metal"].sending == frozenset()
    both = stack([MODELS["metal"], MODELS["rough_metal"]])
    assert both.components == {"f0"}
    assert both.factors == {"one_minus_n_dot_v", "one_minus_n_dot_h", "one_minus_h_dot_v", "n_dot_l"}


@pytest.mark.parametrize("wrong", [AWAY, diffuse, parameter("x"), 1 - n_dot_h])
def test_schlick_takes_one_of_the_cosines(wrong):
    with pytest.raises(ValueError, match="none of the cosines n_dot_l"):
        schlick(reflectance("f0"), wrong)
