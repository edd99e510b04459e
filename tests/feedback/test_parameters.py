"""What a pixel does along a parameter, against shading the palette at each value of it."""

import os
import subprocess
import sys
import textwrap
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from feedback.synthetic import MATTE, palette, system
from scipy import sparse

import symrt
from symrt.feedback.along import along
from symrt.feedback.parameters import Blend, Exposure, Scale, moved
from symrt.interactions import Interaction
from symrt.nodes import Nodes
from symrt.spectra.bands import RGB
from symrt.spectra.palette import Palette
from symrt.spectra.shading import shade
from symrt.system import LinearSystem

IMAGE, COLOURS = system(), palette()
PARAMETERS = [
    Scale("key"),
    Scale("fill"),
    Scale("deep"),
    Scale("brass"),
    Scale("brass.specular"),
    Scale("brass.mirror"),
    Exposure(),
    Blend("deep", "ice"),
    Blend("upland", "shelf"),
]


def glossy_pair():
    """Two materials of the same components, seen in each other's mirrors up to the third degree."""
    random = np.random.default_rng(3)
    names = ("a.diffuse", "a.mirror", "b.diffuse", "b.mirror")
    met = {tuple(sorted(random.choice(names, random.integers(1, 4)))) for _ in range(12)}
    columns = tuple(sorted(Interaction("key", m) for m in met))
    coefficients = random.uniform(0, 0.5, (40, len(columns))) * (random.uniform(size=(40, len(columns))) < 0.3)
    image = LinearSystem(sparse.csr_array(coefficients), columns, 5, 8, {"key": 0.5})
    spectra = {name: random.uniform(0.1, 0.9, 36) for name in names}
    return image, Palette(COLOURS.bands, {"key": 2.0, **spectra})


@pytest.mark.parametrize("parameter", PARAMETERS, ids=str)
@pytest.mark.parametrize("t", [0.0, 0.25, 1.0])
def test_the_polynomial_is_the_shaded_image_at_every_value(parameter, t):
    line = along(IMAGE, COLOURS, parameter)
    shaded = shade(IMAGE, moved(IMAGE, COLOURS, parameter, t)).values.reshape(-1, 36)
    np.testing.assert_allclose(line.at(t), shaded, rtol=1e-12, atol=1e-15)


@pytest.mark.parametrize("t", [1.7, 3.0])
def test_scales_go_on_beyond_the_palette_given(t):
    for parameter in (Scale("brass"), Scale("key"), Exposure()):
        line = along(IMAGE, COLOURS, parameter)
        shaded = shade(IMAGE, moved(IMAGE, COLOURS, parameter, t)).values.reshape(-1, 36)
        np.testing.assert_allclose(line.at(t), shaded, rtol=1e-12, atol=1e-15)


@pytest.mark.parametrize("parameter", [Scale("a"), Scale("a.mirror"), Blend("a", "b"), Blend("b", "a")], ids=str)
def test_degrees_above_one_are_the_shaded_image_too(parameter):
    image, colours = glossy_pair()
    line = along(image, colours, parameter)
    assert line.degree >= 2
    for t in (0.0, 0.3, 0.8, 1.0):
        shaded = shade(image, moved(image, colours, parameter, t)).values.reshape(-1, 36)
        np.testing.assert_allclose(line.at(t), shaded, rtol=1e-12, atol=1e-15)


@pytest.mark.parametrize("parameter", PARAMETERS, ids=str)
def test_touched_pixels_are_those_that_change(parameter):
    line = along(IMAGE, COLOURS, parameter)
    changes = ~np.isclose(line.at(0.2), line.at(0.9), rtol=1e-13, atol=0).all(axis=1)
    assert np.array_equal(line.touched, changes)


@pytest.mark.parametrize("parameter", PARAMETERS, ids=str)
def test_no_coefficient_is_negative_because_no_interaction_is(parameter):
    line = along(IMAGE, COLOURS, parameter)
    assert not line.signed
    assert line.coefficients(slice(None)).min() >= 0


def test_degree_is_the_total_degree_of_what_moves():
    degrees = {str(p): along(IMAGE, COLOURS, p).degree for p in PARAMETERS}
    assert degrees["scale of key"] == degrees["scale of deep"] == degrees["scale of brass.specular"] == 1
    # key*brass.diffuse*brass.mirror**2
    assert degrees["scale of brass"] == 3
    assert degrees["scale of brass.mirror"] == 2


