"""What symrt renders and shades is what a plain scalar tracer sees, pixel by pixel and band by band, to 1e-9."""

import copy
import math
from dataclasses import replace
from pathlib import Path

import imageio.v3 as imageio
import numpy as np
import pytest
import reference
import tomli_w

import symrt as rt

SCENES = sorted((Path(__file__).parents[1] / "scenes").glob("*.toml"))
SMALLER = {"cornell": 14, "lens": 14, "many_lights": 3, "prism": 9}
"""Pixels across pictures of scenes that cost a scalar tracer more than others."""
COMPONENTS = {
    "lambert": ["diffuse"],
    "phong": ["diffuse", "specular"],
    "phong_plain": ["diffuse", "specular"],
    "blinn_phong": ["diffuse", "specular"],
    "fluorescent": [],  # its own test has the matrix
    "mirror": ["mirror"],
    "emitter": [],
    "glass": [],
    "absorption": ["transmittance"],
    "metal": ["f0"],
    "metal_f82": ["f0", "f82"],
    "rough_metal": ["f0"],
}


def disagreement(path, palette, width, height):
    """The largest relative difference of any pixel in any band; infinite where only one of the two is black."""
    scene = rt.load_scene(path)
    # What is gathered is held against the plain tracer in `test_interreflection`, along given rays.
    eye = replace(scene.camera, width=width, height=height, lens_samples=4)
    scene = replace(scene, camera=eye, interreflection=None)
    # Lengths in absorbing glass are interpolated: as finely as can be told from the lengths themselves.
    system = rt.render(scene, error=1e-13, lengths="chebyshev", progress=False)
    seen = rt.shade(system, rt.load_palettes(path)[palette]).values
    expected = np.array(reference.render(path, palette, width, height, lens_samples=4))
    assert seen.shape == expected.shape
    assert expected.max() > 0, "a black picture proves nothing"
    with np.errstate(divide="ignore"):
        return np.divide(abs(seen - expected), abs(expected), where=seen != expected, out=np.zeros(seen.shape)).max()


@pytest.mark.parametrize("palette", ["first", "second"])
@pytest.mark.parametrize("path", SCENES, ids=lambda path: path.stem)
def test_every_scene_looks_as_a_scalar_tracer_sees_it(path, palette):
    name = list(rt.load_palettes(path))[["first", "second"].index(palette)]
    size = SMALLER.get(path.stem, 32)
    assert disagreement(path, name, size, size) <= 1e-9


# --- Small scenes, one for each thing that a scene may hold ---------------------------------------------------------

BASE = {
    "camera": {"position": [0.31, 2.17, 6.83], "target": [0.05, 0.62, -0.1], "field_of_view": 38},
    "shapes": [{"type": "plane", "point": [0, 0, 0], "normal": [0, 1, 0], "material": "floor"}],
    "materials": {
        "floor": {"model": "lambert"},
        "red": {"model": "phong", "exponent": 30},
        "blue": {"model": "lambert"},
        "chrome": {"model": "mirror"},
    },
    "lights": {
        "sun": {"type": "directional", "direction": [-0.7, -1.3, -0.9]},
        "lamp": {"type": "point", "position": [-2.1, 3.3, 2.2]},
    },
}
BALL = {"type": "sphere", "centre": [0.1, 0.9, 0.2], "radius": 0.9, "material": "red"}
TILE = {"type": "rectangle", "centre": [0, 0.9, 0], "edge_u": [1.7, 0.2, 0.3], "edge_v": [-0.2, 1.4, 0.2]}
PIPE = {"type": "cylinder", "base": [-0.4, 0.2, 0.3], "top": [0.5, 1.6, -0.2], "radius": 0.5, "material": "red"}
CRATE = {"type": "box", "centre": [0.1, 0.8, 0.3], "size": [1.1, 1.3, 0.9], "rotate": [20, 30, 40], "material": "red"}
ROOM = {
    "type": "box",
    "centre": [0, 3, 1],
    "size": [15, 9, 17],
    "rotate": [0, 10, 0],
    "material": {"left": "red", "right": "blue", "back": "chrome", "others": "floor"},
}


