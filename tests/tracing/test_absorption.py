"""Absorption in glass: closed forms, the plain tracer, bounds of the nodes that lengths are spread over, refusals."""

import math
from dataclasses import replace
from itertools import pairwise

import mpmath
import numpy as np
import pytest
import reference
from scenes_for_tests import small
from test_pictures import BALL, SUN, TILE, scene, write_scene

import symrt as rt
from symrt.feedback.along import along
from symrt.feedback.sensitivity import _gradient
from symrt.interactions import Interaction
from symrt.lengths import Lengths, lengths_for
from symrt.reflection import Model, reflectance
from symrt.tracing.effects.absorption import _put, _taken

TINTED = ["glass", "absorption"]
WALL = rt.Rectangle((0, 0, -4), (40, 0, 0), (0, 40, 0), "wall")


def before_a_wall(*shapes, index=1.5, model=TINTED, size=24, **changes):
    """Glass before a wall that is lit from everywhere."""
    return rt.Scene(
        camera=rt.Camera(position=(0, 0, 6), target=(0, 0, 0), width=size, height=size, field_of_view=24),
        shapes=[*shapes, WALL],
        materials=[rt.Material("glass", model, index=index), rt.Material("wall")],
        lights=[rt.AmbientLight("sky")],
        depth=changes.pop("depth", 6),
        **changes,
    )


def view(x, y, size=24):
    """The unit direction through the middle of a pixel of that camera."""
    half = math.tan(math.radians(12))
    direction = np.array([half * ((x + 0.5) * 2 / size - 1), half * (1 - (y + 0.5) * 2 / size), -1.0])
    return direction / np.linalg.norm(direction)


def palette(scene, transmittance, **spectra):
    return rt.Palette(rt.RGB, dict.fromkeys(scene.symbols, 1.0) | {"glass.transmittance": transmittance} | spectra)


# --- Closed forms -----------------------------------------------------------------------------------------------------


def test_a_ball_that_bends_nothing_absorbs_along_its_chords():
    scene = before_a_wall(rt.Sphere((0, 0, 0), 1, "glass"), index=1.0)
    tree = rt.trace(scene)
    system = rt.collapse(tree)
    share = [0.3, 0.9, 0.02]
    image = rt.shade(system, palette(scene, share)).values
    error = system.lengths["glass.transmittance"].error
    for y in range(0, 24, 3):
        for x in range(24):
            # Chord 2 √(R² − b²), b the distance from the ball's centre to the ray.
            eye, direction = np.array([0, 0, 6.0]), view(x, y)
            inside = 1 - eye @ eye + (eye @ direction) ** 2
            left = np.array(share) ** (2 * math.sqrt(max(inside, 0.0)))
            formula = rt.formula(tree, x, y)
            for band in range(3):
                spectra = dict.fromkeys(formula.symbols, 1.0) | {"glass.transmittance": share[band]}
                assert formula.evaluate(spectra) == pytest.approx(left[band], rel=1e-12)
            assert np.all(image[y, x] >= left - 1e-14)
            assert np.all(image[y, x] <= left + error)


def test_a_slab_absorbs_along_the_bent_way():
    # At the angle i the way through a slab of thickness w is w / cos t, with sin t = sin i / n.
    scene = before_a_wall(rt.Box((0, 0, 0), (30, 30, 0.8), "glass"), index=1.5, depth=2)
    tree = rt.trace(scene)
    for x, y in ((0, 0), (5, 12), (23, 7)):
        cosine = -view(x, y)[2]
        bent = math.sqrt(1 - (1 - cosine**2) / 1.5**2)
        across, along = (cosine - 1.5 * bent) / (cosine + 1.5 * bent), (1.5 * cosine - bent) / (1.5 * cosine + bent)
        through = (1 - (across**2 + along**2) / 2) ** 2
        formula = rt.formula(tree, x, y)
        assert [v for k, v in formula.values.items() if k.startswith("d_")] == pytest.approx([0.8 / bent], rel=1e-13)
        seen = formula.evaluate({"sky": 1.0, "wall.diffuse": 1.0, "glass.transmittance": 0.4})
        assert seen == pytest.approx(through * 0.4 ** (0.8 / bent), rel=1e-12)


