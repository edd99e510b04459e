"""Step 1: what the tree records, what the plan leaves out, and what the depth limit costs."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
import sympy
from scenes_for_tests import SCENES, camera, every_scene, hall_of_mirrors, mirrors, small, two_materials
from sympy import pi

import symrt as rt
from symrt.feedback.parameters import moved
from symrt.reflection import diffuse, mirror, n_dot_l, n_dot_v, reflectance
from symrt.reflection.symbols import GEOMETRY
from symrt.tracing.factors import factors, reflect


def random_directions(count: int, seed: int) -> np.ndarray:
    v = np.random.default_rng(seed).normal(size=(3, count))
    return v / np.linalg.norm(v, axis=0)


def test_factors_are_the_cosines_of_their_names():
    n, v, light = (random_directions(500, seed) for seed in (1, 2, 3))
    half = (light + v) / np.linalg.norm(light + v, axis=0)
    mirrored = 2 * np.einsum("ij,ij->j", n, light) * n - light
    vectors = {"n": n, "v": v, "l": light, "h": half, "r": mirrored}
    found = factors([f"{p}{c}" for c in GEOMETRY for p in ("", "one_minus_")], n, v, light)
    for name, (a, b) in GEOMETRY.items():
        cosine = np.clip(np.einsum("ij,ij->j", vectors[a], vectors[b]), 0, 1)
        np.testing.assert_allclose(found[name], cosine, atol=1e-15)
        np.testing.assert_allclose(found[f"one_minus_{name}"], 1 - cosine, atol=1e-15)


def test_one_minus_a_cosine_keeps_its_digits_where_the_cosine_has_none():
    angle = np.array([1e-9])
    n = np.array([[0.0], [1.0], [0.0]])
    v = np.stack([np.sin(angle), np.cos(angle), 0 * angle])
    # 1 − cos x = x²/2 − …, far below the spacing of floats at 1.
    assert factors(["one_minus_n_dot_v"], n, v, None)["one_minus_n_dot_v"] == pytest.approx(0.5e-18, rel=1e-9)
    assert factors(["n_dot_v"], n, v, None)["n_dot_v"] == 1.0


def test_a_mirrored_vector_keeps_its_angle_to_the_normal():
    n, v = random_directions(200, 4), random_directions(200, 5)
    np.testing.assert_allclose(np.einsum("ij,ij->j", reflect(v, n), n), np.einsum("ij,ij->j", v, n), atol=1e-14)


def test_only_the_factors_of_a_materials_formulas_are_computed():
    tree = rt.trace(two_materials(exponent=20))
    computed = {p.material: set().union(*(lit.factors for lit in p.lit)) for p in tree.levels[0].points}
    assert computed == {"shiny": {"n_dot_l", "one_minus_r_dot_v"}, "dull": {"n_dot_l"}}


@pytest.mark.parametrize("name", every_scene())
def test_an_effect_that_is_not_called_for_casts_no_ray(name):
    scene = small(name, 16)
    tree, chosen = rt.trace(scene), rt.plan(scene)
    for effect in ("shadows", "mirrors"):
        assert (tree.rays.get(effect, 0) > 0) == (effect in chosen)


def test_switched_off_is_absent_is_weight_zero():
    # A mirror that nothing is made of, a mirror with depth 0, and no mirror: the same bits, and no mirror ray.
    base = mirrors(model="lambert")
    unused = replace(base, materials=[*base.materials, rt.Material("spare", model="mirror")])
    at_depth_0 = replace(mirrors(model=["lambert", "mirror"], depth=0))
    systems = [rt.collapse(rt.trace(scene)) for scene in (base, unused, at_depth_0)]
    for system in systems[1:]:
        assert system.interactions == systems[0].interactions
        assert np.array_equal(system.G.data, systems[0].G.data)


def test_a_light_without_shadows_lights_what_another_shape_hides():
    hidden = mirrors(model="lambert")
    open_light = replace(hidden, lights=[rt.DirectionalLight("sun", direction=(-1, -2, -1), shadows=False)])
    with_shadow, without = (rt.collapse(rt.trace(scene)) for scene in (hidden, open_light))
    floor = [str(i) for i in with_shadow.interactions].index("sun*floor.diffuse")
    lit = [str(i) for i in without.interactions].index("sun*floor.diffuse")
    assert (with_shadow.G[:, [floor]] != 0).nnz < (without.G[:, [lit]] != 0).nnz


@dataclass(frozen=True)
class Spotlight:
    """A light of one's own: a point light that shines straight down through a cone."""

    name: str
    position: tuple[float, float, float]
    shadows: bool = True

    def samples(self, points):
        bulb = rt.PointLight(self.name, position=self.position).samples(points)[0]
        return (replace(bulb, falloff=np.where(bulb.direction[1] > 0.97, bulb.falloff, 0.0)),)


