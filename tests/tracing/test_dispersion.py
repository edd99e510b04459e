"""Dispersion: prisms in closed form, each wavelength traced by itself, energy, tiles, what is refused or bounded."""

import math
from dataclasses import replace
from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest
import reference
import sympy
import tomli_w
from linear.test_formulas import at_50_digits
from scenes_for_tests import camera

import symrt as rt
from symrt.reflection.symbols import Hat
from symrt.windows import windows_of

BANDS = rt.wavelengths(380, 730, 10)
PALETTE = rt.Palette(
    BANDS,
    {
        "sun": np.linspace(1.5, 2.5, 36),
        "sky": 0.3,
        "floor.diffuse": np.linspace(0.7, 0.5, 36),
        "dark.diffuse": np.linspace(0.05, 0.2, 36),
    },
)


def write_prism(folder, apex, height=2.0, length=2.0):
    """A prism along y, its apex up, its base on z = 0: a triangle with the apex's angle in degrees, as a mesh."""
    half = height * math.tan(math.radians(apex) / 2)
    ends = [f"v {x} {y} {z}" for y in (-length / 2, length / 2) for x, z in ((-half, 0), (half, 0), (0, height))]
    faces = ["f 1 2 3", "f 4 6 5", "f 1 4 5", "f 1 5 2", "f 2 5 6", "f 2 6 3", "f 3 6 4", "f 3 4 1"]
    (folder / "prism.obj").write_text("\n".join([*ends, *faces]) + "\n")
    return rt.Mesh("prism.obj", "prism")


def bench(folder, apex, position, target, far=6.0, **medium):
    """One view through a prism onto a wall across x, and a lamp before the wall that prisms do not hide."""
    return rt.Scene(
        camera=rt.Camera(position=position, target=target, up=(0, 1, 0), width=1, height=1, field_of_view=1),
        shapes=[write_prism(folder, apex), rt.Plane(point=(far, 0, 0), normal=(-1, 0, 0), material="floor")],
        materials=[rt.Material("prism", "glass", **medium), rt.Material("floor", "lambert")],
        lights=[rt.PointLight("lamp", position=(far - 1, 0, 1), shadows=False)],
        depth=3,
        folder=folder,
    )


def test_a_prism_deviates_each_window_by_the_closed_form(tmp_path):
    # At minimum deviation D the view runs along the base inside: n sin(A/2) = sin((A + D)/2) (Born and Wolf, §4.7.2).
    apex, level, far, nodes = 60.0, 1.1, 6.0, rt.Scene.nodes.fget(bench(tmp_path, 60, (9, 9, 9), (0, 0, 0), glass="F2"))
    half = math.radians(apex) / 2
    for k, nm in enumerate(nodes):
        deviation = 2 * math.asin(rt.refractive_index("N-SF11", nm) * math.sin(half)) - 2 * half
        inside = (2.0 - level) * math.tan(half)
        rising = math.tan(deviation / 2)
        eye, entry = (-inside - 3, 0, level - 3 * rising), (-inside, 0, level)
        tree = rt.trace(bench(tmp_path, apex, eye, entry, far, glass="N-SF11"))
        # It leaves as it came, downwards, and meets the wall where the lamp gives it 1/d².
        z = level - (far - inside) * rising
        expected = 1 / (1 + (z - 1) ** 2)
        values = rt.formula(tree, 0, 0).values
        assert values[f"irradiance_3tw{k + 1}t"] == pytest.approx(expected, rel=1e-12)
        others = [v for name, v in values.items() if name.startswith("irradiance_3t") and f"w{k + 1}t" not in name]
        assert all(abs(other / expected - 1) > 1e-4 for other in others)


