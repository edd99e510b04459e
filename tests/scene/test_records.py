"""Laws of the records: Python's scenes are checked as files are, and a scene that exists can be traced."""

import pickle
import re
import subprocess
import sys
from dataclasses import FrozenInstanceError, dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from sympy import pi

import symrt as rt
import symrt.reflection.models as reflection
from symrt.geometry import Box, Checker, Mesh, Plane, Rectangle, Sphere, TriangleMesh
from symrt.reflection.symbols import diffuse, lobe, n_dot_l, parameter, r_dot_v, specular
from symrt.scene import AmbientLight, Camera, DirectionalLight, Material, PointLight, Scene, load_scene

CAMERA = Camera(position=(0, 3, 8), target=(0, 0.8, 0), up=(0, 1, 0), field_of_view=40, width=256, height=256)
SUN = DirectionalLight("sun", direction=(1, -1, 0))


def scene(**change):
    parts = {
        "camera": CAMERA,
        "shapes": [Sphere(centre=(0, 1, 0), radius=1, material="red")],
        "materials": [Material("red", model="phong", exponent=40)],
        "lights": [SUN],
    }
    return Scene(**(parts | change))


def test_a_scene_in_python_reads_as_the_design_writes_it():
    made = scene(
        shapes=[
            Sphere(centre=(0, 1, 0), radius=1, material="red"),
            Rectangle(centre=(0, 0, 0), edge_u=(20, 0, 0), edge_v=(0, 0, -20), material="red"),
        ],
        lights=[PointLight("warm", position=(3, 4, 5)), DirectionalLight("sun", direction=(1, -1, 0))],
    )
    assert made.symbols == ("warm", "sun", "red.diffuse", "red.specular")
    assert made.depth == 4
    assert made.folder == Path()


def test_records_of_whole_numbers_hold_floats():
    assert CAMERA.position == (0.0, 3.0, 8.0)
    assert all(isinstance(value, float) for value in (*CAMERA.position, CAMERA.field_of_view, *SUN.direction))
    assert isinstance(Material("red", model="phong", exponent=40).parameters["exponent"], float)


def test_a_scene_travels_to_worker_processes_and_back():
    made = scene(textures=[Checker("tiles", ("red", "red"), 1)])
    assert pickle.loads(pickle.dumps(made)) == made


def test_records_are_frozen():
    for record, key in ((CAMERA, "width"), (scene(), "depth"), (scene().materials[0], "name")):
        with pytest.raises(FrozenInstanceError):
            setattr(record, key, 1)


def test_stacked_models_add_their_formulas_and_share_their_components():
    material = Material("brass", model=["phong_plain", "mirror"], exponent=60)
    assert material.reflection.formulas == {
        **reflection.MODELS["phong_plain"].formulas,
        "reflected": reflection.MODELS["mirror"].reflected,
    }
    assert material.symbols == ("brass.diffuse", "brass.mirror", "brass.specular")


def test_a_model_of_ones_own_brings_its_own_parameters():
    shiny = reflection.Model(direct=diffuse * n_dot_l / pi + specular * lobe(r_dot_v, parameter("gloss")) / pi)
    material = Material("lacquer", model=shiny, gloss=12)
    assert material.reflection is shiny
    assert material.parameters == {"gloss": 12.0}
    assert pickle.loads(pickle.dumps(material)) == material
    with pytest.raises(ValueError, match=r"^gloss: the model of one's own needs it; write gloss = 40, say$"):
        Material("lacquer", model=shiny)


@dataclass(frozen=True)
class OwnLight:
    name: str
    shadows: bool = True

    def samples(self, points):
        return SUN.samples(points)


def test_a_light_of_ones_own_may_stand_in_a_scene():
    assert scene(lights=[OwnLight("candle")]).symbols[0] == "candle"


TRIANGLE = TriangleMesh(np.eye(3), np.array([[0], [1], [2]]), materials=("red",))


def test_a_mesh_made_in_python_may_stand_in_a_scene():
    assert scene(shapes=[TRIANGLE]).used_materials == {"red"}


def test_a_scene_knows_what_its_shapes_use():
    made = scene(
        shapes=[Plane((0, 0, 0), (0, 1, 0), "tiles"), Sphere((0, 1, 0), 1, "blue")],
        materials=[Material(name) for name in ("red", "blue", "grey", "gold")],
        textures=[Checker("tiles", ("red", "grey"), 1), Checker("spare", ("gold", "gold"), 1)],
    )
    assert made.used_textures == {"tiles"}
    assert made.used_materials == {"red", "blue", "grey"}


