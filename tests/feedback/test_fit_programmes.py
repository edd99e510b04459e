"""Fits against other people's solvers, which see every row of the image at once: all pixels inside."""

from dataclasses import replace

import numpy as np
import pytest
from feedback.judge import better, extremes, judge, merit, shared
from feedback.solvers import (
    climbed,
    fairest,
    gains_of,
    largest_least_ratio,
    largest_ratio,
    rows_of,
    undominated,
)
from feedback.synthetic import few_pixels, palette, system
from scipy import sparse

from symrt.device.inks import load_device
from symrt.feedback import Scale, fit
from symrt.gamut.gamuts import device_gamut
from symrt.spectra.reference import Reference

DEVICE = load_device("dye3-endura-premier")
ENVELOPE = device_gamut(DEVICE, "envelope")
COLOURS, EXPOSURE, WITHIN = palette(), 4.0, (0.01, 5.0)
MIXED = [Scale(name) for name in ("key", "brass", "ice", "deep")]


def asked(goal, image, scales, **options):
    usual = {"within": WITHIN, "cap": False, "least_luminance": 0, "reference": Reference("key", exposure=EXPOSURE)}
    return fit(image, COLOURS, ENVELOPE, scales, objective=goal, **(usual | options))


def affine(seed, pixels=30, scales=5, exposure=EXPOSURE):
    """Random textures of some materials under one light."""
    image = few_pixels(seed, pixels, scales)
    names = [Scale(i.met[0]) for i in image.interactions]
    return image, names, judge(image, COLOURS, ENVELOPE.upper, names, exposure)


@pytest.mark.parametrize("share", [0.0, 0.1])
@pytest.mark.parametrize("seed", range(3))
def test_the_darkest_is_the_fairest_solution_of_linear_programmes(seed, share):
    """Lexicographic min-max, nowhere above the lightest; pixels above black stay so, but for those that may fall."""
    image = few_pixels(seed, 30, 4)
    image = replace(image, G=sparse.csr_array(image.G.toarray() - 1e-3))
    scales = [Scale(i.met[0]) for i in image.interactions]
    judged = judge(image, COLOURS, ENVELOPE.upper, scales, EXPOSURE)
    options = {"black": "luminance", "allowed_dark": share}
    found = judged.point(asked("darkest", image, scales, **options).values)[0]
    lightest = judged.point(asked("lightest", image, scales, **options).values)
    black = (DEVICE.samples @ judged.luminance).min()
    given, light, dark = (judged.light(p)[0] >= black for p in (np.ones((1, 4)), lightest, found[None] * (1 + 1e-12)))
    counted = given & light
    fallen = counted & ~dark
    assert fallen.sum() == max(0, int(share * given.sum()) - (given & ~light).sum())
    rows = ((judged.products @ judged.luminance) * judged.weights) @ judged.degrees
    kept = rows[counted & ~fallen]
    bounds = [(-high, -WITHIN[0]) for high in lightest[0]]
    expected = -fairest(kept, np.full(len(kept), -black), bounds)
    assert len(set(expected.round(6))) > 1
    # HiGHS meets its rows to 1e-7.
    np.testing.assert_allclose(found, expected, rtol=1e-5)


def test_the_darkest_of_pixels_that_bind_together_is_called_the_best_nearby():
    """Two pixels reach black together and one may fall: that it is the second is worse, and is not called best."""
    image = replace(few_pixels(0, 3, 2), G=sparse.csr_array([[1.0, 0.0], [0.0, 1.0], [0.0, 1.5]]))
    same = COLOURS.replace(**{i.met[0]: 0.5 for i in image.interactions})
    scales = [Scale(i.met[0]) for i in image.interactions]
    options = {"objective": "darkest", "black": "luminance", "within": WITHIN, "cap": False}
    found = fit(image, same, ENVELOPE, scales, allowed_dark=0.34, **options)
    assert found.optimum == "local"
    first, second = (found.values[scale.name] for scale in scales)
    assert second == pytest.approx(first / 1.5, rel=1e-9)
    none = fit(image, same, ENVELOPE, scales, **options)
    assert none.optimum == "global"
    assert none.values == pytest.approx(dict.fromkeys(none.values, first), rel=1e-9)


