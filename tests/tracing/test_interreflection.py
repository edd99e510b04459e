"""Diffuse interreflection: furnaces, exact form factors, the plain tracer along the same rays, tiles, and bounds."""

import importlib
import math
from dataclasses import replace

import numpy as np
import pytest
import reference
from scipy.stats import qmc
from test_pictures import write_scene

import symrt as rt
from symrt.linear.job import make_job
from symrt.tracing.sobol import DIMENSIONS, sequence

gathering = importlib.import_module("symrt.tracing.gathering")


def ball(paths=4, depth=3, model="lambert", mirrors=2):
    """A closed ball of paint with a lamp in its middle, and the camera inside."""
    return rt.Scene(
        camera=rt.Camera(position=(0.25, 0.125, 0), target=(0, 0, 0.5), width=4, height=4, field_of_view=60),
        shapes=[rt.Sphere(centre=(0, 0, 0), radius=2, material="wall")],
        materials=[rt.Material("wall", model=model)],
        lights=[rt.PointLight("lamp", position=(0, 0, 0))],
        depth=mirrors,
        interreflection=rt.Interreflection(paths, depth),
    )


def cornell(size=16, paths=8, depth=3, lamp=None, **changes):
    """A box that is open in front, two boxes in it, and a rectangle that shines below its ceiling."""
    walls = [
        ((0, -1, 0), (2, 0, 0), (0, 0, -2), "white"),
        ((0, 1, 0), (2, 0, 0), (0, 0, 2), "white"),
        ((0, 0, -1), (2, 0, 0), (0, 2, 0), "white"),
        ((-1, 0, 0), (0, 0, -2), (0, 2, 0), "red"),
        ((1, 0, 0), (0, 0, 2), (0, 2, 0), "green"),
    ]
    boxes = [
        rt.Box((-0.33, -0.4, -0.3), (0.6, 1.2, 0.6), "white", rotate=(0, 18, 0)),
        rt.Box((0.35, -0.7, 0.3), (0.6, 0.6, 0.6), "white", rotate=(0, -17, 0)),
    ]
    scene = rt.Scene(
        camera=rt.Camera(position=(0, 0, 3.6), target=(0, 0, 0), field_of_view=40, width=size, height=size),
        shapes=[*(rt.Rectangle(*wall) for wall in walls), *boxes],
        materials=[rt.Material(name, "lambert") for name in ("white", "red", "green")],
        lights=[lamp or rt.RectangleLight("lamp", (0, 0.99, 0), edge_u=(0.5, 0, 0), edge_v=(0, 0, 0.5))],
        interreflection=rt.Interreflection(paths, depth),
    )
    return replace(scene, **changes)


def coloured(**changes):
    colours = {"lamp": [18, 15, 11], "white.diffuse": 0.74, "red.diffuse": [0.63, 0.06, 0.05]}
    return rt.Palette(rt.RGB, colours | {"green.diffuse": [0.14, 0.45, 0.09]} | changes)


def test_the_sequence_is_sobols():
    with np.errstate(all="ignore"):
        expected = qmc.Sobol(DIMENSIONS, scramble=False, bits=32).random(256)
    # Theirs is in the order of Gray's code.
    gray = np.arange(256) ^ np.arange(256) >> 1
    found = np.stack([sequence(256, k)[gray] for k in range(DIMENSIONS)], axis=1) * 2.0**-32
    np.testing.assert_array_equal(found, expected)


@pytest.mark.parametrize("depth", [0, 1, 4])
@pytest.mark.parametrize("paths", [1, 7, 8])
def test_a_furnace_is_the_geometric_series(depth, paths):
    # The lamp gives every place of the wall the same, and each bounce sends on ρ of it: Σ ρ^k, whatever the paths.
    system = rt.render(ball(paths, depth), progress=False)
    powers = [f"lamp*wall.diffuse**{k}" if k > 1 else "lamp*wall.diffuse" for k in range(1, depth + 2)]
    assert [str(i) for i in system.interactions] == powers
    np.testing.assert_allclose(system.G.toarray(), 1 / (4 * np.pi), rtol=1e-13)


