"""The share that is seen of a lamp: against dense grids, half planes, tiles, and what is left out."""

import importlib
from dataclasses import replace

import numpy as np
import pytest
import sympy
from linear.test_formulas import at_50_digits
from scenes_for_tests import camera, mirrors, small

import symrt as rt
from symrt.geometry.rays import Rays
from symrt.reflection import MODELS, diffuse, n_dot_l, n_dot_v

penumbrae = importlib.import_module("symrt.tracing.effects.penumbrae")

LAMPS = [
    rt.RectangleLight("lamp", centre=(1.5, 4, 1), edge_u=(1.5, 0, 0.75), edge_v=(-0.5, 0, 1)),
    rt.DiskLight("lamp", centre=(1.5, 4, 1), normal=(-0.3, -1, -0.2), radius=0.8),
    rt.SphereLight("lamp", centre=(1.5, 4, 1), radius=0.8),
]


def lit_by(lamp, model="lambert", size=24, **parameters):
    """A ball that floats above a floor, under a lamp."""
    scene = mirrors(model=model, **parameters)
    return replace(scene, camera=camera(size, position=(0, 2, 6)), lights=[lamp])


def seen(tree, material):
    """Places, and shares that are seen, of the points of a material on the first level; the camera is orthographic."""
    points = next(part for part in tree.levels[0].points if part.material == material)
    return points, points.lit[0]


def floor_points(scene, tree):
    """Where the camera's rays meet the floor y = −1.2, from the camera alone."""
    from symrt.scene.cameras import camera_rays  # noqa: PLC0415

    points, lit = seen(tree, "floor")
    rays = camera_rays(scene.camera)[tree.levels[0].sample[points.hit[lit.point]]]
    assert isinstance(rays, Rays)
    return rays.origin + rays.direction * ((-1.2 - rays.origin[1]) / rays.direction[1]), lit


def brute(lamp, points, count=48):
    """Irradiance of floor points and the share that a ball of radius 1 leaves, from count × count places on a lamp."""
    middles = (np.arange(count) + 0.5) / count
    received, whole = np.zeros(points.shape[1]), np.zeros(points.shape[1])
    for s in middles:
        for t in middles:
            if lamp.type == "rectangle":
                u, v = np.array(lamp.edge_u), np.array(lamp.edge_v)
                place = (np.array(lamp.centre) + (s - 0.5) * u + (t - 0.5) * v)[:, None]
                area = np.linalg.norm(u) * np.linalg.norm(v) / count**2
                normal = np.broadcast_to((np.cross(u, v) / np.linalg.norm(np.cross(u, v)))[:, None], points.shape)
            elif lamp.type == "disk":
                normal = np.array(lamp.normal) / np.linalg.norm(lamp.normal)
                u = np.cross(normal, [0, 0, 1]) / np.linalg.norm(np.cross(normal, [0, 0, 1]))
                out = lamp.radius * np.sqrt(s)
                offset = out * (np.cos(2 * np.pi * t) * u + np.sin(2 * np.pi * t) * np.cross(normal, u))
                place, normal = (np.array(lamp.centre) + offset)[:, None], normal[:, None]
                area = np.pi * lamp.radius**2 / count**2
            else:
                # All of the sphere, of which half is turned away.
                up, turn = 1 - 2 * s, 2 * np.pi * t
                normal = np.array([np.sqrt(1 - up**2) * np.cos(turn), up, np.sqrt(1 - up**2) * np.sin(turn)])[:, None]
                place = np.array(lamp.centre)[:, None] + lamp.radius * normal
                area = 4 * np.pi * lamp.radius**2 / count**2
            to = place - points
            square = np.sum(to**2, axis=0)
            amount = np.maximum(to[1], 0) * np.maximum(-np.sum(to * normal, axis=0), 0) / square**2 * area
            nearest = points + np.clip(-np.sum(points * to, axis=0) / square, 0, 1) * to
            received += amount * (np.sum(nearest**2, axis=0) > 1)
            whole += amount
    return whole, received / whole