def test_a_light_of_ones_own_is_a_light():
    scene = replace(mirrors(model="lambert"), lights=[Spotlight("spot", (0, 4, 0)), rt.AmbientLight("sky")])
    system = rt.collapse(rt.trace(scene))
    point = rt.collapse(
        rt.trace(replace(scene, lights=[rt.PointLight("spot", position=(0, 4, 0)), rt.AmbientLight("sky")]))
    )
    column = [str(i) for i in system.interactions].index("spot*ball.diffuse")
    inside = system.G[:, [column]].toarray() > 0
    assert 0 < inside.sum() < (point.G[:, [column]].toarray() > 0).sum()
    np.testing.assert_array_equal(system.G[:, [column]].toarray()[inside], point.G[:, [column]].toarray()[inside])


@pytest.mark.parametrize(
    ("stretch", "falloff", "says"), [(2.0, 1.0, "unit vectors"), (1.0, -1.0, "falloff"), (1.0, np.nan, "falloff")]
)
def test_a_light_of_ones_own_that_breaks_the_rules_is_named(stretch, falloff, says):
    @dataclass(frozen=True)
    class Wrong:
        name: str = "wrong"
        shadows: bool = False

        def samples(self, points):
            right = rt.DirectionalLight("right", direction=(0, -1, 0)).samples(points)[0]
            return (replace(right, direction=right.direction * stretch, falloff=right.falloff * falloff),)

    with pytest.raises(ValueError, match=f"the light wrong: .*{says}"):
        rt.trace(replace(two_materials(exponent=20), camera=camera(position=(0, 0, 6)), lights=[Wrong()]))


def test_a_light_of_ones_own_has_no_certificate_and_can_be_saved(tmp_path):
    hall = replace(hall_of_mirrors(1), lights=[Spotlight("spot", (0, 1, -0.5))])
    with pytest.warns(UserWarning, match="every pixel is black: the camera sees nothing that light reaches"):
        system = rt.render(hall, progress=False)
    rt.save_system(tmp_path / "hall.npz", system)
    palette = rt.Palette(rt.RGB, {s: 0.5 if "." in s else [1.0, 1.0, 0.0] for s in hall.symbols})
    for one in (system, rt.load_system(tmp_path / "hall.npz")):
        image = rt.shade(one, palette)
        assert image.cut_off.tolist() == [np.inf, np.inf, 0.0]
        assert "no certificate" in image.certificate


def test_triangles_given_as_arrays_are_a_shape():
    corners = np.array([[-1.0, 1.0, 0.0], [-1.0, -1.0, 1.0], [0.0, 0.0, 0.0]])
    triangle = rt.TriangleMesh(corners, np.array([[0], [1], [2]]), ("dull",))
    scene = replace(two_materials(exponent=20), shapes=[triangle])
    assert rt.render(scene, progress=False).object_pixels.any()


def test_white_is_a_perfect_diffuser_at_the_target():
    system = rt.collapse(rt.trace(hall_of_mirrors(0)))
    # E/π with E = 1/d² for the point light, L for the ambient one; d from (0, 1, 0.5) to the target (0, 0, −1).
    assert system.white["lamp"] == pytest.approx(1 / (np.pi * (1 + 1.5**2)), rel=1e-15)
    assert system.white["sky"] == 1.0


