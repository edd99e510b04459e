"""A thin lens: disks of the width that optics says, a plane that is sharp, and noise that is no more than is told."""

import math
from dataclasses import replace

import numpy as np
import pytest
import reference
from scenes_for_tests import camera, mirrors, small
from test_pictures import BALL, CRATE, TILE, scene, write_scene

import symrt as rt
from symrt.tracing.nets import disk, net


def columns(system):
    return {str(i): system.G[:, [j]].toarray()[:, 0] for j, i in enumerate(system.interactions)}


# --- Places on the lens -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("bits", [0, 1, 3, 6])
def test_one_point_of_a_set_lies_in_each_rectangle_of_equal_area(bits):
    # The definition of a (0, m, 2)-net, for all sets and all of the rectangles 2^-k by 2^-(m - k).
    points = net(np.array([0, 1, 99, 2**31]), 2**bits)
    for k in range(bits + 1):
        cells = np.floor(points * np.array([2**k, 2 ** (bits - k)])[:, None, None])
        number = cells[0] * 2 ** (bits - k) + cells[1]
        np.testing.assert_array_equal(np.sort(number, axis=1), np.tile(np.arange(2.0**bits), (4, 1)))


def test_a_longer_set_begins_with_the_shorter_and_sets_differ():
    np.testing.assert_array_equal(net(np.array([5]), 64)[:, :, :10], net(np.array([5]), 10))
    first = net(np.arange(1000), 1)[:, :, 0]
    assert np.unique(first[0]).size == 1000
    # Means of 1000 independent numbers, of variance 1/12 each, within five deviations.
    assert np.all(abs(first.mean(axis=1) - 0.5) < 5 / math.sqrt(12 * 1000))
    assert abs(np.corrcoef(first)[0, 1]) < 5 / math.sqrt(1000)


def test_the_disk_is_filled_evenly_and_rings_stay_rings():
    side = (np.arange(200) + 0.5) / 200
    square = np.stack(np.meshgrid(side, side)).reshape(2, -1)
    x, y = disk(square)
    radius = np.hypot(x, y)
    np.testing.assert_allclose(radius, abs(2 * square - 1).max(axis=0), rtol=1e-14)
    # Moments of the uniform disk: E x² = 1/4, E x⁴ = 1/8, E x²y² = 1/24.
    found = [np.mean(x**2), np.mean(y**2), np.mean(x**4), np.mean(x**2 * y**2), np.mean(x * y)]
    np.testing.assert_allclose(found, [1 / 4, 1 / 4, 1 / 8, 1 / 24, 0], atol=2e-5)


# --- Optics -----------------------------------------------------------------------------------------------------------


def point_like(depth, **changes):
    """A tiny ball in even light, at a depth before a lens that focuses on another."""
    eye = {"position": (0, 0, 0), "target": (0, 0, -1), "field_of_view": 20, "aperture": 0.5, "focus": 4.0}
    eye |= {"width": 24, "height": 24, "lens_samples": 1024} | changes
    shapes = [rt.Sphere(centre=(0, 0, -depth), radius=0.012 * depth, material="ball")]
    return rt.Scene(rt.Camera(**eye), shapes, [rt.Material("ball")], [rt.AmbientLight("sky")])


@pytest.mark.parametrize("depth", [1.5, 9.0])
def test_a_point_out_of_focus_is_a_disk_as_wide_as_optics_says(depth):
    # The circle of confusion, A |z − s|/z on the plane that is sharp, of which 2 s tan 10° are 24 pixels; the ball's
    # own disk is blurred into its edge.
    wide = 0.5 * abs(depth - 4) / depth / (2 * 4 * math.tan(math.radians(10))) * 24
    own = 2 * 0.012 / (2 * math.tan(math.radians(10))) * 24
    seen = rt.render(point_like(depth), progress=False).G.toarray()[:, 0].reshape(24, 24)
    y, x = np.nonzero(seen)
    assert x.max() - x.min() + 1 == pytest.approx(wide + own, abs=1)
    assert y.max() - y.min() + 1 == pytest.approx(wide + own, abs=1)
    # Variances add up: of an even disk of diameter d it is d²/16 along either axis.
    across, weight = np.arange(24) - 11.5, seen.sum(axis=0) / seen.sum()
    assert (weight * across**2).sum() == pytest.approx((wide**2 + own**2) / 16, rel=0.02)
    # No light is lost: as much as the pinhole sees of the ball, (own/2)² π pixels of the sky's radiance.
    assert seen.sum() == pytest.approx(math.pi * own**2 / 4, rel=0.02)