@pytest.mark.parametrize("lamp", LAMPS, ids=lambda lamp: lamp.type)
def test_irradiance_and_share_are_those_of_a_dense_grid(lamp):
    scene = lit_by(lamp)
    tree = rt.trace(scene)
    points, lit = floor_points(scene, tree)
    whole, share = brute(lamp, points)
    # A dense grid of a disk has errors of its own at the rim, 1/48² of it; a sphere's at its silhouette, too.
    np.testing.assert_allclose(lit.irradiance * lit.factors["n_dot_l"], whole, rtol=2e-3)
    soft = (share > 0.02) & (share < 0.98)
    assert 20 < np.count_nonzero(soft) < 0.5 * soft.size
    error = lit.visible - share
    assert np.sqrt(np.mean(error**2)) < 3e-3
    assert np.abs(error).max() < 0.02
    # The estimate is one: of the same size, and rather too large.
    assert np.sqrt(np.mean(error**2)) < tree.errors["lamp"].rms < 0.01
    np.testing.assert_array_equal(lit.error[(share == 0) | (share == 1)] <= 0.02, True)


def test_where_nothing_hides_the_share_is_one_and_where_all_is_hidden_none():
    scene = lit_by(LAMPS[0])
    points, lit = floor_points(scene, rt.trace(scene))
    _, share = brute(LAMPS[0], points)
    lower, upper = share < 1e-9, share > 1 - 1e-9
    assert np.mean(lit.visible[upper] == 1) > 0.97
    assert np.mean(lit.visible[lower] == 0) > 0.9


@pytest.mark.parametrize("angle", [0.0, 0.2, 0.6, 1.1])
@pytest.mark.parametrize("lamp", ["rectangle", "disk", "sphere"])
def test_a_half_plane_that_hides_half_leaves_half(lamp, angle):
    # Straight below the middle of the lamp, and the half plane's edge across the axis, turned by an angle.
    lamps = {
        "rectangle": rt.RectangleLight("lamp", centre=(0, 4, 0), edge_u=(2, 0, 0), edge_v=(0, 0, 2)),
        "disk": rt.DiskLight("lamp", centre=(0, 4, 0), normal=(0, -1, 0), radius=1),
        "sphere": rt.SphereLight("lamp", centre=(0, 4, 0), radius=1),
    }
    c, s = 20 * np.cos(angle), 20 * np.sin(angle)
    half = rt.Rectangle(centre=(c / 2, 2, s / 2), edge_u=(c, 0, s), edge_v=(2 * s, 0, -2 * c), material="floor")
    other = replace(half, centre=(-c / 2, 2, -s / 2))
    floor = rt.Rectangle(centre=(0, 0, 0), edge_u=(3, 0, 0), edge_v=(0, 0, -3), material="floor")
    eye = rt.Camera(position=(0, 1, 3), target=(0, 0, 0), width=1, height=1)
    shares = []
    for shapes in ([floor, half], [floor, other], [floor, half, other]):
        scene = rt.Scene(eye, shapes, [rt.Material("floor")], [lamps[lamp]])
        tree = rt.trace(scene)
        lit = tree.levels[0].points[0].lit[0]
        shares.append(float(lit.visible[0]))
        if len(shapes) == 2:
            # The border is found to 1/32 of a cell, of which four stand side by side; the middle ones count 3 % more.
            assert abs(shares[-1] - 0.5) <= 1.04 / 4 / 32
            # The lamp's middle, a corner of the grid, is on the edge itself; where no other corner is, that is all.
            assert angle == 0 or abs(shares[-1] - 0.5) <= 0.5 / 4 / 32
    # The halves leave nothing out and nothing twice, but for rays along their edge.
    assert sum(shares[:2]) == pytest.approx(1, abs=2.08 / 4 / 32)
    assert shares[2] <= 2.08 / 4 / 32