def scene(*shapes, **changes):
    """The floor with these shapes on it; `changes` adds to, or replaces in, the tables of the file."""
    whole = copy.deepcopy(BASE)
    whole["shapes"] += shapes
    for name, change in changes.items():
        whole[name] = {**whole.get(name, {}), **change} if isinstance(change, dict) else change
    return whole


def textured(shape, **texture):
    return scene(shape | {"material": "cloth"}, textures={"cloth": texture})


def glazed(**texture):
    """A ball whose texture has glass in it, before a pipe."""
    glass = {"crystal": {"model": "glass", "index": 1.7}, "water": {"model": "glass", "index": 1.33}}
    cloth = {"cloth": texture}
    behind = PIPE | {"base": [-1.4, 0.2, -0.9], "top": [0.5, 1.6, -1.4], "radius": 0.3}
    return scene(BALL | {"material": "cloth"}, behind, textures=cloth, materials=glass, depth=3)


def modelled(model, **parameters):
    return scene(BALL | {"material": "own"}, materials={"own": {"model": model, **parameters}})


def lit(**lights):
    return scene(BALL, PIPE) | {"lights": lights}


CHECKER = {"type": "checker", "size": 0.37, "materials": ["red", "blue"]}
POINT, SUN = BASE["lights"]["lamp"], BASE["lights"]["sun"]
LAMP = {"type": "rectangle", "centre": [-2.1, 3.3, 2.2], "edge_u": [1.1, 0, 0.4], "edge_v": [-0.2, -0.45, 0.55]}


def under_a_lamp(*shapes, **lamp):
    return scene(*(shape | {"material": "blue"} for shape in shapes)) | {"lights": {"lamp": LAMP | lamp}}


