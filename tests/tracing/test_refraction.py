"""Glass: Snell and Fresnel against 50 digits, energy in closed rooms, slabs in closed form, and what is refused."""

from dataclasses import replace
from fractions import Fraction

import mpmath
import numpy as np
import pytest
import sympy
from linear.test_formulas import at_50_digits
from scenes_for_tests import camera

import symrt as rt
from symrt.arrays import normalise
from symrt.reflection import Model
from symrt.reflection.symbols import fresnel, mirror, transmission
from symrt.tracing.plan import TOLERANCE
from symrt.tracing.refracting import interface

UP = np.array([[0.0], [1.0], [0.0]])
ULP = 2.0**-52


def view(sine):
    """Views at angles of given sines to the normal."""
    sine = np.asarray(sine, dtype=float)
    return np.stack([sine, np.sqrt((1 - sine) * (1 + sine)), np.zeros(sine.size)])


def fresnel_at_50_digits(normal, viewer, eta):
    """Shares mirrored and let through, of the vectors as they are, by the textbook's amplitudes."""
    if eta == 1:
        return 0.0, 1.0
    with mpmath.workdps(50):
        n, v = ([mpmath.mpf(float(x)) for x in vector] for vector in (normal, viewer))
        size = mpmath.sqrt(sum(x * x for x in n) * sum(x * x for x in v))
        across = [n[i] * v[j] - n[j] * v[i] for i, j in ((1, 2), (2, 0), (0, 1))]
        cos_i = abs(sum(a * b for a, b in zip(n, v, strict=True))) / size
        left = 1 - mpmath.mpf(float(eta)) ** 2 * sum(x * x for x in across) / size**2
        if left < 0:
            return 1.0, 0.0
        cos_t, eta = mpmath.sqrt(left), mpmath.mpf(float(eta))
        s, p = (eta * cos_i - cos_t) / (eta * cos_i + cos_t), (cos_i - eta * cos_t) / (cos_i + eta * cos_t)
        mirrored = (s * s + p * p) / 2
        return float(mirrored), float(1 - mirrored)


@pytest.mark.parametrize("eta", [1 / 1.5, 1.5, 1 / 2.4, 2.4, 1 / 1.0003, 1.0003, 1.0])
def test_fresnels_shares_at_any_angle(eta):
    random = np.random.default_rng(1)
    sines = np.concatenate(
        [random.uniform(0, 1, 60), 1 - 10.0 ** -np.arange(1, 15), 10.0 ** -np.arange(1, 15), [0.0, 1.0]]
    )
    if eta > 1:  # on both sides of the critical angle
        sines = np.concatenate([sines, [min(1.0, (1 + k * 10.0**-j) / eta) for j in range(3, 15) for k in (-1, 1)]])
    viewer = view(sines)
    normal = np.broadcast_to(UP, viewer.shape).copy()
    met = interface(normal, viewer, np.full(sines.size, eta))
    for k in range(sines.size):
        mirrored, through = fresnel_at_50_digits(normal[:, k], viewer[:, k], eta)
        assert met.mirrored[k] == pytest.approx(mirrored, rel=2e-15, abs=1e-30)
        assert met.through[k] == pytest.approx(through, rel=2e-15, abs=1e-300)
    assert np.abs(met.mirrored + met.through - 1).max() <= ULP
    if eta == 1:
        assert not met.mirrored.any()


def test_snells_law_bends_the_view():
    random = np.random.default_rng(2)
    normal, viewer = (normalise(random.normal(size=(3, 500))) for _ in range(2))
    normal = np.where((normal * viewer).sum(axis=0) < 0, -normal, normal)
    for index in (1.33, 1.9):
        for eta in (index, 1 / index):
            met = interface(normal, viewer, np.full(500, eta))
            goes = met.through > 0
            assert goes.all() == (eta < 1)
            # The parts along the surface are in the ratio of the indices, and the ray is on the other side.
            across = np.cross(normal, met.bent, axis=0) + eta * np.cross(normal, viewer, axis=0)
            assert np.abs(across[:, goes]).max() < 1e-14
            assert np.all((met.bent * normal).sum(axis=0)[goes] < 0)
            np.testing.assert_allclose(np.linalg.norm(met.bent[:, goes], axis=0), 1, rtol=1e-14)