def test_formula_linear_form_and_pixel_are_one():
    scene = lit_by(LAMPS[0])
    tree = rt.trace(scene)
    system = rt.collapse(tree)
    image = rt.shade(system, rt.Palette(rt.RGB, dict.fromkeys(scene.symbols, 0.7))).values
    spectra = dict.fromkeys(scene.symbols, 0.7)
    _, lit = seen(tree, "floor")
    assert np.any((lit.visible > 0) & (lit.visible < 1))
    for y in range(2, 24, 3):
        for x in range(0, 24, 5):
            for formula in (rt.formula(tree, x, y), rt.formula(system, x, y)):
                error = abs(at_50_digits(formula, spectra) - sympy.Float(float(image[y, x, 0]), 50))
                assert error <= 4 * np.spacing(image[y, x, 0])
    text = rt.formula(tree, 4, 20).text()
    assert text == "lamp*floor.diffuse*irradiance*n_dot_l*visible/pi"


def test_materials_with_highlights_are_lit_by_places():
    scene = lit_by(replace(LAMPS[0], points=2), model="phong", exponent=20)
    tree = rt.trace(scene)
    numbers = {points.material: len(points.lit) for points in tree.levels[0].points}
    assert numbers == {"ball": 4, "floor": 1}
    assert {name for name in ("shadows", "penumbrae") if name in tree.plan} == {"shadows", "penumbrae"}
    assert {"4 a hit", "9 … 185 a hit"} <= {effect.rays for effect in tree.plan.effects}
    # Of many places the sum is what the closed form gives a diffuser, seen from far enough.
    rough = rt.Model(direct=diffuse * n_dot_l**2 / sympy.pi)
    far = replace(LAMPS[0], centre=(6, 16, 4), points=6)
    both = [
        rt.collapse(rt.trace(replace(lit_by(far, model=model), shapes=lit_by(far).shapes[:1]))).G.sum()
        for model in ("lambert", rt.Model(direct=diffuse * n_dot_l / sympy.pi + 0 * n_dot_v))
    ]
    assert both[0] == pytest.approx(both[1], rel=1e-12)
    assert not rough.diffusing
    assert [MODELS[name].diffusing for name in ("lambert", "mirror", "phong", "phong_plain", "blinn_phong")] == [
        *(True, True),
        *(False, False, False),
    ]


def test_a_tiny_lamp_is_a_point_light():
    size = 1e-4
    lamp = rt.SphereLight("lamp", centre=(1.5, 4, 1), radius=size)
    scenes = lit_by(lamp), lit_by(rt.PointLight("lamp", position=(1.5, 4, 1)))
    area, point = (rt.collapse(rt.trace(scene)).G.toarray() for scene in scenes)
    np.testing.assert_allclose(area, np.pi * size**2 * point, rtol=1e-7, atol=1e-4 * np.pi * size**2 * point.max())


def test_penumbrae_left_out_are_bounded():
    scene = lit_by(LAMPS[0])
    shiny = rt.Rectangle(centre=(0, -1.1, 0), edge_u=(2, 0, 0), edge_v=(0, 0, -8), material="shiny")
    materials = [*scene.materials, rt.Material("shiny", model="phong", exponent=20)]
    scene = replace(scene, shapes=[*scene.shapes, shiny], materials=materials)
    palette = rt.Palette(rt.RGB, dict.fromkeys(scene.symbols, 0.5))
    full = rt.shade(rt.render(scene, progress=False), palette)
    for names in (["penumbrae"], ["shadows"], ["penumbrae", "shadows"]):
        force = dict.fromkeys(names, False)
        system = rt.render(scene, force=force, progress=False)
        cut = rt.shade(system, palette)
        difference = np.abs(full.values - cut.values).max(axis=(0, 1))
        assert np.all(difference > 0)
        assert np.all(difference <= cut.cut_off)
        assert ("lamp" in system.errors) == ("penumbrae" not in names)