def test_lengths_of_one_glass_are_added_up_before_they_are_spread():
    # Two panes of one glass, one behind the other: two lengths, one power.
    panes = (rt.Box((0, 0, z), (30, 30, 0.5), "glass") for z in (0, -1))
    system = rt.collapse(rt.trace(before_a_wall(*panes, index=1.0, size=4, depth=4)))
    assert {len(i.powers) for i in system.interactions} == {1}
    assert {length for i in system.interactions for _, length in i.powers} == {1.0, 1.122}
    np.testing.assert_allclose(system.G.sum(axis=1), 1.0, rtol=1e-15)


@pytest.mark.parametrize("index", [1.0, 1.5])
def test_a_transmittance_of_1_is_clear_glass_to_4_ulp(index):
    shapes = rt.Sphere((0, 0, 0), 0.8, "glass"), rt.Box((0.4, 0.2, -2), (1, 1, 1), "glass")
    tinted, clear = (before_a_wall(*shapes, index=index, model=model) for model in (TINTED, "glass"))
    plain = rt.Palette(rt.RGB, {"sky": 0.9, "wall.diffuse": [0.7, 0.1, 1.0]})
    seen = rt.shade(rt.collapse(rt.trace(clear)), plain).values
    again = rt.shade(rt.collapse(rt.trace(tinted)), plain.add({"glass.transmittance": 1.0})).values
    assert np.abs(again - seen).max() <= 4 * np.spacing(seen.max())
    np.testing.assert_array_max_ulp(again, seen, 4)


def test_glass_that_absorbs_nothing_is_not_asked():
    scene = before_a_wall(rt.Sphere((0, 0, 0), 0.8, "glass"), model="glass", size=8)
    tree = rt.trace(scene)
    assert "absorption" not in rt.plan(scene)
    assert all(not level.inside for level in tree.levels)
    assert rt.collapse(tree).lengths == {}


# --- The plain tracer -------------------------------------------------------------------------------------------------

AIR, BERRY = {"model": "glass", "index": 1 / 1.5}, {"model": "lambert"}
NESTED = scene(
    {"type": "sphere", "centre": [-0.9, 0.8, 0.2], "radius": 0.8, "material": "cobalt"},
    {"type": "sphere", "centre": [-0.7, 0.9, 0.4], "radius": 0.3, "material": "air"},
    {"type": "box", "centre": [1.0, 0.7, 0], "size": [1.2, 1.4, 1.0], "rotate": [0, 25, 0], "material": "amber"},
    {"type": "sphere", "centre": [1.0, 0.7, 0], "radius": 0.3, "material": "red"},
    {"type": "sphere", "centre": [1.2, 1.1, 0.1], "radius": 0.15, "material": "cobalt"},
    materials={
        "cobalt": {"model": TINTED, "index": 1.5},
        "amber": {"model": TINTED, "index": 1.3},
        "air": AIR,
    },
    lights={"sun": SUN, "sky": {"type": "ambient"}},
    depth=5,
)
MIXED = scene(
    BALL | {"material": "cloth"},
    TILE | {"material": "blue", "centre": [0, 0.9, -1.6], "edge_u": [4.0, 0, 0], "edge_v": [0, 2.4, 0]},
    textures={"cloth": {"type": "checker", "size": 0.3, "materials": ["cobalt", "amber"]}},
    materials={"cobalt": {"model": TINTED, "index": 1.5}, "amber": {"model": TINTED, "index": 1.3}},
    lights={"sun": SUN, "sky": {"type": "ambient"}},
    depth=3,
)


