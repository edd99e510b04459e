"""Feasible ranges, against shading at their ends, counting, exact rationals and a linear programme."""

import re
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from feedback.synthetic import BANDS, awkward, palette, system
from scipy import sparse
from scipy.optimize import linprog

from symrt.device.inks import load_device
from symrt.feedback import intervals
from symrt.feedback.along import along
from symrt.feedback.limits import rising_limits
from symrt.feedback.parameters import Blend, Exposure, Scale, moved
from symrt.feedback.ranges import feasible
from symrt.gamut import device_gamut
from symrt.interactions import Interaction
from symrt.show.tables import ranges_table
from symrt.spectra.bands import RGB
from symrt.spectra.display import luminance_weights
from symrt.spectra.palette import Palette
from symrt.spectra.products import gamma
from symrt.spectra.reference import Reference
from symrt.spectra.shading import shade
from symrt.system import LinearSystem
from symrt.tails import Tail

DEVICE = load_device("dye3-endura-premier")
IMAGE, COLOURS = system(), palette()
SCALES = [Scale("key"), Scale("fill"), Scale("deep"), Scale("brass"), Scale("brass.specular"), Exposure()]
BLENDS = [Blend("deep", "ice"), Blend("upland", "shelf"), Blend("ice", "mountain")]
UNIT, ENVELOPE = device_gamut(DEVICE, "unit"), device_gamut(DEVICE, "envelope")
MONITOR, COLOURED = device_gamut(load_device("crt-brainard", BANDS), "monitor"), device_gamut(DEVICE, "colorimetric")


def reflectances(image, colours, parameter, t, reference=None):
    """What the image reflects at one value of a parameter, against the white of the palette given."""
    reference = reference or Reference()
    white = reference.white(image, colours)
    shaded = shade(image, moved(image, colours, parameter, t)).values.reshape(-1, len(colours.bands))
    return shaded[image.object_pixels] * reference.exposure / white


def outside(gamut, spectra, slack=0.0):
    return (spectra > gamut.upper * (1 + slack)).any(axis=1)


@pytest.mark.parametrize("gamut", [UNIT, ENVELOPE], ids=["unit", "envelope"])
@pytest.mark.parametrize("parameter", SCALES + BLENDS, ids=str)
def test_every_pixel_but_those_listed_is_inside_at_both_ends(gamut, parameter):
    found = feasible(IMAGE, COLOURS, gamut, parameter, cap=False)
    objects = np.flatnonzero(IMAGE.object_pixels)
    listed = np.isin(objects, np.concatenate([found.untouched_outside, found.unfixable]))
    assert found.intervals
    for t in (found.low, found.high):
        assert not outside(gamut, reflectances(IMAGE, COLOURS, parameter, t)[~listed]).any()
    assert found.verdict == ("rest-only" if listed.any() else "complete")


@pytest.mark.parametrize("gamut", [UNIT, ENVELOPE], ids=["unit", "envelope"])
@pytest.mark.parametrize("parameter", SCALES + BLENDS, ids=str)
def test_just_beyond_an_end_the_pixel_named_is_outside_in_the_band_named(gamut, parameter):
    found = feasible(IMAGE, COLOURS, gamut, parameter, cap=False)
    for t, why, step in zip((found.low, found.high), found.reasons[0], (-1, 1), strict=True):
        if why.side == "range":
            assert t in found.within
            continue
        assert why.side == "upper"
        beyond = moved(IMAGE, COLOURS, parameter, min(max(t + step * 1e-6, 0.0), 9.0))
        spectrum = shade(IMAGE, beyond).values[why.y, why.x] / Reference().white(IMAGE, COLOURS)
        band = DEVICE.bands.labels.index(why.band)
        assert spectrum[band] > gamut.upper[band]
        assert why.extrapolated == bool(DEVICE.extrapolated[band])