@pytest.mark.parametrize("model", [["lambert", "mirror"], ["phong", "mirror"]])
def test_light_cut_off_after_mirrors_is_bounded_however_near_a_lamp_is(model):
    # The lamp almost touches the floor, of which the ball shows a mirrored view.
    lamp = rt.DiskLight("lamp", centre=(0.4, -1.15, 1.2), normal=(0, -1, 0), radius=0.5)
    scene = lit_by(lamp, model=model, **({"exponent": 5} if "phong" in model else {}))
    scene = replace(scene, materials=[scene.materials[0], replaced(scene.materials[0], "floor")])
    palette = rt.Palette(rt.RGB, {symbol: 0.9 if "mirror" in symbol else 0.5 for symbol in scene.symbols})
    cut, deep = (rt.shade(rt.render(replace(scene, depth=d), progress=False), palette) for d in (0, 6))
    missing = (deep.values - cut.values).max(axis=(0, 1))
    assert np.all(missing > 0)
    assert np.all(missing <= cut.cut_off)
    assert rt.trace(replace(scene, depth=0)).lights["lamp"].bound == (np.pi if "lambert" in model else 2 * np.pi * 16)


def replaced(material, name):
    """The same model under another name."""
    return rt.Material(name, model=material.model, **material.parameters)


def test_tiles_and_workers_give_the_same_bits_and_errors():
    scene = lit_by(LAMPS[2], size=33)
    whole = rt.collapse(rt.trace(scene))
    part = rt.collapse(rt.trace(scene, window=(3, 2, 30, 29)))
    rows = whole.G.toarray().reshape(33, 33, -1)[2:29, 3:30].reshape(27 * 27, -1)
    np.testing.assert_array_equal(part.G.toarray(), rows)
    one, two = (rt.render(scene, workers=workers, progress=False) for workers in (1, 2))
    assert one.errors == two.errors
    assert one.errors["lamp"].count == whole.errors["lamp"].count


def test_errors_are_shown_and_kept(tmp_path):
    system = rt.render(lit_by(LAMPS[0]), progress=False)
    assert "the share of lamp that is seen errs by about" in repr(system)
    assert "errs by about" in system._repr_html_()
    rt.save_system(tmp_path / "soft.npz", system)
    assert rt.load_system(tmp_path / "soft.npz").errors == system.errors
    assert not rt.render(small("first", 8), progress=False).errors


def test_a_lamp_without_shadows_and_one_alone_need_no_ray():
    scene = lit_by(replace(LAMPS[0], shadows=False))
    tree = rt.trace(scene)
    assert set(tree.rays) == {"camera"}
    assert not tree.errors
    planned = {effect.name: effect for effect in rt.plan(scene).effects}
    assert planned["penumbrae"].why == "no light has an area"


def test_a_panel_in_the_lamps_own_plane_hides_nothing():
    lamp = LAMPS[0]
    scene = lit_by(lamp)
    panel = rt.Rectangle(centre=lamp.centre, edge_u=lamp.edge_u, edge_v=lamp.edge_v, material="floor")
    with_panel = replace(scene, shapes=[*scene.shapes, panel])
    bare, covered = (rt.trace(one).levels[0] for one in (scene, with_panel))
    assert bare.size == covered.size
    np.testing.assert_array_equal(bare.points[1].lit[0].visible, covered.points[1].lit[0].visible)


def test_no_coefficient_is_negative():
    assert np.all(rt.render(lit_by(LAMPS[1]), progress=False).G.data >= 0)


@pytest.mark.exhaustive  # the device's tables take seconds to read
def test_a_system_of_an_area_light_answers_in_step_5():
    system = rt.render(lit_by(LAMPS[0]), progress=False)
    gamut = rt.device_gamut(rt.load_device("dye3-endura-premier"), model="envelope")
    palette = rt.Palette(gamut.device.bands, {"lamp": 30.0, "ball.diffuse": 0.3, "floor.diffuse": 0.4})
    found = rt.feasible(system, palette, gamut, rt.Scale("lamp"), within=(0.01, 3.0))
    assert 0.01 < found.high <= 3.0