def test_total_reflection_is_decided_window_by_window(tmp_path):
    # Straight through the left face, a view meets the right one at the apex's angle: blue stays inside, red leaves.
    apex = 33.5
    a = math.radians(apex) / 2
    entry = (-0.9 * math.tan(a), 0.0, 1.1)
    eye = (entry[0] - 3 * math.cos(a), 0.0, entry[2] + 3 * math.sin(a))
    scene = bench(tmp_path, apex, eye, entry, glass="N-SF11")
    tree = rt.trace(scene)
    leaving = [
        windows_of(scene.nodes)[k]
        for k, nm in enumerate(scene.nodes)
        if Fraction(rt.refractive_index("N-SF11", nm)) * Fraction(math.sin(2 * a)) < 1
    ]
    assert 0 < len(leaving) < 6
    names = rt.formula(tree, 0, 0).values
    through = {name for name in names if name.startswith("transmission_to_3tw")}
    assert through == {f"transmission_to_3tw{scene.nodes.index(window.centre) + 1}t" for window in leaving}


def ball(windows=6, depth=4, size=16, **medium):
    """A ball of glass over a striped floor; without a medium it is opaque."""
    return rt.Scene(
        camera=camera(size),
        shapes=[
            rt.Sphere(centre=(0, 0, 0), radius=1, material="ball"),
            rt.Rectangle(centre=(0, -1.2, 0), edge_u=(8, 0, 0), edge_v=(0, 0, -8), material="stripes"),
        ],
        textures=[rt.Checker("stripes", ("floor", "dark"), 0.4)],
        materials=[
            rt.Material("ball", "glass", **medium) if medium else rt.Material("ball", "lambert"),
            rt.Material("floor", "lambert"),
            rt.Material("dark", "lambert"),
        ],
        lights=[rt.DirectionalLight("sun", direction=(-1, -2, -1)), rt.AmbientLight("sky")],
        depth=depth,
        windows=windows,
    )


@pytest.mark.parametrize("windows", [2, 6, [380, 500, 505, 730]])
def test_windows_of_equal_index_are_one_window(windows):
    plain, split = (
        rt.shade(rt.render(ball(windows, **medium), progress=False), PALETTE).values
        for medium in ({"index": 1.62}, {"cauchy": [1.62]})
    )
    np.testing.assert_allclose(split, plain, rtol=1e-12)


def test_pixels_that_see_no_such_glass_have_no_windows():
    system, opaque = (rt.render(ball(**medium), progress=False) for medium in ({"glass": "N-SF11"}, {}))
    tree = rt.trace(ball())
    seen = tree.levels[0]
    hits = [part.hit for part in seen.points if part.material == "ball"]
    on_ball = np.isin(np.arange(256), tree.film.pixel[seen.sample[np.concatenate(hits)]])
    named = system.pixels_of(np.array([bool(i.window) for i in system.interactions]))
    assert not named[~on_ball].any()
    assert named[on_ball].mean() > 0.7  # the others look past the floor
    both = [str(i) for i in system.interactions if i in opaque.interactions]
    assert "sun*floor.diffuse" in both
    for name in both:
        rows = (s.G[:, [list(map(str, s.interactions)).index(name)]].toarray()[~on_ball] for s in (system, opaque))
        np.testing.assert_array_equal(*rows)


def test_in_a_uniform_room_such_glass_is_seen_as_nothing():
    room = rt.Scene(
        camera=rt.Camera(position=(0, 0, 4), target=(0, 0, 0), width=8, height=8, field_of_view=20),
        shapes=[
            rt.Sphere((0, 0, 0), 50, "room"),
            rt.Sphere((0, 0, 0), 0.6, "one"),
            rt.Box((0, 0, -2), (1, 1, 1), "two"),
        ],
        materials=[
            rt.Material("room", "lambert"),
            rt.Material("one", "glass", glass="N-SF11"),
            rt.Material("two", "glass", glass="diamond"),
        ],
        lights=[rt.AmbientLight("sky")],
        depth=8,
    )
    system = rt.render(room, progress=False)
    # Rays that are in a window stay in it, whatever glass they meet next.
    assert {i.window for i in system.interactions} <= {(), *windows_of(room.nodes)}
    image = rt.shade(system, rt.Palette(BANDS, {"sky": 1.0, "room.diffuse": 1.0}))
    assert image.values.max() <= 1 + 1e-12
    assert 0 < (1 - image.values).max() <= image.cut_off.max() < 0.5


