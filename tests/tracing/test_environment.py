"""The sky: what is seen of it, what it gives to surfaces, and what stands before it."""

import math
from dataclasses import replace
from itertools import pairwise

import mpmath
import numpy as np
import pytest
from linear.test_formulas import at_50_digits
from scenes_for_tests import camera, mirrors, small

import symrt as rt
from symrt.scene.sky import SkyRegion
from symrt.scene.skylight import Patch, axes_of, patch_irradiance
from symrt.tracing.raytree import LightRecord

ALL = rt.Environment("sky", regions={"all": (-90, 90)})
BANDS = rt.Environment("sky", regions={"zenith": (40, 90), "horizon": (0, 40), "ground": (-90, 0)}, samples=128)


def under(sky, model="lambert", size=24, **changes):
    """A ball above a floor, under a sky alone."""
    scene = mirrors(model=model, **changes)
    return replace(scene, camera=camera(size, position=(0, 2, 6)), lights=[sky] if sky else scene.lights)


def alone(model, lights, **parameters):
    """A ball before the sky and nothing else."""
    scene = under(None, model=model, **parameters)
    return replace(scene, shapes=scene.shapes[:1], lights=lights)


def directions(count, seed=5):
    found = np.random.default_rng(seed).normal(size=(3, count))
    return found / np.linalg.norm(found, axis=0)


def test_regions_that_fill_the_sky_are_one_everywhere():
    skies = [
        BANDS,
        rt.Environment("sky", regions={"up": (0, 90), "a": (-90, 0, 10, 130), "b": (-90, 0, 130, 370)}, up=(1, 2, 3)),
    ]
    for sky in skies:
        total = sum(light.radiance(directions(2000)) for light in sky.lights)
        np.testing.assert_array_equal(total, 1.0)
        assert sum(light.bound(lambda _: 1.0) for light in sky.lights) == pytest.approx(4 * math.pi, rel=1e-12)
    # North is into the picture, east to the right.
    east = rt.Environment("sky", regions={"east": (-10, 10, 80, 100)}).lights[0]
    assert east.radiance(np.eye(3)).tolist() == [1.0, 0.0, 0.0]


@pytest.mark.parametrize("tilt", [0.0, 0.4, 1.1, 1.9, 2.8])
def test_the_irradiance_of_a_band_is_an_integral(tilt):
    low, high = math.radians(-20), math.radians(35)
    normal = np.array([[math.sin(tilt)], [math.cos(tilt)], [0.0]])
    found = patch_irradiance(Patch(low, high, 0.0, 2 * math.pi), axes_of((0, 1, 0), (0, 0, -1)), normal)

    def ring(e):
        # The part of a circle of one elevation that is above the horizon, n·ω integrated along it.
        b, h = math.cos(tilt) * mpmath.sin(e), abs(math.sin(tilt)) * mpmath.cos(e)
        if b >= h:
            return 2 * mpmath.pi * b * mpmath.cos(e)
        if b <= -h:
            return mpmath.mpf(0)
        half = mpmath.acos(-b / h)
        return 2 * (half * b + h * mpmath.sin(half)) * mpmath.cos(e)

    steep = abs(math.atan2(math.sin(tilt), math.cos(tilt)))
    steep = min(steep, math.pi - steep)
    places = sorted(
        {low, high, *(e for e in (math.pi / 2 - steep, steep - math.pi / 2, steep, -steep) if low < e < high)}
    )
    expected = float(mpmath.quad(ring, places))
    assert float(np.sum(found * normal)) == pytest.approx(expected, rel=1e-10, abs=1e-12)


def test_parts_of_the_way_round_add_up_to_the_whole():
    axes, normals = axes_of((0.1, 1, 0.2), (0, 0.3, -1)), directions(300)
    for low, high in ((-90, 90), (-90, -20), (-15, 40), (0, 90), (50, 80)):
        borders = np.radians([0, 20, 95, 200, 201, 360])
        ends = np.radians([low, high]).tolist()
        parts = sum(patch_irradiance(Patch(*ends, *two), axes, normals) for two in pairwise(borders.tolist()))
        whole = patch_irradiance(Patch(*ends, 0.0, 2 * np.pi), axes, normals)
        np.testing.assert_allclose(parts, whole, rtol=0, atol=1e-7)


