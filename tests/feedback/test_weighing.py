"""Weights and masks: shares of an object, or by importance, against counting over a dense grid of values."""

import numpy as np
import pytest
from feedback.synthetic import BANDS, palette, system

from symrt.device.inks import load_device
from symrt.feedback.parameters import Blend, Exposure, Scale, moved
from symrt.feedback.ranges import feasible
from symrt.feedback.regions import split
from symrt.feedback.weighing import Weighed, check_mask, pixels_of, weighed
from symrt.gamut.gamuts import device_gamut
from symrt.interactions import Interaction
from symrt.spectra.display import luminance_weights
from symrt.spectra.palette import Palette
from symrt.spectra.reference import Reference
from symrt.spectra.shading import shade

DEVICE = load_device("dye3-endura-premier")
IMAGE, COLOURS = system(), palette()
ENVELOPE = device_gamut(DEVICE, "envelope")
RANDOM = np.random.default_rng(3)
WEIGHTS = RANDOM.uniform(0, 2, (24, 24)) ** 3 * (RANDOM.uniform(size=(24, 24)) < 0.9)
MASK = RANDOM.uniform(size=(24, 24)) < 0.6
QUESTIONS = [
    {"weights": WEIGHTS},
    {"mask": MASK},
    {"weights": WEIGHTS, "mask": MASK},
    {"weights": np.round(WEIGHTS)},
    {"mask": pixels_of(IMAGE, "brass")},
]
NAMES = ["weights", "mask", "both", "whole weights", "brass"]


def importance(question):
    """The weight of every pixel, 0 where it is not asked about."""
    whole = np.where(question.get("mask", True), question.get("weights", np.ones((24, 24))), 0.0)
    return (whole * IMAGE.object_pixels.reshape(24, 24)).ravel()


def reflectances(parameter, t):
    shaded = shade(IMAGE, moved(IMAGE, COLOURS, parameter, t)).values.reshape(-1, 36)
    return shaded / Reference().white(IMAGE, COLOURS)


def share_out(parameter, t, weight, gamut=ENVELOPE):
    out = (reflectances(parameter, t) > gamut.upper).any(axis=1)
    return float(weight[out].sum() / weight.sum())


@pytest.mark.parametrize("question", QUESTIONS, ids=NAMES)
@pytest.mark.parametrize("share", [0.0, 0.03, 0.2])
@pytest.mark.parametrize("parameter", [Scale("key"), Scale("brass"), Blend("deep", "ice"), Exposure()], ids=str)
def test_weighted_shares_are_those_of_a_dense_count(parameter, share, question):
    found = feasible(IMAGE, COLOURS, ENVELOPE, parameter, allowed_out=share, cap=False, **question)
    weight = importance(question)
    assert found.objects == np.count_nonzero(weight)
    seen = []
    for t in np.linspace(*found.within, 23):
        out = share_out(parameter, t, weight)
        assert found.curve.outside(np.array([t]))[0] == pytest.approx(out, abs=1e-9)
        held = any(low <= t <= high for low, high in found.intervals)
        seen.append(held)
        if found.verdict == "complete":
            assert held == (out <= share)
    lost = weight[np.concatenate([found.untouched_outside, found.unfixable])].sum() / weight.sum()
    assert found.verdict == ("complete" if lost <= share else "rest-only")
    assert any(seen)


@pytest.mark.parametrize("question", QUESTIONS, ids=NAMES)
def test_just_beyond_a_weighted_end_too_much_is_outside(question):
    found = feasible(IMAGE, COLOURS, ENVELOPE, Exposure(), allowed_out=0.1, within=(0.01, 50), **question)
    weight = importance(question)
    assert share_out(Exposure(), found.high, weight) <= 0.1 < share_out(Exposure(), found.high * (1 + 1e-9), weight)
    why = found.reasons[-1][1]
    assert weight[why.y * 24 + why.x] > 0


@pytest.mark.parametrize("question", QUESTIONS, ids=NAMES)
def test_weighted_lower_limits_count_only_what_was_above_black(question):
    gamut = device_gamut(DEVICE, "envelope", "luminance")
    found = feasible(
        IMAGE, COLOURS, gamut, Scale("key"), allowed_out=1.0, allowed_dark=0.1, within=(0.001, 2), **question
    )
    bright = luminance_weights(BANDS) * Reference().white(IMAGE, COLOURS)
    bright = bright / bright.sum()
    black, weight = (DEVICE.samples @ bright).min(), importance(question)

    def dark(t):
        return reflectances(Scale("key"), t) @ bright < black

    lit = weight * ~dark(1.0)
    assert found.dark == pytest.approx((weight - lit).sum() / weight.sum(), rel=1e-12)

    def fallen(t):
        return (lit * dark(t)).sum() / lit.sum()

    assert fallen(found.low) <= 0.1 < fallen(found.low * (1 - 1e-6))


def same(one, other):
    assert one.intervals == other.intervals
    assert one.reasons == other.reasons
    assert np.array_equal(one.unfixable, other.unfixable)
    t = one.curve.values
    np.testing.assert_allclose(one.curve.outside(t), other.curve.outside(t), rtol=1e-12, atol=1e-15)