@pytest.mark.parametrize("parameter", [Scale("key"), Scale("brass"), Scale("ice")], ids=str)
def test_the_end_is_inside_in_exact_arithmetic(parameter):
    found = feasible(IMAGE, COLOURS, ENVELOPE, parameter, cap=False)
    listed = set(np.concatenate([found.untouched_outside, found.unfixable]).tolist())
    white = [Fraction(w) for w in Reference().white(IMAGE, COLOURS).tolist()]
    upper = [Fraction(u) for u in ENVELOPE.upper.tolist()]
    t, moving = Fraction(found.high), {parameter.name}
    spectra = {name: [Fraction(v) for v in COLOURS[name].tolist()] for name in COLOURS}
    binding = [why.y * IMAGE.width + why.x for why in found.reasons[0] if why.side == "upper"]
    for pixel in [*binding, *np.flatnonzero(IMAGE.object_pixels)[::17].tolist()]:
        if pixel in listed:
            continue
        row = IMAGE.G[[pixel]]
        for band in range(36):
            value = Fraction(0)
            for column, g in zip(row.indices, row.data.tolist(), strict=True):
                names = (IMAGE.interactions[column].light, *IMAGE.interactions[column].met)
                product = Fraction(g)
                for name in names:
                    product *= spectra[name][band] * (t if {name, name.partition(".")[0]} & moving else 1)
                value += product
            assert value <= upper[band] * white[band]


@pytest.mark.parametrize("name", ["key", "deep", "ice", "brass.specular"])
def test_a_linear_programme_finds_the_same_limit(name):
    found = feasible(IMAGE, COLOURS, ENVELOPE, Scale(name), within=(0, 100), cap=False)
    line = along(IMAGE, COLOURS, Scale(name))
    q = line.coefficients(slice(None)) / Reference().white(IMAGE, COLOURS)
    kept = line.touched.copy()
    kept[found.unfixable] = False
    best = linprog([-1], A_ub=q[1, kept].reshape(-1, 1), b_ub=(ENVELOPE.upper - q[0, kept]).ravel(), bounds=[(0, 100)])
    assert found.high == pytest.approx(best.x[0], rel=1e-7)