def test_total_reflection_is_decided_as_in_exact_arithmetic():
    random, decided = np.random.default_rng(3), set()
    for _ in range(400):
        index = float(random.uniform(1.01, 3))
        sine = 1 / index
        for _ in range(int(random.integers(0, 4))):
            sine = np.nextafter(sine, random.choice([0.0, 1.0]))
        viewer = view([sine])
        n, v = ([Fraction(float(x)) for x in vector[:, 0]] for vector in (UP, viewer))
        across = [n[i] * v[j] - n[j] * v[i] for i, j in ((1, 2), (2, 0), (0, 1))]
        exactly = Fraction(index) ** 2 * sum(x * x for x in across) > sum(x * x for x in n) * sum(x * x for x in v)
        met = interface(UP, viewer, np.array([index]))
        assert (met.mirrored[0] == 1.0 and met.through[0] == 0.0) == exactly or not exactly
        if exactly:
            assert not met.bent.any()
        decided.add(exactly)
    assert decided == {False, True}


def lit_room(shapes, depth, **camera_of):
    """A white room lit from everywhere, with something of glass in it."""
    return rt.Scene(
        camera=rt.Camera(position=(0, 0, 4), target=(0, 0, 0), width=8, height=8, field_of_view=20, **camera_of),
        shapes=[rt.Sphere((0, 0, 0), 50, "room"), *shapes],
        materials=[rt.Material("room", "lambert"), rt.Material("ball", "glass", index=1.5)],
        lights=[rt.AmbientLight("sky")],
        depth=depth,
    )


def test_a_slab_seen_straight_lets_through_the_series():
    # Of every round trip inside R² is left: (1 − R)² Σ R^2k comes through, and R + R (1 − R)² Σ R^2k back.
    scene = lit_room([rt.Box((0, 0, 0), (30, 30, 1), "ball")], depth=9)
    scene = replace(scene, camera=replace(scene.camera, width=1, height=1))
    system = rt.render(scene, progress=False)
    share = ((1.5 - 1) / (1.5 + 1)) ** 2
    image = rt.shade(system, rt.Palette(rt.RGB, {"sky": 1.0, "room.diffuse": 1.0}))
    assert [str(i) for i in system.interactions] == ["sky*room.diffuse"]
    # Through after 0, 1 round trips, and back after 0 and 1; what is below the threshold is left out, and bounded.
    followed = (1 - share) ** 2 * (1 + share**2) + share + share * (1 - share) ** 2
    assert share**3 < TOLERANCE < share**2
    assert image.values[0, 0, 0] == pytest.approx(followed, rel=1e-12)
    assert 0 < 1 - followed <= image.cut_off.max() < 4 * TOLERANCE


@pytest.mark.parametrize("depth", [0, 1, 2, 5, 12])
def test_in_a_uniform_room_glass_is_seen_as_nothing(depth):
    # Energy: whatever is mirrored, bent and mirrored inside sees the same radiance everywhere.
    scene = lit_room([rt.Sphere((0, 0, 0), 0.6, "ball"), rt.Box((0.4, 0.3, -2), (1, 1, 1), "ball")], depth)
    image = rt.shade(rt.render(scene, progress=False), rt.Palette(rt.RGB, {"sky": 1.0, "room.diffuse": 1.0}))
    assert image.values.max() <= 1 + 1e-12
    assert (1 - image.values).max() <= image.cut_off.max()
    assert image.cut_off.max() <= (0.05 if depth == 12 else 2)