@pytest.mark.parametrize(
    ("change", "line"),
    [
        ({"lights": []}, r"^lights: there is none, so the picture would be black"),
        ({"lights": [SUN, AmbientLight("sun")]}, r"^lights: the name 'sun' is already used in lights"),
        ({"lights": [AmbientLight("red")]}, r"^materials: the name 'red' is already used in lights"),
        ({"materials": [Material("rad")]}, r"^shapes\[0\].material = 'red': no material or .* did you mean 'rad'\?"),
        (
            {"textures": [Checker("t", ("red", "blue"), 1)]},
            r"^textures.t.materials\[1\] = 'blue': no material has this",
        ),
        ({"shapes": [replace(TRIANGLE, materials=("blue",))]}, r"^shapes\[0\].material\[0\] = 'blue': no material"),
        ({"shapes": [Mesh("a.obj", {"Brass": "brass"})]}, r"shapes\[0\].material.Brass = 'brass': no material"),
        ({"shapes": [Mesh("a.obj", "red")]}, r"^shapes\[0\].file: 'a.obj' does not exist in the scene's folder"),
        ({"shapes": [Mesh("/a.obj", "red")]}, r"^shapes\[0\].file: '/a.obj' is an absolute path"),
        ({"shapes": [Box((0, 0, 0), (1, 1, 1), {"others": "blue"})]}, r"^shapes\[0\].material.others = 'blue': no "),
        ({"lights": [PointLight("a", position=(0, 0.8, 0))]}, r"^lights.a.position: it stands at the camera's target"),
        ({"depth": -1}, r"^depth = -1: it must be a whole number from 0 to 1000"),
        ({"shapes": [SUN]}, r"^shapes\[0\] = DirectionalLight.*: this is not one of the shapes; move it"),
    ],
)
def test_a_scene_that_does_not_hold_together_says_why(change, line):
    with pytest.raises(ValueError, match=line):
        scene(**change)


def test_all_faults_of_a_scene_are_told_at_once():
    with pytest.raises(ValueError, match="lights") as caught:
        scene(lights=[], depth=-1, materials=[], textures=[Checker("t", ("a", "b"), 1)])
    assert [line.split(" = ")[0].split(":")[0] for line in str(caught.value).splitlines()] == [
        "lights",
        "depth",
        "textures.t.materials[0]",
        "textures.t.materials[1]",
        "shapes[0].material",
    ]


@pytest.mark.parametrize(
    ("make", "line"),
    [
        (lambda: Material("deep sea"), r"^name = 'deep sea': a name is a letter"),
        (lambda: Material("red", model="fong"), r"^model = 'fong': no model has this name; did you mean 'phong'\?"),
        (lambda: Material("red", model=3), r"^model = 3: a model is a name"),
        (lambda: Material("red", model=[]), r"^model = \[\]: a material needs at least one model"),
        (lambda: Material("red", model="phong"), r"^exponent: the model phong needs it"),
        (lambda: Material("red", exponent=3), r"^exponent: the model lambert has no such parameter; there are none"),
        (lambda: Material("red", model="phong", exponent="40"), r"^exponent = '40': it must be a number"),
        (lambda: Material("red", model="phong", exponent=float("nan")), r"^exponent = nan: numbers must be finite"),
        (lambda: Material("red", model="phong", exponent=2e7), r"^exponent = 20000000.0: it must be from 0 to 1e7"),
    ],
)
def test_a_material_that_cannot_reflect_says_why(make, line):
    with pytest.raises(ValueError, match=line):
        make()


def test_a_scene_shows_itself_with_everything_escaped():
    made = scene(shapes=[replace(TRIANGLE, materials=("red",)), Sphere((0, 1, 0), 1, "red")])
    table = made._repr_html_()
    assert "<td>sun</td>" in table
    assert "<td>phong exponent = 40.0</td>" in table
    assert "256 × 256 pixels" in table
    odd = scene(lights=[OwnLight("candle")])
    object.__setattr__(odd.lights[0], "name", "<script>")
    assert "<script>" not in odd._repr_html_()


def test_reading_a_scene_loads_no_heavy_library():
    """Colour takes 1.2 s and trimesh 0.6 s to import; a scene needs neither until it is traced."""
    code = (
        "import symrt.scene, sys; symrt.scene.load_scene('first'); print([m for m in sys.argv[1:] if m in sys.modules])"
    )
    heavy = ["colour", "trimesh", "embreex", "matplotlib"]
    ran = subprocess.run([sys.executable, "-c", code, *heavy], capture_output=True, text=True, check=True)
    assert ran.stdout.strip() == "[]"


def test_the_shipped_globe_names_six_bands_of_elevation_and_every_spectrum_it_needs():
    globe = load_scene("globe")
    assert globe.used_materials >= {"deep", "shelf", "lowland", "upland", "mountain", "ice", "brass"}
    assert {f"{name}.diffuse" for name in globe.used_materials} <= set(globe.symbols)


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: rt.Sphere(center=(0, 0, 0), radius=1, material="a"), "Sphere has no 'center': did you mean 'centre'"),
        (lambda: rt.Plane(point=(0, 0, 0), normal=(0, 1, 0), texture="a"), "no 'texture': did you mean 'material'"),
        (lambda: rt.Camera(positon=(0, 0, 0), target=(0, 0, 1), width=3, height=3), "did you mean 'position'"),
        (lambda: rt.PointLight("a", (0, 0, 0), intensity=3), "PointLight has no 'intensity': there are 'name'"),
    ],
)
def test_words_that_are_not_ours_and_arguments_of_another_kind_are_named(make, says):
    with pytest.raises(TypeError, match=re.escape(says)):
        make()
