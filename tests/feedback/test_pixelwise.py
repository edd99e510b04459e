"""Mapping pixel by pixel ends inside, moves no pixel that is inside, and is as smooth as asked."""

import numpy as np
import pytest
from feedback import synthetic
from scenes_for_tests import palettes, small
from scipy import sparse

import symrt as rt
from symrt.device import load_device
from symrt.feedback import map_pixels
from symrt.gamut import device_gamut


@pytest.fixture(scope="module")
def globe():
    system, palette = rt.render(small("globe", 64), progress=False), palettes("globe")["macbeth"]
    return system, palette.replace(key=1.4 * palette["key"])


@pytest.fixture(scope="module", params=["unit", "envelope", "colorimetric"])
def gamut(request):
    return device_gamut(load_device("dye3-endura-premier"), request.param)


def seen(system, palette, image):
    # The reference is the key light as it was given, 1.4 times as bright.
    return image.values.reshape(-1, 36)[system.object_pixels] / rt.Reference().white(system, palette)


@pytest.mark.parametrize("towards", ["neutral", "centre", "nearest"])
def test_every_object_pixel_ends_inside(globe, gamut, towards):
    mapped = map_pixels(*globe, gamut, towards=towards)
    under = gamut.under(rt.Reference().white(*globe))
    assert under.violation(seen(*globe, mapped.image)).max() <= 1e-9
    assert (mapped.share > 0) == (not under.contains(seen(*globe, rt.shade(*globe))).all())


@pytest.mark.parametrize("exposure", [1.0, 0.3, 1.7e8])
@pytest.mark.parametrize("towards", ["neutral", "centre", "nearest"])
def test_whatever_rounds_on_the_way_back_to_radiances_stays_inside(globe, gamut, towards, exposure):
    reference = rt.Reference(exposure=exposure)
    mapped = map_pixels(*globe, gamut, towards=towards, reference=reference)
    white = reference.white(*globe) / exposure
    values = mapped.image.values.reshape(-1, 36)[globe[0].object_pixels]
    assert gamut.under(white).contains(values / white).all()


@pytest.mark.parametrize("towards", ["neutral", "centre", "nearest"])
def test_pixels_inside_stay_bit_for_bit(globe, gamut, towards):
    before = rt.shade(*globe)
    inside = gamut.under(rt.Reference().white(*globe)).contains(seen(*globe, before))
    after = map_pixels(*globe, gamut, towards=towards).image
    objects = globe[0].object_pixels
    kept, given = (image.values.reshape(-1, 36)[objects][inside] for image in (after, before))
    np.testing.assert_array_equal(kept, given)


def test_the_nearest_point_moves_each_pixel_least(globe, gamut):
    moved = {t: map_pixels(*globe, gamut, towards=t).moved for t in ("neutral", "centre", "nearest")}
    for other in ("neutral", "centre"):
        assert np.all(moved["nearest"] <= moved[other] + 1e-9)


def test_towards_neutral_keeps_the_mean_reflectance_where_the_grey_is_inside(globe):
    gamut = device_gamut(load_device("dye3-endura-premier"), "envelope")
    before, after = seen(*globe, rt.shade(*globe)), seen(*globe, map_pixels(*globe, gamut).image)
    grey_inside = before.mean(axis=1) < 0.85
    np.testing.assert_allclose(after.mean(axis=1)[grey_inside], before.mean(axis=1)[grey_inside], rtol=1e-12)


def test_smoothness_spreads_what_one_pixel_needs_over_its_neighbours_and_stays_inside():
    device = load_device("dye3-endura-premier")
    gamut = device_gamut(device, "envelope")
    g = np.full((21, 21), 0.9)
    g[10, 10] = 1.2
    column = rt.Interaction("sun", ("sea.diffuse",))
    system = rt.LinearSystem(sparse.csr_array(g.reshape(-1, 1)), (column,), 21, 21, {"sun": 1.0})
    palette = rt.Palette(device.bands, {"sun": 1, "sea.diffuse": np.linspace(0.1, 0.9, 36)})
    rough, smooth = (map_pixels(system, palette, gamut, smoothness=s) for s in (0.0, 2.0))
    steps = [np.abs(np.diff(m.moved, axis=0)).max() for m in (rough, smooth)]
    assert rough.share == 1 / 441
    assert steps[1] < steps[0] / 3
    assert gamut.violation(smooth.image.values.reshape(-1, 36)).max() <= 1e-12


def test_a_smoothed_picture_is_inside_too(globe, gamut):
    smooth = map_pixels(*globe, gamut, smoothness=2.0)
    under = gamut.under(rt.Reference().white(*globe))
    assert under.violation(seen(*globe, smooth.image)).max() <= 1e-9
    assert smooth.share >= map_pixels(*globe, gamut).share


def test_options_that_do_not_fit_are_refused(globe, gamut):
    with pytest.raises(ValueError, match="nearest points"):
        map_pixels(*globe, gamut, towards="nearest", smoothness=2)
    with pytest.raises(ValueError, match="size of the image"):
        map_pixels(*globe, gamut, smoothness=-1)
    with pytest.raises(ValueError, match="towards = 'grey': there are 'neutral', 'centre', 'nearest'"):
        map_pixels(*globe, gamut, towards="grey")


def test_what_happened_is_said(globe):
    mapped = map_pixels(*globe, device_gamut(load_device("dye3-endura-premier"), "envelope"))
    assert "towards neutral" in repr(mapped)
    assert mapped._repr_png_()[1:4] == b"PNG"


def test_a_reference_that_leaves_bands_dark_is_refused_and_never_divided_by(globe, gamut):
    system, palette = globe
    dark = palette["key"].copy()
    dark[:3] = 0
    with pytest.raises(ValueError, match="does not light 380 nm, 390 nm, 400 nm"):
        map_pixels(system, palette.replace(key=dark), gamut)
    other = device_gamut(load_device("dye3-endura-premier", rt.wavelengths(400, 700, 20)), "unit")
    with pytest.raises(ValueError, match="same bands"):
        map_pixels(system, palette, other)


@pytest.mark.parametrize("towards", ["neutral", "nearest"])
def test_a_hull_takes_every_pixel_in_and_lines_end_where_a_clip_ends_them(towards):
    bands = synthetic.BANDS
    system, palette = synthetic.system(height=6, width=6), synthetic.palette()
    hull = device_gamut(load_device("synthetic-cmyk", bands), "hull")
    white = rt.Reference().white(system, palette)
    before = rt.shade(system, palette).values.reshape(-1, len(bands))[system.object_pixels] / white
    mapped = map_pixels(system, palette, hull, towards=towards, progress=False)
    after = mapped.image.values.reshape(-1, len(bands))[system.object_pixels] / white
    outside = ~hull.contains(before)
    assert outside.any()
    assert hull.violation(after).max() <= 1e-7
    if towards == "neutral":
        low, high = (getattr(hull.clip(np.zeros((1, 36)), np.ones((1, 36))), end)[0] for end in ("low", "high"))
        grey = np.clip(before[outside].mean(axis=1, keepdims=True), low, high)
        ends = hull.clip(np.repeat(grey, 36, axis=1), before[outside] - grey).high
        np.testing.assert_allclose(after[outside], grey + ends[:, None] * (before[outside] - grey), atol=1e-6)


def test_inks_have_nearest_points_only():
    gamut = device_gamut(load_device("synthetic-cmyk", synthetic.BANDS), "inks")
    with pytest.raises(ValueError, match="choose towards='nearest'"):
        map_pixels(synthetic.system(height=2, width=2), synthetic.palette(), gamut)