def scene_of_glass(**parts):
    return rt.Scene(
        camera=camera(16),
        shapes=[
            rt.Sphere(centre=(0, 0, 0), radius=1, material="ball"),
            rt.Rectangle(centre=(0, -1.2, 0), edge_u=(8, 0, 0), edge_v=(0, 0, -8), material="floor"),
        ],
        materials=[rt.Material("ball", "glass", index=1.5), rt.Material("floor", "lambert")],
        lights=[rt.DirectionalLight("sun", direction=(-1, -2, -1)), rt.AmbientLight("sky")],
        depth=4,
        **parts,
    )


def blended(scene):
    """The same scene, its ball glass, a mirror and another glass, blended."""
    materials = [*scene.materials, rt.Material("flint", "glass", index=1.7), rt.Material("chrome", "mirror")]
    shapes = [replace(scene.shapes[0], material="cloth"), *scene.shapes[1:]]
    texture = rt.BandedRelief("cloth", levels=(-3000, 0), blend=1400, materials=("ball", "chrome", "flint"))
    return replace(scene, materials=materials, shapes=shapes, textures=[texture])


@pytest.mark.parametrize("change", [lambda scene: scene, blended], ids=["glass", "glasses and a mirror blended"])
def test_formula_linear_form_and_pixel_are_one(change):
    scene = change(scene_of_glass())
    tree = rt.trace(scene)
    system = rt.collapse(tree)
    palette = rt.Palette(rt.RGB, {"sun": 2.0, "sky": 0.3, "floor.diffuse": 0.6, "chrome.mirror": 0.7})
    image, bent = rt.shade(system, palette).values, 0
    spectra = {symbol: float(palette[symbol][0]) for symbol in scene.symbols}
    for y in range(0, 16, 3):
        for x in range(0, 16, 2):
            letters, linear = rt.formula(tree, x, y), rt.formula(system, x, y)
            bent += any(name.startswith("transmission") for name in letters.values)
            terms = len(sympy.Add.make_args(letters.expression.expand()))
            for formula in (letters, linear):
                error = abs(at_50_digits(formula, spectra) - sympy.Float(float(image[y, x, 0]), 50))
                assert error <= max(4, terms) * np.spacing(image[y, x, 0])
    assert bent > 4
    assert tree.rays["refraction"] > 0
    assert ("mirrors" in tree.rays) == ("chrome.mirror" in scene.symbols)


def test_tiles_have_the_same_bits():
    scene = scene_of_glass()
    whole, part = rt.collapse(rt.trace(scene)), rt.collapse(rt.trace(scene, window=(3, 2, 11, 9)))
    rows = whole.G.toarray().reshape(16, 16, -1)[2:9, 3:11].reshape(56, -1)
    for j, interaction in enumerate(part.interactions):
        np.testing.assert_array_equal(part.G[:, [j]].toarray()[:, 0], rows[:, whole.interactions.index(interaction)])


def test_what_refraction_would_bring_is_bounded_without_it():
    scene = scene_of_glass()
    palette = rt.Palette(rt.RGB, {"sun": 2.0, "sky": 0.3, "floor.diffuse": 0.6})
    full, without = (
        rt.shade(rt.render(scene, force=force, progress=False), palette) for force in (None, {"refraction": False})
    )
    missing = np.abs(full.values - without.values).max()
    assert 0 < missing <= without.cut_off.max() < np.inf
    chosen = rt.plan(scene)
    assert "refraction" in chosen
    assert "mirrors" not in chosen
    assert "refraction" not in rt.plan(replace(scene, shapes=scene.shapes[1:]))


def test_caustics_stand_in_the_plan_as_left_out():
    chosen = {effect.name: effect for effect in rt.plan(scene_of_glass()).effects}
    assert (chosen["caustics"].state, chosen["caustics"].called_by) == ("left out, not bounded", ("ball",))
    assert "its shadows are full" in chosen["caustics"].why
    assert chosen["mirrors"].state == "not called for"
    # Certificates are of everything else.
    image = rt.shade(
        rt.render(scene_of_glass(), progress=False), rt.Palette(rt.RGB, {"sun": 2, "sky": 1, "floor.diffuse": 0.5})
    )
    assert image.cut_off.max() < np.inf
    with pytest.raises(ValueError, match="caustics cannot be simulated: light is not followed through glass"):
        rt.plan(scene_of_glass(), force={"caustics": True})