def test_beside_mirrors_each_kind_of_bounce_has_a_depth_of_its_own():
    # Twice mirrored, twice scattered, in every order: binomials.
    system = rt.render(ball(3, 2, ["lambert", "mirror"], mirrors=2), progress=False)
    sums = {str(i): g for i, g in zip(system.interactions, system.G.toarray()[0] * 4 * np.pi, strict=True)}
    assert len(sums) == 9
    for d in range(3):
        for m in range(3):
            diffuse = f"*wall.diffuse**{d + 1}" if d else "*wall.diffuse"
            mirror = f"*wall.mirror**{m}" if m > 1 else "*wall.mirror" * m
            assert sums[f"lamp{diffuse}{mirror}"] == pytest.approx(math.comb(d + m, d), rel=1e-12)


@pytest.mark.parametrize("workers", [1, 2, pytest.param("processes", marks=pytest.mark.exhaustive)])
def test_tiles_and_workers_have_the_same_bits(workers):
    scene = cornell(72, 4)
    whole = rt.collapse(rt.trace(scene))
    assert len(make_job(scene).windows()) > 1
    rendered = rt.render(scene, workers=workers, progress=False)
    part = rt.collapse(rt.trace(scene, window=(3, 2, 11, 9)))
    np.testing.assert_array_equal(rendered.G.toarray(), whole.G.toarray())
    rows = whole.G.toarray().reshape(72, 72, -1)[2:9, 3:11].reshape(56, -1)
    for j, interaction in enumerate(part.interactions):
        np.testing.assert_array_equal(part.G[:, [j]].toarray()[:, 0], rows[:, whole.interactions.index(interaction)])
    assert np.count_nonzero(rows) == part.G.nnz


def test_a_scene_that_does_not_ask_has_the_same_light_from_its_lights():
    with_it = rt.render(cornell(), progress=False)
    without = rt.render(cornell(interreflection=None), progress=False)
    none = rt.render(cornell(depth=0), progress=False)
    for system in (without, none):
        assert {i.degree for i in system.interactions} == {1}
        for j, interaction in enumerate(system.interactions):
            column = with_it.G[:, [with_it.interactions.index(interaction)]]
            np.testing.assert_array_equal(system.G[:, [j]].toarray(), column.toarray())
    assert "interreflection" not in without.counts.effects
    assert without.tail.bound.nnz == 0
    assert none.tail.bound.nnz > 0
    chosen = {effect.name: effect for effect in rt.plan(cornell(depth=0)).effects}["interreflection"]
    assert (chosen.state, chosen.why) == ("left out, bounded", "its depth is 0")
    assert {effect.name: effect for effect in rt.plan(cornell(interreflection=None)).effects}[
        "interreflection"
    ].why == "the scene does not ask for it"


@pytest.mark.parametrize("depth", [0, 1, 2, 3])
def test_what_is_missing_is_within_the_bound(depth):
    # Of the same paths, deeper: what they bring is what is missing.
    deep, cut = (rt.render(cornell(8, 4, d), progress=False) for d in (8, depth))
    for share in (0.3, 0.5, 0.7, 0.9, 0.95):
        palette = coloured(**{f"{name}.diffuse": share for name in ("white", "red", "green")})
        image = rt.shade(cut, palette)
        missing = (rt.shade(deep, palette).values - image.values).max(axis=(0, 1))
        assert np.all(missing > 0)
        assert np.all(missing <= image.cut_off)
        assert np.all(np.isfinite(image.cut_off))


def test_fresh_trees_and_other_palettes_are_one():
    # Walls repainted after the fact, against a scene that was painted so from the beginning.
    system = rt.render(cornell(12, 4), progress=False)
    swapped = cornell(12, 4)
    names = {"red": "green", "green": "red"}
    shapes = [replace(s, material=names.get(s.material, s.material)) for s in swapped.shapes[:5]] + [
        *swapped.shapes[5:]
    ]
    fresh = rt.shade(rt.render(replace(swapped, shapes=shapes), progress=False), coloured())
    palette = coloured(**{"red.diffuse": [0.14, 0.45, 0.09], "green.diffuse": [0.63, 0.06, 0.05]})
    np.testing.assert_allclose(rt.shade(system, palette).values, fresh.values, rtol=1e-12)


