"""Floats reach the functions made of expressions with every bit they had."""

import numpy as np
import pytest
import sympy

import symrt as rt
from symrt.linear.functions import function_of
from symrt.reflection.symbols import Factor, lobe_value


def test_no_bit_of_a_float_is_lost():
    draws = np.random.default_rng(3)
    numbers = (draws.uniform(-1, 1, 500) * 10.0 ** draws.uniform(-300, 300, 500)).tolist()
    letter = Factor("n_dot_l")
    assert function_of([letter], [letter * sympy.Float(x) for x in numbers], lobe_value)(1.0) == numbers


def test_an_exponent_keeps_its_bits():
    lobe = rt.lobe(Factor("r_dot_v"), sympy.Float(1e7 / 3))
    compiled = function_of(sorted(lobe.free_symbols, key=str), [lobe], lobe_value)
    assert compiled(1e-7) == [lobe_value(1e-7, 1e7 / 3)]


@pytest.mark.parametrize("name", ["first", "spheres", "globe"])
def test_a_formula_evaluates_to_the_shaded_pixel(name):
    scene, palette = rt.load_scene(name), next(iter(rt.load_palettes(name).values()))
    system = rt.render(scene, progress=False)
    image = rt.shade(system, palette).values
    rows = np.diff(system.G.indptr)
    spectra = {symbol: palette[symbol][1] for symbol in system.symbols}
    for pixel in np.random.default_rng(5).choice(np.flatnonzero(rows), 40, replace=False):
        y, x = divmod(int(pixel), system.width)
        shaded = image[y, x, 1]
        error = abs(rt.formula(system, x, y).evaluate(spectra) - shaded)
        assert error <= max(4, rows[pixel]) * np.spacing(shaded), (x, y)
