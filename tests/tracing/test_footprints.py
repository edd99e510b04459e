"""Filtered textures: one sample a pixel shows what very many show, for what two floats a ray cost."""

from dataclasses import replace

import numpy as np
import pytest
from scenes_for_tests import SCENES, camera, small

import symrt as rt

SKY = [rt.AmbientLight("sky")]
MATERIALS = [rt.Material("light"), rt.Material("dark"), rt.Material("chrome", model="mirror")]
PALETTE = rt.Palette(rt.RGB, {"sky": 1.0, "light.diffuse": 0.8, "dark.diffuse": 0.1, "chrome.mirror": 1.0})


def tiled(*shapes, size=0.5, filtered=True, **view):
    eye = {"position": (0.3, 1.2, 6), "target": (0.1, 0.3, 0), "field_of_view": 40, "width": 64, "height": 48}
    tiles = rt.Checker("tiles", ("light", "dark"), size, filtered=filtered)
    return rt.Scene(rt.Camera(**(eye | view)), list(shapes), MATERIALS, SKY, textures=[tiles])


def seen(scene):
    return rt.shade(rt.render(scene, progress=False), PALETTE).values[..., 0]


def errors(scene):
    """Root mean square errors of a picture without the filter and with it, against 16 × 16 samples a pixel."""
    plain = replace(scene, textures=[replace(scene.textures[0], filtered=False)])
    truth = seen(replace(plain, camera=replace(plain.camera, samples=16)))
    return [float(np.sqrt(np.mean((seen(one) - truth) ** 2))) for one in (plain, scene)]


FLOOR = rt.Plane(point=(0, 0, 0), normal=(0, 1, 0), material="tiles")
BALL = rt.Sphere(centre=(0.1, 0.3, 0), radius=1.6, material="tiles")
WALL = rt.Rectangle(centre=(0.1, 0.3, 0), edge_u=(9, 0, -9), edge_v=(0, 7, 0), material="tiles")
CRATE = rt.Box(centre=(0.1, 0.3, 0), size=(2, 2, 2), rotate=(20, 30, 0), material="tiles")
ROOF = rt.Rectangle(centre=(0, 4, 0), edge_u=(60, 0, 0), edge_v=(0, 0, 60), material="tiles")
MIRRORED = (rt.Sphere(centre=(0.1, 0.3, 0), radius=1.6, material="chrome"), ROOF)


@pytest.mark.parametrize(
    ("shapes", "size", "ratio"),
    [
        # Measured: 0.205 and 0.035, 0.231 and 0.035, 0.217 and 0.021, 0.187 and 0.059, 0.166 and 0.041.
        ((FLOOR,), 0.5, 0.3),
        ((BALL,), 0.06, 0.3),
        ((WALL,), 0.15, 0.3),
        ((CRATE,), 0.1, 0.4),
        (MIRRORED, 1.0, 0.5),
    ],
    ids=["floor", "ball", "wall", "crate", "mirrored in a ball"],
)
def test_one_filtered_sample_is_nearer_to_very_many_than_one_plain_sample(shapes, size, ratio):
    without, filtered = errors(tiled(*shapes, size=size))
    assert filtered < ratio * without


def test_a_checker_that_is_too_fine_is_grey():
    grey = seen(tiled(FLOOR, size=1e-3))
    lit = grey[grey > 0]
    np.testing.assert_allclose(lit, 0.45, atol=1e-3)


def test_parallel_rays_straight_on_a_wall_see_the_means_of_their_pixels():
    # Pixels of 4/16 on squares of 0.3, from 2 on: the share of even squares, from the ends of the intervals.
    wall = rt.Rectangle(centre=(0, 0, 0), edge_u=(8, 0, 0), edge_v=(0, -8, 0), material="tiles")
    view = {"type": "orthographic", "view_width": 4, "field_of_view": None, "width": 16, "height": 16}
    found = seen(tiled(wall, size=0.3, position=(0, 0, 5), target=(0, 0, 0), **view))
    edges = (2 + np.arange(17) * 0.25) / 0.3
    wave = np.cumsum(np.where(np.arange(2000) % 2 < 1, 1.0, -1.0)[:40])
    integral = np.interp(edges, np.arange(41), np.concatenate([[0.0], wave]))
    mean = np.diff(integral) / np.diff(edges)
    expected = 0.45 + 0.35 * np.outer(mean, mean)
    np.testing.assert_allclose(found, expected, atol=1e-9)