@pytest.mark.parametrize("table", [NESTED, MIXED], ids=["one within the other", "a checker of two"])
def test_the_plain_tracer_sees_the_same(table, tmp_path):
    write_scene(tmp_path, table)
    path = tmp_path / "scene.toml"
    ours, theirs = rt.load_scene(path), reference.load(path)
    width, height = 11, 8
    ours = replace(ours, camera=replace(ours.camera, width=width, height=height, samples=1))
    tree = rt.trace(ours)
    system = rt.collapse(tree)
    random = np.random.default_rng(5)
    spectra = {name: random.uniform(0.1, 1.0, 3).tolist() for name in ours.symbols}
    image = rt.shade(system, rt.Palette(rt.RGB, spectra)).values
    clear = rt.shade(system, rt.Palette(rt.RGB, spectra | dict.fromkeys(system.lengths, 1.0))).values
    interpolation = sum(lengths.error for lengths in system.lengths.values())
    glass = 0
    for y in range(height):
        for x in range(width):
            seen = np.array(reference.pixel(theirs, spectra, x, y, width, height))
            formula = rt.formula(tree, x, y)
            for band in range(3):
                value = formula.evaluate({name: spectra[name][band] for name in formula.symbols})
                assert value == pytest.approx(seen[band], rel=1e-9, abs=1e-12)
            above = image[y, x] - seen
            assert np.all((above >= -1e-9) & (above <= interpolation * clear[y, x] + 1e-9))
            glass += any(name.startswith("d_") for name in formula.values)
    assert glass > 10


def test_a_camera_within_glass_sees_through_it_from_the_start():
    scene = before_a_wall(rt.Sphere((0, 0, 6), 2.0, "glass"), index=1.0, size=4)
    formula = rt.formula(rt.trace(scene), 1, 1)
    assert formula.values["d"] == pytest.approx(2.0, rel=1e-12)
    assert str(formula.expression).count("glass.transmittance") == 1


def test_glasses_that_a_ray_is_in_are_taken_off_in_any_order():
    random, base = np.random.default_rng(2), 4
    for _ in range(200):
        stack, number = [], np.array([0])
        for _ in range(random.integers(1, 12)):
            glass = int(random.integers(1, base))
            if random.random() < 0.6:
                stack.append(glass)
                number = _put(number, glass, base)
            else:
                if stack:
                    del stack[max((k for k, g in enumerate(stack) if g == glass), default=len(stack) - 1)]
                number = _taken(number, glass, base)
            assert number[0] == sum(g * base**k for k, g in enumerate(reversed(stack)))
    for _ in range(80):
        number = _put(number, 3, base)
        assert number[0] > 0


# --- Nodes ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "lengths", [Lengths(20), Lengths(5), Lengths(7, "chebyshev"), Lengths(12, "chebyshev")], ids=str
)
def test_the_error_of_the_nodes_is_a_bound(lengths):
    random = np.random.default_rng(3)
    d = 10 ** random.uniform(-4, 3, 1000)
    share = np.concatenate([random.uniform(0, 1, 400), np.exp(-(10 ** random.uniform(-3, 4, 600)))])
    nodes, weights = lengths.weights(d)
    np.testing.assert_allclose(weights.sum(axis=0), 1.0, rtol=1e-14)
    error = (weights * share**nodes).sum(axis=0) - share**d
    assert np.abs(error).max() <= lengths.error
    if lengths.scheme == "hats":
        assert weights.min() >= 0
        assert error.min() >= -1e-15
        # The worst of all is nearly met: at the steepest transmittance between the nodes that are farthest apart.
        ratio = nodes[1] / nodes[0]
        worst = np.exp(-2 / (nodes[0] * np.sqrt(ratio)))
        middle = nodes.mean(axis=0)
        assert ((worst ** nodes[0] + worst ** nodes[1]) / 2 - worst**middle).max() > 0.9 * lengths.error
    assert np.all(lengths.below(d) <= d)


def test_the_error_of_hats_is_the_gap_of_a_logarithm():
    # (4/e²) max (ln x − its chord) over [1, q], found by mpmath at 30 digits.
    with mpmath.workdps(30):
        q = max(mpmath.mpf(str(after)) / mpmath.mpf(str(before)) for before, after in pairwise(Lengths(20)._decade))
        slope = mpmath.log(q) / (q - 1)
        gap = mpmath.log(1 / slope) - slope * (1 / slope - 1)
        assert Lengths(20).error == pytest.approx(float(4 / mpmath.e**2 * gap), rel=1e-10)


