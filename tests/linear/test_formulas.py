"""A printed formula is the pixel: text, LaTeX, Python, before and after collapse (paper §4)."""

import math
import subprocess
import sys
from dataclasses import replace
from fractions import Fraction

import mpmath
import numpy as np
import pytest
import sympy
from scenes_for_tests import SCENES, every_scene, hall_of_mirrors, mirrors, palettes, small

import symrt as rt
from symrt.linear.formulas import Formula
from symrt.reflection.symbols import Factor, Hat, Light, Reflectance, lobe, n_dot_l, r_dot_v
from symrt.windows import SpectralWindow

DIGITS = 50


def at_50_digits(formula: Formula, spectra: dict[str, float], nm: float = math.nan) -> mpmath.mpf:
    """The formula's value from its float leaves, with nothing rounded on the way, at one wavelength if it asks."""
    leaves = {Factor(name): sympy.Float(value, DIGITS) for name, value in formula.values.items()}
    leaves |= {s: sympy.Float(float(spectra[s.name]), DIGITS) for s in formula.expression.atoms(Light, Reflectance)}
    at = np.array([nm])
    leaves |= {
        s: sympy.Float(float(SpectralWindow.of(s.name).weights(at)[0]), DIGITS) for s in formula.expression.atoms(Hat)
    }
    exact = formula.expression.xreplace({f: sympy.Float(f, DIGITS) for f in formula.expression.atoms(sympy.Float)})
    return sympy.re(exact.xreplace(leaves).evalf(DIGITS))


def in_order_at_50_digits(formula: Formula, palette: rt.Palette, band: int, chains: dict) -> sympy.Float:
    """The same where some reflectances are matrices: products in the order met, as fractions; kept in `chains`."""
    letters = {Factor(name): sympy.Float(value, DIGITS) for name, value in formula.values.items()}
    total = sympy.Integer(0)
    for interaction, coefficient in rt.linear_form(formula.expression).items():
        if interaction not in chains:
            light = [Fraction(x) for x in palette[interaction.light].tolist()]
            for name in interaction.met:
                factor = [Fraction(x) for x in palette[name].ravel().tolist()]
                rows = [factor[k : k + len(light)] for k in range(0, len(factor), len(light))]
                light = (
                    [sum(x * row[j] for x, row in zip(light, rows, strict=True)) for j in range(len(light))]
                    if name in palette.fluorescent
                    else [x * y for x, y in zip(light, factor, strict=True)]
                )
            chains[interaction] = sympy.Rational(light[band].numerator, light[band].denominator)
        exact = coefficient.xreplace({f: sympy.Float(f, DIGITS) for f in coefficient.atoms(sympy.Float)})
        total += exact.xreplace(letters).evalf(DIGITS) * chains[interaction]
    return total


def some_pixels(system: rt.LinearSystem, count: int) -> np.ndarray:
    lit = np.flatnonzero(system.object_pixels)
    return np.random.default_rng(7).choice(lit, size=min(count, lit.size), replace=False)


