"""Trees of several branches say what the plain tracer sees: every rule is told to both, and both tell their pictures.

The spectra are drawn at random in four bands, so that coefficients that differ give pixels that differ.
"""

import itertools
import math
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
import pytest
import reference
from reference.lights import point_light
from reference.models import from_everywhere, lambert
from reference.vectors import add, dot, mirrored, unit
from sympy import pi
from test_pictures import BALL, CRATE, POINT, SUN, TILE, scene, write_scene
from tracing.toys import BACK, EMBER, GLASS, GLOW, LEANING, MIRRORED, SCATTER, TENT, UNEVEN, Twin

import symrt as rt
from symrt.reflection import diffuse, n_dot_l, n_dot_v, reflectance
from symrt.tracing import effects

WIDTH, HEIGHT = 9, 7

# --- The rules of the toys, once more: one ray at a time --------------------------------------------------------------


def glass(hit, to_eye):
    onward = mirrored(to_eye, hit.shading)
    return [reference.Ray("reflected", onward, MIRRORED), reference.Ray("reflected", to_eye, BACK)]


def scatter(hit, to_eye):
    facing = dot(hit.shading, to_eye)
    return [
        reference.Ray("reflected", mirrored(to_eye, hit.shading), facing / 2),
        reference.Ray("reflected", to_eye, 0.5 - facing / 2),
        reference.Ray("direct", unit(add(hit.shading, LEANING)), 1 - facing / 4),
    ]


def glow(hit, to_eye):
    return {"glow": dot(hit.normal, to_eye) / 3}


def uneven(x, y):
    if x % 2:
        return [reference.Sample(x + 0.5, y + 0.5, 1.0)]
    thirds = [(k + 0.5) / 3 for k in range(3)]
    return [
        reference.Sample(x + across, y + down, weight)
        for (down, across), weight in zip(itertools.product(thirds, thirds), TENT, strict=True)
    ]


def twin(point):
    ways = [point_light({"position": [x, 4, 2]})(point)[0] for x in (-1.0, 1.0)]
    return [way._replace(irradiance=way.irradiance / 2) for way in ways]


AWAY = (1 - n_dot_v) ** 5
SCHLICK = rt.Model(
    direct=diffuse * n_dot_l / pi, ambient=diffuse, reflected=AWAY + (1 - AWAY) * reflectance("f0") * diffuse
)


def schlick(at, _):
    """The share that nothing takes a colour of, and one that a stain of two reflectances colours."""
    away = (1 - at.n_v) ** 5
    return [("", away), ("f0*diffuse", 1 - away)]


# --- Scenes, told twice -----------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Case:
    """A scene file, and what no file can say: for symrt, and in the words of the plain tracer.

    `effects` take the place of mirrors; `ours` changes symrt's scene, `asked` is said to `trace`; `theirs` changes the
    plain scene.  `brightest` are the largest shares that a surface sends of each light, times its largest irradiance;
    `bounded` changes the plain scene once more, to one that shows the bound on the light of an effect left out, and
    `whole` to one that leaves nothing out.
    """

    table: dict
    effects: tuple = ()
    ours: dict = field(default_factory=dict)
    asked: dict = field(default_factory=dict)
    theirs: dict = field(default_factory=dict)
    spectra: tuple = ()
    brightest: dict = field(default_factory=lambda: {"sun": 1 / math.pi, "sky": 1.0})
    bounded: dict = field(default_factory=dict)
    whole: dict = field(default_factory=dict)


GLAZED = {"model": ["lambert", "mirror"]}
GLOSSY = {"model": ["phong", "mirror"], "exponent": 30}
SKY = {"type": "ambient"}


def room(*, lights=None, **changes):
    """A glazed ball, a mirror behind it and a floor that mirrors a little, under a sun and a sky, two bounces deep."""
    materials = {"red": GLAZED, "floor": GLAZED}
    behind = TILE | {"material": "chrome", "centre": [-1.2, 0.9, -1.1], "edge_u": [2.0, 0, 0.9], "edge_v": [0, 1.6, 0]}
    whole = scene(BALL, behind, materials=materials | changes.pop("materials", {}), depth=2, **changes)
    return whole | {"lights": {"sun": SUN, "sky": SKY} if lights is None else lights}