def test_formula_linear_form_and_pixel_are_one():
    scene = ball(3, size=12, glass="N-SF11")
    tree = rt.trace(scene)
    system = rt.collapse(tree)
    image, split = rt.shade(system, PALETTE).values, 0
    spectra = {symbol: PALETTE[symbol] for symbol in scene.symbols}
    nm = np.array(BANDS.centres)
    for y in range(4, 9, 2):
        for x in range(3, 9, 2):
            letters, linear = rt.formula(tree, x, y), rt.formula(system, x, y)
            split += "nm]" in letters.text()
            for formula in (letters, linear):
                terms = max(4, len(sympy.Add.make_args(sympy.expand(formula.expression))))
                found = formula.evaluate({name: spectra[name] for name in formula.symbols}, nm=nm)
                assert np.all(np.abs(found - image[y, x]) <= terms * np.spacing(image[y, x]))
            # At a window's centre the hats are 1 and 0, and 50 digits judge.
            hats = {Hat(str(w)): sympy.Integer(w.centre == 380) for w in windows_of(scene.nodes)}
            for formula in (letters, linear):
                at_380 = replace(formula, expression=formula.expression.xreplace(hats))
                band = {name: float(spectra[name][0]) for name in scene.symbols}
                error = abs(at_50_digits(at_380, band) - sympy.Float(float(image[y, x, 0]), 50))
                assert error <= terms * np.spacing(image[y, x, 0])
    assert split > 3


def test_tiles_and_workers_have_the_same_bits():
    scene = ball(4, glass="F2")
    whole, part = rt.collapse(rt.trace(scene)), rt.collapse(rt.trace(scene, window=(3, 2, 11, 9)))
    rows = whole.G.toarray().reshape(16, 16, -1)[2:9, 3:11].reshape(56, -1)
    for j, interaction in enumerate(part.interactions):
        np.testing.assert_array_equal(part.G[:, [j]].toarray()[:, 0], rows[:, whole.interactions.index(interaction)])
    assert np.count_nonzero(rows) == part.G.nnz
    for workers in (1, 2):
        again = rt.render(scene, workers=workers, progress=False)
        assert again.interactions == whole.interactions
        np.testing.assert_array_equal(again.G.data, whole.G.data)