def test_untouched_and_unfixable_pixels_are_found_and_told_apart():
    bright = COLOURS.replace({"ice.diffuse": 1.0}, key=9.0)
    found = feasible(IMAGE, bright, ENVELOPE, Scale("brass.specular"), cap=False, reference=Reference(exposure=2.0))
    objects = np.flatnonzero(IMAGE.object_pixels)
    args = (IMAGE, bright, Scale("brass.specular"))
    low, high = (outside(ENVELOPE, reflectances(*args, t, Reference(exposure=2.0))) for t in (0.01, 3.0))
    touched = along(*args).touched[objects]
    assert np.array_equal(found.untouched_outside, objects[~touched & low & high])
    assert np.array_equal(found.unfixable, objects[touched & low])
    assert len(found.untouched_outside) > 5
    assert len(found.unfixable) > 0
    assert found.verdict == "rest-only"
    assert found.places(found.unfixable)[0].tolist() == [found.unfixable[0] % 24, found.unfixable[0] // 24]


@pytest.mark.parametrize("share", [0.01, 0.05, 0.2])
@pytest.mark.parametrize("parameter", [Scale("key"), Scale("brass"), Blend("deep", "ice"), Exposure()], ids=str)
def test_no_more_than_the_share_allowed_is_outside(parameter, share):
    found = feasible(IMAGE, COLOURS, ENVELOPE, parameter, allowed_out=share, cap=False)
    within = found.within
    for t in np.linspace(*within, 40):
        out = outside(ENVELOPE, reflectances(IMAGE, COLOURS, parameter, t)).mean()
        held = any(low <= t <= high for low, high in found.intervals)
        assert held == (out <= share) or found.verdict == "rest-only"
        assert found.curve.outside(np.array([t]))[0] == pytest.approx(out, abs=1e-12)
    assert found.verdict == "complete"
    assert found.high >= feasible(IMAGE, COLOURS, ENVELOPE, parameter, cap=False).high


@pytest.mark.parametrize("share", [0.0, 0.05])
def test_lower_limits_count_only_pixels_that_were_above_black(share):
    gamut = device_gamut(DEVICE, "envelope", "luminance")
    found = feasible(IMAGE, COLOURS, gamut, Scale("key"), allowed_out=0.9, allowed_dark=share, within=(0.01, 2.0))
    weights = luminance_weights(BANDS) * Reference().white(IMAGE, COLOURS)
    weights = weights / weights.sum()
    black = (DEVICE.samples @ weights).min()
    lit = reflectances(IMAGE, COLOURS, Scale("key"), 1.0) @ weights >= black
    assert found.dark == pytest.approx(1 - lit.mean())
    assert 0 < found.dark < 0.5

    def fallen(t):
        return (reflectances(IMAGE, COLOURS, Scale("key"), t)[lit] @ weights < black).mean()

    assert fallen(found.low) <= share < fallen(found.low * (1 - 1e-6))
    assert found.reasons[0][0].side == "luminance"


def test_strict_black_bounds_every_band_from_below():
    gamut = device_gamut(DEVICE, "envelope", "strict")
    found = feasible(IMAGE, COLOURS, gamut, Scale("key"), allowed_out=0.9, allowed_dark=0.02, within=(0.01, 2.0))
    lit = (reflectances(IMAGE, COLOURS, Scale("key"), 1.0) >= gamut.lower).all(axis=1)

    def fallen(t):
        return (reflectances(IMAGE, COLOURS, Scale("key"), t)[lit] < gamut.lower).any(axis=1).mean()

    assert fallen(found.low) <= 0.02 < fallen(found.low * (1 - 1e-6))
    assert found.reasons[0][0].side == "lower"


def test_exposure_and_reference_scale_the_limits():
    plain = feasible(IMAGE, COLOURS, UNIT, Exposure(), within=(0, 100))
    twice = feasible(IMAGE, COLOURS, UNIT, Exposure(), within=(0, 100), reference=Reference(exposure=2.0))
    assert twice.high == pytest.approx(plain.high / 2, rel=1e-12)
    # The fill light's white is dimmer, so that the same radiances are larger shares of it.
    dimmer = feasible(IMAGE, COLOURS, UNIT, Exposure(), within=(0, 100), reference=Reference("fill"))
    assert dimmer.high < plain.high
    assert "reference fill, exposure 1" in dimmer.note
    assert "reference key, exposure 2" in twice.note


def test_bands_that_the_reference_does_not_light_are_left_out_and_named():
    dark = np.array(COLOURS["key"])
    dark[:3] = 0
    found = feasible(IMAGE, COLOURS.replace(key=dark), UNIT, Scale("key"), within=(0.01, 100))
    assert "not lit and left out: 380 nm, 390 nm, 400 nm" in found.note
    assert found.reasons[0][1].band not in ("380 nm", "390 nm", "400 nm")


def test_what_the_depth_limit_left_out_is_said():
    # A last mirror of reflectance 0.5 would add at most 0.01 · 2 · 0.5 / (1 − 0.5) of radiance, on a white of 1.
    columns = (Interaction("key", ("a.mirror",)),)
    tail = Tail(sparse.csr_array([[0.01]]), columns, (((("a.mirror",), 1.0),),))
    image = LinearSystem(sparse.csr_array([[0.1]]), columns, 1, 1, {"key": 0.5}, tail=tail)
    found = feasible(image, Palette(BANDS, {"key": 2.0, "a.mirror": 0.5}), UNIT, Scale("key"))
    assert "the depth limit left out at most 0.02 of a pixel" in found.note


def test_the_physical_cap_holds_unless_it_is_switched_off():
    found = feasible(IMAGE, COLOURS, UNIT, Scale("upland"), within=(0.01, 3.0))
    top = COLOURS["upland.diffuse"].max()
    assert found.high == pytest.approx(min(1 / top, 3.0), rel=1e-12)
    assert found.above_one == ()
    free = feasible(IMAGE, COLOURS, UNIT, Scale("upland"), within=(0.01, 3.0), cap=False)
    if found.high < 3:
        assert found.reasons[0][1].side == "cap"
        assert "upland would reflect more than it receives at" in repr(found)
    assert free.high >= found.high
    assert ("upland" in free.above_one) == (free.high * top > 1)


def bowl():
    """One pixel that sees a mirror of a in b: its radiance is a product of both, and dips in the blend's middle."""
    columns = (Interaction("key", ("a.diffuse", "a.mirror")),)
    image = LinearSystem(sparse.csr_array([[1.0]]), columns, 1, 1, {"key": 1.0})
    spectra = {"a.diffuse": 1.0, "a.mirror": 0.1, "b.diffuse": 0.1, "b.mirror": 1.0}
    return image, Palette(BANDS, {"key": 1.0, **spectra})


def test_a_blend_of_higher_degree_can_be_feasible_in_several_intervals():
    image, colours = bowl()
    # (1 − 0.9 t)(0.1 + 0.9 t) is 0.1 at both ends and 0.3025 in the middle; it is 0.2 at two values.
    gamut = replace(UNIT, upper=np.full(36, 0.2))
    found = feasible(image, colours, gamut, Blend("a", "b"))
    root = np.sqrt(1.1**2 / 4 - 0.2 * 1.0)
    ends = sorted((0.45 + s * root) / 0.9 for s in (-1, 1))
    assert len(found.intervals) == 2
    assert found.intervals[0] == pytest.approx((0.0, ends[0]), abs=1e-9)
    assert found.intervals[1] == pytest.approx((ends[1], 1.0), abs=1e-9)
    assert " or " in repr(found)
    for low, high in found.intervals:
        for t in (low, high):
            assert not outside(gamut, reflectances(image, colours, Blend("a", "b"), t)).any()


def test_where_no_value_serves_both_bounds_and_their_pixels_are_named():
    columns = (Interaction("key", ("a.diffuse",)),)
    image = LinearSystem(sparse.csr_array([[1.0], [0.008]]), columns, 1, 2, {"key": 0.5})
    colours = Palette(BANDS, {"key": 2.0, "a.diffuse": 0.8})
    gamut = device_gamut(DEVICE, "unit", "luminance")
    found = feasible(image, colours, gamut, Scale("a"), cap=False)
    assert found.intervals == ()
    assert found.low is None
    assert found.high is None
    (least, needs), (most, allows) = found.conflict
    assert most == pytest.approx(1 / 1.6, rel=1e-12)
    assert 0.5 < least < 1
    assert (needs.side, needs.x, allows.side, allows.x) == ("luminance", 1, "upper", 0)
    assert re.search(r"has no value in 0.01 … 3 .*\nAt least .* is needed, where pixel \(1, 0\)", repr(found))


def test_a_negative_coefficient_is_handled_without_assuming_monotone_pixels():
    image, colours = bowl()
    columns = (*image.interactions, Interaction("key", ("a.diffuse",)))
    order = sorted(range(2), key=lambda k: columns[k])
    coefficients = np.array([[4.0, -0.5]])[:, order]
    signed = replace(image, G=sparse.csr_array(coefficients), interactions=tuple(columns[k] for k in order))
    # 4·0.1 t² − 0.5 t: it meets 1 at t = (0.5 + √(0.25 + 1.6)) / 0.8.
    found = feasible(signed, colours, UNIT, Scale("a"), within=(0.01, 4.0), cap=False)
    assert found.high == pytest.approx((0.5 + np.sqrt(0.25 + 1.6)) / 0.8, rel=1e-9)


@pytest.mark.parametrize("bright", [1e6, 1e12])
@pytest.mark.parametrize("gamut", [UNIT, MONITOR, COLOURED], ids=["unit", "monitor", "colorimetric"])
@pytest.mark.parametrize("parameter", [Blend("a", "b"), Blend("a", "b", "kubelka-munk"), Scale("a")], ids=str)
def test_a_pixel_as_bright_as_the_sun_leaves_all_others_their_range(parameter, gamut, bright):
    """What rounding amounts to there is no other pixel's affair, whether it is moved, mirrors itself, or is at rest."""
    columns = tuple(sorted(Interaction("key", met) for met in [("a.diffuse",), ("a.diffuse",) * 2, ("b.diffuse",)]))
    one, two, other = (
        columns.index(Interaction("key", met)) for met in [("a.diffuse",), ("a.diffuse",) * 2, ("b.diffuse",)]
    )
    coefficients = np.zeros((6, 3))
    coefficients[[0, 1, 2, 3, 4], [one, two, other, other, two]] = 1.2, 1.3, 1.6, 1.9, bright
    coefficients[1, one] = 0.3
    ramp = np.linspace(0, 1, 36)
    colours = Palette(BANDS, {"key": 1.0, "a.diffuse": 0.5 + 0.1 * ramp, "b.diffuse": 0.8 - 0.2 * ramp})
    image = LinearSystem(sparse.csr_array(coefficients), columns, 1, 6, white={"key": 1.0})
    options = {"cap": False, "progress": False}
    alone = feasible(image, colours, gamut, parameter, mask=np.arange(6)[None] < 4, **options)
    among = feasible(image, colours, gamut, parameter, allowed_out=0.75, **options)
    assert set(among.untouched_outside) == set(alone.untouched_outside)
    assert set(among.unfixable) == {*alone.unfixable, 4}
    values = np.setdiff1d(alone.curve.values, alone.within)
    assert len(values)
    assert np.abs(among.curve.values[:, None] - values).min(axis=0).max() < 1e-9


def test_materials_that_are_white_in_one_band_may_mirror_themselves():
    """A band that lies on its bound whatever the blend asks for nothing; the others decide."""
    columns = (Interaction("key", ("a.diffuse",)), Interaction("key", ("a.diffuse",) * 2))
    image = LinearSystem(sparse.csr_array([[0.5, 0.5]]), columns, 1, 1, white={"key": 1.0})
    one, other = np.full(36, 0.5), np.full(36, 0.9)
    one[0] = other[0] = 1.0
    found = feasible(image, Palette(BANDS, {"key": 1.0, "a.diffuse": one, "b.diffuse": other}), UNIT, Blend("a", "b"))
    assert (found.intervals, found.verdict) == (((0.0, 1.0),), "complete")


@pytest.mark.parametrize("top", [1e20, 1e60, 1e300])
def test_ranges_of_any_length_end_where_pixels_do(top):
    image = LinearSystem(sparse.csr_array([[1e6]]), (Interaction("key", ("a.mirror",) * 6),), 1, 1, white={"key": 1.0})
    colours = Palette(BANDS, {"key": 1.0, "a.mirror": 0.9})
    found = feasible(image, colours, UNIT, Scale("a"), within=(0.0, top), cap=False)
    # 1e6 (0.9 t)⁶ = 1 at t = 1 / 9.
    assert found.high == pytest.approx(1 / 9, rel=1e-12)


def test_a_picture_of_nothing_is_inside_whatever_happens():
    empty = replace(IMAGE, G=sparse.csr_array(IMAGE.G.shape))
    found = feasible(empty, COLOURS, UNIT, Scale("key"))
    assert (found.intervals, found.objects, found.verdict) == (((0.01, 3.0),), 0, "complete")


@pytest.mark.parametrize("seed", range(20))
def test_awkward_systems_are_inside_at_every_end_and_outside_beyond(seed):
    image, colours, materials = awkward(seed)
    objects = np.flatnonzero(image.object_pixels)
    for parameter in (Scale("key"), Scale(materials[0]), Scale("m1.diffuse"), Blend("m0", "m1")):
        found = feasible(image, colours, ENVELOPE, parameter, cap=False)
        kept = ~np.isin(objects, np.concatenate([found.untouched_outside, found.unfixable]))
        for t in np.ravel(found.intervals):
            assert not outside(ENVELOPE, reflectances(image, colours, parameter, float(t))[kept], 4e-16).any()
        for ends, reasons in zip(found.intervals, found.reasons, strict=True):
            for t, why, step in zip(ends, reasons, (-1e-6, 1e-6), strict=True):
                if why.side == "upper":
                    beyond = reflectances(image, colours, parameter, t + step * max(t, 1e-3))
                    band = BANDS.labels.index(why.band)
                    assert beyond[objects == why.x][0, band] > ENVELOPE.upper[band]


@pytest.mark.parametrize("parameter", [Scale("key"), Scale("brass"), Blend("deep", "ice"), Exposure()], ids=str)
@pytest.mark.parametrize("black", ["clip", "luminance", "strict"])
def test_looking_closely_only_near_the_bounds_changes_no_bit(parameter, black, monkeypatch):
    gamut = device_gamut(DEVICE, "envelope", black)
    options = {"reference": Reference(exposure=0.4), "allowed_dark": 0.05, "cap": False}
    quick = feasible(IMAGE, COLOURS, gamut, parameter, **options)
    monkeypatch.setattr(intervals, "FAR", -1.0)
    close = feasible(IMAGE, COLOURS, gamut, parameter, **options)
    assert quick.intervals == close.intervals
    assert quick.reasons == close.reasons
    assert np.array_equal(quick.untouched_outside, close.untouched_outside)
    assert np.array_equal(quick.unfixable, close.unfixable)
    assert all(np.array_equal(a, b) for a, b in zip(quick.curve.begins, close.curve.begins, strict=True))
    assert all(np.array_equal(a, b) for a, b in zip(quick.curve.ends, close.curve.ends, strict=True))


def test_a_band_that_the_parameter_does_not_move_may_lie_on_its_bound():
    columns = (Interaction("key", ("a.diffuse",)), Interaction("key", ("b.diffuse",)))
    image = LinearSystem(sparse.csr_array([[0.5, 0.5]]), columns, 1, 1, {"key": 0.5})
    first, second = np.repeat([1.0, 0.0], 18), np.repeat([0.0, 0.25], 18)
    colours = Palette(BANDS, {"key": 2.0, "a.diffuse": first, "b.diffuse": second})
    found = feasible(image, colours, UNIT, Scale("b"), within=(0.01, 9.0), cap=False)
    assert found.high == pytest.approx(4.0, rel=1e-12)


def test_the_answer_reads_like_a_sentence_and_says_what_is_modelled():
    text = repr(feasible(IMAGE, COLOURS, ENVELOPE, Scale("key")))
    assert text.startswith("The scale of key may be 0.01 … ")
    for words in ("pixel (", "at ", " nm", "envelope of dye3-endura-premier", "necessary", "modelled", "reference key"):
        assert words in text
    assert "8650" not in text
    page = feasible(IMAGE, COLOURS, ENVELOPE, Scale("key"))._repr_html_()
    assert page.startswith("<p>The scale of key")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"within": (2.0, 1.0)}, r"within = \(2.0, 1.0\)"),
        ({"within": (-1.0, 1.0)}, "0 <= low"),
        ({"within": (0.0, np.nan)}, "finite"),
        ({"allowed_out": 5.0}, "for 5 % give 0.05"),
        ({"allowed_dark": -0.1}, "allowed_dark = -0.1"),
        ({"parameter": Blend("deep", "ice"), "within": (0.0, 2.0)}, "at most 1"),
        ({"parameter": Blend("deep", "ice"), "within": (0.0, 0.0)}, "high above 0"),
        ({"palette": Palette(RGB, {"key": 1.0})}, r"palette is in RGB, unit gamut .* in Bands"),
        ({"reference": Reference("keys")}, "keys"),
    ],
)
def test_bad_questions_are_answered_in_one_line(change, message):
    question = {"system": IMAGE, "palette": COLOURS, "gamut": UNIT, "parameter": Scale("key")} | change
    with pytest.raises(ValueError, match=message) as error:
        feasible(**question)
    assert "\n" not in str(error.value)