SMALL = {
    "a plane": scene(),
    "a sphere": scene(BALL),
    "a disk": scene({"type": "disk", "centre": [0, 1, 0], "normal": [0.2, 0.3, 1], "radius": 0.8, "material": "red"}),
    "a rectangle": scene(TILE | {"material": "red"}),
    "a capped cylinder": scene(PIPE),
    "an open cylinder, seen into": scene(PIPE | {"top": [0.1, 0.9, 2.0], "capped": False}),
    "a box, turned": scene(CRATE),
    "a checked box": textured(CRATE, **CHECKER),
    "a label image on a box": textured(
        CRATE, type="label_image", file="labels.png", materials=["red", "blue", "floor"]
    ),
    "a room of several walls": scene(ROOM, CRATE, BALL | {"centre": [1.6, 0.9, 0.2], "material": "chrome"}),
    "a room of mirrors": scene(ROOM | {"material": "chrome"}, BALL, depth=5),
    "the inside of a ball": scene(BALL | {"centre": [0, 2, 1], "radius": 9, "material": "chrome"}, BALL),
    "the inside of a cylinder": scene(PIPE | {"base": [0, -3, 0], "top": [0.5, 6, 0], "radius": 9}, BALL),
    "the inside of a mesh": scene({"type": "mesh", "file": "cube.obj", "material": "red", "scale": 17}, BALL),
    "a flat mesh": scene({"type": "mesh", "file": "cube.obj", "material": "red", "translate": [0.1, 0.8, 0.3]}),
    "a smooth mesh": scene({"type": "mesh", "file": "egg.obj", "material": "red", "translate": [0.1, 0.9, 0.2]}),
    "a smooth mesh whose faces are wound inwards": scene(
        {"type": "mesh", "file": "inwards.obj", "material": "red", "translate": [0.1, 0.9, 0.2]}
    ),
    "a mesh, turned and scaled": scene(
        {"type": "mesh", "file": "cube.obj", "material": "red"}
        | {"scale": 0.6, "rotate": [20, 30, 40], "translate": [0.2, 1.1, 0.1]}
    ),
    "a mesh of two materials": scene(
        {"type": "mesh", "file": "cube.obj", "material": {"lid": "red", "walls": "blue"}, "translate": [0.1, 0.8, 0.3]}
    ),
    "a checked plane": scene()
    | {"shapes": [BASE["shapes"][0] | {"material": "cloth"}], "textures": {"cloth": CHECKER}},
    "a checked sphere": textured(BALL | {"pole": [0.2, 1, 0.1], "meridian": [0.4, 0, 1]}, **CHECKER),
    "a checked disk": textured(
        {"type": "disk", "centre": [0, 1, 0], "normal": [0.2, 0.3, 1], "radius": 0.8}, **CHECKER
    ),
    "a checked rectangle": textured(TILE, **CHECKER),
    "a checked cylinder": textured(PIPE, **CHECKER),
    "a label image": textured(TILE, type="label_image", file="labels.png", materials=["red", "blue", "floor"]),
    "a weight image": textured(TILE, type="weight_image", file="weights.png", materials=["red", "blue", "floor"]),
    "a label image on a sphere": textured(
        BALL, type="label_image", file="labels.png", materials=["red", "blue", "floor"]
    ),
    "a label image on a mesh": textured(
        {"type": "mesh", "file": "sail.obj", "translate": [0.1, 0.9, 0.2]},
        type="label_image",
        file="labels.png",
        materials=["red", "blue", "floor"],
    ),
    "a grey weight image": textured(TILE, type="weight_image", file="labels.png", materials=["red", "chrome"]),
    "a relief": textured(
        BALL, type="banded_relief", levels=[-3000, 0, 900], blend=200, materials=["blue", "floor", "red", "chrome"]
    ),
    "lambert": modelled("lambert"),
    "phong": modelled("phong", exponent=45.5),
    "phong with an exponent of 0": modelled("phong", exponent=0),
    "phong_plain": modelled("phong_plain", exponent=12),
    "blinn_phong": modelled("blinn_phong", exponent=80),
    "mirror": modelled("mirror"),
    "metal": modelled("metal"),
    "a metal with its own edge": modelled("metal_f82"),
    "a rough metal": modelled("rough_metal", exponent=70),
    "metals that mirror each other, and glint": scene(
        BALL | {"material": "own"},
        BALL | {"material": "own", "centre": [1.5, 0.6, 1.1], "radius": 0.6},
        materials={"own": {"model": ["metal_f82", "rough_metal"], "exponent": 30}},
    ),
    "a stack of phong and mirror": modelled(["phong", "mirror"], exponent=20),
    "a stack of two diffuse models": modelled(["lambert", "phong_plain"], exponent=20),
    "a point light": lit(lamp=POINT),
    "a directional light": lit(sun=SUN),
    "a surface that glows, seen in chrome and through glass": scene(
        BALL | {"material": "ember"},
        TILE | {"material": "chrome", "centre": [-1.2, 0.9, -1.1]},
        BALL | {"material": "crystal", "centre": [0.7, 0.9, 2.0], "radius": 0.5},
        materials={"ember": {"model": ["lambert", "emitter"]}, "crystal": {"model": "glass", "index": 1.5}},
        lights={"glow": {"type": "surface", "material": "ember"}},
    ),
    "a texture of two surfaces that glow": textured(BALL, **CHECKER)
    | {"materials": BASE["materials"] | {"red": {"model": "emitter"}, "blue": {"model": ["emitter", "lambert"]}}}
    | {
        "lights": {
            "sun": SUN,
            "one": {"type": "surface", "material": "red"},
            "two": {"type": "surface", "material": "blue"},
            "both": {"type": "surface", "material": "blue"},
        }
    },
    "a lamp that is seen": scene(
        TILE | {"material": "chrome", "centre": [-1.2, 0.9, -1.1]},
        BALL | {"material": "blue"},
        lights={"lamp": LAMP | {"centre": [-1.0, 2.3, 0.2], "visible": True}},
    ),
    "a sky of regions": scene(BALL | {"material": "chrome"}, PIPE | {"material": "blue"})
    | {
        "shapes": [
            BALL | {"material": "chrome"},
            PIPE | {"material": "blue"},
            ROOM | {"centre": [0, -2.9, 0], "size": [4, 5.6, 4], "material": "floor"},
        ],
        "lights": {
            "sun": SUN,
            "sky": {
                "type": "environment",
                "samples": 48,
                "up": [0.1, 1, 0.2],
                "regions": {"zenith": [35, 90], "horizon": [-10, 35], "ground": [-90, -10]},
            },
        },
    },
    "a lamp that is seen from behind": under_a_lamp(BALL, centre=[-0.9, 1.3, 2.2], visible=True),
    "an ambient light": lit(sky={"type": "ambient"}),
    "all kinds of light": lit(sky={"type": "ambient"}, sun=SUN, lamp=POINT),
    "a light that nothing blocks": lit(sun=SUN | {"shadows": False}, lamp=POINT),
    "a light below the floor": lit(lamp={"type": "point", "position": [0, -2, 0]}, sun=SUN),
    "a light inside a sphere": scene(BALL, lights={"lamp": {"type": "point", "position": [0.1, 0.9, 0.2]}}),
    "a lamp with an area": under_a_lamp(BALL, PIPE | {"base": [1.2, 0, 1.1], "top": [1.3, 1.5, 1.2], "radius": 0.2}),
    "a lamp of a fine grid": under_a_lamp(CRATE, grid=4, refinement=2),
    "a lamp of a coarse grid": under_a_lamp(TILE, grid=2, refinement=0),
    "a lamp that nothing blocks": under_a_lamp(BALL, shadows=False),
    "a lamp over a smooth mesh": under_a_lamp({"type": "mesh", "file": "egg.obj", "translate": [0.1, 0.9, 0.2]}),
    "a lamp that the horizon cuts": under_a_lamp(
        BALL, centre=[-2.1, 0.1, 2.2], edge_v=[0, 1.5, 0], edge_u=[-0.7, 0, -0.8]
    ),
    "an orthographic camera": scene(BALL)
    | {"camera": {"type": "orthographic", "view_width": 4.3, "position": [1, 2, 6], "target": [0, 0.7, 0]}},
    "a camera on its side": scene(BALL, PIPE, camera={"up": [1, 0.3, 0.2], "field_of_view": 71}),
    "3 by 3 samples": scene(BALL, PIPE, camera={"samples": 3}),
    "shadows through several shapes": scene(
        BALL,
        {"type": "disk", "centre": [-1.1, 2.0, 0.9], "normal": [0.3, 1, 0.1], "radius": 0.4, "material": "blue"},
        {"type": "cylinder", "base": [0.8, 0, 1.2], "top": [1.2, 1.7, 1.0], "radius": 0.2, "material": "blue"},
        {"type": "mesh", "file": "egg.obj", "material": "red", "scale": 0.4, "translate": [1.4, 2.2, 1.9]},
        TILE | {"material": "blue", "centre": [-1.3, 0.8, -0.9]},
    ),
    "mirrors that face each other": scene(
        TILE | {"material": "chrome", "centre": [0, 0.9, -1.5], "edge_u": [4, 0, 0.2], "edge_v": [0, 1.4, 0]},
        TILE | {"material": "chrome", "centre": [0.3, 0.7, 1.5], "edge_u": [1.3, 0, -0.2], "edge_v": [0, 1, 0]},
        BALL | {"radius": 0.4, "centre": [0, 1.3, 0]},
    ),
    "mirror balls": scene(
        BALL | {"material": "chrome"}, BALL | {"material": "chrome", "centre": [1.5, 0.6, 1.1], "radius": 0.6}, PIPE
    ),
    "a mirror of smooth normals": scene(
        {"type": "mesh", "file": "egg.obj", "material": "chrome", "translate": [0.1, 0.9, 0.2]}, PIPE
    ),
    "a depth of 0": scene(BALL | {"material": "chrome"}, depth=0),
    "a depth of 1": scene(BALL | {"material": "chrome"}, PIPE | {"material": "chrome"}, depth=1),
    "a checker of mirror and paint": textured(BALL, type="checker", size=0.4, materials=["chrome", "blue"]),
    "a checker of two glasses": glazed(type="checker", size=0.3, materials=["crystal", "water"]),
    "glasses, a mirror and paint blended": glazed(
        type="weight_image", file="weights.png", materials=["crystal", "chrome", "water"]
    ),
    "glass and paint blended": glazed(type="weight_image", file="weights.png", materials=["blue", "crystal", "red"]),
}


