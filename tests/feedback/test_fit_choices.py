"""Which pixels to leave out: every choice tried in turn, each solved by somebody else with all of its rows."""

from itertools import combinations

import numpy as np
import pytest
from feedback.judge import better, judge, merit
from feedback.solvers import fairest, filled, gains_of, largest, largest_ratio, nearest, rows_of, undominated
from feedback.synthetic import few_pixels, palette

from symrt.device.inks import load_device
from symrt.feedback import Scale, fit
from symrt.gamut.gamuts import device_gamut
from symrt.spectra.reference import Reference

DEVICE = load_device("dye3-endura-premier")
ENVELOPE = device_gamut(DEVICE, "envelope")
COLOURS, EXPOSURE, WITHIN = palette(), 4.0, (0.01, 5.0)
MORE = pytest.mark.exhaustive


def question(seed, pixels, scales):
    """A few pixels with textures of some materials; two regions of them."""
    image = few_pixels(seed, pixels, scales)
    names = [Scale(i.met[0]) for i in image.interactions]
    order = np.random.default_rng(seed + 100).permutation(pixels)
    pair = order[: pixels // 3], order[pixels // 3 : 2 * pixels // 3]
    return image, names, judge(image, COLOURS, ENVELOPE.upper, names, EXPOSURE), pair


def asked(goal, image, scales, pair, budget):
    masks = [tuple(np.isin(np.arange(image.width), region)[None] for region in pair)]
    options = {"regions": masks} if goal == "contrast" else {}
    options |= {"within": WITHIN, "cap": False, "least_luminance": 0, "reference": Reference("key", exposure=EXPOSURE)}
    return fit(image, COLOURS, ENVELOPE, scales, objective=goal, allowed_out=(budget + 0.1) / image.width, **options)


def solved(goal, judged, rows, pair):
    """The best scales for some rows."""
    if goal == "lightest":
        return filled(rows, WITHIN)
    if goal == "brightest":
        return largest(gains_of(judged), rows, WITHIN)
    if goal == "contrast":
        return largest_ratio(*(gains_of(judged, region) for region in pair), rows, WITHIN)
    level = min(1.0, filled(rows, WITHIN).min()) if goal == "lexicographic" else WITHIN[0]
    return nearest(rows, (level, WITHIN[1]))


def gap(goal, seed, pixels=8, scales=4, budget=2):
    """How far the answer falls short of the best of all choices, as a share of what leaving out gains; and its kind."""
    image, names, judged, pair = question(seed, pixels, scales)
    found = asked(goal, image, names, pair, budget)
    point = judged.point(found.values)
    assert judged.outside(point, 1e-13).sum() <= budget
    rows = rows_of(judged)
    choices = [np.delete(rows, out, axis=0) for out in combinations(range(pixels), budget)]
    points = np.array([solved(goal, judged, undominated(kept), pair) for kept in [rows, *choices]])
    merits, here = merit(goal, points, judged, [pair]), merit(goal, point, judged, [pair])
    # SLSQP and HiGHS meet their rows to 1e-7.
    none, ahead = merits[0], better(merits, here, 1e-6)
    assert not ahead[0]
    if not ahead.any():
        assert not better(here, merits[np.lexsort(merits.round(9).T[::-1])[-1]], 1e-6).any()
        return 0.0, found.optimum
    best = merits[ahead, 0].max()
    return float((best - here[0, 0]) / (best - none[0])), found.optimum


@pytest.mark.parametrize("goal", ["lightest", "lexicographic"])
def test_where_all_scales_move_together_no_choice_is_better(goal):
    for seed in range(4):
        assert gap(goal, seed) == (0.0, "global")
    assert gap(goal, 4, pixels=12, scales=5, budget=1) == (0.0, "global")


@pytest.mark.parametrize(
    ("goal", "seed", "most"),
    [
        *(("brightest", seed, most) for seed, most in ((0, 0.0), (34, 0.05))),
        *(("closest", seed, most) for seed, most in ((0, 0.0), (16, 0.02), (36, 0.04))),
        ("contrast", 0, 0.0),
        *(
            pytest.param(goal, seed, 0.0, marks=MORE)
            for goal, seed in (("brightest", 17), ("brightest", 32), ("contrast", 1))
        ),
    ],
)
def test_otherwise_the_best_nearby_is_as_a_rule_the_best_of_all_choices(goal, seed, most):
    """Of 40 brightest 39 were, of 40 closest 38, of 24 contrasts all; the worst of each is among these."""
    short, optimum = gap(goal, seed)
    assert short <= most
    assert optimum == "local"


@pytest.mark.parametrize("seed", range(3))
def test_the_darkest_lets_fall_the_pixels_whose_fall_helps_most(seed):
    """Every choice of pixels above black that may fall, each a lexicographic min-max below the lightest by HiGHS."""
    image, names, judged, _ = question(seed, 8, 3)
    options = {"within": WITHIN, "cap": False, "reference": Reference("key", exposure=EXPOSURE), "black": "luminance"}
    options |= {"allowed_out": 0.13, "allowed_dark": 0.4}
    found = fit(image, COLOURS, ENVELOPE, names, objective="darkest", **options)
    lightest = judged.point(fit(image, COLOURS, ENVELOPE, names, objective="lightest", **options).values)
    black = (DEVICE.samples @ judged.luminance).min()
    given, counted = (judged.light(point)[0] >= black for point in (np.ones((1, 3)), lightest))
    fall = int(0.4 * given.sum()) - (given & ~counted).sum()
    light = ((judged.products @ judged.luminance) * judged.weights)[given & counted] @ judged.degrees
    bounds = [(-high, -WITHIN[0]) for high in lightest[0]]
    kept = [np.delete(light, out, axis=0) for out in combinations(range(len(light)), fall)]
    points = [-fairest(rows, np.full(len(rows), -black), bounds) for rows in kept]
    assert fall >= 1
    here = merit("darkest", judged.point(found.values), judged)
    merits = merit("darkest", np.array(points), judged)
    assert found.optimum == "global"
    assert not better(merits, here, 1e-6).any()
    assert not better(here, merits[np.lexsort(merits.round(9).T[::-1])[-1]], 1e-6).any()
    assert len(np.unique(merits.round(6), axis=0)) > 1