@pytest.mark.parametrize("parameter", [Scale("brass"), Blend("deep", "ice")], ids=str)
def test_equal_weights_change_nothing_whatever_their_size(parameter):
    plain = feasible(IMAGE, COLOURS, ENVELOPE, parameter, allowed_out=0.05, cap=False)
    everything = np.ones((24, 24), dtype=bool)
    same(plain, feasible(IMAGE, COLOURS, ENVELOPE, parameter, allowed_out=0.05, cap=False, mask=everything))
    for size in (0.1, 1.0, 1e-300, 1e300):
        weights = np.full((24, 24), size)
        same(plain, feasible(IMAGE, COLOURS, ENVELOPE, parameter, allowed_out=0.05, cap=False, weights=weights))


def test_a_share_that_weights_add_up_to_is_allowed():
    # Three tenths and seven tenths: neither is a float, and the share of the first is 0.3.
    image = system(1, 2, background=0.0)
    count = weighed(image, weights=np.array([[0.3, 0.7]]))
    assert count.allowance(0.3, count.pixels) >= count.sum(count.pixels[:1])
    assert count.allowance(0.299999, count.pixels) < count.sum(count.pixels[:1])


def test_a_tiny_weight_still_counts_where_nothing_may_be_outside():
    heavy = np.where(np.arange(576).reshape(24, 24) == 0, 1e30, 1.0)
    plain = feasible(IMAGE, COLOURS, ENVELOPE, Scale("key"), cap=False)
    same_end = feasible(IMAGE, COLOURS, ENVELOPE, Scale("key"), cap=False, weights=heavy)
    assert same_end.intervals == plain.intervals


def test_a_mask_asks_what_the_part_alone_would_answer():
    """A region with a name of its own, seen alone by setting everything else to black, has the same range."""
    mask = pixels_of(IMAGE, "ice") & MASK
    found = feasible(IMAGE, COLOURS, ENVELOPE, Scale("ice"), mask=mask, within=(0.01, 100), cap=False)
    parted = split(IMAGE, "ice", mask, "cap")
    spectra = {name: COLOURS[name] * (name in ("key", "fill")) for name in COLOURS}
    alone = Palette(BANDS, spectra | {"cap.diffuse": COLOURS["ice.diffuse"]})
    expected = feasible(parted, alone, ENVELOPE, Scale("cap"), within=(0.01, 100), cap=False)
    assert found.high == pytest.approx(expected.high, rel=1e-12)
    assert f"asked about {mask.sum()} of {IMAGE.object_pixels.sum()} object pixels" in found.note


@pytest.mark.parametrize("name", ["key", "brass", "brass.mirror", "deep"])
def test_pixels_of_a_name_are_those_that_change_with_it(name):
    symbols = [s for s in COLOURS if name in (s, s.partition(".")[0])]
    without = COLOURS.replace(dict.fromkeys(symbols, 0.0))
    changed = (shade(IMAGE, COLOURS).values != shade(IMAGE, without).values).any(axis=2)
    assert np.array_equal(pixels_of(IMAGE, name), changed)
    assert 0 < changed.sum() < IMAGE.object_pixels.sum() + 1


def test_what_might_be_there_is_not_there():
    image = system(1, 1, background=0.0)
    columns = tuple(
        Interaction(i.light, tuple(m.replace("ice", "deep>ice") for m in i.met)) for i in image.interactions
    )
    other = type(image)(image.G, columns, 1, 1, image.white)
    with pytest.raises(ValueError, match="ice"):
        pixels_of(other, "ice")


@pytest.mark.parametrize(
    ("question", "message"),
    [
        ({"weights": np.ones((2, 3))}, r"weights: the shape is \(2, 3\), the image's \(24, 24\)"),
        ({"mask": np.ones((24, 1), dtype=bool)}, r"the mask is \(24, 1\), the image \(24, 24\)"),
        ({"weights": np.where(MASK, 1.0, -1.0)}, r"the weight of pixel \(\d+, \d+\) is -1.0"),
        ({"weights": np.full((24, 24), np.nan)}, r"pixel \(0, 0\) is nan"),
        ({"weights": np.full((24, 24), np.inf)}, "finite"),
        ({"weights": np.zeros((24, 24))}, "weight 0: nothing is asked"),
        ({"mask": np.zeros((24, 24), dtype=bool)}, "the mask has no pixel that light reaches"),
        ({"weights": 1.0 * ~MASK, "mask": MASK}, "weight 0"),
    ],
)
def test_bad_weights_and_masks_are_refused_in_one_line(question, message):
    with pytest.raises(ValueError, match=message) as error:
        feasible(IMAGE, COLOURS, ENVELOPE, Scale("key"), **question)
    assert "\n" not in str(error.value)


def test_a_mask_of_numbers_is_refused():
    """As numbers of pixels it would ask about the first two."""
    with pytest.raises(ValueError, match="the mask is of int64: true or false is asked, such as mask > 0"):
        check_mask(IMAGE, MASK.astype(np.int64), "the mask")


def test_a_name_that_is_not_in_the_picture_is_refused_with_those_that_are():
    with pytest.raises(ValueError, match=r"brasss.*brass"):
        pixels_of(IMAGE, "brasss")


def test_sums_of_weights_do_not_depend_on_their_order():
    weights = RANDOM.uniform(size=(24, 24)) ** 20
    count = weighed(IMAGE, weights=weights)
    shuffled = RANDOM.permutation(count.pixels)
    assert isinstance(count, Weighed)
    assert count.sum(shuffled) == count.sum(count.pixels) == sum(count.weights.tolist())
    assert count.sum(count.pixels) < 2**62
