"""Surfaces and lamps that are seen to shine: columns of degree 0, counted once, bounded, and no objects."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scenes_for_tests import camera, mirrors, small
from tracing.toys import SCATTER

import symrt as rt
from symrt.reflection import n_dot_v, parameter, reflectance
from symrt.tracing import effects

STAR = rt.Model(emitted=1 - parameter("darkening") * (1 - n_dot_v))
LAMP = rt.RectangleLight("lamp", centre=(0, 2, -1), edge_u=(2, 0, 0), edge_v=(0, 0.4, 1), visible=True)


def star(model=STAR, size=25, **changes):
    """One ball that glows, seen from straight ahead and from far away, and nothing else."""
    return rt.Scene(
        **{
            "camera": camera(size, position=(0, 0, 1000), field_of_view=0.2),
            "shapes": [rt.Sphere(centre=(0, 0, 0), radius=1, material="star")],
            "materials": [rt.Material("star", model=model, **({"darkening": 0.6} if model is STAR else {}))],
            "lights": [rt.SurfaceLight("shine", material="star")],
        }
        | changes
    )


def room(model=("lambert", "mirror"), wall="emitter", depth=4):
    """A closed ball of one material around the camera."""
    return rt.Scene(
        camera=rt.Camera(position=(0.25, 0.125, 0), target=(0, 0, 0.5), width=4, height=4, field_of_view=60),
        shapes=[rt.Sphere(centre=(0, 0, 0), radius=2, material="wall")],
        materials=[rt.Material("wall", model=[*model, wall])],
        lights=[rt.SurfaceLight("glow", material="wall")],
        depth=depth,
    )


def test_a_star_is_darker_towards_its_edge():
    tree = rt.trace(star())
    system = rt.collapse(tree)
    # At a distance ρ of the disk's radius the cosine is √(1 − ρ²); the rays of so far an eye are parallel to 1e-3.
    y, x = np.mgrid[0:25, 0:25]
    off = 1000 * math.tan(math.radians(0.1)) * np.hypot((x - 12) / 12.5, (y - 12) / 12.5)
    inside = off < 0.95
    seen = system.G.toarray().reshape(25, 25, -1)[..., 0]
    expected = 1 - 0.6 * (1 - np.sqrt(np.maximum(1 - off**2, 0)))
    np.testing.assert_allclose(seen[inside], expected[inside], rtol=2e-3)
    assert [str(i) for i in system.interactions] == ["shine"]
    assert rt.formula(tree, 12, 12).text() == "shine*(0.6*n_dot_v + 0.4)"
    assert [e.called_by for e in rt.plan(star()).effects if e.name == "emission"] == [("shine",)]


def test_its_darkening_stays_free_and_may_have_a_colour():
    free = rt.collapse(rt.trace(star()), free={"star.darkening": (0.2, 0.9)}).at({"star.darkening": 0.6})
    np.testing.assert_allclose(free.G.toarray(), rt.collapse(rt.trace(star())).G.toarray(), rtol=1e-6)
    tint = rt.Model(emitted=reflectance("centre") * n_dot_v + reflectance("edge") * (1 - n_dot_v))
    coloured = rt.render(star(tint), progress=False)
    assert {str(i) for i in coloured.interactions} == {"shine*star.centre", "shine*star.edge"}
    np.testing.assert_allclose(coloured.G.sum(axis=1)[coloured.object_pixels], 1, rtol=1e-15)


@pytest.mark.parametrize("depth", [0, 1, 5])
def test_a_furnace_that_glows_is_the_geometric_series_and_bounded(depth):
    system = rt.render(room(depth=depth), progress=False)
    share, palette = 0.8, rt.Palette(rt.RGB, {"glow": 1.0, "wall.diffuse": 0.3, "wall.mirror": 0.8})
    image = rt.shade(system, palette)
    np.testing.assert_allclose(image.values, (1 - share ** (depth + 1)) / (1 - share), rtol=1e-13)
    rest = share ** (depth + 1) / (1 - share)
    assert np.all((rest * (1 - 1e-12) <= image.cut_off) & (image.cut_off <= rest * (1 + 1e-9)))


def test_a_lamp_is_seen_from_its_front_and_not_from_behind():
    scene = replace(mirrors(model="lambert"), lights=[LAMP, rt.AmbientLight("sky")])
    shown, hidden = (
        rt.render(replace(scene, lights=[replace(LAMP, visible=v), scene.lights[1]]), progress=False)
        for v in (True, False)
    )
    behind = replace(LAMP, edge_u=(-2, 0, 0))
    back = rt.render(replace(scene, lights=[behind, scene.lights[1]]), progress=False)
    column = [str(i) for i in shown.interactions].index("lamp")
    lamp = shown.G[:, [column]].toarray()[:, 0]
    assert set(lamp) == {0.0, 1.0}
    assert "lamp" not in map(str, (*hidden.interactions, *back.interactions))
    # What it shines on is what it was.
    dark = lamp == 0
    others = [k for k in range(len(shown.interactions)) if k != column]
    np.testing.assert_array_equal(shown.G[:, others].toarray()[dark], hidden.G.toarray()[dark])
    assert shown.glowing == ("lamp",)
    assert hidden.glowing == ()


def test_light_that_is_sampled_is_not_gathered_again(monkeypatch):
    # A toy sends rays on by the formula direct, too: they meet surfaces that glow, but no lamps.
    monkeypatch.setattr(effects, "EFFECTS", (*(e for e in effects.EFFECTS if e.name != "mirrors"), SCATTER))
    scene = replace(mirrors(model=["lambert", "mirror"], depth=1), camera=camera(12))
    wall = rt.Rectangle(centre=(0, 2.5, -1), edge_u=(12, 0, 0), edge_v=(0, 9, 10), material="wall")
    glowing = replace(
        scene,
        shapes=[*scene.shapes, wall],
        materials=[*scene.materials, rt.Material("wall", model="emitter")],
        lights=[rt.SurfaceLight("lamp", material="wall")],
    )
    lamp = rt.RectangleLight("lamp", centre=wall.centre, edge_u=wall.edge_u, edge_v=wall.edge_v, visible=True)
    of_surface, of_lamp = (rt.trace(one) for one in (glowing, replace(scene, lights=[lamp])))
    met = [{b.via for b in level.branches} for level in of_lamp.levels]
    assert met[1] == {"reflected", "direct"}
    gathered = [
        np.repeat([b.via == "direct" for b in level.branches], [b.size for b in level.branches])
        for level in (of_surface.levels[1], of_lamp.levels[1])
    ]
    hits = [
        np.concatenate([p.hit for p in of_surface.levels[1].points if p.material == "wall" and p.lit]),
        np.concatenate([e.hit for e in of_lamp.levels[1].emitted]),
    ]
    assert gathered[0][hits[0]].any()
    assert not gathered[1][hits[1]].any()


def test_left_out_it_is_bounded_and_absent_it_costs_nothing():
    ball = rt.Material("ball", model=["lambert", "mirror", "emitter"])
    base = mirrors(depth=2)
    scene = replace(
        base,
        materials=[ball, *base.materials[1:]],
        lights=[*base.lights, LAMP, rt.SurfaceLight("glow", material="ball")],
    )
    palette = rt.Palette(rt.RGB, dict.fromkeys(scene.symbols, 0.5))
    whole, without = (rt.render(scene, force=force, progress=False) for force in (None, {"emission": False}))
    full, cut = rt.shade(whole, palette), rt.shade(without, palette)
    difference = np.abs(full.values - cut.values).max(axis=(0, 1))
    assert np.all((difference > 0.4) & (difference <= cut.cut_off) & (cut.cut_off < np.inf))
    assert not {"glow", "lamp"} & {str(i) for i in without.interactions}
    # The name of an effect that glows is a word of no other scene.
    assert "emission" not in rt.plan(small("spheres", 8))


def test_pixels_of_lights_are_no_objects_unless_asked():
    base = mirrors(model="mirror")
    shapes = [*base.shapes, rt.Sphere(centre=(-2, 0.5, 0), radius=0.5, material="ember")]
    scene = replace(
        base,
        shapes=shapes,
        materials=[*base.materials, rt.Material("ember", model="emitter")],
        lights=[*base.lights, rt.SurfaceLight("glow", material="ember")],
    )
    system = rt.render(scene, progress=False)
    column = [str(i) for i in system.interactions].index("glow")
    ember = system.G[:, [column]].toarray()[:, 0] > 0
    np.testing.assert_array_equal(system.object_pixels, (np.diff(system.G.indptr) > 0) & ~ember)
    assert any(str(i) == "glow*ball.mirror" for i in system.interactions)

    # A lamp ten times as bright as white paper is no colour that a printer lacks, unless it is asked about.
    gamut = rt.device_gamut(rt.load_device("dye3-endura-premier"), "envelope")
    lights = {"sun": 3.0, "sky": 0.1, "glow": 30.0}
    palette = rt.Palette(gamut.device.bands, dict.fromkeys(scene.symbols, 0.2) | lights)
    asked = [
        rt.feasible(system, palette, gamut, rt.Scale("floor"), mask=mask, cap=False)
        for mask in (None, ember.reshape(24, 24))
    ]
    assert [found.objects for found in asked] == [system.object_pixels.sum(), ember.sum()]
    assert len(asked[1].untouched_outside) == ember.sum()

    # Where nothing else shines it is itself the white.
    whites = [
        rt.Reference().white(system, p)[0]
        for p in (palette, palette.replace(sun=0.0), palette.replace(sun=0.0, sky=0.0))
    ]
    assert whites == pytest.approx([3 / math.pi, 0.1, 30.0])


def test_what_glows_and_what_shines_belong_together():
    base = mirrors(model="lambert")
    with pytest.raises(ValueError, match=r"materials\.ember: it glows, and no light says with what spectrum; add a li"):
        replace(base, materials=[*base.materials, rt.Material("ember", model="emitter")])
    with pytest.raises(ValueError, match=r"lights\.glow\.material = 'ball': it does not glow"):
        replace(base, lights=[rt.SurfaceLight("glow", material="ball")])
    with pytest.raises(ValueError, match=r"lights\.glow\.material = 'bal': no material has this name; did you mean 'b"):
        replace(base, lights=[rt.SurfaceLight("glow", material="bal")])
    with pytest.raises(ValueError, match="visible = 'yes': it must be true or false"):
        replace(LAMP, visible="yes")