FURNACE = {
    "camera": {"position": [0.25, 0.125, 0], "target": [0, 0, 0.5], "field_of_view": 60},
    "shapes": [{"type": "sphere", "centre": [0, 0, 0], "radius": 2, "material": "wall"}],
    "materials": {"wall": GLAZED},
    "lights": {"lamp": {"type": "point", "position": [0, 0, 0]}},
    "depth": 3,
}
TEXTURED = room(
    textures={"cloth": {"type": "weight_image", "file": "weights.png", "materials": ["red", "blue", "chrome"]}}
)
TEXTURED["shapes"] = [*TEXTURED["shapes"], CRATE | {"centre": [1.5, 0.7, 0.4], "material": "cloth"}]
LAMPLIT = {"sun": 17 / math.pi, "sky": 1.0, "glow": 0.0}  # a lobe of exponent 30 adds (30 + 2)/2π to a diffuser's 1/π
OWN = {"model": [{"direct": lambert, "ambient": from_everywhere, "reflected": schlick}]}


def as_bright_as_can_be(via, share):
    """The room's materials, each sending on the same share of all light by one formula, whatever its angle."""
    bright = {"model": [{via: lambda *_: [("", share)]}, "mirror"]}
    return {"red": bright, "floor": bright, "chrome": {"model": "mirror"}}


CASES = {
    "mirrors": Case(room()),
    "mirrors at depth 0": Case(room() | {"depth": 0}),
    "mirrors left out": Case(room(), asked={"force": {"mirrors": False}}, theirs={"depth": 0}),
    "shadows left out": Case(
        room(),
        asked={"force": {"shadows": False}},
        theirs={"unshadowed": {"sun"}},
        bounded={"materials": as_bright_as_can_be("direct", 1 / math.pi), "ambient": []},
        whole={"unshadowed": set()},
    ),
    "the sky left out": Case(
        room(),
        asked={"force": {"ambient": False}},
        theirs={"ambient": []},
        bounded={"materials": as_bright_as_can_be("ambient", 1.0), "ambient": ["sky"], "lights": {}},
        whole={"ambient": ["sky"]},
    ),
    "two branches with fixed shares": Case(room(), (GLASS,), theirs={"sending": (glass,)}),
    "two branches in a furnace": Case(
        FURNACE, (GLASS,), theirs={"sending": (glass,)}, brightest={"lamp": 1 / (4 * math.pi)}
    ),
    "three branches by two formulas": Case(room(), (SCATTER,), theirs={"sending": (scatter,)}),
    "three branches and gloss": Case(
        room(materials={"red": GLOSSY}), (SCATTER,), theirs={"sending": (scatter,)}, brightest=LAMPLIT
    ),
    "two rules at once": Case(room(), (GLASS, SCATTER), theirs={"sending": (glass, scatter)}),
    "branches from blended materials": Case(TEXTURED, (SCATTER,), theirs={"sending": (scatter,)}),
    "a formula of several terms": Case(
        room(),
        (GLASS,),
        ours={"materials": {"red": SCHLICK, "floor": SCHLICK}},
        theirs={"sending": (glass,), "materials": {"red": OWN, "floor": OWN, "chrome": {"model": "mirror"}}},
        spectra=("red.f0", "floor.f0"),
    ),
    "light that hits send by themselves": Case(
        room(),
        (GLASS, GLOW, EMBER),
        theirs={"sending": (glass,), "emitting": (glow, lambda *_: {"ember": 0.125})},
        spectra=("glow", "ember"),
    ),
    "a film of uneven weights": Case(room(), (GLASS, UNEVEN), theirs={"sending": (glass,), "film": uneven}),
    "3 by 3 samples and two branches": Case(room(camera={"samples": 3}), (GLASS,), theirs={"sending": (glass,)}),
    "a light of two ways": Case(
        room(lights={"sky": SKY, "twin": POINT}),
        (GLASS,),
        ours={"lights": (rt.AmbientLight("sky"), Twin("twin"))},
        theirs={"sending": (glass,), "lights": {"twin": twin}},
        brightest={"sky": 1.0, "twin": math.inf},
    ),
    "an alternative": Case(
        room(materials={"floor": {"model": "lambert"}}),
        (GLASS,),
        asked={"alternatives": {"floor": ["red"]}},
        theirs={
            "sending": (glass,),
            "materials": {"floor>red": GLAZED, "floor": {"model": "lambert"}, "red": GLAZED}
            | {"chrome": {"model": "mirror"}},
            "textures": {"floor": lambda _: {"floor": 1.0, "floor>red": 1.0}},
        },
        spectra=("floor>red.diffuse", "floor>red.mirror"),
        # What may stand at a point is added: the floor, and the red that may take its place.
        brightest={"sun": 2 / math.pi, "sky": 2.0},
    ),
    "all at once": Case(
        TEXTURED,
        (SCATTER, GLASS, GLOW, UNEVEN),
        theirs={"sending": (scatter, glass), "emitting": (glow,), "film": uneven} | {"depth": 1},
        ours={"depth": 1},
        spectra=("glow",),
    ),
}