def test_interactions_have_the_products_that_shading_gives_them():
    """The test's own picture of an image, `reflectances`, is G Γ over the white."""
    white = Reference().white(IMAGE, COLOURS)
    products = gamma(IMAGE.interactions, COLOURS)
    np.testing.assert_allclose(
        reflectances(IMAGE, COLOURS, Scale("key"), 1.0),
        (IMAGE.G @ products)[IMAGE.object_pixels] / white,
        rtol=1e-12,
    )


@pytest.mark.parametrize("model", ["hull", "inks", "colorimetric", "monitor"])
def test_what_needs_rising_bounds_refuses_other_gamuts_with_a_remedy(model):
    gamut = device_gamut(load_device("crt-brainard" if model == "monitor" else "dye3-endura-premier"), model)
    with pytest.raises(ValueError, match="use adapt, which fits them to the device's envelope"):
        rising_limits(IMAGE, COLOURS, gamut)


def test_an_image_of_which_nothing_is_inside_has_no_rest_to_keep():
    columns = (Interaction("key", ("a.diffuse",)), Interaction("key", ("b.diffuse",)))
    image = LinearSystem(sparse.csr_array([[0.5, 0.0], [0.5, 0.1]]), columns, 1, 2, {"key": 0.5})
    colours = Palette(UNIT.bands, {"key": 2.0, "a.diffuse": 0.9, "b.diffuse": 0.5})
    bright = Reference("key", exposure=2.0)
    found = feasible(image, colours, UNIT, Scale("b"), cap=False, reference=bright)
    assert (len(found.untouched_outside), len(found.unfixable), found.objects) == (1, 1, 2)
    assert repr(found).startswith("No pixel is inside, whatever the scale of b: there is no rest to keep inside")
    assert ranges_table([found]).splitlines()[-1].split()[3:5] == ["none", "none"]
    assert not feasible(image, colours, UNIT, Scale("b"), cap=False).none_inside