def test_a_uniform_sky_is_ambient_light_where_nothing_hides_it():
    sky, ambient = (rt.render(alone("lambert", [light]), progress=False) for light in (ALL, rt.AmbientLight("sky_all")))
    lit = [str(i) for i in sky.interactions].index("sky_all*ball.diffuse")
    np.testing.assert_allclose(sky.G[:, [lit]].toarray(), ambient.G.toarray(), rtol=1e-13)
    assert sky.errors["sky_all"].largest == 0
    assert sky.white == {"sky_all": 1.0}


@pytest.mark.parametrize("model", ["mirror", "lambert", "metal", ["lambert", "mirror"]])
def test_a_white_ball_in_a_uniform_sky_vanishes(model):
    system = rt.render(alone(model, [ALL]), progress=False)
    share = 0.5 if isinstance(model, list) else 1.0
    names = {name for i in system.interactions for name in i.met}
    image = rt.shade(system, rt.Palette(rt.RGB, {"sky_all": 3.0} | dict.fromkeys(names, share)))
    np.testing.assert_allclose(image.values, 3.0, rtol=1e-12)


def test_below_a_ball_the_sky_is_hidden_as_the_closed_form_says():
    # A ball of radius 1 at the height 1.2 fills sin²α = (1/d)² of the irradiance, times the cosine to its middle.
    sky = rt.Environment("sky", regions={"up": (0, 90)}, samples=1024)
    scene = under(sky, size=16)
    tree = rt.trace(replace(scene, camera=replace(scene.camera, position=(0.0, 8.0, 0.01))))
    points = next(part for part in tree.levels[0].points if part.material == "floor")
    (lit,) = points.lit
    rays = np.stack(np.meshgrid(np.arange(16), np.arange(16)), axis=-1).reshape(-1, 2)[
        tree.film.pixel[tree.levels[0].sample[points.hit[lit.point]]]
    ]
    # The camera looks straight down: a pixel's place on the floor, 9.2 below it.
    half = 9.2 * math.tan(math.radians(20))
    off = np.hypot(*(((rays + 0.5) / 8 - 1) * half).T)
    clear = off > 0.05
    distance = np.hypot(off, 1.2)
    expected = 1 - 1.2 / distance**3
    error = np.abs(lit.visible - expected)[clear]
    assert error.max() < 0.04
    assert np.sqrt(np.mean(error**2)) < 2 * tree.errors["sky_up"].rms < 0.04


def test_tiles_have_the_same_bits():
    scene = under(BANDS, model=["lambert", "mirror"], size=16)
    whole, part = rt.collapse(rt.trace(scene)), rt.collapse(rt.trace(scene, window=(3, 2, 11, 9)))
    rows = whole.G.toarray().reshape(16, 16, -1)[2:9, 3:11].reshape(56, -1)
    for j, interaction in enumerate(part.interactions):
        np.testing.assert_array_equal(part.G[:, [j]].toarray()[:, 0], rows[:, whole.interactions.index(interaction)])
    assert np.count_nonzero(rows) == part.G.nnz


@pytest.mark.parametrize(("force", "depth"), [({"environment": False}, 4), ({"mirrors": False}, 4), (None, 0)])
def test_what_is_missing_of_the_sky_is_bounded(force, depth):
    scene = under(BANDS, model=["lambert", "mirror"], size=12)
    scene = replace(scene, lights=[*scene.lights, rt.AmbientLight("haze")])
    palette = rt.Palette(rt.RGB, dict.fromkeys(scene.symbols, 0.5))
    whole = rt.shade(rt.render(scene, progress=False), palette)
    cut = rt.shade(rt.render(replace(scene, depth=depth), force=force, progress=False), palette)
    difference = np.abs(whole.values - cut.values).max(axis=(0, 1))
    assert np.all((difference > 0.05) & (difference <= cut.cut_off) & (cut.cut_off < np.inf))