def test_as_many_nodes_as_the_error_asks_for():
    for error in (3e-2, 1e-3, 1e-5):
        found = lengths_for(error)
        assert found.error <= error < Lengths(found.a_decade - 1).error
    with pytest.raises(ValueError, match=r"error = 1e-09: more than 1000 nodes a decade of lengths; .*'chebyshev'"):
        lengths_for(1e-9)
    assert lengths_for(1e-9, "chebyshev").error <= 1e-9
    with pytest.raises(ValueError, match="there are 'hats' and 'chebyshev'"):
        lengths_for(1e-3, "splines")


def test_a_finer_error_comes_nearer_to_the_letters():
    tree = rt.trace(before_a_wall(rt.Sphere((0, 0, 0), 1, "glass"), index=1.3, size=12))
    exact = rt.coefficient_matrix(rt.expressions(tree), 12, 12, {"sky": 1.0})
    seen = rt.shade(exact, palette(before_a_wall(), 0.35)).values
    for how in (
        {"error": 1e-2},
        {},
        {"error": 1e-5},
        {"lengths": "chebyshev"},
        {"error": 1e-8, "lengths": "chebyshev"},
    ):
        system = rt.collapse(tree, **how)
        error = system.lengths["glass.transmittance"].error
        assert error <= how.get("error", 1e-3)
        assert np.abs(rt.shade(system, palette(before_a_wall(), 0.35)).values - seen).max() <= error
        signed = how.get("lengths") == "chebyshev"
        assert set(system.signed.values()) == ({"interpolation in glass.transmittance"} if signed else set())


# --- Bits, bounds, files ----------------------------------------------------------------------------------------------


def test_light_that_is_cut_off_is_bounded_with_what_glass_leaves_of_it():
    scene = replace(small("tinted", 16), depth=1)
    tinted = rt.load_palettes("tinted")["rgb"]
    deep, cut = (rt.shade(rt.collapse(rt.trace(replace(scene, depth=depth))), tinted) for depth in (12, 2))
    missing = (deep.values - cut.values).max(axis=(0, 1))
    assert np.all(missing <= cut.cut_off)
    assert np.all(missing > 0)
    # Through darker glass less can be missing.
    black = rt.shade(rt.collapse(rt.trace(scene)), tinted.replace({"wine.transmittance": 0.0}))
    assert np.all(black.cut_off <= rt.shade(rt.collapse(rt.trace(scene)), tinted).cut_off)


def test_absorption_left_out_on_request_is_bounded():
    scene = small("tinted", 16)
    tinted = rt.load_palettes("tinted")["rgb"]
    whole, clear = (rt.render(scene, force=force, progress=False) for force in (None, {"absorption": False}))
    assert clear.lengths == {}
    assert not any(i.powers for i in clear.interactions)
    seen, bright = rt.shade(whole, tinted), rt.shade(clear, tinted)
    difference = np.abs(bright.values - seen.values).max(axis=(0, 1))
    assert np.all(difference > 0.1 * seen.values.max())
    assert np.all(difference <= bright.cut_off)


def test_systems_with_lengths_are_written_and_read():
    system = rt.LinearSystem.of(
        "0.5*sun*wall.diffuse*wine.transmittance**1.5 + 2*sun*wine.transmittance**2", "0.25*sun*wine.transmittance**.5"
    )
    assert [str(i) for i in system.interactions] == [
        "sun*wine.transmittance**0.5",
        "sun*wall.diffuse*wine.transmittance**1.5",
        "sun*wine.transmittance**2",
    ]
    assert system.reflectances == ("wall.diffuse", "wine.transmittance")
    for interaction in (*system.interactions, Interaction("sun", powers=(("w.t", 1e-7), ("x.t", 12.59)))):
        assert rt.LinearSystem.of(str(interaction)).interactions == (interaction,)
    share, wall = 0.3, 0.7
    image = rt.shade(system, rt.Palette(rt.RGB, {"sun": 1.0, "wall.diffuse": wall, "wine.transmittance": share}))
    expected = [0.5 * wall * share**1.5 + 2 * share**2, 0.25 * share**0.5]
    assert image.values[0, :, 0].tolist() == pytest.approx(expected, rel=1e-15)
    for text in ("sun*wine.transmittance**0.0", "sun*wine.transmittance**1e999"):
        with pytest.raises(ValueError, match="is no length: write a number above 0"):
            rt.LinearSystem.of(text)