@pytest.mark.parametrize("name", every_scene())
def test_printed_formula_evaluates_to_the_shaded_pixel(name):
    scene = small(name, 48)
    tree = rt.trace(scene)
    system = rt.collapse(tree)
    for palette in palettes(name).values():
        image = rt.shade(system, palette).values
        interpolation = sum(lengths.error for lengths in system.lengths.values())
        clear = rt.shade(system, palette.replace(dict.fromkeys(system.lengths, 1.0))).values
        band = len(palette.bands) // 2
        spectra = {
            symbol: float(palette[symbol][band]) for symbol in system.symbols if symbol not in palette.fluorescent
        }
        chains: dict = {}
        for pixel in some_pixels(system, 200 // len(palettes(name))):
            y, x = divmod(int(pixel), 48)
            for formula, hats in ((rt.formula(tree, x, y), interpolation), (rt.formula(system, x, y), 0.0)):
                terms = max(1, system.G.indptr[pixel + 1] - system.G.indptr[pixel])
                if palette.fluorescent:
                    # Each term is a sum over the bands that light came from.
                    terms *= len(palette.bands)
                    exact = in_order_at_50_digits(formula, palette, band, chains)
                else:
                    exact = at_50_digits(formula, spectra, palette.bands.centres[band])
                above = sympy.Float(float(image[y, x, band]), DIGITS) - exact
                rounding = max(4, terms) * np.spacing(image[y, x, band])
                # Letters keep each length in glass; of a few nodes pixels are too bright, at most by what is told.
                assert -rounding <= above <= rounding + hats * clear[y, x, band], (name, x, y, formula)


@pytest.mark.parametrize("name", every_scene())
def test_letters_and_linear_form_have_the_same_monomials(name):
    tree = rt.trace(small(name, 24))
    system = rt.collapse(tree)
    for pixel in some_pixels(system, 40):
        y, x = divmod(int(pixel), 24)
        before, after = rt.formula(tree, x, y), rt.formula(system, x, y)
        letters = {Factor(k): sympy.Float(v) for k, v in before.values.items()}
        # Lengths in glass are nodes in the linear form, and letters before: the glass is the same.
        lengths = {d: letters[d] for p in before.expression.atoms(sympy.Pow) for d in p.exp.atoms(Factor)}
        exact = rt.linear_form(before.expression.xreplace(lengths) if lengths else before.expression)
        form = {i: c.xreplace(letters).evalf() for i, c in exact.items()}
        # A highlight far from its peak is smaller than any float: it has no coefficient.
        found = {_glasses(i) for i, c in form.items() if float(c) != 0}
        assert found == {_glasses(i) for i in rt.linear_form(after.expression)}


def _glasses(interaction: rt.Interaction) -> rt.Interaction:
    return replace(interaction, powers=tuple((name, 1.0) for name, _ in interaction.powers))


def test_python_code_runs_and_gives_the_pixel():
    scene = mirrors(model=["phong_plain", "mirror"], exponent=30)
    tree = rt.trace(scene)
    system = rt.collapse(tree)
    spectra = {name: 0.3 + 0.1 * k for k, name in enumerate(system.symbols)}
    for x, y in ((12, 12), (10, 20)):
        for formula in (rt.formula(tree, x, y), rt.formula(system, x, y)):
            namespace: dict = {}
            exec(formula.code("radiance"), namespace)
            arguments = [spectra[name] for name in formula.symbols]
            assert namespace["radiance"](*arguments) == pytest.approx(formula.evaluate(spectra), rel=1e-13)


@pytest.mark.parametrize("name", every_scene())
def test_python_code_gives_every_lit_pixel(name):
    # Away from a highlight the cosine of a lobe is 0, and has no logarithm.
    at_540 = np.array([540.0])
    tree = rt.trace(small(name, 24))
    system = rt.collapse(tree)
    for pixel in some_pixels(system, 60):
        y, x = divmod(int(pixel), 24)
        for formula in (rt.formula(tree, x, y), rt.formula(system, x, y)):
            namespace: dict = {}
            exec(formula.code(), namespace)
            # With a matrix the code takes arrays of all bands, here of one.
            matrices = any(symbol.endswith("fluorescence") for symbol in formula.symbols)
            ones = [np.ones((1,) * (1 + s.endswith("fluorescence"))) if matrices else 1.0 for s in formula.symbols]
            # Glass that bends wavelengths apart asks for one.
            nm = {"nm": 540.0} if formula.expression.atoms(Hat) else {}
            shares = [float(i.window.weights(at_540)[0]) if i.window else 1.0 for i in system.interactions]
            assert namespace["pixel"](*ones, **nm) == pytest.approx((system.G[[pixel], :] @ shares)[0], rel=1e-13)


@pytest.mark.parametrize("exponent", [0, 1])
def test_a_cosine_of_0_has_powers_in_code(exponent):
    namespace: dict = {}
    exec(Formula(Light("sun") * lobe(r_dot_v, exponent), {"one_minus_r_dot_v": 1.0}).code(), namespace)
    assert namespace["pixel"](2.0) == 2.0 * 0.0**exponent


def test_floats_stay_whole_in_code_and_lose_digits_in_text_only():
    third = Formula(sympy.Float(1 / 3) * Light("sun") * Reflectance("sea.diffuse"))
    assert repr(1 / 3) in third.code()
    assert third.text() == "0.3333*sun*sea.diffuse"
    assert third.text(digits=2) == "0.33*sun*sea.diffuse"
    assert third.latex(digits=2) == r"0.33\,\mathrm{sun}\,\mathrm{sea}_{\mathrm{diffuse}}"


def test_a_long_formula_is_truncated_on_request_and_says_so():
    long = Formula(
        sympy.Add(*(sympy.Float(k + 0.5) * Light(f"l{k}") * Reflectance("sea.diffuse") for k in range(5000)))
    )
    assert "4997 more terms" in long.text(terms=3)
    assert long.text().count("sea.diffuse") == 5000
    with pytest.raises(ValueError, match="at least one"):
        long.text(terms=0)


def test_names_that_would_collide_in_python_are_kept_apart():
    colliding = Light("sea_diffuse") * Reflectance("sea.diffuse") * Light("lambda") * Light("math")
    code = Formula(colliding).code()
    compile(code, "formula", "exec")
    arguments = code.split("(")[1].split(")")[0].split(", ")
    assert len(set(arguments)) == 4
    assert not {"lambda", "math"} & set(arguments)


def test_a_lobe_prints_as_a_power_and_computes_from_one_minus_its_cosine():
    shiny = Formula(Light("sun") * lobe(r_dot_v, 60) * n_dot_l, {"one_minus_r_dot_v": 0.25, "n_dot_l": 0.5})
    assert shiny.text() == "sun*n_dot_l*r_dot_v**60"
    assert "r_dot_v = 0.75" in str(shiny)
    assert "lobe(r_dot_v, 60)" in shiny.code()
    assert "one_minus" not in shiny.code() + str(shiny)
    assert shiny.letters == {"r_dot_v": 0.75, "n_dot_l": 0.5}
    assert shiny.evaluate({"sun": 2.0}) == pytest.approx(0.75**60, rel=1e-14)


def test_one_minus_a_cosine_reads_as_that_and_computes_from_its_own_letter():
    tree = rt.trace(mirrors(model=["metal", "rough_metal"], depth=1, exponent=30), window=(14, 13, 15, 14))
    ball = rt.formula(tree, 0, 0)
    assert "(ball.f0 + (1 - n_dot_v)**5*(1 - ball.f0))*" in ball.text()
    assert "(ball.f0 + (1 - h_dot_v)**5*(1 - ball.f0))*n_dot_h**30" in ball.text()
    assert "one_minus" not in str(ball)
    assert r"\left(1 - (n \cdot v)\right)^{5}" in ball.latex()
    spectra = dict(zip(ball.symbols, (2.0, 0.1, 0.6, 0.3), strict=True))
    namespace = {}
    exec(ball.code(), namespace)
    assert namespace["pixel"](*spectra.values()) == pytest.approx(ball.evaluate(spectra), rel=1e-15)
    # A cosine that is both raised to a power by a lobe and taken from 1 has one letter in code.
    both = Formula(Light("sun") * lobe(r_dot_v, 60) * Factor("one_minus_r_dot_v"), {"one_minus_r_dot_v": 0.25})
    assert "one_minus_r_dot_v*lobe(1 - Decimal(one_minus_r_dot_v), 60)" in both.code()
    exec(both.code(), namespace)
    assert namespace["pixel"](2.0) == pytest.approx(2 * 0.75**60 / 4, rel=1e-15)


def test_a_missing_spectrum_is_named():
    with pytest.raises(ValueError, match=r"no value for sea\.diffuse"):
        Formula(Light("sun") * Reflectance("sea.diffuse")).evaluate({"sun": 1.0})


def test_a_scenes_own_formula_traces_one_pixel():
    scene = small("first", 64)
    tree = rt.trace(scene)
    for x, y in ((32, 28), (0, 0), (30, 40)):
        assert rt.formula(scene, x=x, y=y) == rt.formula(tree, x=x, y=y)


@pytest.mark.parametrize(("x", "y"), [(-1, 0), (0, -1), (24, 0), (0, 24)])
def test_a_pixel_outside_the_image_is_refused(x, y):
    tree = rt.trace(small("first", 24))
    for source in (tree, rt.collapse(tree), small("first", 24)):
        with pytest.raises(ValueError, match="outside the image"):
            rt.formula(source, x, y)


def test_a_light_that_is_named_like_anothers_bounce_has_letters_of_its_own():
    # Where the light sun falls one bounce deep would be sun_2, too.
    lights = [rt.DirectionalLight("sun", (-1, -2, -1)), rt.DirectionalLight("sun_2", (1, -1, -2))]
    scene = replace(mirrors(model=["lambert", "mirror"], depth=1), lights=lights)
    tree = rt.trace(scene, window=(8, 12, 16, 17))
    spectra = {symbol: 0.3 + 0.05 * k for k, symbol in enumerate(scene.symbols)}
    image = rt.shade(rt.collapse(tree), rt.Palette(rt.RGB, spectra)).values
    alike = 0
    for y, x in np.ndindex(5, 8):
        formula = rt.formula(tree, x, y)
        alike += "n_dot_l_sun_2_" in formula.values
        assert formula.evaluate(spectra) == pytest.approx(image[y, x, 0], rel=1e-13)
    assert alike > 3


def test_every_mirror_bounce_has_letters_of_its_own():
    tree = rt.trace(hall_of_mirrors(depth=3))
    formula = rt.formula(tree, 8, 8)
    assert {"n_dot_l", "n_dot_l_2", "n_dot_l_3", "n_dot_l_4"} <= set(formula.values)
    assert "front.mirror" in formula.text()


def test_as_many_bounces_as_can_be_printed_are_and_more_are_refused():
    along = rt.Camera(position=(0, 0, 0), target=(0, 0, -1), width=2, height=2, field_of_view=0.02)
    tree = rt.trace(replace(hall_of_mirrors(64, tilt=0.0), camera=along))
    letters, linear = rt.formula(tree, 0, 0), rt.formula(rt.collapse(tree), 0, 0)
    half = dict.fromkeys(letters.symbols, 0.5)
    assert letters.evaluate(half) == pytest.approx(linear.evaluate(half), rel=1e-13)
    assert letters.text().count("lamp") == letters.latex().count("lamp}") > 64
    with pytest.raises(ValueError, match=r"65 bounces .* formula\(collapse\(tree\), x, y\)"):
        rt.formula(rt.trace(replace(hall_of_mirrors(65, tilt=0.0), camera=along)), 0, 0)


def test_supersampled_letters_stay_apart_and_average():
    scene = small("first", 8, samples=2)
    tree = rt.trace(scene)
    system = rt.collapse(tree)
    formula = rt.formula(tree, 4, 4)
    spectra = dict.fromkeys(system.symbols, 1.0)
    assert len(rt.formula(system, 4, 4).symbols) > 0
    assert formula.evaluate(spectra) == pytest.approx(rt.formula(system, 4, 4).evaluate(spectra), rel=1e-14)
    assert any(name.endswith("_s3") for name in formula.values)


@pytest.mark.parametrize("seed", ["1", "20"])
def test_the_order_of_terms_is_the_same_for_every_hash_seed(seed):
    script = (
        "import symrt as rt; from dataclasses import replace;"
        f"s = rt.load_scene({str(SCENES / 'first.toml')!r});"
        "s = replace(s, camera=replace(s.camera, width=16, height=16));"
        "t = rt.trace(s); print(rt.formula(t, 8, 6)); print(rt.formula(rt.collapse(t), 8, 6).latex())"
    )
    runs = [
        subprocess.run(
            [sys.executable, "-c", script],
            env={"PYTHONHASHSEED": s, "PYTHONPATH": str(SCENES.parent)},
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for s in (seed, "0")
    ]
    assert runs[0] == runs[1] != ""


def test_fsum_of_the_linear_form_is_the_pixel():
    system = rt.collapse(rt.trace(hall_of_mirrors(depth=4)))
    palette = rt.Palette(
        bands=rt.wavelengths(500, 520, 10), spectra={s: 0.7 if "." in s else 1.3 for s in system.symbols}
    )
    image = rt.shade(system, palette).values
    for pixel in some_pixels(system, 50):
        row = slice(system.G.indptr[pixel], system.G.indptr[pixel + 1])
        gamma = [1.3 * 0.7 ** system.interactions[j].degree for j in system.G.indices[row]]
        found = math.fsum(g * c for g, c in zip(system.G.data[row], gamma, strict=True))
        assert image.reshape(-1, 3)[pixel, 0] == pytest.approx(found, rel=1e-14)


def sun_on(*terms: tuple[float, str]) -> Formula:
    return Formula(sympy.Add(*(sympy.Float(g) * Light("sun") * Reflectance(f"{name}.diffuse") for g, name in terms)))


def test_terms_come_largest_first_and_equal_ones_by_name():
    pixel = sun_on((0.25, "b"), (0.5, "c"), (-0.75, "d"), (0.25, "a"))
    assert pixel.text() == "-0.75*sun*d.diffuse + 0.5*sun*c.diffuse + 0.25*sun*a.diffuse + 0.25*sun*b.diffuse"
    assert pixel.text(terms=1) == "-0.75*sun*d.diffuse + … (3 more terms)"
    nested = Formula(
        Light("sun")
        * (Reflectance("a.diffuse") * Factor("n_dot_l_1") + Reflectance("b.diffuse") * Factor("n_dot_l_2")),
        {"n_dot_l_1": 0.1, "n_dot_l_2": 0.9},
    )
    assert nested.text() == "sun*(b.diffuse*n_dot_l_2 + a.diffuse*n_dot_l_1)"
    assert nested.latex().index("b") < nested.latex().index("a}_")


def test_terms_that_do_not_show_in_the_pixel_are_counted_but_stay_in_code_and_value():
    pixel = sun_on((0.5, "a"), (3e-321, "b"), (1e-12, "c"))
    assert pixel.text() == "0.5*sun*a.diffuse + … (2 terms below 1e-09 of the pixel)"
    assert "2 terms below" in pixel.latex()
    assert "3e-321" in pixel.code()
    assert pixel.evaluate({"sun": 1.0, "a.diffuse": 0.0, "b.diffuse": 0.0, "c.diffuse": 1.0}) == 1e-12
    assert sun_on((0.5, "a"), (1e-300, "b")).text(terms=1).endswith("(1 term below 1e-09 of the pixel)")


def test_a_factor_of_1_is_not_printed():
    assert sun_on((1.0, "a")).text() == "sun*a.diffuse"
    assert sun_on((0.999999, "a"), (-1.0, "b")).text() == "-sun*b.diffuse + sun*a.diffuse"
    assert "1" not in sun_on((1.0, "a"), (0.99999, "b")).latex()
    tree = rt.trace(mirrors(model="lambert"))
    assert "1*" not in rt.formula(rt.collapse(tree), 12, 18).text()


def test_a_pure_mirror_has_no_letters_that_its_formula_does_not_hold():
    scene = mirrors(model="mirror")
    tree = rt.trace(scene)
    for pixel in some_pixels(rt.collapse(tree), 60):
        y, x = divmod(int(pixel), tree.width)
        pixel_formula = rt.formula(tree, x, y)
        held = {symbol.name for symbol in pixel_formula.expression.free_symbols if isinstance(symbol, Factor)}
        assert set(pixel_formula.values) == held
        # What text and Python call a letter is the same.
        for letter in pixel_formula.letters:
            assert f"{letter} = " in pixel_formula.code()
            assert letter in str(pixel_formula)


@pytest.mark.parametrize("exponent", [40, 1e5, 1e7])
@pytest.mark.parametrize("one_minus", [3e-17, 1.234567e-9, 2e-4])
def test_code_of_a_lobe_is_right_to_the_last_digit(one_minus, exponent):
    namespace: dict = {}
    exec(Formula(Light("sun") * lobe(r_dot_v, exponent), {"one_minus_r_dot_v": one_minus}).code(), namespace)
    with mpmath.workdps(DIGITS):
        true = (1 - mpmath.mpf(one_minus)) ** mpmath.mpf(exponent)
        assert abs(mpmath.mpf(namespace["pixel"](1.0)) - true) <= 0.51 * np.spacing(float(true))


def test_a_formula_of_3000_terms_compiles_and_is_evaluated():
    # A chain of more than 2,984 additions is nested too deep for Python's compiler.
    random = np.random.default_rng(3)
    g = random.uniform(0.1, 1, 3000)
    pixel = sun_on(*((value, f"m{k}") for k, value in enumerate(g)))
    namespace: dict = {}
    code = pixel.code()
    exec(code, namespace)
    assert "math.fsum((" in code
    spectra = dict.fromkeys(pixel.symbols, 0.5)
    true = math.fsum(0.25 * g)
    assert namespace["pixel"](*[0.5] * 3001) == pytest.approx(true, rel=1e-15)
    assert pixel.evaluate(spectra) == pytest.approx(true, rel=1e-15)
    bands = pixel.evaluate(spectra | {"sun": np.array([0.5, 1.0])})
    np.testing.assert_allclose(bands, [true, 2 * true], rtol=1e-13)


@pytest.mark.parametrize(("x", "y", "named"), [(10.5, 10, "x = 10.5"), (10, "3", "y = '3'"), (True, 1, "x = True")])
def test_a_pixel_that_is_no_whole_number_is_refused(x, y, named):
    tree = rt.trace(small("first", 24))
    for source in (tree, rt.collapse(tree), small("first", 24)):
        with pytest.raises(ValueError, match=f"{named}: a pixel's .* is a whole number"):
            rt.formula(source, x, y)


def test_what_has_no_formula_says_what_has():
    with pytest.raises(TypeError, match="formula of a str, 'globe': give a Scene, a RayTree or a LinearSystem"):
        rt.formula("globe", 1, 1)