@pytest.mark.parametrize("depth", [0, 1, 3, 6])
def test_what_the_depth_limit_cuts_off_is_within_its_certificate(depth):
    cut, deep = (rt.collapse(rt.trace(hall_of_mirrors(d))) for d in (depth, 40))
    spectra = {s: 0.6 if s.endswith("mirror") else 0.3 if "." in s else 1.0 for s in deep.symbols}
    palette = rt.Palette(bands=rt.wavelengths(500, 520, 10), spectra=spectra)
    image = rt.shade(cut, palette)
    missing = rt.shade(deep, palette).values - image.values
    assert missing.max() > 0
    assert np.all(missing >= -1e-15)
    assert np.all(missing.max(axis=(0, 1)) <= image.cut_off)


def hall_of(model, depth: int, **changes) -> rt.Scene:
    return replace(
        hall_of_mirrors(depth), materials=[rt.Material(name, model=model) for name in ("front", "back")], **changes
    )


PAINT = {"direct": diffuse * n_dot_l / pi, "ambient": diffuse}
AWAY = (1 - n_dot_v) ** 5


@pytest.mark.parametrize("reflectances", [0.6, 0.95])
@pytest.mark.parametrize(
    "model",
    [
        rt.Model(**PAINT, reflected=reflectance("f0")),
        rt.Model(**PAINT, reflected=0.6),
        rt.Model(**PAINT, reflected=AWAY + (1 - AWAY) * reflectance("f0")),
        rt.Model(**PAINT, reflected=mirror / 4 + mirror * reflectance("coat") / 2),
        rt.Model(**PAINT, reflected=mirror * 3 / 2),
        rt.Model(**PAINT, reflected=-mirror),
        rt.Model(**(PAINT | {"direct": sympy.E**2 * diffuse * n_dot_l}), reflected=mirror),
        rt.Model(direct=sympy.E * diffuse * n_dot_l, reflected=mirror),
    ],
    ids=str,
)
def test_a_certificate_holds_for_models_of_ones_own(model, reflectances):
    cut, deep = (rt.collapse(rt.trace(hall_of(model, d))) for d in (1, 9))
    names = {*deep.symbols, *deep.lights}
    palette = rt.Palette(bands=rt.RGB, spectra={s: reflectances if "." in s else 1.0 for s in names})
    image = rt.shade(cut, palette)
    missing = np.abs(rt.shade(deep, palette).values - image.values).max()
    assert missing > 0
    assert np.all(missing <= image.cut_off)


def two_balls(model, depth: int) -> rt.LinearSystem:
    """Two balls that touch, on a floor: light goes from one to the other, and comes from the floor alone."""
    balls = [rt.Sphere(centre=(x, 0, 0), radius=1, material="ball") for x in (-1, 1)]
    scene = mirrors(model=model, depth=depth)
    return rt.collapse(rt.trace(replace(scene, camera=camera(16), shapes=[*balls, *scene.shapes[1:]])))


@pytest.mark.parametrize("f0", [0.2, 0.7, 1.0])
@pytest.mark.parametrize("model", ["metal", "metal_f82", "mirror"])
def test_what_metals_cut_off_is_bounded_although_they_mirror_everything_at_their_edge(model, f0):
    # A metal reflects no lamp itself, so that no bounce between metals adds any light.
    cut, deep = two_balls(model, 1), two_balls(model, 9)
    names = {*cut.symbols, *deep.symbols}
    palette = rt.Palette(rt.RGB, {name: 0.5 if name == "floor.diffuse" else f0 if "." in name else 1 for name in names})
    image = rt.shade(cut, palette)
    missing = rt.shade(deep, palette).values - image.values
    assert missing.max() > 1e-3
    assert np.all(missing >= -1e-15)
    assert np.all(missing.max(axis=(0, 1)) <= image.cut_off)
    assert np.all(image.cut_off < 8)


def test_a_metal_that_is_given_more_than_everything_has_no_certificate():
    cut = two_balls("metal_f82", 1)
    palette = rt.Palette(rt.RGB, {"sun": 1, "sky": 1, "floor.diffuse": 0.5, "ball.f0": 0.0})
    # Of F82 = 1 over F0 = 0 the bent curve passes 1; of F82 = 0.46, Schlick's own, it does not.
    for f82, bounded in ((1.0, False), (0.46, True)):
        cut_off = rt.shade(cut, palette.add({"ball.f82": f82})).cut_off
        assert np.all(np.isfinite(cut_off) == bounded), f82


