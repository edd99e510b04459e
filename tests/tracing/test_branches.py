"""A hit may send on several rays: a toy glass, a toy lamp and a light of two samples, each registered from here alone.

Nothing else of symrt changes for them: an effect is one file and one entry in a list.
"""

import json
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import sympy
from linear.test_formulas import at_50_digits
from scenes_for_tests import camera, every_scene, mirrors, small
from tracing.toys import BACK, EMBER, GATHER, GLASS, MIRRORED, SCATTER, Twin

import symrt as rt
from symrt.tracing import effects


@pytest.fixture
def glass(monkeypatch):
    """The toy glass in the place of mirrors."""
    monkeypatch.setattr(effects, "EFFECTS", (*(e for e in effects.EFFECTS if e.name != "mirrors"), GLASS))


def furnace(depth):
    """A closed ball of mirror and paint with a lamp in its middle, and the camera inside."""
    return rt.Scene(
        camera=rt.Camera(position=(0.25, 0.125, 0), target=(0, 0, 0.5), width=4, height=4, field_of_view=60),
        shapes=[rt.Sphere(centre=(0, 0, 0), radius=2, material="wall")],
        materials=[rt.Material("wall", model=["lambert", "mirror"])],
        lights=[rt.PointLight("lamp", position=(0, 0, 0))],
        depth=depth,
    )


@pytest.mark.usefixtures("glass")
@pytest.mark.parametrize("depth", [0, 1, 5])
def test_a_furnace_of_two_branches_is_the_geometric_series(depth):
    tree = rt.trace(furnace(depth))
    assert [level.size for level in tree.levels] == [16 * 2**k for k in range(depth + 1)]
    assert [len(level.branches) for level in tree.levels] == [0] + [2] * depth
    system = rt.collapse(tree)
    # Wherever the wall is seen the lamp gives it 1/(π 2²), and each ray brings the same again: Σ K^k.
    assert [str(i) for i in system.interactions] == [
        "*".join(["lamp", "wall.diffuse", *([f"wall.mirror**{k}" if k > 1 else "wall.mirror"] if k else [])])
        for k in range(depth + 1)
    ]
    np.testing.assert_allclose(system.G.toarray(), 1 / (4 * np.pi), rtol=1e-14)
    # What is cut off is the rest of the series: both rays of each last hit, and nothing else.
    share = 0.8
    palette = rt.Palette(rt.RGB, {"lamp": 4 * np.pi, "wall.diffuse": 1.0, "wall.mirror": share}, unphysical=True)
    image = rt.shade(system, palette)
    rest = share ** (depth + 1) / (1 - share)
    np.testing.assert_allclose(image.values, (1 - share ** (depth + 1)) / (1 - share), rtol=1e-13)
    assert np.all(image.cut_off >= rest * (1 - 1e-12))
    assert np.all(image.cut_off <= 1.01 * rest)


@pytest.mark.parametrize("depth", [0, 1, 3])
@pytest.mark.parametrize("model", ["lambert", ["lambert", "mirror"]])
def test_light_gathered_by_a_formula_of_lights_counts_in_the_certificate(monkeypatch, model, depth):
    # Of every ray a diffuser sends on its albedo ρ, and a mirror beside it m of another: the rest is a series.
    monkeypatch.setattr(effects, "EFFECTS", (*effects.EFFECTS, GATHER))
    scene = furnace(depth)
    scene = replace(scene, materials=[rt.Material("wall", model=model)])
    system = rt.collapse(rt.trace(scene))
    mirror = {"wall.mirror": 0.04} if isinstance(model, list) else {}
    for share in (0.3, 0.5, 0.7, 0.9, 0.95):
        palette = rt.Palette(rt.RGB, {"lamp": 4 * np.pi, "wall.diffuse": share} | mirror)
        image, sent = rt.shade(system, palette), share + sum(mirror.values())
        missing = share * sent ** (depth + 1) / (1 - sent)
        np.testing.assert_allclose(image.values, share / (1 - sent) - missing, rtol=1e-13)
        # The lamp's bound is of a surface that is white: by 1/ρ it is too large, and by nothing else.
        assert np.all(image.cut_off >= missing)
        np.testing.assert_allclose(image.cut_off / missing, 1 / share, rtol=0.01)


@pytest.mark.usefixtures("glass")
def test_letters_are_unique_by_branch():
    tree = rt.trace(furnace(2))
    formula = rt.formula(tree, 1, 2)
    for place in ("2r1", "2r2", "3r1r1", "3r1r2", "3r2r1", "3r2r2"):
        assert formula.values[f"n_dot_l_{place}"] == pytest.approx(1.0, rel=1e-12)
        assert formula.values[f"weight_{place}"] == (MIRRORED if place.endswith("1") else BACK)
    spectra = {"lamp": 4 * np.pi, "wall.diffuse": 1.0, "wall.mirror": 0.5}
    assert formula.evaluate(spectra) == pytest.approx(1.75, rel=1e-13)


