"""Scene files: what is right becomes records, what is wrong ends in one line that says file, key, rule and remedy."""

import copy
import datetime as dt
import functools
import os
import re
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest
import sympy
import tomli_w
from scenes_for_tests import every_scene

from symrt.errors import SceneError
from symrt.geometry import BandedRelief, Checker, Mesh, Sphere
from symrt.scene import load_scene, shipped_scene
from symrt.scene.lights import AmbientLight, DirectionalLight, PointLight

CAMERA = """
[camera]
position = [0, 3, 8]
target = [0, 1, 0]
width = 16
height = 12
"""
SHAPE = """
[[shapes]]
type = "sphere"
centre = [0, 1, 0]
radius = 1
material = "red"
"""
RED = "[materials.red]\n"
SUN = """
[lights.sun]
type = "directional"
direction = [1, -1, 0]
"""
GOOD = CAMERA + SHAPE + RED + SUN


def faults_of(folder, text):
    """The lines of the error, without the file's name, which each must begin with."""
    path = folder / "scene.toml"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(SceneError) as caught:
        load_scene(path)
    assert all(line.startswith(f"{path}: ") for line in caught.value.faults)
    return [line.removeprefix(f"{path}: ") for line in caught.value.faults]


def test_a_file_becomes_the_records_that_python_would_make(tmp_path):
    (tmp_path / "ring.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    (tmp_path / "scene.toml").write_text(
        "depth = 2\n"
        + GOOD
        + """
        [[shapes]]
        type = "mesh"
        file = "ring.obj"
        material = { Brass = "brass" }
        rotate = [0, 0, -23.4]
        [[shapes]]
        type = "plane"
        point = [0, 0, 0]
        normal = [0, 1, 0]
        material = "tiles"
        [materials.brass]
        model = ["phong_plain", "mirror"]
        exponent = 60
        [textures.tiles]
        type = "checker"
        materials = ["red", "brass"]
        size = 0.5
        [textures.earth]
        type = "banded_relief"
        levels = [-200, 0, 500]
        materials = ["red", "brass", "red", "brass"]
        blend = 50
        [lights.lamp]
        type = "point"
        position = [1, 5, 2]
        shadows = false
        [lights.sky]
        type = "ambient"
        [palettes.any]
        bands = "this reader does not look here"
        nonsense = { nan = nan, sun = 1e999 }
        """
    )
    scene = load_scene(tmp_path / "scene.toml")
    assert scene.depth == 2
    assert scene.folder == tmp_path
    assert scene.shapes[0] == Sphere(centre=(0, 1, 0), radius=1, material="red")
    assert scene.shapes[1] == Mesh(file="ring.obj", material={"Brass": "brass"}, rotate=(0, 0, -23.4))
    assert scene.lights == (
        DirectionalLight("sun", direction=(1, -1, 0)),
        PointLight("lamp", position=(1, 5, 2), shadows=False),
        AmbientLight("sky"),
    )
    assert scene.textures == (
        Checker(name="tiles", materials=("red", "brass"), size=0.5),
        BandedRelief(name="earth", levels=(-200, 0, 500), materials=("red", "brass", "red", "brass"), blend=50),
    )
    assert scene.material("red").model == "lambert"
    assert (scene.material("brass").model, scene.material("brass").parameters) == (
        ("phong_plain", "mirror"),
        {"exponent": 60.0},
    )
    assert scene.used_textures == {"tiles"}
    assert scene.used_materials == {"red", "brass"}
    assert (scene.camera.field_of_view, scene.camera.samples, scene.camera.type) == (40.0, 1, "perspective")