def test_a_blend_with_traced_alternatives_ends_at_the_other_material():
    # Two pixels of sea; ice, of another model, shades the same points otherwise.
    columns = (Interaction("key", ("sea.diffuse",)), Interaction("key", ("sea>ice.diffuse",)))
    columns += (Interaction("key", ("sea>ice.specular",)),)
    coefficients = np.array([[0.2, 0.2, 0.7], [0.3, 0.3, 0.0]])
    models = {"sea": "lambert", "ice": "phong", "sea>ice": "phong"}
    image = LinearSystem(sparse.csr_array(coefficients), columns, 1, 2, {"key": 0.5}, models=models)
    colours = Palette(
        RGB, {"key": 1.0, "sea.diffuse": [0.1, 0.2, 0.4], "ice.diffuse": [0.8, 0.9, 1.0], "ice.specular": 0.3}
    )
    line = along(image, colours, Blend("sea", "ice"))
    np.testing.assert_allclose(line.at(0.0), coefficients[:, :1] * colours["sea.diffuse"], rtol=1e-15)
    np.testing.assert_allclose(
        line.at(1.0), coefficients[:, 1:2] * colours["ice.diffuse"] + coefficients[:, 2:] * 0.3, rtol=1e-15
    )
    shaded = shade(image, moved(image, colours, Blend("sea", "ice"), 0.4)).values.reshape(2, 3)
    np.testing.assert_allclose(line.at(0.4), shaded, rtol=1e-12)


def test_materials_that_differ_in_more_than_spectra_are_not_blended_silently():
    with pytest.raises(ValueError, match=r'alternatives=\{"brass": \["deep"\]\}'):
        along(IMAGE, COLOURS, Blend("brass", "deep"))
    otherwise = replace(IMAGE, models={"deep": "lambert", "ice": "phong"})
    with pytest.raises(ValueError, match=r"deep \(diffuse; lambert\) and ice \(diffuse; phong\) differ"):
        along(otherwise, COLOURS, Blend("deep", "ice"))
    with pytest.raises(ValueError, match="with itself"):
        along(IMAGE, COLOURS, Blend("deep", "deep"))


@pytest.mark.parametrize("name", ["", "nothing of the kind"])
def test_a_scale_of_nothing_is_refused_with_the_names_that_there_are(name):
    """A light's material has no name, and is not everything that has none."""
    with pytest.raises(ValueError, match=r"there are brass, deep, fill, ice, key, lowland, mountain, shelf, upland$"):
        along(IMAGE, COLOURS, Scale(name))


def test_misspelt_names_get_a_suggestion():
    with pytest.raises(ValueError, match=r"'bras' \(did you mean 'brass'\?\)"):
        along(IMAGE, COLOURS, Scale("bras"))
    with pytest.raises(ValueError, match=r"no material is called 'deap' \(did you mean 'deep'\?\)"):
        along(IMAGE, COLOURS, Blend("deap", "ice"))
    with pytest.raises(ValueError, match=r"palette lacks 'ice.diffuse'"):
        along(IMAGE, Palette(COLOURS.bands, {n: COLOURS[n] for n in COLOURS if n != "ice.diffuse"}), Scale("key"))


def test_a_parameter_of_a_model_that_is_still_free_is_named():
    nodes = Nodes("brass.exponent", 5.0, 80.0, 2)
    columns = tuple(Interaction("key", ("brass.specular",), (("brass.exponent", j),)) for j in range(2))
    image = LinearSystem(
        sparse.csr_array(np.ones((1, 2))), columns, 1, 1, {"key": 0.5}, parameters={"brass.exponent": nodes}
    )
    with pytest.raises(ValueError, match=r"brass.exponent free: give values, collapse\(tree, values="):
        along(image, COLOURS, Scale("key"))


def test_a_palette_that_passes_one_says_so():
    assert moved(IMAGE, COLOURS, Scale("ice"), 3.0).unphysical
    assert not moved(IMAGE, COLOURS, Scale("ice"), 0.5).unphysical
    assert not moved(IMAGE, COLOURS, Scale("key"), 3.0).unphysical