def test_a_window_has_the_bits_of_the_whole_and_unfiltered_textures_keep_theirs():
    whole = tiled(FLOOR, *MIRRORED[:1], width=24, height=18, samples=2)
    picture = rt.collapse(rt.trace(whole)).G.toarray().reshape(18, 24, -1)
    part = rt.collapse(rt.trace(whole, window=(5, 4, 15, 16)))
    np.testing.assert_array_equal(part.G.toarray().reshape(12, 10, -1), picture[4:16, 5:15])

    # Of two textures one is filtered: the other shows what it showed.
    both = replace(
        tiled(FLOOR),
        shapes=[FLOOR, replace(BALL, material="spots")],
        textures=[
            rt.Checker("tiles", ("light", "dark"), 0.5, filtered=True),
            rt.Checker("spots", ("chrome", "dark"), 0.3),
        ],
    )
    neither = replace(both, textures=[replace(both.textures[0], filtered=False), both.textures[1]])
    one, other = (
        {p.material: p for p in rt.trace(scene).levels[0].points if p.material == "chrome"} for scene in (both, neither)
    )
    np.testing.assert_array_equal(one["chrome"].weight, other["chrome"].weight)
    np.testing.assert_array_equal(one["chrome"].hit, other["chrome"].hit)


def test_cones_go_with_lenses_samples_and_tiles():
    eye = camera(12, aperture=0.3, samples=2, lens_samples=16)
    scene = replace(tiled(FLOOR, BALL), camera=replace(eye, target=(0, 0.4, 0)))
    system = rt.render(scene, progress=False, workers=2)
    np.testing.assert_array_equal(system.G.data, rt.render(scene, progress=False, workers=1).G.data)
    # Shares of what is seen sum to 1 in each pixel that is covered.
    assert system.G.toarray().sum(axis=1).max() == pytest.approx(1, abs=1e-12)


def test_the_plan_names_filtered_textures_and_files_ask_for_them(tmp_path):
    (tmp_path / "floor.toml").write_text(
        (SCENES / "spheres.toml").read_text().replace('type = "checker"', 'type = "checker"\nfiltered = true')
    )
    assert "footprints" in rt.plan(rt.load_scene(tmp_path / "floor.toml"))
    (tmp_path / "wrong.toml").write_text(
        (SCENES / "spheres.toml").read_text().replace('type = "checker"', 'type = "checker"\nfiltered = "yes"')
    )
    with pytest.raises(rt.SceneError, match=r"textures\.tiles\.filtered = 'yes': it must be true or false"):
        rt.load_scene(tmp_path / "wrong.toml")
    scene = tiled(FLOOR)
    (planned,) = (one for one in rt.plan(scene).effects if one.name == "footprints")
    assert (planned.state, planned.called_by) == ("simulated", ("tiles",))
    assert "footprints" not in rt.plan(small("spheres", 8))
    with pytest.raises(ValueError, match=r"footprints cannot be left out: .*set filtered = false"):
        rt.plan(scene, force={"footprints": False})
    weight = rt.formula(replace(scene, camera=replace(scene.camera, width=8, height=6)), 4, 3)
    assert "weight_light" in str(weight)


def test_a_filter_moves_nothing_where_both_materials_are_of_one_colour():
    # In and behind glass that absorbs as well: shares sum to 1, and what rays went through is kept.
    plain = small("tinted", 12)
    filtered = replace(plain, textures=[replace(texture, filtered=True) for texture in plain.textures])
    palette = rt.Palette(rt.RGB, dict.fromkeys(plain.symbols, 0.6))
    one, other = (rt.shade(rt.render(scene, progress=False), palette).values for scene in (plain, filtered))
    np.testing.assert_allclose(one, other, rtol=1e-12)
    assert "absorption" in rt.plan(filtered)