@pytest.mark.parametrize("name", SMALL)
def test_each_thing_in_a_scene_looks_as_a_scalar_tracer_sees_it(tmp_path, name):
    write_scene(tmp_path, SMALL[name])
    assert disagreement(tmp_path / "scene.toml", "drawn", 24, 17) <= 1e-9


def test_a_light_of_ones_own_looks_as_a_scalar_tracer_sees_it(tmp_path):
    write_scene(tmp_path, scene(BALL))
    path = tmp_path / "scene.toml"

    def narrowed(light):
        def at(point):
            (found,) = light(point)
            return [found._replace(irradiance=found.irradiance * max(0.0, found.direction[1]) ** 8)]

        return at

    plain = reference.load(path)
    plain = plain._replace(lights=plain.lights | {"lamp": narrowed(plain.lights["lamp"])})
    spectra = reference.load_palette(path, "drawn")
    expected = reference.picture(plain, spectra, 24, 17)
    ours = rt.load_scene(path)
    ours = replace(
        ours,
        camera=replace(ours.camera, width=24, height=17),
        lights=[Spotlight(light) if light.name == "lamp" else light for light in ours.lights],
    )
    seen = rt.shade(rt.render(ours, progress=False), rt.load_palettes(path)["drawn"]).values
    np.testing.assert_allclose(seen, expected, rtol=1e-9, atol=0)