def test_the_plain_tracer_sees_each_wavelength_by_itself(tmp_path):
    table = {
        "windows": [400, 500, 620, 700],
        "depth": 4,
        "camera": {"position": [0.31, 2.17, 6.83], "target": [0.05, 0.62, -0.1], "field_of_view": 30},
        "shapes": [
            {"type": "plane", "point": [0, 0, 0], "normal": [0, 1, 0], "material": "tiles"},
            {"type": "sphere", "centre": [0.1, 0.9, 0.2], "radius": 0.9, "material": "ball"},
        ],
        "textures": {"tiles": {"type": "checker", "size": 0.37, "materials": ["floor", "dark"]}},
        "materials": {
            "floor": {"model": "lambert"},
            "dark": {"model": "lambert"},
            "ball": {"model": "glass", "glass": "N-SF11"},
        },
        "lights": {"sun": {"type": "directional", "direction": [-0.7, -1.3, -0.9]}},
        "palettes": {"p": {"bands": [400, 700, 20], "sun": 2.0, "floor.diffuse": 0.7, "dark.diffuse": 0.1}},
    }
    table["camera"] |= {"width": 10, "height": 10}
    path = tmp_path / "ball.toml"
    path.write_text(tomli_w.dumps(table))
    seen = rt.shade(rt.render(rt.load_scene(path), progress=False), rt.load_palettes(path)["p"]).values
    # Windows are mixtures of the pictures at their centres, in all bands ...
    np.testing.assert_allclose(seen, reference.render(path, "p", 10, 10), rtol=1e-9)
    # ... and at the centres themselves they are the truth.
    for nm in (400, 500, 620, 700):
        truth = np.array(reference.picture(reference.load(path, nm), reference.load_palette(path, "p"), 10, 10))
        np.testing.assert_allclose(seen[..., (nm - 400) // 20], truth[..., (nm - 400) // 20], rtol=1e-9)


def test_pictures_converge_as_windows_are_added():
    # The truth: a window at each band.  Mean errors behind a strong flint, relative to the mean of the ball's pixels.
    def picture(windows):
        return rt.shade(rt.render(ball(windows, size=32, glass="N-SF11"), progress=False), PALETTE).values

    truth = picture(list(BANDS.centres))
    behind = np.abs(picture(2) - truth).max(axis=2) > 0
    errors = [np.abs(picture(n) - truth)[behind].mean() / truth[behind].mean() for n in (3, 6, 12, 24)]
    # 5.1 %, 2.2 %, 0.9 % and 0.6 % here.
    assert errors[0] < 0.06
    assert all(finer < 0.7 * coarser for coarser, finer in pairwise(errors))


def test_what_dispersion_would_change_is_bounded_without_it():
    scene = ball(glass="N-SF11")
    full, without = (
        rt.shade(rt.render(scene, force=force, progress=False), PALETTE) for force in (None, {"dispersion": False})
    )
    missing = np.abs(full.values - without.values).max()
    assert 0 < missing <= without.cut_off.max() < np.inf
    # The index in the middle of the windows stands for all, and three bands are enough.
    middle = rt.render(ball(index=rt.refractive_index("N-SF11", 555.0)), progress=False)
    one = rt.render(scene, force={"dispersion": False}, progress=False)
    assert one.interactions == middle.interactions
    np.testing.assert_array_equal(one.G.toarray(), middle.G.toarray())
    assert rt.shade(one, rt.Palette(rt.RGB, dict.fromkeys(scene.symbols, 0.5))).values.max() > 0
    # Refraction left out bounds all windows, too.
    cut = rt.shade(rt.render(scene, force={"refraction": False}, progress=False), PALETTE)
    assert np.abs(full.values - cut.values).max() <= cut.cut_off.max() < np.inf


def test_the_plan_names_who_calls_for_windows():
    chosen = {effect.name: effect for effect in rt.plan(ball(12, glass="F2")).effects}["dispersion"]
    assert (chosen.state, chosen.called_by) == ("simulated", ("ball",))
    assert chosen.rays.startswith("12 ")
    plain = {effect.name: effect for effect in rt.plan(ball(index=1.5)).effects}["dispersion"]
    assert (plain.state, plain.why) == ("not called for", "no index changes with the wavelength")


def test_an_index_by_wavelength_cannot_be_moved_after_the_trace():
    tree = rt.trace(ball(glass="F2"))
    with pytest.raises(ValueError, match=r"ball.index: rays were bent by it; trace the scene again with another index"):
        rt.collapse(tree, values={"ball.index": 1.4})
    with pytest.raises(ValueError, match=r"ball.index: rays were bent by it"):
        rt.collapse(tree, free=["ball.index"])
    with pytest.raises(
        ValueError, match=r"the palette's bands are RGB, and glass bends wavelengths apart here: take a"
    ):
        rt.shade(rt.collapse(tree), rt.Palette(rt.RGB, dict.fromkeys(ball().symbols, 0.5)))


def test_paint_gathers_nothing_through_glass_that_tells_wavelengths_apart():
    scene = ball(glass="F2")
    paint = rt.Material("dark", ["lambert", "fluorescent"])
    painted = replace(scene, materials=[*scene.materials[:2], paint])
    with pytest.raises(
        ValueError, match=r"interreflection: dark fluoresces, and would gather light through ball, whose"
    ):
        replace(painted, interreflection=rt.Interreflection(paths=4, depth=1))


def test_ordered_columns_keep_their_windows():
    scene = ball(3, glass="F2")
    ordered, merged = rt.collapse(rt.trace(scene), ordered=True), rt.collapse(rt.trace(scene))
    assert {(i.light, tuple(sorted(i.met)), i.window) for i in ordered.interactions} == {
        (i.light, i.met, i.window) for i in merged.interactions
    }
