"""The pairs of two parameters said to keep an image inside are those that shading pair by pair finds."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from feedback.synthetic import BANDS, awkward, palette, system
from scipy import sparse
from scipy.spatial import ConvexHull, HalfspaceIntersection

import symrt as rt
from symrt.feedback.caps import above_one
from symrt.feedback.joint.joint_region import joint_region
from symrt.feedback.parameters import moved
from symrt.spectra.display import luminance_weights

NARROW = 1e-9
"""Pairs nearer than this to where an interval ends are not decided by brute force."""


@cache
def gamut(model="envelope", black="clip"):
    return rt.device_gamut(rt.load_device("dye3-endura-premier"), model, black)


def reflectance(image, colours, white, pair, parameters):
    """Every pixel at a pair of values, shaded anew; the white is the one of the palette given."""
    for parameter, value in zip(parameters, pair, strict=True):
        colours = moved(image, colours, parameter, value)
    return rt.shade(image, colours).values.reshape(-1, 36) / white, colours


def outside(r, limit, lit):
    """Pixels beyond an upper bound by more than rounding."""
    return (r > limit * (1 + 1e-12)).any(axis=1) & lit


CASES = [
    (rt.Scale("ice"), rt.Scale("brass")),
    (rt.Scale("brass.diffuse"), rt.Scale("brass.mirror")),
    (rt.Scale("key"), rt.Exposure()),
    (rt.Scale("brass"), rt.Blend("deep", "ice")),
    (rt.Blend("deep", "ice"), rt.Scale("brass")),
    (rt.Blend("mountain", "shelf"), rt.Blend("lowland", "shelf")),
    (rt.Scale("brass"), rt.Scale("brass.specular")),
]


def exposure_of(parameters):
    """Blends make little lighter: they are asked for at an exposure at which some picture is outside."""
    return 3.0 if all(isinstance(one, rt.Blend) for one in parameters) else 1.1


@pytest.mark.parametrize("cap", [False, True])
@pytest.mark.parametrize("parameters", CASES, ids=lambda pair: " x ".join(map(str, pair)))
def test_a_pair_on_a_line_is_inside_exactly_if_its_picture_is(parameters, cap):
    image, colours = system(8, 8, seed=4), palette(seed=4)
    seen = rt.Reference(exposure=exposure_of(parameters))
    found = joint_region(image, colours, gamut(), *parameters, steps=4, cap=cap, reference=seen, progress=False)
    white, lit = seen.white(image, colours) / seen.exposure, image.object_pixels
    left_out = np.zeros(len(lit), dtype=bool)
    left_out[[*found.untouched_outside, *found.unfixable]] = True
    random = np.random.default_rng(5)
    low, high = found.within[1]
    decided, kinds = 0, set()
    for value, intervals in zip(found.values, found.intervals, strict=True):
        ends = np.array(intervals).ravel()
        tried = [*random.uniform(low, high, 4), *ends, *(ends * (1 - 1e-6)), *(ends * (1 + 1e-6))]
        for t in tried:
            if not low <= t <= high or (0 < np.abs(ends - t).min(initial=1) < NARROW):
                continue
            r, then = reflectance(image, colours, white, (value, t), parameters)
            physical = not cap or not above_one(then, symbols_of(image, colours, parameters))
            inside = not outside(r, gamut().upper, lit & ~left_out).any() and physical
            claimed = any(a <= t <= b for a, b in intervals)
            assert claimed <= inside, (value, t)  # what is claimed holds
            if t not in ends:
                assert claimed == inside, (value, t)
            decided += 1
            kinds.add(inside)
    assert decided > 30
    assert kinds == {True, False}


def symbols_of(image, colours, parameters):
    """The spectra that either parameter changes."""
    changed = [moved(image, colours, parameter, 0.37) for parameter in parameters]
    return [name for name in colours if any((after[name] != colours[name]).any() for after in changed)]


@pytest.mark.parametrize("parameters", CASES, ids=lambda pair: " x ".join(map(str, pair)))
def test_the_share_outside_is_counted_pixel_by_pixel(parameters):
    image, colours = system(8, 8, seed=2), palette(seed=2)
    seen = rt.Reference(exposure=exposure_of(parameters))
    found = joint_region(image, colours, gamut(), *parameters, steps=4, reference=seen, progress=False)
    white, lit = seen.white(image, colours) / seen.exposure, image.object_pixels
    for i, value in enumerate(found.values):
        for j, t in enumerate(found.across):
            r, _ = reflectance(image, colours, white, (value, t), parameters)
            assert found.outside[i, j] == pytest.approx(outside(r, gamut().upper, lit).sum() / lit.sum(), abs=1e-12)
    assert found.outside.max() > 0


def test_awkward_systems_keep_what_is_promised():
    checked = 0
    for seed in range(8):
        image, colours, materials = awkward(seed)
        one, other = rt.Scale(materials[0]), rt.Scale(materials[1])
        found = joint_region(image, colours, gamut("unit"), one, other, steps=4, cap=False, progress=False)
        white, lit = rt.Reference().white(image, colours), image.object_pixels.copy()
        lit[[*found.untouched_outside, *found.unfixable]] = False
        assert np.isfinite(found.outside).all()
        for value, intervals in zip(found.values, found.intervals, strict=True):
            for t in np.array(intervals).ravel():
                r, _ = reflectance(image, colours, white, (value, t), (one, other))
                assert (r[lit] <= 1 + 1e-13).all()
                checked += 1
    assert checked > 30


def test_a_line_at_the_palette_given_is_the_range_of_the_other_alone():
    image, colours = system(12, 12, seed=1), palette(seed=1)
    seen = rt.Reference(exposure=0.8)
    for black in ("clip", "luminance", "strict"):
        asked = gamut(black=black)
        found = joint_region(
            image, colours, asked, rt.Scale("ice"), rt.Scale("key"), reference=seen, steps=5, progress=False
        )
        alone = rt.feasible(image, colours, asked, rt.Scale("key"), reference=seen)
        line = found.intervals[found.values.tolist().index(1.0)]
        assert len(alone.unfixable) == len(found.unfixable) == 0
        np.testing.assert_allclose(line, alone.intervals, rtol=1e-13)
        assert str(found.reasons[found.values.tolist().index(1.0)][0][1]) == str(alone.reasons[0][1])


def test_pixels_that_may_be_outside_widen_the_region_as_much_as_the_range():
    image, colours = system(12, 12, seed=3), palette(seed=3)
    strict, lax = (
        joint_region(
            image, colours, gamut(), rt.Scale("ice"), rt.Scale("key"), allowed_out=share, steps=9, progress=False
        )
        for share in (0.0, 0.2)
    )
    alone = rt.feasible(image, colours, gamut(), rt.Scale("key"), allowed_out=0.2)
    at = lax.values.tolist().index(1.0)
    np.testing.assert_allclose(lax.intervals[at], alone.intervals, rtol=1e-13)
    assert lax.share > strict.share > 0


@pytest.mark.parametrize("model", ["monitor", "colorimetric", "hull"])
def test_any_gamut_contains_every_pixel_where_the_region_says_so(model):
    image, colours = system(4, 4, seed=3), palette(seed=3)
    device = "crt-brainard" if model == "monitor" else "dye3-endura-premier"
    asked = rt.device_gamut(rt.load_device(device, BANDS), model)
    if model == "hull":  # a grey that prints can be mixed to
        colours = colours.replace({"lowland.diffuse": 0.6 * asked.device.white})
    parameters = rt.Scale("key"), rt.Scale("lowland")
    mask = rt.pixels_of(image, "lowland")
    seen = rt.Reference(exposure=1.5)
    found = joint_region(
        image, colours, asked, *parameters, within=((0.5, 2), (0.05, 2)), steps=3, mask=mask, reference=seen, cap=False
    )
    white = seen.white(image, colours) / seen.exposure
    under = asked.under(white * seen.exposure)
    first = rt.shade(image, colours).values.reshape(-1, 36) / white
    weights = luminance_weights(BANDS) * white
    black = 0.0 if model == "monitor" else (asked.device.samples @ weights).min() / weights.sum()
    # Pixels darker than the device's black print as it and are not asked about.
    left_in = mask.ravel() & image.object_pixels & (first @ weights / weights.sum() >= black)
    assert found.objects == left_in.sum()
    left_in[[*found.untouched_outside, *found.unfixable]] = False
    random = np.random.default_rng(1)
    kinds = set()
    for value, intervals in zip(found.values, found.intervals, strict=True):
        ends = np.array(intervals).ravel()
        for t in [*random.uniform(*found.within[1], 6), *(ends * (1 - 1e-4)), *(ends * (1 + 1e-4))]:
            if found.within[1][0] <= t <= found.within[1][1]:
                claimed = any(a <= t <= b for a, b in intervals)
                r, _ = reflectance(image, colours, white, (value, t), parameters)
                assert claimed == under.contains(r[left_in]).all(), (value, t)
                kinds.add(claimed)
    assert kinds == {True, False}


def test_a_mask_asks_about_some_pixels_only():
    image, colours = system(12, 12, seed=3), palette(seed=3)
    parameters, ask = (rt.Scale("ice"), rt.Scale("key")), {"steps": 9, "progress": False}
    mask = rt.pixels_of(image, "ice")
    masked = joint_region(image, colours, gamut(), *parameters, mask=mask, **ask)
    part = replace(image, G=image.G.multiply(mask.reshape(-1, 1)).tocsr())
    part.G.eliminate_zeros()
    alone = joint_region(part, colours, gamut(), *parameters, **ask)
    assert masked.objects == alone.objects == int(mask.sum())
    assert masked.share == pytest.approx(alone.share, rel=1e-2)  # lines stand at other places
    at = [k.values.tolist().index(1.0) for k in (masked, alone)]
    assert masked.intervals[at[0]] == alone.intervals[at[1]]


def test_the_safe_box_lies_in_the_region_and_touches_its_edge():
    image, colours = system(12, 12, seed=6), palette(seed=6)
    seen = rt.Reference(exposure=0.7)
    names = ("brass.diffuse", "brass.mirror")
    scales = [rt.Scale(name) for name in names]
    found = joint_region(image, colours, gamut(), *scales, reference=seen, cap=False, progress=False)
    (a, b), (c, d) = (found.box.box[name] for name in names)
    inner = 1 - 1e-9
    assert (a, c) in found
    assert (b * inner, d * inner) in found
    assert (b * (1 + 1e-6), d * (1 + 1e-6)) not in found


def test_the_rectangle_of_separate_ranges_is_measured_as_random_pairs_measure_it():
    image, colours = system(12, 12, seed=6), palette(seed=6)
    seen = rt.Reference(exposure=0.4)
    parameters = rt.Scale("key"), rt.Exposure()
    found = joint_region(image, colours, gamut(), *parameters, reference=seen, steps=49, progress=False)
    white, lit = seen.white(image, colours) / seen.exposure, image.object_pixels
    (a, b), (c, d) = (alone.intervals[0] for alone in found.separate)
    pairs = np.random.default_rng(1).uniform([a, c], [b, d], (300, 2))
    inside = [
        not outside(reflectance(image, colours, white, pair, parameters)[0], gamut().upper, lit).any() for pair in pairs
    ]
    # Four standard deviations of a share of 300 draws.
    assert found.separate_inside == pytest.approx(np.mean(inside), abs=4 * np.sqrt(0.25 / 300))
    assert 0.1 < found.separate_inside < 0.9


def test_what_cannot_be_asked_is_refused_in_a_sentence():
    image, colours = system(4, 4), palette()
    ask = {"progress": False}
    with pytest.raises(ValueError, match="named twice"):
        joint_region(image, colours, gamut(), rt.Scale("ice"), rt.Scale("ice"), **ask)
    with pytest.raises(ValueError, match="ask feasible"):
        joint_region(image, colours, gamut(), rt.Blend("deep", "ice", "kubelka-munk"), rt.Scale("key"), **ask)
    with pytest.raises(ValueError, match="two lines"):
        joint_region(image, colours, gamut(), rt.Scale("ice"), rt.Scale("key"), steps=1, **ask)
    with pytest.raises(ValueError, match="room"):
        joint_region(image, colours, gamut(), rt.Scale("ice"), rt.Scale("key"), within=((1, 1), None), **ask)
    with pytest.raises(ValueError, match="ghost"):
        joint_region(image, colours, gamut(), rt.Scale("ghost"), rt.Scale("key"), **ask)


def test_a_region_tells_itself_in_text_and_in_a_notebook():
    image, colours = system(6, 6), palette()
    found = joint_region(image, colours, gamut(), rt.Scale("ice"), rt.Scale("key"), steps=5, progress=False)
    said = repr(replace(found, separate_inside=0.25))
    assert said.startswith("Of all pairs, scale of ice in 0.01 … 3 and scale of key in 0.01 … 3, ")
    assert "Of the rectangle of these ranges 25.0% is inside." in said
    assert "<p>" in found._repr_html_()


def two_pixels(first, second):
    """Two pixels, each of one material that reaches a perfect white at the factor given."""
    coefficients = sparse.csr_array([[0.5 / first, 0.0], [0.0, 0.5 / second]])
    columns = (rt.Interaction("sun", ("ice.diffuse",)), rt.Interaction("sun", ("sea.diffuse",)))
    colours = rt.Palette(BANDS, {"sun": 1, "ice.diffuse": 1, "sea.diffuse": 1})
    return rt.LinearSystem(coefficients, columns, height=1, width=2, white={"sun": 0.5}), colours


@pytest.mark.parametrize(("first", "second"), [(0.1, 0.97), (1.23, 2.2), (2.99, 0.02)])
def test_the_share_of_a_rectangle_is_its_area(first, second):
    # Each scale ends at its own factor, whatever the other: the region is a rectangle, wherever lines stand.
    image, colours = two_pixels(first, second)
    unit = rt.device_gamut(rt.load_device("dye3-endura-premier"), "unit")
    found = joint_region(image, colours, unit, rt.Scale("ice"), rt.Scale("sea"), steps=9, cap=False, progress=False)
    area = (first - 0.01) * (second - 0.01) / (3 - 0.01) ** 2
    assert found.share == pytest.approx(area, rel=1e-6)


def test_the_share_ends_where_a_region_does_that_no_range_ends_at():
    # sea, ice and their sum may not pass 1: a triangle whose tip no separate range names, once sea starts at 0.3.
    image, colours = two_pixels(1.0, 1.0)
    image = replace(image, G=sparse.csr_array([[0.5, 0.5], [0.0, 0.0]]))
    unit = rt.device_gamut(rt.load_device("dye3-endura-premier"), "unit")
    within = ((0.01, 3.0), (0.3, 3.0))
    found = joint_region(
        image, colours, unit, rt.Scale("ice"), rt.Scale("sea"), within=within, steps=9, cap=False, progress=False
    )
    assert found.share == pytest.approx((1 - 0.31) ** 2 / 2 / (2.99 * 2.7), rel=1e-4)


def polygon_area(slopes, low, high):
    """The area of the pairs in a square whose weighted sums stay below 1, by another library."""
    sides = [[-1, 0, low[0]], [0, -1, low[1]], [1, 0, -high[0]], [0, 1, -high[1]]]
    halves = np.vstack([np.column_stack([slopes, -np.ones(len(slopes))]), sides])
    # Just above the lower corner lies inside all of them.
    inside = np.array(low) + 1e-6
    return ConvexHull(HalfspaceIntersection(halves, inside).intersections).volume


@pytest.mark.parametrize("seed", range(8))
def test_shares_are_as_near_a_polygons_areas_as_they_say(seed):
    # Oracle: half-planes that each pixel's weighted sum of two scales makes; bends stand anywhere between lines.
    random = np.random.default_rng(seed)
    slopes = np.exp(random.uniform(-2.5, -0.5, (6, 2)))
    image, colours = two_pixels(1.0, 1.0)
    image = replace(image, G=sparse.csr_array(0.5 * slopes), width=6)
    unit = rt.device_gamut(rt.load_device("dye3-endura-premier"), "unit")
    ask = {"steps": 9, "cap": False, "progress": False}
    found = joint_region(image, colours, unit, rt.Scale("ice"), rt.Scale("sea"), **ask)
    area = polygon_area(slopes, (0.01, 0.01), (3, 3)) / 2.99**2
    assert abs(found.share - area) <= found.share_error + 1e-9
    assert found.share_error <= 2e-3 * found.share

    # The rectangle of the separate ranges, each with the other at 1.
    (a, b), (c, d) = (alone.intervals[0] for alone in found.separate)
    part = polygon_area(slopes, (a, c), (b, d)) / ((b - a) * (d - c))
    assert abs(found.separate_inside - part) <= found.separate_error + 1e-6
    assert found.separate_error <= 2e-3 * found.separate_inside
