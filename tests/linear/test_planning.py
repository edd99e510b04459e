"""A plan foretells what a render will count, and what pixels miss without an effect; what is little is left out."""

from dataclasses import replace

import numpy as np
import pytest
from scenes_for_tests import camera, lamps, mirrors, small

import symrt as rt
from symrt.reflection import diffuse, mirror, n_dot_l


def without_times(plan):
    return {n: (one.rays, one.most, one.mean, one.certified) for n, one in plan.expectation.effects.items()}


def dim():
    """A ball that mirrors a little, above a floor that the sun hardly touches."""
    scene = mirrors(model=rt.Model(direct=diffuse * n_dot_l / np.pi, reflected=0.2 * mirror), depth=2)
    return replace(scene, camera=camera(16), lights=[rt.DirectionalLight("sun", direction=(-1, -0.05, -1))])


@pytest.mark.parametrize(
    "name",
    ["first", "spheres", *(pytest.param(name, marks=pytest.mark.exhaustive) for name in ("glass", "soft_shadow"))],
)
def test_expected_rays_are_those_of_the_render(name):
    scene = small(name, 64)
    expected = rt.plan(scene, probe=True)
    counts = rt.trace(scene).counts.effects
    assert list(expected.expectation.effects) == list(counts)
    for effect, one in expected.expectation.effects.items():
        assert one.rays == pytest.approx(counts[effect].rays, rel=0.1, abs=64)
        assert one.seconds >= 0


def test_what_is_missed_is_the_difference_of_two_pictures():
    # All reflectances are 1, and a light at a time is as bright as makes its white 1.
    scene = replace(mirrors(model=["lambert", "mirror"], depth=2), camera=camera(16))
    expected = rt.plan(scene, probe=True).expectation.effects
    assert expected["camera"].most is None
    for name in ("shadows", "mirrors", "ambient"):
        systems = [rt.render(scene, force=force, progress=False) for force in (None, {name: False})]
        shares = []
        for light in systems[0].lights:
            spectra = {s: 1.0 if "." in s else 0.0 for s in scene.symbols} | {light: 1 / systems[0].white[light]}
            one, other = (rt.shade(system, rt.Palette(rt.RGB, spectra)).values[..., 0] for system in systems)
            shares.append(np.abs(one - other))
        share = np.max(shares, axis=0)
        assert (expected[name].most, expected[name].mean) == pytest.approx((share.max(), share.mean()), rel=1e-12)
        assert expected[name].certified >= expected[name].most > 0


def test_all_but_the_times_is_the_same_each_time():
    assert without_times(rt.plan(dim(), probe=True)) == without_times(rt.plan(dim(), probe=True))


@pytest.mark.parametrize("seed", range(2))
def test_no_palette_misses_more(seed):
    scene = replace(mirrors(model=["phong", "mirror"], exponent=8, depth=2), camera=camera(16))
    rng = np.random.default_rng(seed)
    palette = rt.Palette(rt.RGB, {s: rng.uniform(0, 1, 3) * (1 if "." in s else 9) for s in scene.symbols})
    for name, one in rt.plan(scene, probe=True).expectation.effects.items():
        if one.most is not None:
            systems = [rt.render(scene, force=force, progress=False) for force in (None, {name: False})]
            whole, less = (rt.shade(system, palette) for system in systems)
            white = sum(value * palette[light] for light, value in systems[0].white.items())
            assert np.all(np.abs(whole.values - less.values) <= one.most * white * (1 + 1e-12))


def test_an_effect_that_is_hardly_missed_is_left_out_and_bounded():
    scene = dim()
    missed = rt.plan(scene, probe=True).expectation.effects["mirrors"]
    assert 0 < missed.most < 0.02
    chosen = rt.plan(scene, tolerance=0.02)
    (planned,) = (effect for effect in chosen.effects if effect.name == "mirrors")
    assert (planned.state, planned.why) == (
        "left out, bounded",
        "without it pixels miss less than the tolerance, 2%",
    )
    for kept in (
        rt.plan(scene),
        rt.plan(scene, tolerance=missed.most / 2),
        rt.plan(scene, tolerance=0.02, force={"mirrors": True}),
    ):
        assert "mirrors" in kept
    # A render does the same, what it misses is less than its certificate says, and a trace may be given the plan.
    system, whole = (rt.render(scene, tolerance=t, progress=False) for t in (0.02, 0))
    traced = rt.collapse(rt.trace(scene, planned=chosen))
    assert (traced.G != system.G).nnz == 0
    assert "mirrors" not in system.counts.effects
    palette = rt.Palette(rt.RGB, dict.fromkeys(scene.symbols, 0.7))
    full, less = (rt.shade(one, palette) for one in (whole, system))
    missing = np.abs(full.values - less.values).max()
    assert 0 < missing <= less.cut_off.max()
    with pytest.raises(ValueError, match="the plan has its own force and tolerance"):
        rt.trace(scene, planned=chosen, tolerance=0.1)


def test_what_was_left_out_on_request_is_told_what_it_is_worth():
    scene = replace(mirrors(model=["lambert", "mirror"], depth=2), camera=camera(16))
    whole, less = (rt.plan(scene, force=force, probe=True).expectation for force in (None, {"mirrors": False}))
    assert less.effects["mirrors"].rays == 0
    assert less.effects["mirrors"].most == pytest.approx(whole.effects["mirrors"].most, rel=1e-12)
    # What is beyond the depth cannot be compared with anything.
    flat = rt.plan(replace(scene, depth=0), probe=True)
    assert "mirrors" not in flat.expectation.effects
    assert "the depth is 0" in str(flat)


def test_scenes_of_many_rays_are_probed_by_fewer_pixels():
    expected = rt.plan(lamps(40), probe=True).expectation
    assert expected.pixels < 16**2
    assert expected.effects["shadows"].most > 0
    assert "lamp0, lamp1, lamp2 … lamp39, 40 in all" in " ".join(str(rt.plan(lamps(40))).split())


def test_a_plan_shows_itself_in_a_notebook():
    shown = rt.plan(dim(), probe=True)._repr_html_()
    assert "<th>without it pixels miss</th>" in shown
    assert "<td>mirrors</td>" in shown


def test_effects_leave_a_plan_and_come_back():
    chosen = rt.plan(dim())
    assert chosen.without("mirrors").restored("mirrors").effects[2].state == "simulated"
    for wrong in ("textures", "mirors"):
        with pytest.raises(ValueError, match="cannot be left out of this plan"):
            chosen.without(wrong)
