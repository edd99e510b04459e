"""Fits against random scales that are inside: none is better, with or without pixels that may be left out."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from feedback.judge import around, better, drawn_back, extremes, judge, merit, shared
from feedback.synthetic import palette, system

from symrt.device.inks import load_device
from symrt.feedback import Scale, fit
from symrt.gamut.gamuts import device_gamut
from symrt.spectra.reference import Reference

DEVICE = load_device("dye3-endura-premier")
IMAGE, COLOURS = system(height=8, width=12), palette()
EXPOSURE = 4.0
MIXED = [Scale(name) for name in ("key", "brass", "ice", "deep")]
WITHIN = (0.01, 3.0)
GOALS = ["lightest", "darkest", "closest", "lexicographic", "brightest", "contrast"]


def asked(goal, share, **options):
    gamut = device_gamut(DEVICE, "envelope", "luminance" if goal == "darkest" else "clip")
    usual = {"within": WITHIN, "cap": False, "least_luminance": 0, "reference": Reference("key", exposure=EXPOSURE)}
    return fit(IMAGE, COLOURS, gamut, MIXED, objective=goal, allowed_out=share, **(usual | options))


def question(goal, share, allowed_dark=0.0):
    """The image as judged, what is feasible, a feasible point, and the range in which there may be better ones."""
    judged = judge(IMAGE, COLOURS, device_gamut(DEVICE, "envelope").upper, MIXED, EXPOSURE)
    budget = int(share * len(judged.pixels))

    def few(points):
        return judged.outside(points).sum(axis=1) <= budget

    if goal != "darkest":
        level = shared(judged, WITHIN, budget)
        least = {"lightest": level, "lexicographic": min(1.0, level)}.get(goal, WITHIN[0])
        return judged, few, np.full((1, len(MIXED)), min(1.0, level) * (1 - 1e-12)), (least, WITHIN[1])
    # The darkest image is one that is nowhere above the lightest.
    lightest = judged.point(asked("lightest", share).values)
    black = (DEVICE.samples @ judged.luminance).min()
    counted = (judged.light(np.ones((1, len(MIXED)))) >= black)[0]
    lost = counted & (judged.light(lightest) < black)[0]
    fall = max(0, int(allowed_dark * counted.sum()) - lost.sum())

    def lit(points):
        dark = (judged.light(points) < black) & (counted & ~lost)
        return few(points * (1 - 1e-13)) & (dark.sum(axis=1) <= fall)

    return judged, lit, lightest, (WITHIN[0], lightest)


@cache
def answered(goal, share):
    """What the fit says, and the judge's own view of the question."""
    judged, feasible, anchor, box = question(goal, share)
    return judged, feasible, anchor, box, asked(goal, share)


@pytest.mark.parametrize("share", [0.0, 0.08])
@pytest.mark.parametrize("goal", GOALS)
def test_no_random_scales_inside_are_better(goal, share):
    """Anywhere where the answer is called global; otherwise within a few hundredths."""
    judged, feasible, anchor, box, found = answered(goal, share)
    point, pairs = judged.point(found.values), extremes(judged)
    assert np.array_equal(judged.pixels[judged.outside(point, 1e-13)[0]], np.sort(found.left_out))
    assert len(found.left_out) == int(share * len(judged.pixels))
    random = around(point, box, 1500, sizes=(1e-3, 0.3) if found.optimum == "global" else (1e-4, 0.02))
    inside = drawn_back(random, anchor, feasible)
    assert feasible(inside).sum() >= 1000
    best = merit(goal, point, judged, pairs)
    assert not better(merit(goal, random[feasible(random)], judged, pairs), best).any()
    assert not better(merit(goal, inside[feasible(inside)], judged, pairs), best).any()
    # Many would be better were they inside, and an answer only a little worse would have been beaten.
    assert better(merit(goal, random[~feasible(random)], judged, pairs), best).sum() >= 100
    worse = point**0.9 * anchor**0.1
    assert better(merit(goal, inside[feasible(inside)], judged, pairs), merit(goal, worse, judged, pairs)).any()


@pytest.mark.parametrize(("goal", "short"), [("closest", 0.1), ("brightest", 0.0), ("contrast", 0.0)])
def test_what_is_best_nearby_falls_little_short_of_what_random_scales_find_elsewhere(goal, short):
    """As a share of what leaving pixels out gains: the bound is what was measured, a twelfth for the closest."""
    judged, feasible, anchor, box, found = answered(goal, 0.08)
    assert found.optimum == "local"
    random = around(judged.point(found.values), box, 3000, sizes=(0.03, 0.3))
    inside = drawn_back(random, anchor, feasible)
    pairs = extremes(judged)
    best = merit(goal, inside[feasible(inside)], judged, pairs).max()
    here, none = (merit(goal, judged.point(f.values), judged, pairs)[0, 0] for f in (found, asked(goal, 0.0)))
    assert feasible(inside).sum() >= 2000
    assert best - here <= short * (best - none) + 1e-9 * abs(here)


def compared(goal, judged, found, feasible, anchor, box):
    """Random scales that are feasible and better, and such that are better but not feasible."""
    point = judged.point(found.values)
    random = around(point, box, 1500)
    inside = drawn_back(random, anchor, feasible)
    inside = inside[feasible(inside)]
    assert len(inside) >= 1000
    best = merit(goal, point, judged)
    return better(merit(goal, inside, judged), best), better(merit(goal, random[~feasible(random)], judged), best)


def test_no_random_scales_that_are_physical_are_lighter():
    """No material reflects more than it receives."""
    judged, *_ = question("closest", 0.0)
    found = asked("lightest", 0.0, cap=True, reference=Reference("key", exposure=0.5))
    dim = replace(judged, products=judged.products * 0.5 / EXPOSURE)
    sums = {m: sum(COLOURS[n] for n in COLOURS if n.startswith(f"{m}.")).max() for m in dim.names if m != "key"}
    most = np.array([1 / sums[name] if name in sums else WITHIN[1] for name in dim.names])

    def physical(points):
        return ~dim.outside(points).any(axis=1) & (points <= most).all(axis=1)

    level = min(shared(dim, WITHIN), most.min()) * (1 - 1e-12)
    ahead, unphysical = compared("lightest", dim, found, physical, np.full((1, 4), level), (level, WITHIN[1]))
    assert {why.side for why in found.reasons.values()} >= {"cap"}
    assert not ahead.any()
    assert unphysical.sum() >= 100


def test_no_random_scales_that_keep_enough_luminance_are_closer():
    judged, feasible, _, box, free = answered("closest", 0.0)
    found = asked("closest", 0.0, least_luminance=1.01 * free.luminance)
    given = np.minimum(judged.light(np.ones((1, 4))), 1).mean()

    def bright(points):
        return feasible(points) & (judged.light(points).mean(axis=1) >= 1.01 * free.luminance * given)

    anchor = judged.point(asked("brightest", 0.0).values) * (1 - 1e-12)
    ahead, dark = compared("closest", judged, found, bright, anchor, box)
    assert found.luminance == pytest.approx(1.01 * free.luminance, rel=1e-9)
    assert not ahead.any()
    assert dark.sum() >= 100