def test_systems_with_lengths_are_saved_and_loaded(tmp_path):
    for how in ("hats", "chebyshev"):
        system = rt.render(small("tinted", 6), lengths=how, error=1e-2, progress=False)
        rt.save_system(tmp_path / f"{how}.npz", system)
        again = rt.load_system(tmp_path / f"{how}.npz")
        assert again.interactions == system.interactions
        assert again.lengths == system.lengths
        assert again.tail.interactions == system.tail.interactions
        np.testing.assert_array_equal(again.G.toarray(), system.G.toarray())
        assert again.signed == system.signed
        assert repr(again) == repr(system)


# --- Step 5 -----------------------------------------------------------------------------------------------------------


def test_scales_and_blends_answer_but_for_those_of_a_transmittance():
    scene = small("tinted", 16)
    scene = replace(scene, materials=[*scene.materials, rt.Material("ink", TINTED, index=1.34)])
    system = rt.render(scene, progress=False)
    tinted = rt.load_palettes("tinted")["rgb"].add({"ink.transmittance": 0.1})
    seen = rt.shade(system, tinted).values.reshape(-1, 3)
    for parameter in (rt.Scale("sky"), rt.Scale("wall"), rt.Exposure(), rt.Blend("berry", "wall")):
        line = along(system, tinted, parameter)
        c = line.coefficients(slice(None))
        given = c.sum(axis=0) if line.form == "power" else c[0]
        np.testing.assert_allclose(given, seen, rtol=1e-12, err_msg=str(parameter))
    for parameter in (rt.Scale("wine"), rt.Scale("wine.transmittance"), rt.Blend("wine", "ink")):
        with pytest.raises(ValueError, match=r"wine\.transmittance: light that goes a length d .*palette\.replace"):
            along(system, tinted, parameter)


def test_what_another_transmittance_would_move_is_its_derivative():
    system = rt.LinearSystem.of("0.5*sun*wall.diffuse*wine.transmittance**1.5 + sun*wine.transmittance**0.5")
    at, step = {"sun": 1.0, "wall.diffuse": 0.7, "wine.transmittance": 0.3}, 1e-6
    found = _gradient(system, rt.Palette(rt.RGB, at), 0, np.array([1.0, 0.0, 0.0]))
    for name in at:
        higher, lower = (
            rt.shade(system, rt.Palette(rt.RGB, at | {name: at[name] + d})).values[0, 0, 0] for d in (step, -step)
        )
        assert found[name][0] == pytest.approx((higher - lower) / (2 * step), rel=1e-8)


# --- Refusals ---------------------------------------------------------------------------------------------------------


def test_what_cannot_absorb_is_refused():
    with pytest.raises(ValueError, match=r"lets none in; stack it on glass"):
        rt.Material("wine", "absorption")
    with pytest.raises(ValueError, match=r"lets none in; stack it on glass"):
        rt.Material("wine", ["lambert", "absorption"])
    with pytest.raises(ValueError, match=r"inside = 2\*transmittance: it is one reflectance"):
        rt.Material("wine", [*TINTED, "absorption"], index=1.5)
    with pytest.raises(ValueError, match="a rectangle has no inside"):
        before_a_wall(rt.Rectangle((0, 0, 0), (1, 0, 0), (0, 1, 0), "glass"))
    with pytest.raises(ValueError, match="one reflectance"):
        Model(inside=reflectance("a") * reflectance("b"))


def test_a_transmittance_above_1_is_refused_in_any_palette():
    system = rt.LinearSystem.of("sun*wine.transmittance**1.5")
    with pytest.raises(ValueError, match=r"wine\.transmittance"):
        rt.Palette(rt.RGB, {"sun": 1.0, "wine.transmittance": 1.2})
    unphysical = rt.Palette(rt.RGB, {"sun": 1.0, "wine.transmittance": 1.2}, unphysical=True)
    with pytest.raises(ValueError, match=r"wine\.transmittance reaches 1\.2: light would grow on its way"):
        rt.shade(system, unphysical)