class Spotlight:
    """A light of one's own: brightest straight below."""

    def __init__(self, bulb):
        self.bulb, self.name, self.shadows = bulb, bulb.name, True

    def samples(self, points):
        plain = self.bulb.samples(points)[0]
        return (replace(plain, falloff=plain.falloff * np.clip(plain.direction[1], 0, 1) ** 8),)


# --- The files that they need ---------------------------------------------------------------------------------------


def write_scene(folder, whole):
    """A scene file with a palette of four bands in which every symbol is drawn at random, and the files it names."""
    random = np.random.default_rng(20260)
    skies = {name: light.get("regions", {}) for name, light in whole["lights"].items()}
    symbols = [symbol for name, parts in skies.items() for symbol in ([f"{name}_{part}" for part in parts] or [name])]
    for material, table in whole["materials"].items():
        models = table["model"] if isinstance(table["model"], list) else [table["model"]]
        symbols += {f"{material}.{component}": 0 for model in models for component in COMPONENTS[model]}
    palette = {symbol: random.uniform(0.05, 0.95, 4).tolist() for symbol in symbols}
    whole = whole | {"palettes": {"drawn": {"bands": [400, 700, 100]} | palette}}
    whole["camera"] = {"width": 24, "height": 17} | whole["camera"]
    (folder / "scene.toml").write_text(tomli_w.dumps(whole))
    imageio.imwrite(folder / "labels.png", random.integers(0, 3, (5, 7), dtype=np.uint8))
    imageio.imwrite(folder / "weights.png", random.integers(1, 255, (6, 5, 3), dtype=np.uint8))
    (folder / "cube.obj").write_text(CUBE)
    (folder / "cube.mtl").write_text("newmtl walls\nKd 1 1 1\nnewmtl lid\nKd 1 0 0\n")
    (folder / "sail.obj").write_text(SAIL)
    (folder / "egg.obj").write_text(egg(16, 24))
    (folder / "inwards.obj").write_text(egg(16, 24, inwards=True))


CUBE = """# six faces, as quads, of two materials
v -0.6 -0.6 -0.6
v 0.6 -0.6 -0.6
v 0.6 0.6 -0.6
v -0.6 0.6 -0.6
v -0.6 -0.6 0.6
v 0.6 -0.6 0.6
v 0.6 0.6 0.6
v -0.6 0.6 0.6
mtllib cube.mtl
usemtl walls
f 1 4 3 2
f 5 6 7 8
f 1 5 8 4
f 2 3 7 6
f 1 2 6 5
usemtl lid
f 4 8 7 3
"""