def test_bad_input_says_what_to_do():
    for bad, says in (
        ({"paths": 0}, "paths = 0: it must be a whole number from 1 to 65536"),
        ({"paths": 2.5}, "paths = 2.5: it must be a whole number"),
        ({"depth": -1}, "depth = -1: it must be a whole number from 0 to 8"),
        ({"depth": 9}, "depth = 9: it must be a whole number from 0 to 8"),
    ):
        with pytest.raises(ValueError, match=says):
            rt.Interreflection(**bad)
    with pytest.raises(ValueError, match=r"interreflection = 64: ask with a record, such as Interreflection\(paths=64"):
        cornell(interreflection=64)


SHARES = (0.3, 0.5, 0.7, 0.9, 0.95)


@pytest.mark.parametrize("depth", [1, 2, 5])
def test_in_a_furnace_the_estimate_is_what_is_missing(depth):
    system = rt.render(ball(3, depth), progress=False)
    for share in SHARES:
        image = rt.shade(system, rt.Palette(rt.RGB, {"lamp": 4 * np.pi, "wall.diffuse": share}))
        missing = share ** (depth + 2) / (1 - share)
        np.testing.assert_allclose(image.missing, missing, rtol=1e-11)
        # The bound is of walls that are white: too large by 1/ρ, and by nothing else.
        np.testing.assert_allclose(image.cut_off, missing / share, rtol=0.01)
        assert np.all(image.cut_off >= missing)


@pytest.mark.parametrize("depth", [1, 2, 3])
def test_what_is_missing_is_estimated(depth, tmp_path):
    # Against the same paths eight bounces deep; with walls of more than 0.7 even those miss much.
    deep, cut = (rt.render(cornell(12, 8, d), progress=False) for d in (8, depth))
    rt.save_system(tmp_path / "cut.npz", cut)
    assert rt.load_system(tmp_path / "cut.npz").tail.gathered == cut.tail.gathered
    for share in SHARES:
        palette = coloured(**{f"{name}.diffuse": share for name in ("white", "red", "green")})
        image = rt.shade(cut, palette)
        missing = (rt.shade(deep, palette).values - image.values).max(axis=(0, 1))
        assert np.all(missing <= 3 * image.missing)
        assert np.all(image.missing <= (3 * missing if share <= 0.7 else image.cut_off))
        assert "by estimate" in image.certificate


def test_the_noise_told_is_that_of_other_paths(monkeypatch):
    # Pixels by the same number of paths, drawn anew, differ by √2 times the noise that each tells of itself.
    scene = cornell(16, 16, 2)
    one = rt.render(scene, progress=False)
    seeds = gathering.hashed
    monkeypatch.setattr(gathering, "hashed", lambda numbers: seeds(numbers ^ np.uint64(1 << 60)))
    other = rt.render(scene, progress=False)
    assert one.interactions == other.interactions
    difference = (one.G - other.G).sum(axis=1) / one.white["lamp"]
    rms = math.sqrt(np.mean(difference[difference != 0] ** 2) / 2)
    assert rms / 1.5 <= one.noise["lamp"].rms <= 1.5 * rms
    assert "the noise of lamp is about" in repr(one)
    assert rt.render(ball(1, 2), progress=False).noise == {}


def test_formula_linear_form_and_pixel_are_one():
    # Few letters, however many paths: one for each product of spectra that they gathered.
    scene = cornell(32, 64)
    tree = rt.trace(scene, window=(10, 28, 11, 29))
    system = rt.collapse(tree)
    palette = coloured()
    pixel = rt.shade(system, palette).values[0, 0]
    letters, linear = rt.formula(tree, 0, 0), rt.formula(system, 0, 0)
    for formula in (letters, linear):
        found = formula.evaluate({symbol: palette[symbol] for symbol in scene.symbols})
        np.testing.assert_allclose(found, pixel, rtol=1e-14)
    text = str(letters)
    assert "lamp*white.diffuse*irradiance*n_dot_l" in text
    assert "lamp*red.diffuse*E_2" in text
    assert len(letters.letters) < 20


FACING = 2 / math.pi * (math.log(2 / math.sqrt(3)) + 2 * math.sqrt(2) * math.atan(1 / math.sqrt(2)) - math.pi / 2)
"""The form factor of opposite faces of a cube (J. R. Howell, Catalogue of Radiation Configuration Factors, C-11)."""