def test_what_passes_one_has_no_certificate():
    scene = hall_of_mirrors(1)
    system = rt.collapse(rt.trace(scene))
    palette = rt.Palette(rt.RGB, {s: 0.5 if "." in s else 1.0 for s in scene.symbols}, unphysical=True)
    image = rt.shade(system, palette.replace({"front.diffuse": [0.5, 1.0, 3.0]}))
    assert np.isfinite(image.cut_off).tolist() == [True, True, False]


def test_an_alternative_that_mirrors_is_followed():
    base = mirrors(model="lambert")
    scene = replace(base, materials=[*base.materials, rt.Material("chrome", model="mirror")])
    swapped = replace(base, materials=[rt.Material("ball", model="mirror"), rt.Material("floor")])
    assert "mirrors" not in rt.plan(scene)
    assert "mirrors" in rt.plan(scene, alternatives={"ball": ["chrome"]})
    both = rt.render(scene, alternatives={"ball": ["chrome"]}, progress=False)
    alone = rt.render(swapped, progress=False)
    for light in both.lights:
        seen = both.G[:, [[str(i) for i in both.interactions].index(f"{light}*ball>chrome.mirror*floor.diffuse")]]
        other = alone.G[:, [[str(i) for i in alone.interactions].index(f"{light}*ball.mirror*floor.diffuse")]]
        assert seen.nnz > 0
        np.testing.assert_array_equal(seen.toarray(), other.toarray())


def test_the_certificate_counts_an_alternatives_mirror_once_the_palette_names_it():
    scene = mirrors(model="mirror", depth=1)
    system = rt.render(scene, alternatives={"floor": ["ball"]}, progress=False)
    palette = rt.Palette(rt.RGB, {"sun": 1, "sky": 1, "ball.mirror": 0.5, "floor.diffuse": 0.5})
    assert rt.shade(system, palette).certificate == "nothing cut off"
    mixed = rt.shade(system, palette.add({"floor>ball.mirror": 0.5}))
    assert np.all((mixed.cut_off > 0) & np.isfinite(mixed.cut_off))


@pytest.mark.parametrize("own", ["floor", "ball"])
def test_a_metal_is_no_alternative_because_its_edge_is_there_whatever_its_spectra(own):
    # Its white edge would be seen in a picture that no blend was asked of.
    base = mirrors(model="metal" if own == "ball" else "lambert")
    scene = replace(base, materials=[*base.materials, rt.Material("gold", model="metal")])
    other = "gold" if own == "floor" else "floor"
    with pytest.raises(ValueError, match=r"alternatives: '(gold|ball)' has a term that names no reflectance.*'mirror'"):
        rt.trace(scene, alternatives={own: [other]})
    assert rt.trace(scene, alternatives={own: []}).levels


def test_metals_of_one_model_blend_without_alternatives():
    base = mirrors(model="metal")
    scene = replace(base, materials=[*base.materials, rt.Material("gold", model="metal")])
    system = rt.render(scene, progress=False)
    spectra = {"sun": 1, "sky": 0.2, "floor.diffuse": 0.6, "ball.f0": "metal/iron", "gold.f0": "metal/gold"}
    palette = rt.Palette(rt.wavelengths(400, 700, 100), spectra)
    ends = moved(system, palette, rt.Blend("ball", "gold"), 1.0)
    gold = rt.shade(system, palette.replace({"ball.f0": "metal/gold"})).values
    np.testing.assert_allclose(rt.shade(system, ends).values, gold, rtol=1e-14)


def test_an_alternative_named_twice_counts_once_and_names_come_in_a_list():
    scene = two_materials(exponent=20)
    once, twice = (rt.collapse(rt.trace(scene, alternatives={"dull": n})) for n in (["shiny"], ["shiny"] * 2))
    assert np.array_equal(once.G.toarray(), twice.G.toarray())
    with pytest.raises(ValueError, match="give a list of names"):
        rt.trace(scene, alternatives={"dull": "shiny"})