@pytest.mark.usefixtures("glass")
def test_formula_linear_form_and_pixel_of_two_branches_are_one():
    scene = replace(mirrors(model=["phong_plain", "mirror"], exponent=8, depth=3), camera=camera(16))
    tree = rt.trace(scene)
    system = rt.collapse(tree)
    palette = rt.Palette(rt.RGB, {symbol: 0.3 + 0.05 * k for k, symbol in enumerate(scene.symbols)})
    image = rt.shade(system, palette).values
    spectra = {symbol: float(palette[symbol][0]) for symbol in scene.symbols}
    branching = 0
    for y in range(0, 16, 3):
        for x in range(16):
            letters, linear = rt.formula(tree, x, y), rt.formula(system, x, y)
            branching += any("_2r1" in name for name in letters.values)
            terms = max(1, len(sympy.Add.make_args(linear.expression)))
            for formula in (letters, linear):
                error = abs(at_50_digits(formula, spectra) - sympy.Float(float(image[y, x, 0]), 50))
                assert error <= max(4, terms) * np.spacing(image[y, x, 0])
    assert branching > 3
    assert tree.rays["toy glass"] > 0
    assert "toy glass" in rt.plan(scene)


@pytest.mark.usefixtures("glass")
def test_whole_and_tiles_of_two_branches_have_the_same_bits():
    scene = replace(mirrors(model=["lambert", "mirror"], depth=3), camera=camera(16))
    whole = rt.collapse(rt.trace(scene))
    part = rt.collapse(rt.trace(scene, window=(3, 2, 11, 9)))
    rows = whole.G.toarray().reshape(16, 16, -1)[2:9, 3:11].reshape(56, -1)
    for j, interaction in enumerate(part.interactions):
        np.testing.assert_array_equal(part.G[:, [j]].toarray()[:, 0], rows[:, whole.interactions.index(interaction)])
    assert np.count_nonzero(rows) == part.G.nnz


def test_light_that_hits_send_by_themselves_is_a_column_of_degree_0(monkeypatch):
    monkeypatch.setattr(effects, "EFFECTS", (*effects.EFFECTS, EMBER))
    tree = rt.trace(replace(mirrors(model="mirror", depth=2), camera=camera(8)))
    system = rt.collapse(tree)
    column = [str(i) for i in system.interactions].index("ember")
    seen = np.bincount(tree.film.pixel[tree.levels[0].sample], minlength=64) > 0
    np.testing.assert_array_equal(system.G[:, [column]].toarray()[:, 0], np.where(seen, 0.125, 0.0))
    assert "ember*ball.mirror" in map(str, system.interactions)
    y, x = divmod(int(np.flatnonzero(seen)[0]), 8)
    assert "ember*radiance" in rt.formula(tree, x, y).text()


def test_a_parameter_of_a_formula_that_sends_rays_on_cannot_stay_free(monkeypatch):
    monkeypatch.setattr(effects, "EFFECTS", (*effects.EFFECTS, SCATTER))
    tree = rt.trace(replace(mirrors(model="phong", depth=1, exponent=20), camera=camera(4)))
    with pytest.raises(ValueError, match=r"ball\.exponent cannot stay free: rays are sent on by the formula direct"):
        rt.collapse(tree, free=["ball.exponent"])


def test_a_light_may_reach_a_hit_several_times():
    base = replace(mirrors(model="lambert"), camera=camera(12))
    halves = [rt.PointLight(name, position=(x, 4, 2)) for name, x in (("one", -1.0), ("two", 1.0))]
    twin, pair = (rt.collapse(rt.trace(replace(base, lights=lights))) for lights in ([Twin("twin")], halves))
    for symbol in ("ball.diffuse", "floor.diffuse"):
        both = sum(
            pair.G[:, [list(map(str, pair.interactions)).index(f"{n}*{symbol}")]].toarray() for n in ("one", "two")
        )
        own = twin.G[:, [list(map(str, twin.interactions)).index(f"twin*{symbol}")]].toarray()
        np.testing.assert_allclose(own, both / 2, rtol=1e-14)
    tree = rt.trace(replace(base, lights=[Twin("twin")]))
    text = str(rt.formula(tree, 6, 10))
    assert "n_dot_l_l1" in text
    assert "n_dot_l_l2" in text