def test_a_users_own_model_lets_light_through_a_tint():
    tint = rt.Material("ball", Model(reflected=fresnel, transmitted=transmission * mirror), index=1.5)
    scene = scene_of_glass()
    system = rt.render(replace(scene, materials=[tint, scene.materials[1]]), progress=False)
    assert "sky*ball.mirror**2*floor.diffuse" in map(str, system.interactions)
    # With a tint of 1 it is clear glass.
    clear, tinted = (
        rt.shade(s, rt.Palette(rt.RGB, {"sun": 2.0, "sky": 0.3, "floor.diffuse": 0.6, "ball.mirror": 1.0}))
        for s in (rt.render(scene, progress=False), system)
    )
    np.testing.assert_allclose(tinted.values, clear.values, rtol=1e-12)


def test_what_cannot_be_glass_is_refused_with_a_remedy(tmp_path):
    scene = scene_of_glass()
    with pytest.raises(ValueError, match=r"index: the model glass needs it"):
        rt.Material("ball", "glass")
    for index in (0.0, -1.5, 1e-300, 1e9):
        with pytest.raises(ValueError, match=r"index = .*: it must be from 0.01 to 100; glass has 1.5"):
            rt.Material("ball", "glass", index=index)
    with pytest.raises(ValueError, match=r"shapes\[1\].material = 'ball': .* a rectangle has no inside; use a sphere"):
        replace(scene, shapes=[scene.shapes[0], replace(scene.shapes[1], material="ball")])
    with pytest.raises(ValueError, match=r"ball.index: rays were bent by it; trace the scene again"):
        rt.collapse(rt.trace(scene), values={"ball.index": 1.4})
    with pytest.raises(ValueError, match=r"ball.index: rays were bent by it"):
        rt.collapse(rt.trace(scene), free=["ball.index"])
    with pytest.raises(ValueError, match=r"fresnel is a ray's; use it in reflected or transmitted"):
        Model(direct=mirror * fresnel)
    (tmp_path / "open.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\n")
    opened = replace(scene, shapes=[rt.Mesh("open.obj", "ball"), scene.shapes[1]], folder=tmp_path)
    with pytest.raises(ValueError, match=r"shapes\[0\]: a mesh of glass must be closed, and its edge from \(") as said:
        rt.trace(opened)
    assert "\n" not in str(said.value)
    both = rt.Checker("both", ("ball", "floor"), 0.5)
    with pytest.raises(
        ValueError, match=r"shapes\[1\].material = 'both': light goes through it, and a rectangle has no"
    ):
        replace(scene, shapes=[scene.shapes[0], replace(scene.shapes[1], material="both")], textures=[both])
    with pytest.raises(ValueError, match=r"shapes\[0\]: a mesh of glass must be closed"):
        rt.trace(replace(opened, shapes=[rt.Mesh("open.obj", "both"), scene.shapes[1]], textures=[both]))


@pytest.mark.parametrize("outwards", [True, False])
def test_a_mesh_of_glass_has_its_normals_outside(tmp_path, outwards):
    faces = ["1 3 2", "1 2 4", "1 4 3", "2 3 4"]
    lines = [f if outwards else " ".join(reversed(f.split())) for f in faces]
    points = ["v 0 0 0", "v 1 0 0", "v 0 1 0", "v 0 0 1"]
    (tmp_path / "drop.obj").write_text("\n".join([*points, *(f"f {line}" for line in lines)]) + "\n")
    base = scene_of_glass()
    scene = replace(base, shapes=[rt.Mesh("drop.obj", "ball"), base.shapes[1]], folder=tmp_path)
    if outwards:
        assert rt.trace(scene).rays["refraction"] > 0
    else:
        with pytest.raises(ValueError, match=r"shapes\[0\]: a mesh of glass is wound inside out; turn its faces round"):
            rt.trace(scene)