def test_a_plan_says_why_mirrors_at_depth_0_are_left_out():
    assert "the depth is 0" in str(rt.plan(mirrors(model="mirror", depth=0)))


def test_depth_300_between_mirrors_loses_nothing_silently():
    # Products of 300 mirrors of 1e-3 are far below the smallest float; they stay monomials.
    hall = hall_of_mirrors(300, tilt=0.0)
    along = rt.Camera(position=(0, 0, 0), target=(0, 0, -1), width=4, height=4, field_of_view=0.2)
    system = rt.collapse(rt.trace(replace(hall, camera=along)))
    deepest = max(interaction.degree for interaction in system.interactions)
    assert deepest == 301
    spectra = {s: 1e-3 if "." in s else 1.0 for s in system.symbols}
    palette = rt.Palette(bands=rt.wavelengths(500, 520, 10), spectra=spectra)
    image = rt.shade(system, palette)
    assert np.all(np.isfinite(image.values))
    assert np.all(image.values > 0)


@pytest.mark.parametrize("shift", [1e6, 1e8])
def test_a_scene_moved_far_away_looks_the_same(shift):
    def moved(by):
        base = hall_of_mirrors(2)
        cam = rt.Camera(position=(0.25 + by, 0.25, 0), target=(by, 0, -1), width=16, height=16, field_of_view=50)
        shapes = [replace(s, centre=(s.centre[0] + by, s.centre[1], s.centre[2])) for s in base.shapes]
        lights = [rt.PointLight("lamp", position=(by, 1, 0.5)), rt.AmbientLight("sky")]
        return rt.collapse(rt.trace(replace(base, camera=cam, shapes=shapes, lights=lights)))

    here, there = moved(0.0), moved(shift)
    assert here.interactions == there.interactions
    np.testing.assert_allclose(there.G.toarray(), here.G.toarray(), rtol=1e-7)


@pytest.mark.parametrize("window", [(0, 0, 0, 4), (-1, 0, 3, 3), (0, 0, 25, 3), (3, 3, 2, 5)])
def test_a_window_outside_the_film_is_refused(window):
    with pytest.raises(ValueError, match="window"):
        rt.trace(two_materials(exponent=20), window=window)


def test_a_window_is_a_part_of_the_picture():
    scene = small("first", 20)
    whole = rt.collapse(rt.trace(scene)).G.toarray().reshape(20, 20, -1)
    part = rt.collapse(rt.trace(scene, window=(4, 6, 14, 12)))
    np.testing.assert_array_equal(part.G.toarray().reshape(6, 10, -1), whole[6:12, 4:14])


def test_an_orthographic_camera_sees_equal_balls_equally():
    scene = two_materials(exponent=20)
    flat = replace(scene, camera=camera(type="orthographic", view_width=4, position=(0, 0, 6)))
    levels = rt.trace(flat).levels[0]
    sizes = {points.material: points.hit.size for points in levels.points}
    assert sizes["shiny"] == sizes["dull"]


def test_unknown_alternatives_are_named():
    with pytest.raises(ValueError, match="rust"):
        rt.trace(two_materials(exponent=20), alternatives={"dull": ["rust"]})


def test_a_scene_that_nothing_is_in_is_black():
    scene = replace(two_materials(exponent=20), shapes=[rt.Sphere(centre=(0, 99, 0), radius=1, material="dull")])
    system = rt.collapse(rt.trace(scene))
    assert system.G.shape == (576, 0)
    assert not system.object_pixels.any()


def test_the_plan_names_what_calls_for_each_effect():
    chosen = rt.plan(mirrors(model=["lambert", "mirror"]))
    by_name = {effect.name: effect for effect in chosen.effects}
    assert by_name["mirrors"].called_by == ("ball",)
    assert by_name["shadows"].called_by == ("sun",)
    assert by_name["ambient"].called_by == ("sky",)
    assert not by_name["textures"].simulated
    assert "ball" in str(chosen)
    assert "ball" in chosen._repr_html_()
    assert SCENES.exists()