@pytest.mark.parametrize(
    ("name", "model"),
    [*((name, ["lambert", "mirror"]) for name in ("shadows", "ambient", "mirrors")), ("shadows", "lambert")],
)
def test_an_effect_left_out_on_request_is_bounded(name, model):
    scene = replace(mirrors(model=model, depth=3), camera=camera(12))
    whole, without = (rt.render(scene, force=force, progress=False) for force in (None, {name: False}))
    palette = rt.Palette(rt.RGB, dict.fromkeys(scene.symbols, 0.5))
    full, cut = rt.shade(whole, palette), rt.shade(without, palette)
    difference = np.abs(full.values - cut.values).max(axis=(0, 1))
    assert np.all(difference > 0)
    assert np.all(difference <= cut.cut_off)
    assert np.all(np.isfinite(cut.cut_off))
    chosen = rt.plan(scene, force={name: False})
    assert name not in chosen
    (planned,) = (effect for effect in chosen.effects if effect.name == name)
    assert (planned.state, planned.why) == ("left out, bounded", "it was left out on request")


def test_what_cannot_be_forced_says_why():
    scene = small("globe", 8)
    for force, says in (
        ({"mirors": False}, "there is no effect 'mirors'; did you mean 'mirrors'"),
        ({"textures": False}, "textures cannot be left out: a surface with a texture has no other material"),
        ({"ambient": True}, "nothing calls for ambient"),
    ):
        with pytest.raises(ValueError, match=says):
            rt.plan(scene, force=force)
    with pytest.raises(ValueError, match="mirrors cannot be simulated: the depth is 0"):
        rt.plan(replace(small("spheres", 8), depth=0), force={"mirrors": True})


# --- An effect that nothing calls for costs nothing -------------------------------------------------------------------


CHEAP = ("first", "globe", "spheres", "soft_shadow", "fluorescent", "cornell")
"""Scenes that are asked about at once; together they call for most effects, and each leaves most of them aside."""


@pytest.mark.parametrize(
    "names",
    [CHEAP, pytest.param(tuple(sorted({*every_scene()} - {*CHEAP})), marks=pytest.mark.exhaustive)],
    ids=["some", "the rest"],
)
def test_an_effect_that_nothing_calls_for_costs_nothing(names):
    # In a process of its own, where nothing watches types: bits, rays, calls of Python and of C, and peak bytes, with
    # the whole list of effects and with the list cut down to the plan.
    home = os.environ | {
        "PYTHONPATH": os.pathsep.join(map(str, (Path(rt.__file__).parents[1], Path(__file__).parents[1])))
    }
    script = Path(__file__).with_name("uncalled.py")
    said = subprocess.run([sys.executable, script, *names], capture_output=True, text=True, check=True, env=home)
    measured = json.loads(said.stdout)
    assert set(measured) == set(names)
    for name, sizes in measured.items():
        assert [found["same bits"] and found["same rays"] for found in sizes] == [True, True], name
        few, many = (found["more calls"] for found in sizes)
        assert few == many, name
        assert few <= 8 * sizes[0]["left aside"], name
        # Arrays are as many and as large; the interpreter's own small objects come and go by some kilobytes.
        assert all(abs(found["more bytes"]) <= 4096 < 0.02 * found["bytes"] for found in sizes), (name, sizes)


def as_far_as_they_commute(met):
    """Sorted between those that end in fluorescence, which stay."""
    if not (matrices := [k for k, name in enumerate(met) if name.endswith("fluorescence")]):
        return tuple(sorted(met))
    first = matrices[0]
    return (*sorted(met[:first]), met[first], *as_far_as_they_commute(met[first + 1 :]))


@pytest.mark.parametrize("name", every_scene())
def test_columns_in_the_order_met_merge_into_the_sorted_system(name, tmp_path):
    tree = rt.trace(small(name, 32))
    ordered, usual = rt.collapse(tree, ordered=True), rt.collapse(tree)
    merged = {}
    for j, interaction in enumerate(ordered.interactions):
        key = replace(interaction, met=as_far_as_they_commute(interaction.met))
        column = ordered.G[:, [j]].toarray()[:, 0]
        merged[key] = merged[key] + column if key in merged else column
    assert sorted(merged) == list(usual.interactions)
    for j, interaction in enumerate(usual.interactions):
        np.testing.assert_array_equal(merged[interaction], usual.G[:, [j]].toarray()[:, 0])
    if name == "spheres":
        met = {interaction.met for interaction in ordered.interactions}
        # From the light to the eye: the red ball in the chrome one is met before it.
        assert ("red.diffuse", "chrome.mirror") in met
        rt.save_system(tmp_path / "ordered.npz", ordered)
        assert rt.load_system(tmp_path / "ordered.npz").interactions == ordered.interactions