@pytest.mark.parametrize("name", every_scene())
def test_every_shipped_scene_loads_by_its_bare_name_from_anywhere(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert load_scene(name) == load_scene(shipped_scene(name))
    assert shipped_scene(name).is_file()


def test_a_file_of_the_same_name_comes_before_a_shipped_scene(tmp_path, monkeypatch):
    (tmp_path / "first").write_text(GOOD)
    monkeypatch.chdir(tmp_path)
    assert load_scene("first").camera.width == 16


WRONG = {
    "an unknown key of a shape": (
        GOOD.replace("radius", "raduis"),
        ["shapes[0].raduis: there is no such key; did you mean 'radius'?"],
    ),
    "an unknown key of the camera": (
        GOOD.replace("width", "widht"),
        ["camera.widht: there is no such key; did you mean 'width'?"],
    ),
    "an unknown table": ("[light]\nx = 1\n" + GOOD, ["light: there is no such key; did you mean 'lights'?"]),
    "an unknown key of a light": (
        GOOD + "shadow = true\n",
        ["lights.sun.shadow: there is no such key; did you mean 'shadows'?"],
    ),
    "an unknown parameter": (
        GOOD.replace(RED, RED + "model = 'phong'\nexponent = 40\nexponnet = 40\n"),
        ["materials.red.exponnet: the model phong has no such parameter; did you mean 'exponent'?"],
    ),
    "an unknown type": (
        GOOD.replace('"sphere"', '"spere"'),
        ["shapes[0].type = 'spere': there is no such type; did you mean 'sphere'?"],
    ),
    "a type that is missing": (
        GOOD.replace('type = "directional"', ""),
        [
            "lights.sun.type: missing; there are 'point', 'directional', 'ambient', 'rectangle', 'disk', 'sphere', "
            "'surface', 'environment'"
        ],
    ),
    "an unknown model": (
        GOOD.replace(RED, RED + "model = 'fong'\n"),
        ["materials.red.model = 'fong': no model has this name; did you mean 'phong'?"],
    ),
    "no model at all": (
        GOOD.replace(RED, RED + "model = []\n"),
        ["materials.red.model = []: a material needs at least one model; write model = 'lambert'"],
    ),
    "a model that is a number": (
        GOOD.replace(RED, RED + "model = 7\n"),
        ["materials.red.model = 7: a model is a name, a list of names, or an rt.Model; try 'lambert'"],
    ),
    "a parameter that is missing": (
        GOOD.replace(RED, RED + "model = 'phong'\n"),
        ["materials.red.exponent: the model phong needs it; write exponent = 40, say"],
    ),
    "an exponent that is negative": (
        GOOD.replace(RED, RED + "model = 'phong'\nexponent = -1\n"),
        ["materials.red.exponent = -1: it must be from 0 to 1e7; 40 is glossy"],
    ),
    "a material of no shape's": (
        GOOD.replace('material = "red"', 'material = "rad"'),
        ["shapes[0].material = 'rad': no material or texture has this name; did you mean 'red'?"],
    ),
    "a texture of materials that are not there": (
        GOOD + "[textures.tiles]\ntype = 'checker'\nsize = 1\nmaterials = ['red', 'blue']\n",
        ["textures.tiles.materials[1] = 'blue': no material has this name; there are 'red'"],
    ),
    "a name that two kinds share": (
        GOOD + "[materials.sun]\n",
        [
            "materials: the name 'sun' is already used in lights; lights, materials and textures share names, "
            "so rename one"
        ],
    ),
    "a table twice": (
        GOOD + RED,
        ["not TOML: Cannot declare ('materials', 'red') twice (at line 18, column 15); correct that line"],
    ),
    "no lights": (
        CAMERA + SHAPE + RED,
        ["lights: there is none, so the picture would be black; add one, such as [lights.sun]"],
    ),
    "an image of no size": (
        GOOD.replace("width = 16", "width = 0"),
        ["camera.width = 0: it must be a whole number from 1 to 32768"],
    ),
    "a field of view of 0": (
        GOOD.replace("width", "field_of_view = 0\nwidth"),
        ["camera.field_of_view = 0: it must be more than 0 and less than 180 degrees; 40 is usual"],
    ),
    "a field of view of 180": (
        GOOD.replace("width", "field_of_view = 180\nwidth"),
        ["camera.field_of_view = 180: it must be more than 0 and less than 180 degrees; 40 is usual"],
    ),
    "a camera of no known kind": (
        GOOD.replace("[camera]", "[camera]\ntype = 'fisheye'"),
        ["camera.type = 'fisheye': it must be 'perspective' or 'orthographic'"],
    ),
    "a box with a face that there is not": (
        GOOD
        + '[[shapes]]\ntype = "box"\ncentre = [0, 1, 0]\nsize = [1, 1, 2]\nmaterial = { lft = "red", top = "red" }\n',
        [
            "shapes[1].material = {'lft': 'red', 'top': 'red'}: there is no face 'lft'; "
            "name left, right, bottom, top, back, front, or others for the rest"
        ],
    ),
    "a box without thickness": (
        GOOD + '[[shapes]]\ntype = "box"\ncentre = [0, 1, 0]\nsize = [1, 0, 2]\nmaterial = { lft = "red" }\n',
        ["shapes[1].size[1] = 0: it must be greater than 0"],
    ),
    "nan": (
        GOOD.replace("radius = 1", "radius = nan"),
        ["shapes[0].radius = nan: numbers must be finite and within ±1.8e308; write an ordinary one, such as 1.5"],
    ),
    "infinity": (
        GOOD.replace("[0, 1, 0]\nradius", "[0, -inf, 0]\nradius"),
        ["shapes[0].centre[1] = -inf: numbers must be finite and within ±1.8e308; write an ordinary one, such as 1.5"],
    ),
    "1e999": (
        GOOD.replace("[1, -1, 0]", "[1, 1e999, 0]"),
        [
            "lights.sun.direction[1] = inf: numbers must be finite and within ±1.8e308; write an ordinary one, such as "
            "1.5"
        ],
    ),
    "text for a number": (
        GOOD.replace("radius = 1", 'radius = "1"'),
        ["shapes[0].radius = '1': it must be a number; write it without quotes, such as 1.5"],
    ),
    "text for a parameter": (
        GOOD.replace(RED, RED + "model = 'phong'\nexponent = '40'\n"),
        ["materials.red.exponent = '40': it must be a number; write it without quotes, such as 1.5"],
    ),
    "text for a whole number": (
        GOOD.replace("width = 16", "width = '16'"),
        ["camera.width = '16': it must be a whole number; write it without quotes or decimals, such as 256"],
    ),
    "a fraction for a whole number": (
        GOOD.replace("width = 16", "width = 16.5"),
        ["camera.width = 16.5: it must be a whole number; write it without quotes or decimals, such as 256"],
    ),
    "truth for a number": (
        GOOD.replace("radius = 1", "radius = true"),
        ["shapes[0].radius = True: it must be a number; write it without quotes, such as 1.5"],
    ),
    "two numbers for three": (
        GOOD.replace("[0, 1, 0]\nradius", "[0, 1]\nradius"),
        ["shapes[0].centre[2]: it is missing; a point or direction is three numbers, such as [0, 1, 0]"],
    ),
    "four numbers for three": (
        GOOD.replace("[0, 1, 0]\nradius", "[0, 1, 0, 5]\nradius"),
        ["shapes[0].centre = [0, 1, 0, 5]: it has too many numbers; a point or direction is three, such as [0, 1, 0]"],
    ),
    "a negative radius": (
        GOOD.replace("radius = 1", "radius = -1"),
        ["shapes[0].radius = -1: it must be greater than 0"],
    ),
    "a whole number of 30 digits": (
        GOOD.replace("width = 16", "width = 1" + 29 * "0"),
        [f"camera.width = 1{29 * '0'}: whole numbers have at most 18 digits; write it as 1.5e20"],
    ),
    "a whole number of 5,000 digits": (
        GOOD.replace("width = 16", "width = " + 5000 * "1"),
        ["line 5: a number with thousands of digits; write it as 1.5e3"],
    ),
    "a date": (
        GOOD.replace("radius = 1", "radius = 2004-05-27"),
        ["shapes[0].radius = 2004-05-27: a scene has no dates or times; write a number, or text in quotes"],
    ),
    "arrays 100,000 deep": (
        "x = " + 100_000 * "[" + "\n" + GOOD,
        ["nested too deeply; a scene has at most 8 levels"],
    ),
    "tables 100,000 deep": (
        "x = " + 100_000 * "{a = " + "\n" + GOOD,
        ["nested too deeply; a scene has at most 8 levels"],
    ),
    "a key 100,000 deep": (
        GOOD + 100_000 * "a." + "a = 1\n",
        ["line 18: nested too deeply; a scene has at most 8 levels"],
    ),
    "a key 20 deep": (
        20 * "a." + "a = 1\n" + GOOD,
        ["a.a.a.a.a.a.a.a.a: nested too deeply; a scene has at most 8 levels"],
    ),
    "bytes that are not text": (b"\xff\xfe" + GOOD.encode(), ["byte 0 is not UTF-8; save the file as UTF-8 text"]),
    "not TOML": (
        "camera: position\n",
        ["not TOML: Expected '=' after a key in a key/value pair (at line 1, column 7); correct that line"],
    ),
    "a number where tables belong": (
        CAMERA.replace("[camera]", "shapes = 3\n[camera]") + RED + SUN,
        ["shapes = 3: it must be a list in brackets, such as [0, 1, 0]"],
    ),
    "a number for a material": (
        "[materials]\nred = 3\n" + CAMERA + SHAPE + SUN,
        ["materials.red: it must be a table; write [materials.red] and its keys below it"],
    ),
    "a depth beyond reason": (
        "depth = 100000\n" + GOOD,
        ["depth = 100000: it must be a whole number from 0 to 1000"],
    ),
    "a light at the white": (
        GOOD + "[lights.lamp]\ntype = 'point'\nposition = [0, 1, 0]\n",
        [
            "lights.lamp.position: it stands at the camera's target, where the white that reflectances are measured "
            "against is looked for; move the light or the target"
        ],
    ),
    "relief that does not add up": (
        GOOD + "[textures.t]\ntype = 'banded_relief'\nlevels = [0, 1]\nmaterials = ['red', 'red']\nblend = 0\n",
        ["textures.t.levels = (0, 1), blend = 0, 2 materials: there must be one material more than levels"],
    ),
    "an empty file": (
        "",
        [
            "camera: missing; add it",
            "shapes: missing; add it",
            "materials: missing; add it",
            "lights: there is none, so the picture would be black; add one, such as [lights.sun]",
        ],
    ),
}


@pytest.mark.parametrize(("text", "lines"), WRONG.values(), ids=WRONG)
def test_a_wrong_file_ends_in_lines_that_say_key_rule_and_remedy(text, lines, tmp_path):
    assert faults_of(tmp_path, text) == lines


def test_all_faults_of_a_file_are_told_at_once(tmp_path):
    text = (
        GOOD.replace("width = 16", "width = 0")
        .replace("radius = 1", "radius = inf")
        .replace('material = "red"', 'material = "rad"')
        .replace(RED, RED + "model = 'phong'\n")
        .replace("[1, -1, 0]", "[0, 0, 0]")
    )
    assert [line.split(" = ")[0].split(": ")[0] for line in faults_of(tmp_path, text)] == [
        "shapes[0].radius",
        "camera.width",
        "materials.red.exponent",
        "lights.sun.direction",
        "shapes[0].material",
    ]


NAMES = [
    "deep sea",
    "it's",
    'say "sea"',
    "{sea}",
    "back\\slash",
    "__import__",
    "__import__('os')",
    "",
    "7up",
    "µ",
    "a.b",
    "new\nline",
    "x" * 65,
]


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("kind", ["lights", "materials", "textures"])
def test_names_that_formulas_cannot_use_are_refused(name, kind, tmp_path):
    escaped = name.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n")
    tables = {
        "lights": "type = 'ambient'",
        "materials": "model = 'lambert'",
        "textures": "type = 'checker'\nsize = 1\nmaterials = ['red', 'red']",
    }
    lines = faults_of(tmp_path, f'{GOOD}\n[{kind}."{escaped}"]\n{tables[kind]}\n')
    assert [line.split(" = ")[0] for line in lines] == [f"{kind}: name"]
    assert "a name is a letter, then letters, digits or underscores" in lines[0]


MESH = GOOD + "[[shapes]]\ntype = 'mesh'\nmaterial = 'red'\nfile = {file!r}\n"
LABELS = GOOD + "[textures.map]\ntype = 'label_image'\nmaterials = ['red']\nfile = {file!r}\n"


@pytest.mark.parametrize(
    ("text", "key"), [(MESH, "shapes[1].file"), (LABELS, "textures.map.file")], ids=["mesh", "map"]
)
@pytest.mark.parametrize(
    ("file", "rule"),
    [
        ("/etc/passwd", "is an absolute path: give one relative to the scene's folder"),
        ("C:\\data\\ring.obj", "is an absolute path"),
        ("\\\\server\\share\\ring.obj", "is an absolute path"),
        ("../outside.obj", "leaves the scene's folder: give a path inside it, without '..'"),
        ("sub/../../outside.obj", "leaves the scene's folder"),
        ("sub\\..\\..\\outside.obj", "leaves the scene's folder"),
        ("missing.obj", "does not exist in the scene's folder: correct the name or add the file"),
        ("sub", "does not exist in the scene's folder"),
        ("link.obj", "is a link out of the scene's folder: copy the file into it"),
        ("linked/outside.obj", "is a link out of the scene's folder"),
        ("circle.obj", ""),
        ("", "is not a file name"),
        ("x" * 5000, "cannot be read"),
    ],
)
def test_files_outside_the_scenes_folder_are_refused(text, key, file, rule, tmp_path):
    folder = tmp_path / "scenes"
    (folder / "sub").mkdir(parents=True)
    (tmp_path / "outside.obj").write_text("v 0 0 0\n")
    (folder / "link.obj").symlink_to(tmp_path / "outside.obj")
    (folder / "linked").symlink_to(tmp_path)
    (folder / "circle.obj").symlink_to(folder / "circle.obj")
    (line,) = faults_of(folder, text.format(file=file))
    assert line.startswith(f"{key}: ")
    assert rule in line


def test_a_link_that_stays_inside_the_folder_is_followed(tmp_path):
    (tmp_path / "ring.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    (tmp_path / "link.obj").symlink_to(tmp_path / "ring.obj")
    (tmp_path / "scene.toml").write_text(MESH.format(file="link.obj"))
    assert load_scene(tmp_path / "scene.toml").shapes[1].file == "link.obj"


def test_a_scene_that_cannot_be_read_says_why(tmp_path):
    with pytest.raises(SceneError, match=r"nowhere\.toml: no such file; give the path of a scene"):
        load_scene(tmp_path / "nowhere.toml")
    with pytest.raises(SceneError, match="cannot be read: Is a directory"):
        load_scene(tmp_path)
    with pytest.raises(SceneError, match=r"'glob': no scene of this name comes with symrt; did you mean 'globe'\?"):
        load_scene("glob")
    huge = tmp_path / "huge.toml"
    with huge.open("wb") as file:
        file.truncate(17 << 20)
    with pytest.raises(SceneError, match="a scene file has at most 16 MiB"):
        load_scene(huge)


EVERYTHING = """
[camera]
type = "perspective"
position = [0, 3, 8]
target = [0, 1, 0]
up = [0, 1, 0]
field_of_view = 30
width = 16
height = 12
samples = 2
[[shapes]]
type = "sphere"
centre = [0, 1, 0]
radius = 1
material = "earth"
pole = [0, 1, 0]
meridian = [0, 0, 1]
[[shapes]]
type = "plane"
point = [0, 0, 0]
normal = [0, 1, 0]
material = "tiles"
[[shapes]]
type = "disk"
centre = [0, 0, 0]
normal = [0, 1, 0]
radius = 1
material = "red"
[[shapes]]
type = "rectangle"
centre = [0, 0, 0]
edge_u = [1, 0, 0]
edge_v = [0, 1, 0]
material = "red"
[[shapes]]
type = "cylinder"
base = [0, 0, 0]
top = [0, 1, 0]
radius = 0.5
material = "red"
capped = false
[[shapes]]
type = "box"
centre = [0, 0, 0]
size = [9, 8, 7]
rotate = [0, 45, 0]
material = { left = "red", others = "red" }
[[shapes]]
type = "mesh"
file = "ring.obj"
material = { Brass = "red" }
scale = 2
rotate = [0, 0, 23.4]
translate = [1, 0, 0]
[materials.red]
model = ["phong", "mirror"]
exponent = 40
[lights.sun]
type = "directional"
direction = [1, -1, 0]
shadows = false
[lights.lamp]
type = "point"
position = [1, 4, 0]
[lights.sky]
type = "ambient"
[textures.tiles]
type = "checker"
materials = ["red", "red"]
size = 1
[textures.labels]
type = "label_image"
file = "ring.obj"
materials = ["red"]
[textures.shares]
type = "weight_image"
file = "ring.obj"
materials = ["red"]
[textures.earth]
type = "banded_relief"
relief = "etopo5"
levels = [0, 500]
materials = ["red", "red", "red"]
blend = 20
"""
ODD = [
    float("nan"),
    -float("inf"),
    1e308,
    -1,
    0,
    2**62,
    10**30,
    True,
    "",
    "red",
    "\ud7ff\n{}",
    [],
    {},
    [[]],
    [1, 2, 3],
    [1e308] * 3,
    [0, 0, 0],
    ["a"],
    {"a": 1},
    {"type": "sphere"},
    [{"type": "sphere"}],
    dt.date(2004, 5, 27),
]


def parts(value, way=()):
    """The way to each part of a file, tables and lists included."""
    yield way
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, inner in items:
        yield from parts(inner, (*way, key))


@pytest.mark.parametrize("draws", [1, pytest.param(len(ODD), marks=pytest.mark.exhaustive)])
def test_whatever_stands_anywhere_in_a_file_it_is_a_scene_or_a_scene_error(draws, tmp_path):
    """Each part of a file that has everything is replaced by some of many oddities, then removed."""
    (tmp_path / "ring.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    path = tmp_path / "scene.toml"
    path.write_text(EVERYTHING)
    load_scene(path)
    told = []
    whole, random = tomllib.loads(EVERYTHING), np.random.default_rng(20)
    for *way, last in filter(None, parts(whole)):
        for odd in [ODD[i] for i in random.permutation(len(ODD))[:draws]] + [None]:
            tables = copy.deepcopy(whole)
            place = functools.reduce(lambda table, key: table[key], way, tables)
            if odd is None:
                del place[last]
            else:
                place[last] = odd
            path.write_text(tomli_w.dumps(tables), encoding="utf-8")
            told += outcome(path)
    assert len(told) > 150 * draws
    line = re.compile(rf"{re.escape(str(path))}: \S.*( = |: ).*[;:,] .+")
    assert [wrong for wrong in told if not line.fullmatch(wrong)] == []


def outcome(path):
    """The faults of a file; none if it is a scene."""
    try:
        load_scene(path)
    except SceneError as error:
        return error.faults
    return ()


CANARY = "__import__('symrt_canary').sing()"


def test_no_name_or_text_of_a_file_reaches_an_evaluator(tmp_path, monkeypatch):
    """A canary in every field that takes text: whoever evaluates it imports a module."""
    (tmp_path / "symrt_canary.py").write_text("def sing(): ...")
    monkeypatch.syspath_prepend(tmp_path)
    fields = {
        "camera.type": GOOD.replace("[camera]", f'[camera]\ntype = "{CANARY}"'),
        "camera.width": GOOD.replace("width = 16", f'width = "{CANARY}"'),
        "camera.position": GOOD.replace("[0, 3, 8]", f'["{CANARY}", 3, 8]'),
        "a key": GOOD.replace("radius = 1", f'radius = 1\n"{CANARY}" = 1'),
        "a table": GOOD + f'["{CANARY}"]\n',
        "shape.type": GOOD.replace('"sphere"', f'"{CANARY}"'),
        "shape.radius": GOOD.replace("radius = 1", f'radius = "{CANARY}"'),
        "shape.material": GOOD.replace('material = "red"', f'material = "{CANARY}"'),
        "shape.materials": GOOD.replace('material = "red"', f'material = {{ "{CANARY}" = "{CANARY}" }}'),
        "mesh.file": MESH.format(file="FILE").replace("'FILE'", f'"{CANARY}"'),
        "mesh.material": MESH.format(file="a.obj").replace(
            "material = 'red'", f'material = {{"{CANARY}" = "{CANARY}"}}'
        ),
        "material name": GOOD + f'[materials."{CANARY}"]\n',
        "material.model": GOOD.replace(RED, RED + f'model = "{CANARY}"\n'),
        "material.models": GOOD.replace(RED, RED + f'model = ["lambert", "{CANARY}"]\n'),
        "material.parameter": GOOD.replace(RED, RED + f'"{CANARY}" = 1\n'),
        "material.exponent": GOOD.replace(RED, RED + f'model = "phong"\nexponent = "{CANARY}"\n'),
        "light name": GOOD + f'[lights."{CANARY}"]\ntype = "ambient"\n',
        "light.type": GOOD.replace('"directional"', f'"{CANARY}"'),
        "light.direction": GOOD.replace("[1, -1, 0]", f'"{CANARY}"'),
        "texture name": GOOD + f'[textures."{CANARY}"]\ntype = "checker"\nsize = 1\nmaterials = ["red", "red"]\n',
        "texture.materials": GOOD + f'[textures.t]\ntype = "checker"\nsize = 1\nmaterials = ["red", "{CANARY}"]\n',
        "texture.relief": GOOD + f'[textures.t]\ntype = "banded_relief"\nrelief = "{CANARY}"\n',
        "texture.file": LABELS.format(file="FILE").replace("'FILE'", f'"{CANARY}"'),
        "depth": f'depth = "{CANARY}"\n' + GOOD,
    }
    for field, text in fields.items():
        assert faults_of(tmp_path, text), field
        assert "symrt_canary" not in sys.modules, field
    # The trap works: whoever evaluates the text of a field is caught.
    sympy.sympify(CANARY)
    assert "symrt_canary" in sys.modules
    monkeypatch.delitem(sys.modules, "symrt_canary")


def test_a_palette_is_not_this_readers_business(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text(GOOD + f'[palettes."{CANARY}"]\nbands = nan\n"a.b.c" = "{CANARY}"\n')
    assert load_scene(path).symbols == ("sun", "red.diffuse")


def test_reading_a_scene_opens_nothing_but_files_of_its_folder(tmp_path, monkeypatch):
    path = tmp_path / "scene.toml"
    path.write_text(GOOD)
    load_scene(path)
    opened = []
    original = os.open
    monkeypatch.setattr(os, "open", lambda name, *rest, **more: (opened.append(name), original(name, *rest, **more))[1])
    load_scene(path)
    assert all(Path(name).is_relative_to(tmp_path) for name in opened)