def test_a_reader_of_a_plan_sees_no_word_of_what_nothing_calls_for():
    chosen = rt.plan(mirrors(model=["lambert", "mirror"]))
    table, _, rest = str(chosen).partition("not called for: ")
    for effect in chosen.effects:
        assert (effect.name in table) == bool(effect.called_by)
        assert (effect.name in rest.replace("\n", " ").split(", ")) == (not effect.called_by)
        assert effect.called_by or effect.why not in str(chosen)


def furnace(shape, light=(0, 0, 0), depth=6):
    """A closed shape of one material, seen from inside, with a lamp inside."""
    return rt.Scene(
        camera=rt.Camera(position=(0, 0, 0), target=(0.3, 0.2, -1), field_of_view=90, width=9, height=7),
        shapes=[shape],
        materials=[rt.Material("wall", model=["lambert", "mirror"])],
        lights=[rt.PointLight("lamp", position=light)],
        depth=depth,
    )


@pytest.mark.parametrize("depth", [0, 1, 6, 40])
def test_a_closed_furnace_is_the_geometric_series(depth):
    # Camera and lamp in the middle of a sphere of radius R: every bounce meets the wall at a right angle, so the pixel
    # is Σ K^k ρ/(π R²), k = 0 … depth, and what is cut off is all of K^(depth + 1).
    system = rt.collapse(rt.trace(furnace(rt.Sphere((0, 0, 0), 2, "wall"), depth=depth)))
    mirrors = [one.met.count("wall.mirror") for one in system.interactions]
    assert sorted(mirrors) == list(range(depth + 1))
    assert all(one.met.count("wall.diffuse") == 1 for one in system.interactions)
    np.testing.assert_allclose(system.G.toarray(), 1 / (4 * np.pi), rtol=1e-12)
    palette = rt.Palette(
        bands=rt.wavelengths(400, 700, 100), spectra={"lamp": 3, "wall.diffuse": 1, "wall.mirror": 0.5}
    )
    expected = 3 / (4 * np.pi) * (1 - 0.5 ** (depth + 1)) / (1 - 0.5)
    np.testing.assert_allclose(rt.shade(system, palette).values, expected, rtol=1e-12)


@pytest.mark.parametrize("turn", [(0, 0, 0), (20, 30, 40)])
def test_no_ray_escapes_from_a_furnace_in_a_box(turn):
    scene = furnace(rt.Box((0.1, -0.2, 0.3), (2, 3, 4), "wall", rotate=turn), light=(0.4, 0.3, 0.2), depth=30)
    tree = rt.trace(scene)
    # Nothing hides the lamp in a convex room, so that every sample is lit at every bounce.
    assert [level.sample.size for level in tree.levels] == [63] * 31
    assert (rt.collapse(tree).G.toarray() > 0).all()


@pytest.mark.parametrize(
    ("shape", "nearest"),
    [
        (rt.Sphere((0, 0.5, 0), 2, "wall"), 1.5),
        (rt.Cylinder((0, -2, 0), (0, 3, 0), 1.25, "wall"), 1.25),
        (rt.Box((0, 0, 0), (2, 3, 4), "wall"), 1.0),
    ],
)
def test_a_lamp_inside_is_bounded_by_the_nearest_wall(shape, nearest):
    tree = rt.trace(furnace(shape))
    assert tree.lights["lamp"].bound == pytest.approx(1 / nearest**2, rel=1e-12)


def test_the_plan_says_what_stands_inside_a_closed_shape():
    inside = rt.plan(furnace(rt.Sphere((0, 0, 0), 2, "wall")))
    assert inside.remarks == ("The camera is inside shapes[0], a sphere: it sees what is inside, and its inner side.",)
    assert inside.remarks[0] in " ".join(str(inside).split())
    assert inside.remarks[0] in inside._repr_html_()
    lamp = rt.plan(furnace(rt.Box((9, 0, 0), (2, 2, 2), "wall"), light=(9, 0, 0)))
    assert lamp.remarks == ("The light lamp is inside shapes[0], a box: it does not shine outside of it.",)
    assert rt.plan(furnace(rt.Box((9, 0, 0), (2, 2, 2), "wall"))).remarks == ()
    dark = rt.plan(
        replace(furnace(rt.Box((0, 0, 0), (2, 2, 2), "wall")), lights=[rt.DirectionalLight("sun", (0, -1, 0))])
    )
    assert dark.remarks[1:] == ("The light sun is outside of shapes[0], a box: it does not shine inside it.",)