def test_the_sky_is_seen_once_and_is_no_object():
    scene = under(BANDS, model="mirror")
    tree = rt.trace(scene)
    system = rt.collapse(tree)
    seen = {str(i) for i in system.interactions}
    assert {"sky_horizon", "sky_zenith*ball.mirror", "sky_horizon*floor.diffuse"} <= seen
    assert "sky_ground*floor.diffuse" not in seen
    background = np.bincount(tree.film.pixel[tree.levels[0].sample], minlength=576) - sum(
        np.bincount(tree.film.pixel[tree.levels[0].sample[p.hit]], minlength=576) for p in tree.levels[0].points
    )
    np.testing.assert_array_equal(system.object_pixels, background == 0)
    assert rt.formula(tree, 0, 0).text() == "sky_horizon"
    assert system.glowing == ("sky_zenith", "sky_horizon", "sky_ground")


def test_formula_linear_form_and_pixel_are_one_under_the_sky():
    scene = small("sky", 16)
    tree = rt.trace(scene)
    system = rt.collapse(tree)
    palette = rt.Palette(rt.RGB, {symbol: 0.3 + 0.02 * k for k, symbol in enumerate(scene.symbols)})
    image = rt.shade(system, palette).values
    spectra = {symbol: float(palette[symbol][0]) for symbol in scene.symbols}
    for y, x in ((3, 8), (12, 5)):
        for formula in (rt.formula(tree, x, y), rt.formula(system, x, y)):
            error = abs(at_50_digits(formula, spectra) - float(image[y, x, 0]))
            assert error <= 4 * len(system.terms(16 * y + x)) * np.spacing(image[y, x, 0])


def test_highlights_are_lit_by_the_directions_themselves():
    sky = rt.Environment("sky", regions={"all": (-90, 90)}, samples=200)
    system = rt.render(alone("phong", [sky], exponent=0, size=8), progress=False)
    # An exponent of 0 makes the lobe a diffuser's: (0 + 2)/2π · n·l is 1/π · n·l.
    matte = rt.render(alone("lambert", [sky], size=8), progress=False)
    lobe = system.G[:, [[str(i) for i in system.interactions].index("sky_all*ball.specular")]].toarray()
    exact = matte.G[:, [[str(i) for i in matte.interactions].index("sky_all*ball.diffuse")]].toarray()
    np.testing.assert_allclose(lobe, exact, atol=0.02)
    assert rt.plan(alone("phong", [sky], exponent=0)).effects[0].called_by == ("sky_all",)


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"regions": {}}, "an environment has at least one region, each with its lowest and highest elevation"),
        ({"regions": {"up": (30, 0)}}, r"regions\.up = \[30, 0\]: elevations rise, from -90 to 90 degrees"),
        ({"regions": {"up": (0, 95)}}, r"regions\.up = \[0, 95\]: elevations rise"),
        ({"regions": {"up": (0, 90, 30)}}, "give two elevations, or these and two azimuths"),
        ({"regions": {"up": (0, 90, 30, 20)}}, "azimuths go east, by at most 360 degrees"),
        ({"regions": {"up": (0, math.nan)}}, "numbers must be finite"),
        ({"regions": {"the sky": (0, 90)}}, "regions = 'the sky': a name is a letter, then letters"),
        ({"north": (0, 2, 0)}, r"north = \[0, 2, 0\]: it is along up = \[0, 1, 0\]; turn one of them"),
        ({"samples": 3}, "samples = 3: it must be a whole number from 16 to 16384"),
        ({"shadows": 1}, "shadows = 1: it must be true or false"),
    ],
)
def test_a_wrong_sky_is_refused_in_one_line(changes, says):
    with pytest.raises(ValueError, match=says) as refusal:
        rt.Environment(**({"name": "sky", "regions": {"up": (0, 90)}} | changes))
    assert "\n" not in str(refusal.value)


def test_names_of_regions_are_unique_like_others():
    scene = under(BANDS)
    with pytest.raises(ValueError, match="the name 'sky_zenith' is already used in lights"):
        replace(scene, lights=[BANDS, rt.AmbientLight("sky_zenith")])
    assert [light.name for light in scene.lights] == ["sky_zenith", "sky_horizon", "sky_ground"]
    assert all(isinstance(light, SkyRegion) for light in scene.lights)
    assert LightRecord("direct", 1.0, 1.0, 1.0).glowing