@pytest.mark.parametrize("view", [{}, {"type": "orthographic", "view_width": 3.0, "field_of_view": None}])
def test_what_stands_in_the_focal_plane_is_as_sharp_as_through_a_pinhole(view):
    eye = camera(16, position=(0.3, 0.2, 5), target=(0.3, 0.2, 0), **view)
    tiles = rt.Checker("tiles", ("light", "dark"), size=0.37)
    wall = rt.Rectangle(centre=(0.3, 0.2, 0), edge_u=(5, 1, 0), edge_v=(-1, 5, 0), material="tiles")
    materials = [rt.Material("light"), rt.Material("dark")]
    sharp = rt.Scene(eye, [wall], materials, [rt.PointLight("lamp", position=(1, 2, 3))], textures=[tiles])
    wide = replace(sharp, camera=replace(eye, aperture=2.0, lens_samples=16))
    one, other = (columns(rt.render(scene, progress=False)) for scene in (sharp, wide))
    assert list(one) == list(other) == ["lamp*dark.diffuse", "lamp*light.diffuse"]
    for name, values in one.items():
        np.testing.assert_allclose(other[name], values, rtol=1e-12)


def test_an_f_number_is_the_focal_length_over_the_diameter():
    # A 50 mm lens for 36 mm of film, focused on 2 m: by the lens equation the film is v = 1/(1/f − 1/s) behind it.
    between = 1 / (1 / 0.05 - 1 / 2)
    angle = 2 * math.degrees(math.atan(0.018 / between))
    eye = camera(4, field_of_view=angle, f_number=1.8, film_width=0.036, focus=2)
    assert eye.lens_diameter == pytest.approx(0.05 / 1.8, rel=1e-14)
    assert camera(4).focus_distance == math.dist((0, 1, 6), (0, 0, 0))


# --- The picture ------------------------------------------------------------------------------------------------------

LENSES = {
    "places alone": {"aperture": 0.4, "lens_samples": 7},
    "places and samples": {"aperture": 0.6, "focus": 5.1, "samples": 2, "lens_samples": 11},
    "parallel": {"aperture": 0.5, "type": "orthographic", "view_width": 4, "focus": 6},
}


@pytest.mark.parametrize("lens", LENSES)
def test_a_lens_shows_what_a_scalar_tracer_sees_through_it(lens, tmp_path):
    changed = LENSES[lens] | ({} if "view_width" in LENSES[lens] else {"field_of_view": 38})
    whole = scene(BALL | {"material": "chrome"}, TILE | {"material": "blue"}, CRATE | {"centre": [1.4, 0.8, -1]})
    whole["camera"] = {k: v for k, v in whole["camera"].items() if k != "field_of_view"} | changed
    write_scene(tmp_path, whole)
    ours = rt.load_scene(tmp_path / "scene.toml")
    ours = replace(ours, camera=replace(ours.camera, width=9, height=7))
    palette = rt.load_palettes(tmp_path / "scene.toml")["drawn"]
    seen = rt.shade(rt.collapse(rt.trace(ours)), palette).values
    expected = np.array(reference.render(tmp_path / "scene.toml", "drawn", 9, 7))
    assert expected.max() > 0
    np.testing.assert_allclose(seen, expected, rtol=1e-9, atol=0)


def test_a_pinhole_knows_nothing_of_lenses():
    pinhole = small("spheres", 16)
    told = replace(pinhole, camera=replace(pinhole.camera, focus=3.0, lens_samples=9))
    one, other = (rt.render(scene, progress=False) for scene in (pinhole, told))
    np.testing.assert_array_equal(one.G.data, other.G.data)
    assert other.noise == {}
    assert "lens" not in rt.plan(told)
    with pytest.raises(ValueError, match="lens cannot be left out: a lens shows what no pinhole does"):
        rt.plan(small("lens", 16), force={"lens": False})