def test_a_camera_inside_a_mesh_sees_its_inner_side(tmp_path):
    corners = [(x, y, z) for x in (-9, 9) for y in (-9, 9) for z in (-9, 9)]
    faces = [(1, 2, 4, 3), (5, 7, 8, 6), (1, 5, 6, 2), (3, 4, 8, 7), (1, 3, 7, 5), (2, 6, 8, 4)]
    lines = [*("v {} {} {}".format(*c) for c in corners), *("f {} {} {} {}".format(*f) for f in faces)]
    (tmp_path / "box.obj").write_text("\n".join(lines))
    scene = replace(two_materials(exponent=20), shapes=[rt.Mesh("box.obj", "dull")], folder=tmp_path)
    assert rt.trace(scene).levels[0].sample.size == scene.camera.width * scene.camera.height


@pytest.mark.parametrize("depth", [0, 1])
@pytest.mark.parametrize("name", every_scene())
def test_at_any_depth_what_is_missing_is_bounded(name, depth):
    scene = replace(small(name, 24), depth=depth)
    palette = next(iter(rt.load_palettes(SCENES / f"{name}.toml").values()))
    cut, deep = (rt.shade(rt.collapse(rt.trace(replace(scene, depth=d))), palette) for d in (depth, 12))
    missing = (deep.values - cut.values).max(axis=(0, 1))
    assert np.all(missing <= (0 if cut.cut_off is None else cut.cut_off))
    if name == "spheres":
        assert missing.max() > 0
        assert "cut off" in cut.certificate
        assert cut.certificate != "nothing cut off"


def test_mirrors_at_depth_0_are_left_out_and_bounded():
    planned = {effect.name: effect for effect in rt.plan(replace(small("spheres", 8), depth=0)).effects}["mirrors"]
    assert (planned.state, planned.why) == ("left out, bounded", "the depth is 0")
    assert "chrome" in planned.called_by
    assert "left out, bounded" in str(rt.plan(replace(small("spheres", 8), depth=0)))


def test_a_camera_that_sees_nothing_says_so():
    away = replace(small("first", 8), camera=camera(8, position=(0, 0, 50), target=(0, 0, 99)))
    with pytest.warns(UserWarning, match=r"look at camera\.position, camera\.target"):
        system = rt.render(away, progress=False)
    assert "nothing is seen here that light reaches" in str(rt.formula(system, 3, 3))
    assert str(rt.probe(away, rays=64)).startswith("The camera sees nothing that light reaches")


def test_products_of_many_mirrors_that_vanish_are_not_called_nothing():
    # 200 mirrors of 0.02 leave 1e-340, which no float holds: what is lost is bounded, not denied.
    hall = hall_of_mirrors(200, tilt=0.0)
    along = rt.Camera(position=(0, 0, 0), target=(0, 0, -1), width=1, height=1, field_of_view=0.2)
    system = rt.collapse(rt.trace(replace(hall, camera=along)))
    spectra = {s: 0.02 if s.endswith("mirror") else 0.5 if "." in s else 1.0 for s in system.symbols}
    image = rt.shade(replace(system, tail=None), rt.Palette(rt.RGB, spectra))
    assert np.all(image.cut_off > 0)
    assert image.certificate != "nothing cut off"


def test_numbers_that_vanish_on_the_way_are_bounded_in_the_tail():
    # A mirror of a number, not of a symbol: its powers are multiplied while the tree is collapsed.
    dim = [rt.Material(name, model=rt.Model(**PAINT, reflected=1e-3)) for name in ("front", "back")]
    along = rt.Camera(position=(0, 0, 0), target=(0, 0, -1), width=2, height=2, field_of_view=0.2)
    hall = replace(hall_of_mirrors(120, tilt=0.0), materials=dim, camera=along)
    tree = rt.trace(hall, tolerance=0)
    assert len(tree.levels) == 121
    tail = rt.collapse(tree).tail
    assert sorted(set(tail.bound.indices.tolist())) == [0, 1]  # of the lamp, and of the sky
    assert 0 < tail.bound.data.max() < 1e-300
