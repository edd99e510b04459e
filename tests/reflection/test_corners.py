"""Sums that bound what a surface sends on, against its formula at random cosines and reflectances."""

from dataclasses import replace

import numpy as np
import pytest
import sympy
from scenes_for_tests import camera, mirrors

import symrt as rt
from symrt.reflection import f82, mirror, n_dot_v, parameter, reflectance
from symrt.reflection.corners import corners
from symrt.reflection.symbols import Factor

f0, edge = reflectance("f0"), reflectance("edge")
grazing = Factor("one_minus_n_dot_v")
FORMULAS = {
    "constant": mirror / 3,
    "schlick": f0 + (1 - f0) * grazing**5,
    "edge": f0 * (1 - grazing**5) + edge * grazing**5,
    "signed": f0 + (1 - f0) * grazing**5 - edge * n_dot_v * grazing**6 / 2,
    "two": (1 - n_dot_v) * mirror + n_dot_v * (1 - grazing) * edge,
    "parameter": parameter("gloss") * mirror + (1 - parameter("gloss")) * edge,
    "no polynomial": sympy.sqrt(1 - n_dot_v) * mirror,
    "float": 0.1 * mirror + 0.2 * edge,
    "f82": f82(f0, edge, n_dot_v),
    "tent": 4 * mirror * n_dot_v * (1 - n_dot_v) - mirror**2 * n_dot_v**3,
}


@pytest.mark.parametrize("name", FORMULAS)
def test_no_sum_is_ever_passed(name):
    formula, random = FORMULAS[name], np.random.default_rng(3)
    symbols = sorted(formula.free_symbols, key=str)
    values = random.uniform(0, 1, (len(symbols), 3000)) ** random.choice([0.2, 1, 5], (len(symbols), 3000))
    values[:, :40] = np.maximum(np.round(values[:, :40]), 1e-300)
    values[[s.name == "gloss" for s in symbols]] = 0.25
    # A cosine and 1 − cosine belong to one angle.
    if (angle := [s.name in ("n_dot_v", "one_minus_n_dot_v") for s in symbols]).count(True) == 2:
        values[angle] = [values[angle][0], 1 - values[angle][0]]
    size = np.abs(np.broadcast_to(sympy.lambdify(symbols, formula)(*values), 3000))
    known = {s.name: row for s, row in zip(symbols, values, strict=True)}
    sums = [
        sum(c * np.prod([np.ones(3000), *(known[n] for n in met)], axis=0) for met, c in shares)
        for shares in corners(formula, {"gloss": (0.25, 0.25)})
    ]
    assert np.all(size <= np.max(sums, axis=0) * (1 + 1e-12))


def test_what_is_mirrored_or_let_through_is_no_more_than_all():
    assert corners(FORMULAS["schlick"], {}) == (((("f0",), 1.0),), (((), 1.0),))
    assert corners(FORMULAS["edge"], {}) == (((("f0",), 1.0),), ((("edge",), 1.0),))
    assert corners(sympy.Integer(0), {}) == ()


def test_the_terms_of_a_bent_curve_are_held_against_each_other():
    # Metals whose F82 is at most Schlick's send on at most everything, although its weight is 2.5 in one corner.
    for normal, at_82 in ((1.0, 1.0), (0.9, 0.88), (0.55, 0.57), (0.4, 0.67)):
        known = {"f0": normal, "edge": at_82}
        sums = [
            sum(c * np.prod([known[name] for name in met]) for met, c in shares)
            for shares in corners(FORMULAS["f82"], {})
        ]
        assert max(sums) == pytest.approx(1.0, abs=1e-15)


@pytest.mark.parametrize("share", [0.5, 1.0])
def test_a_perfect_mirror_leaves_the_certificate_finite_and_true(share):
    # What a mirror sends on comes from the floor in the end, however often it was mirrored.
    palette = rt.Palette(rt.RGB, {"sun": 2.0, "sky": 0.2, "ball.mirror": share, "floor.diffuse": 0.6})
    balls = [rt.Sphere(centre=(x, 0, 0), radius=1, material="ball") for x in (-1.05, 1.05)]
    base = mirrors(model="mirror")
    scene = replace(base, shapes=[*balls, base.shapes[1]], camera=camera(16))
    few, many = (rt.shade(rt.collapse(rt.trace(replace(scene, depth=depth))), palette) for depth in (1, 12))
    missing = np.abs(many.values - few.values).max()
    assert 0 < missing <= few.cut_off.max() < np.inf