def test_a_tile_has_the_bits_of_the_whole_picture_and_so_have_workers():
    whole = small("lens", 12)
    system, part = rt.render(whole, progress=False), rt.collapse(rt.trace(whole, window=(3, 2, 11, 9)))
    rows, own = columns(system), columns(part)
    for name, values in own.items():
        np.testing.assert_array_equal(values, rows[name].reshape(12, 12)[2:9, 3:11].ravel())
    # Two tiles, by one worker and by three.
    large = replace(whole, camera=replace(whole.camera, width=100, height=99))
    first, again = (rt.render(large, workers=workers, progress=False) for workers in (1, 3))
    np.testing.assert_array_equal(again.G.data, first.G.data)
    np.testing.assert_array_equal(again.tail.bound.data, first.tail.bound.data)
    assert again.noise == first.noise


def test_weights_of_a_pixel_sum_to_one():
    for samples, places in ((1, 64), (3, 10), (5, 4)):
        eye = camera(3, aperture=0.2, samples=samples, lens_samples=places)
        film = rt.trace(replace(mirrors(model="lambert"), camera=eye)).film
        weights = film.weight.reshape(9, -1)
        np.testing.assert_allclose(weights.sum(axis=1), 1, rtol=1e-15)
        assert weights.shape[1] == eye.rays_a_pixel >= max(places, samples**2)
        np.testing.assert_array_equal(film.half.reshape(9, -1).sum(axis=1) * 2, weights.shape[1])


def test_the_noise_that_is_told_is_the_error_that_is_made():
    # Against 32 times as many places, whose own error is small beside it.
    rough = replace(mirrors(model="lambert"), camera=camera(14, aperture=1.2, focus=4, lens_samples=16))
    fine = replace(rough, camera=replace(rough.camera, lens_samples=512))
    one, other = (rt.render(scene, progress=False) for scene in (rough, fine))
    white = rt.Palette(rt.RGB, {"sun": 0.0, "sky": 0.0, "ball.diffuse": 1.0, "floor.diffuse": 1.0})
    for light in ("sun", "sky"):
        lit = white.replace({light: 1.0 / one.white[light]})
        first, second = (rt.shade(system, lit).values[..., 0] for system in (one, other))
        error = math.sqrt(np.mean((first - second)[second > 0] ** 2))
        assert 0.5 < one.noise[light].rms / error < 2
        assert other.noise[light].rms < 0.25 * one.noise[light].rms


def test_the_noise_is_saved_and_shown(tmp_path):
    system = rt.render(small("lens", 12), progress=False)
    assert set(system.noise) == {"lamp", "back", "sky"}
    assert "the noise of sky is about" in repr(system)
    rt.save_system(tmp_path / "lens.npz", system)
    assert rt.load_system(tmp_path / "lens.npz").noise == system.noise


def test_a_pixel_of_many_samples_has_a_formula_that_can_be_read():
    shown = rt.load_scene("lens")
    shown = replace(shown, camera=replace(shown.camera, width=48, height=32))
    formula = rt.formula(shown, 24, 18)
    assert len(formula.values) > 100
    assert len(str(formula)) < 1200
    assert "in the mean over the pixel's samples" in str(formula)
    assert "n_dot_l_lamp = 0." in str(formula)
    spectra = {name: 0.1 + 0.01 * k for k, name in enumerate(shown.symbols)}
    linear = rt.formula(rt.collapse(rt.trace(shown, window=(24, 18, 25, 19))), 0, 0)
    assert formula.evaluate(spectra) == pytest.approx(linear.evaluate(spectra), rel=1e-13)


def test_the_plan_says_that_a_lens_reaches_into_a_shape():
    inside = replace(mirrors(model="lambert"), camera=camera(4, position=(0, 0, 1.2), aperture=0.5, focus=1))
    assert rt.plan(inside).remarks == (
        "The lens reaches into shapes[0], a sphere: from there it sees past its surface.",
    )