def test_a_material_s_scale_moves_all_its_components_and_no_other():
    doubled = moved(IMAGE, COLOURS, Scale("brass"), 2.0)
    for name in COLOURS:
        factor = 2.0 if name.startswith("brass.") else 1.0
        np.testing.assert_array_equal(doubled[name], factor * COLOURS[name])
    assert set(MATTE).isdisjoint(n.partition(".")[0] for n in COLOURS if n.startswith("brass."))


def test_arguments_in_each_others_place_are_named_with_what_makes_them():
    """In a process of its own: here the types in signatures are checked before."""
    lines = """
        import symrt as rt
        scene = rt.load_scene("first")
        system, palette = rt.render(scene, progress=False), rt.load_palettes("first")["plain"]
        device = rt.load_device("dye3-endura-premier")
        gamut, red = rt.device_gamut(device), rt.Scale("red")
        for ask in (
            lambda: rt.feasible(system, palette, gamut, "red"),
            lambda: rt.feasible(system, palette, device, red),
            lambda: rt.fit(scene, palette, gamut, [red]),
            lambda: rt.report(palette, system, [gamut]),
            lambda: rt.map_pixels(system, rt.load_palettes("first"), gamut),
            lambda: rt.adapt(system, palette, gamut, ["red"]),
            lambda: rt.shade(scene, palette),
            lambda: rt.render("globe"),
            lambda: rt.trace("globe"),
            lambda: rt.collapse("globe"),
            lambda: rt.shade(palette, system),
            lambda: rt.preview(system, rt.load_palettes("first")),
            lambda: rt.fit(system, palette, gamut, rt.Scale),
            lambda: rt.safe_box(system, palette, gamut, red),
            lambda: rt.feasible(system, palette, gamut, rt.Scale),
            lambda: rt.adapt(scene, palette, gamut, [red]),
            lambda: rt.adapt(system, palette, gamut, red),
            lambda: rt.map_pixels(palette, system, gamut),
            lambda: rt.report(system, palette, gamut),
            lambda: rt.safe_box(system, palette, gamut, None),
            lambda: rt.joint_region(system, palette, gamut, red, "sun"),
            lambda: rt.with_region(system, "red", "left"),
            lambda: rt.feasible(system, palette, gamut, red, reference="sun"),
            lambda: rt.report(system, palette, [gamut], reference=palette["sun"]),
            lambda: rt.adapt(system, palette, gamut, [red], reference=rt.Reference),
            lambda: rt.preview(system, palette, white=red),
            lambda: rt.to_rgb(palette),
            lambda: rt.to_rgb(rt.shade(system, palette), exposure="1"),
            lambda: rt.save_palettes("a.toml", palette),
            lambda: rt.Palette("rgb", {"sun": 1}),
            lambda: rt.srgb(3),
        ):
            try:
                ask()
            except TypeError as error:
                print(error)
    """
    home = os.environ | {"PYTHONPATH": str(Path(symrt.__file__).parents[1])}
    said = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(lines)], capture_output=True, text=True, check=True, env=home
    ).stdout.splitlines()
    kinds = [
        "parameter is a str",
        "gamut is a Device",
        "system is a Scene",
        "system is a Palette",
        "palette is a Palettes",
    ]
    kinds += ["scale is a str", "system is a Scene", "scene is a str", "scene is a str", "tree is a str"]
    kinds += ["system is a Palette", "palette is a Palettes"]
    kinds += ["scales is the class", "scales is Scale(name='red'): give", "parameter is the class"]
    kinds += [
        "system is a Scene",
        "scales is Scale(name='red'): give",
        "system is a Palette",
        "gamuts is Gamut(unit gamut",
    ]
    kinds += ["scales is None: give", "parameter is a str", "palette is a LinearSystem", "reference is a str"]
    kinds += ["reference is a ndarray", "reference is the class", "white is a Scale", "image is a Palette"]
    kinds += ["exposure is a str", "palettes is a Palette", "bands is a str", "colour is an int"]
    assert [" ".join(line.split()[:4]).rstrip(",") for line in said] == kinds
    assert "give device_gamut(load_device(name), model)" in said[1]