@pytest.mark.parametrize(("glowing", "factor"), [("ceiling", FACING), ("left", (1 - FACING) / 4)])
def test_the_mean_of_a_cubes_floor_is_the_form_factor_of_the_face_that_glows(glowing, factor):
    assert pytest.approx(0.19982, abs=1e-5) == FACING
    faces = {
        "floor": ((0, -0.5, 0), (1, 0, 0), (0, 0, -1)),
        "ceiling": ((0, 0.5, 0), (1, 0, 0), (0, 0, 1)),
        "left": ((-0.5, 0, 0), (0, 0, -1), (0, 1, 0)),
        "right": ((0.5, 0, 0), (0, 0, 1), (0, 1, 0)),
        "back": ((0, 0, -0.5), (1, 0, 0), (0, 1, 0)),
        "front": ((0, 0, 0.5), (-1, 0, 0), (0, 1, 0)),
    }
    scene = rt.Scene(
        # Rays straight down, which spread evenly over the whole floor.
        camera=rt.Camera(
            type="orthographic",
            position=(0, 0.4, 0),
            target=(0, 0, 0),
            up=(0, 0, -1),
            view_width=1,
            width=32,
            height=32,
        ),
        shapes=[rt.Rectangle(*face, name) for name, face in faces.items()],
        materials=[rt.Material(name, "emitter" if name == glowing else "lambert") for name in faces],
        lights=[rt.SurfaceLight("glow", material=glowing)],
        interreflection=rt.Interreflection(paths=64, depth=1),
    )
    system = rt.render(scene, progress=False)
    assert [str(i) for i in system.interactions] == ["glow*floor.diffuse"]
    seen = system.G.toarray()
    spread = math.sqrt(factor * (1 - factor) / (64 * seen.size))  # of independent paths; these are more even
    assert seen.mean() == pytest.approx(factor, abs=2 * spread)


def test_the_plain_tracer_sees_the_same_along_the_same_rays(tmp_path, monkeypatch):
    # No digit is flipped: every hit sends its rays in the same directions about its normal.
    monkeypatch.setattr(gathering, "hashed", np.zeros_like)
    paths, effect = 6, importlib.import_module("symrt.tracing.effects.interreflection")
    balls = [
        {"type": "sphere", "centre": [-0.9, 0.8, 0], "radius": 0.8, "material": "red"},
        {"type": "sphere", "centre": [0.8, 0.6, 0.4], "radius": 0.6, "material": "white"},
        {"type": "plane", "point": [0, 0, 0], "normal": [0, 1, 0], "material": "white"},
    ]
    table = {
        "depth": 1,
        "camera": {"type": "perspective", "position": [0, 2, 5], "target": [0, 0.6, 0], "field_of_view": 40},
        "shapes": balls,
        "materials": {"red": {"model": "lambert"}, "white": {"model": "phong", "exponent": 20}},
        "lights": {"lamp": {"type": "point", "position": [2, 4, 3]}},
    }
    table["camera"] |= {"width": 12, "height": 9}
    write_scene(tmp_path, table)
    ours = replace(rt.load_scene(tmp_path / "scene.toml"), interreflection=rt.Interreflection(paths, depth=1))

    numbers = [sequence(paths, k) * 2.0**-32 + 2.0**-33 for k in (0, 1)]

    def scattered(hit, _):
        normal = np.repeat(np.array(hit.shading)[:, None], paths, axis=1)
        ways = effect._scattered(normal, *numbers).T.tolist()
        return [reference.Ray("ambient", tuple(way), 1 / paths) for way in ways]

    plain = reference.load(tmp_path / "scene.toml")._replace(sending=(scattered,), least=0.0)
    spectra = {
        "lamp": [90.0, 60.0],
        "red.diffuse": [0.6, 0.1],
        "white.diffuse": [0.8, 0.7],
        "white.specular": [0.1, 0.1],
    }
    expected = np.array(reference.picture(plain, spectra, 12, 9))
    seen = rt.shade(rt.render(ours, progress=False), rt.Palette(rt.wavelengths(500, 600, 100), spectra)).values
    np.testing.assert_allclose(seen, expected, rtol=1e-9, atol=0)
    alone = np.array(reference.picture(plain._replace(sending=()), spectra, 12, 9))
    assert (expected > 1.02 * alone).mean() > 0.3