@dataclass(frozen=True, eq=False)
class Told:
    """A case as both tracers have it."""

    scene: rt.Scene
    plain: reference.Scene
    spectra: dict
    case: Case

    @property
    def palette(self):
        own = {name: values for name, values in self.spectra.items() if name != "beyond" and "*" not in name}
        return rt.Palette(rt.wavelengths(400, 700, 100), own)

    def tree(self):
        return rt.trace(self.scene, **self.case.asked)

    def seen(self, **changes):
        """The plain tracer's picture of a changed scene, (row, column, band)."""
        return np.array(reference.picture(self.plain._replace(**changes), self.spectra, WIDTH, HEIGHT))

    @cached_property
    def picture(self):
        return self.seen()


@pytest.fixture(params=CASES, scope="module")
def told(request, tmp_path_factory):
    case, folder = CASES[request.param], tmp_path_factory.mktemp("told")
    with pytest.MonkeyPatch.context() as patch:
        if case.effects:
            others = (effect for effect in effects.EFFECTS if effect.name != "mirrors")
            patch.setattr(effects, "EFFECTS", (*case.effects, *others))
        yield both_ways(case, folder)


def both_ways(case, folder):
    """A case as symrt has it, and as the plain tracer has it."""
    # Symrt's scene: the file, with models and lights that no file can name.
    write_scene(folder, case.table)
    path = folder / "scene.toml"
    ours = rt.load_scene(path)
    ours = replace(ours, camera=replace(ours.camera, width=WIDTH, height=HEIGHT))
    own = case.ours.get("materials", {})
    materials = [rt.Material(m.name, model=own[m.name]) if m.name in own else m for m in ours.materials]
    ours = replace(ours, **(case.ours | {"materials": materials}))

    # The plain one: tables are added to, the rest is replaced.
    plain = reference.load(path)._replace(least=0.0)  # the rules tell no bound of what they send on
    added = {
        name: getattr(plain, name) | case.theirs[name] for name in ("materials", "textures") if name in case.theirs
    }
    plain = plain._replace(**(case.theirs | added))

    # The palette, and spectra of what no file can name.
    random = np.random.default_rng(7)
    spectra = reference.load_palette(path, "drawn")
    spectra |= {name: random.uniform(0.05, 0.95, 4).tolist() for name in case.spectra}
    spectra |= {f"{m}.f0*diffuse": np.multiply(spectra[f"{m}.f0"], spectra[f"{m}.diffuse"]).tolist() for m in own}
    beyond = np.sum([k * np.array(spectra[light]) for light, k in case.brightest.items() if k], axis=0)
    return Told(ours, plain, spectra | {"beyond": beyond.tolist()}, case)


def test_a_tree_of_branches_shows_what_a_scalar_tracer_sees(told):
    tree, expected = told.tree(), told.picture
    seen = rt.shade(rt.collapse(tree), told.palette).values
    np.testing.assert_allclose(seen, expected, rtol=1e-9, atol=0)

    # The same in letters, in the darkest and the brightest pixel that is not black.
    lit = np.flatnonzero(expected.sum(axis=2))
    order = lit[np.argsort(expected.sum(axis=2).ravel()[lit])]
    spectra = {name: np.array(values) for name, values in told.spectra.items()}
    for y, x in (divmod(int(k), WIDTH) for k in order[[0, -1]]):
        np.testing.assert_allclose(rt.formula(tree, x, y).evaluate(spectra), expected[y, x], rtol=1e-9, atol=0)


def test_the_tail_is_what_cut_rays_bring_if_all_is_as_bright_as_can_be(told):
    tail = rt.collapse(told.tree()).tail
    if np.isinf(told.spectra["beyond"]).any():
        assert np.isinf(tail.bound.data).any()
        return
    spectra = {name: np.array(values) for name, values in told.spectra.items()}
    columns = [np.prod([spectra[name] for name in (i.light, *i.met)], axis=0) for i in tail.interactions]
    bound = (tail.bound @ np.array(columns)).reshape(HEIGHT, WIDTH, 4)
    expected = told.seen(beyond="beyond") - told.picture
    if told.case.bounded:
        expected += told.seen(**told.case.bounded)
    assert expected.max() > 0
    np.testing.assert_allclose(bound, expected, rtol=1e-9, atol=1e-15)


def test_what_is_missing_is_within_the_certificate(told):
    image = rt.shade(rt.collapse(told.tree()), told.palette)
    missing = abs(told.seen(depth=told.plain.depth + 1, **told.case.whole) - told.picture).max(axis=(0, 1))
    assert np.all(missing > 0)
    assert np.all(missing <= image.cut_off)