@pytest.mark.parametrize("seed", [0, 1, 4])
def test_the_contrast_of_two_regions_is_that_of_a_linear_programme(seed):
    """A quotient of sums is quasiconcave, so that what is best nearby is best; the last of them is a long way off."""
    image, scales, judged = affine(seed, pixels=12, exposure=2.5)
    order = np.random.default_rng(seed + 100).permutation(12)
    light, dark = order[:4], order[4:8]
    regions = [tuple(np.isin(np.arange(12), region)[None] for region in (light, dark))]
    found = asked("contrast", image, scales, regions=regions, reference=Reference("key", exposure=2.5))
    rows = undominated(rows_of(judged))
    best = largest_ratio(gains_of(judged, light), gains_of(judged, dark), rows, WITHIN)
    values = [merit("contrast", p, judged, [(light, dark)])[0, 0] for p in (judged.point(found.values), best[None])]
    none = merit("contrast", np.ones((1, 5)), judged, [(light, dark)])[0, 0]
    assert values[0] == pytest.approx(values[1], abs=1e-7)
    assert values[1] > none + 0.1


@pytest.mark.parametrize("seed", range(3))
def test_the_least_contrast_of_three_pairs_is_that_of_linear_programmes(seed):
    image, scales, judged = affine(seed, pixels=18)
    parts = np.split(np.random.default_rng(seed).permutation(18), 6)
    pairs = list(zip(parts[:3], parts[3:], strict=True))
    regions = [tuple(np.isin(np.arange(18), region)[None] for region in pair) for pair in pairs]
    found = asked("contrast", image, scales, regions=regions)
    lights, darks = ([gains_of(judged, region) for region in side] for side in zip(*pairs, strict=True))
    best = largest_least_ratio(lights, darks, undominated(rows_of(judged)), WITHIN)
    reached = np.exp(merit("contrast", judged.point(found.values), judged, pairs)[0, 0])
    assert reached == pytest.approx(best, rel=1e-5)
    assert best > np.exp(merit("contrast", np.ones((1, 5)), judged, pairs)[0, 0])


@pytest.mark.parametrize("goal", ["closest", "lexicographic", "brightest", "contrast"])
def test_with_mirrors_and_lights_no_other_solver_gets_further(goal):
    """Sequential quadratic programming with every pixel, from the answer and from other starts that are inside."""
    image = system(height=6, width=8)
    judged = judge(image, COLOURS, ENVELOPE.upper, MIXED, EXPOSURE)
    point, pairs = judged.point(asked(goal, image, MIXED).values), extremes(judged)
    level = shared(judged, WITHIN)
    low = min(1.0, level) if goal == "lexicographic" else WITHIN[0]
    products = judged.products / judged.upper

    def room(y):
        return -np.log(((judged.weights * judged.factors(np.exp(y)[None])[0]) @ products).max(axis=1))

    def value(y):
        return -merit(goal, np.exp(y)[None], judged, pairs)[0, -1]

    random = np.random.default_rng(0)
    starts = [np.log(point[0]) - 0.01, *(np.log(level) - random.uniform(0, 1, (4, 4)))]
    ends = np.exp([climbed(value, room, np.maximum(start, np.log(low)), (low, WITHIN[1])) for start in starts])
    inside = np.array([room(y).min() >= -1e-9 for y in np.log(ends)])
    assert inside.sum() >= 2
    best = merit(goal, point, judged, pairs)
    assert not better(merit(goal, ends[inside], judged, pairs), best, 1e-6).any()
    # The other solver comes to the same end, so that it would have found more.
    assert better(merit(goal, ends[inside], judged, pairs), best - 1e-4 * np.abs(best)).any()