SAIL = """# two triangles, with texture coordinates that reach beyond the picture
v -1 -0.8 0
v 1 -0.8 0.2
v 1 0.9 0.1
v -1 0.9 -0.2
vt 0.1 -0.2
vt 1.3 0
vt 1 0.9
vt 0 1.1
f 1/1 2/2 3/3
f -4/-4 -2/-2 -1/-1
"""


def egg(rows, columns, *, inwards=False):
    """An ellipsoid with a normal at each corner; its faces are wound as its normals point, or the other way."""
    lines = []
    for i in range(rows + 1):
        for j in range(columns):
            north, east = math.pi * i / rows, 2 * math.pi * j / columns
            x, y, z = math.sin(north) * math.cos(east), math.cos(north), math.sin(north) * math.sin(east)
            lines += [f"v {0.7 * x!r} {0.9 * y!r} {0.6 * z!r}", f"vn {x / 0.7!r} {y / 0.9!r} {z / 0.6!r}"]
    for i in range(rows):
        for j in range(columns):
            a, b = i * columns + j + 1, i * columns + (j + 1) % columns + 1
            c, d = a + columns, b + columns
            for face in ([(a, b, d)] if i < rows - 1 else []) + ([(a, d, c)] if i > 0 else []):
                lines.append("f " + " ".join(f"{k}//{k}" for k in (face[::-1] if inwards else face)))
    return "\n".join(lines) + "\n"


def test_fluorescent_paint_behind_tinted_glass_that_bends_wavelengths_apart(tmp_path):
    # All three in one column: light meets the paint, goes through glass that takes of it, and each window its own way.
    ball = {"type": "sphere", "centre": [0.1, 0.9, 2.2], "radius": 0.8, "material": "wine"}
    materials = {"red": {"model": ["lambert", "fluorescent"]}, "floor": {"model": "lambert"}}
    file = scene(BALL, ball, materials=materials | {"wine": {"model": ["glass", "absorption"], "glass": "N-SF6"}})
    bell = {"peak": 420, "width": 90}
    file |= {"windows": 3, "depth": 3, "camera": file["camera"] | {"width": 12, "height": 12}}
    file["palettes"] = {
        "nm": {
            "bands": [380, 730, 50],
            "sun": 2.0,
            "lamp": bell | {"scale": 30},
            "floor.diffuse": 0.4,
            "red.diffuse": [0.1, 0.1, 0.1, 0.2, 0.5, 0.6, 0.6, 0.6],
            "red.fluorescence": {"excitation": bell, "emission": bell | {"peak": 600}, "efficiency": 0.5},
            "wine.transmittance": [0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9],
        }
    }
    path = tmp_path / "three.toml"
    path.write_text(tomli_w.dumps(file))
    system = rt.render(rt.load_scene(path), error=1e-13, lengths="chebyshev", progress=False)
    assert any(i.window and i.powers and "red.fluorescence" in i.met for i in system.interactions)
    palette = rt.load_palettes(path)["nm"]
    seen = rt.shade(system, palette).values
    np.testing.assert_allclose(seen, reference.render(path, "nm", 12, 12), rtol=1e-9, atol=1e-14)

    # Formulas say the same, in letters and with numbers, and name the paint before the glass that it is seen through.
    nm, tree = np.array(palette.bands.centres), rt.trace(rt.load_scene(path))
    x, y = next((x, y) for y in range(12) for x in range(12) if _met(system, x, y))
    for formula in (rt.formula(system, x, y), rt.formula(tree, x, y)):
        values = formula.evaluate({name: palette[name] for name in formula.symbols}, nm=nm)
        np.testing.assert_allclose(values, seen[y, x], rtol=1e-9)
    assert "red.fluorescence*wine.transmittance**" in rt.formula(system, x, y).text()


def _met(system, x, y):
    """The columns of a pixel that have all three, if there are any."""
    found = [i for i, _ in system.terms(12 * y + x)]
    return [i for i in found if i.window and i.powers and "red.fluorescence" in i.met]
