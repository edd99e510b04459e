"""Glasses by name: their indices against the makers' catalogues; media of a user's own, and what is refused."""

import re
from dataclasses import replace

import numpy as np
import pytest
from scenes_for_tests import camera

import symrt as rt
from symrt.scene.media import Dispersion, window_nodes

D, F, C = 587.5618, 486.1327, 656.2725
"""The yellow line of helium, the blue and the red line of hydrogen, in nm (ISO 7944)."""

# n_d and the Abbe number (n_d - 1)/(n_F - n_C): SCHOTT's catalogue of optical glasses, 2017; for fused silica and
# fluorite Corning's and Hellma's data sheets.
CATALOGUE = {
    "N-BK7": (1.51680, 64.17),
    "N-K5": (1.52249, 59.48),
    "N-SK16": (1.62041, 60.32),
    "F2": (1.62004, 36.37),
    "N-SF10": (1.72828, 28.53),
    "N-SF11": (1.78472, 25.68),
    "N-SF6": (1.80518, 25.36),
    "N-SF66": (1.92286, 20.88),
    "fused silica": (1.45846, 67.82),
    "fluorite": (1.43385, 94.99),
}
# n_F and n_C of the same data sheets.
LINES = {"N-BK7": (1.52238, 1.51432), "F2": (1.63208, 1.61503), "fused silica": (1.46313, 1.45637)}


@pytest.mark.parametrize("glass", CATALOGUE)
def test_indices_are_those_of_the_catalogues(glass):
    n_d, n_f, n_c = (rt.refractive_index(glass, nm) for nm in (D, F, C))
    assert (round(n_d, 5), round((n_d - 1) / (n_f - n_c), 1)) == (CATALOGUE[glass][0], round(CATALOGUE[glass][1], 1))
    if glass in LINES:
        assert (round(n_f, 5), round(n_c, 5)) == LINES[glass]


def test_water_and_diamond_are_as_others_measured_them():
    # IAPWS R9-97, 20 °C, 0.1 MPa, against vacuum at 589 nm; diamond: J. R. Phillips III's value as in the CRC Handbook.
    assert rt.refractive_index("water", 589.0) == pytest.approx(1.33336, abs=2e-5)
    assert rt.refractive_index("diamond", 589.3) == pytest.approx(2.4173, abs=3e-4)
    assert set(rt.glasses()) == {*CATALOGUE, "water", "diamond"}


def test_numbers_of_ones_own_are_the_formulas_of_the_textbook():
    nm = np.array([400.0, 555.0, 700.0])
    pairs = [(1.03961212, 0.00600069867), (0.231792344, 0.0200179144), (1.01046945, 103.560653)]
    own = rt.Material("own", "glass", sellmeier=pairs).dispersion
    np.testing.assert_allclose(own.index(nm), rt.refractive_index("N-BK7", nm), rtol=1e-15)
    cauchy = rt.Material("own", "glass", cauchy=[1.5046, 0.0042, 1e-5]).dispersion
    by_hand = [1.5046 + 0.0042 / (x / 1000) ** 2 + 1e-5 / (x / 1000) ** 4 for x in nm]
    np.testing.assert_allclose(cauchy.index(nm), by_hand, rtol=1e-15)
    assert str(own).startswith("sellmeier = [[1.03961212, 0.00600069867], ")
    assert str(cauchy) == "cauchy = [1.5046, 0.0042, 1e-05]"
    assert str(rt.Material("own", "glass", glass="F2").dispersion) == "glass = 'F2'"


@pytest.mark.parametrize(
    ("given", "fault"),
    [
        ({"glass": "N-SF12"}, r"glass = 'N-SF12': no glass has this name; did you mean 'N-SF1\d'\?"),
        ({"glass": 1.5}, r"glass = 1.5: no glass has this name"),
        ({"glass": "F2", "index": 1.5}, r"index = 1.5, glass = 'F2': one way to give an index is enough"),
        ({"glass": "F2", "cauchy": [1.5]}, r"glass = 'F2', cauchy = \[1.5\]: one way to give an index is enough"),
        ({"sellmeier": [1.0, 0.01]}, r"sellmeier = \[1.0, 0.01\]: it must be pairs of B and C, C in µm²"),
        ({"sellmeier": []}, r"sellmeier = \[\]: it must be pairs of B and C"),
        ({"sellmeier": [[1.0, "x"]]}, r"sellmeier\[0\]\[1\] = 'x': it must be a number"),
        ({"cauchy": 1.5}, r"cauchy = 1.5: it must be numbers A₀"),
        ({"cauchy": [float("nan")]}, r"cauchy\[0\] = nan: numbers must be finite"),
        ({}, r"index: the model glass needs it; write index = 1.5, or glass = 'N-BK7'"),
        ({"model": "lambert", "glass": "F2"}, r"glass = 'F2': light does not go through this model"),
    ],
)
def test_an_index_that_is_none_is_refused_with_a_remedy(given, fault):
    with pytest.raises(ValueError, match=fault) as said:
        rt.Material("prism", **{"model": "glass", **given})
    assert "\n" not in str(said.value)


def scene(windows=6, **medium):
    return rt.Scene(
        camera=camera(4),
        shapes=[rt.Sphere(centre=(0, 0, 0), radius=1, material="prism")],
        materials=[rt.Material("prism", "glass", **medium)],
        lights=[rt.AmbientLight("sky")],
        windows=windows,
    )


@pytest.mark.parametrize(
    ("medium", "windows", "fault"),
    [
        (
            {"glass": "N-SF66"},
            6,
            r"materials.prism: glass = 'N-SF66': its index is published for 390 … 2500 nm, and the",
        ),
        ({"glass": "diamond"}, [400, 800], r"published for 226 … 760 nm, .* run from 400 to 800 nm: choose them"),
        ({"sellmeier": [[1.0, 0.25]]}, 6, r"the index has a pole at 500 nm, within the scene's windows, 380 … 730 nm"),
        ({"sellmeier": [[1.0, 0.6]]}, 6, r"the index at \d+(\.\d)? nm is not real: it must be from"),
        ({"sellmeier": [[-1.5, 0.01]]}, 6, r"the index at 380 nm is not real"),
        (
            {"cauchy": [1.5, -0.4]},
            6,
            r"the index at 380 nm is -1.27: it must be from 0.01 to 100; wavelengths are in µm",
        ),
        ({"glass": "F2"}, 1, r"windows = 1: it must be a whole number from 2 to 64"),
        ({"glass": "F2"}, [500], r"windows = \[500\]: give 2 to 64 wavelengths in nm, or a number of windows"),
        ({"glass": "F2"}, [500, 400], r"windows = \[500, 400\]: wavelengths must increase"),
        ({"glass": "F2"}, [0.4, 0.7], r"windows = \[0.4, 0.7\]: wavelengths are in nm, from 100 to 3000"),
        ({"glass": "F2"}, [400, "red"], r"windows\[1\] = 'red': it must be a number"),
        ({"glass": "F2"}, 6.0, r"windows = 6.0: it must be a whole number"),
    ],
)
def test_windows_without_an_index_are_refused(medium, windows, fault):
    with pytest.raises(ValueError, match=fault) as said:
        scene(windows, **medium)
    assert "\n" not in str(said.value)


def test_scene_files_name_glasses_and_windows(tmp_path):
    text = """
windows = WINDOWS
[camera]
position = [0, 0, 4]
target = [0, 0, 0]
width = 4
height = 4
[[shapes]]
type = "sphere"
centre = [0, 0, 0]
radius = 1
material = "prism"
[materials.prism]
model = "glass"
GLASS
[lights.sky]
type = "ambient"
"""
    path = tmp_path / "s.toml"
    path.write_text(text.replace("WINDOWS", "[400, 550.5, 700]").replace("GLASS", 'glass = "N-SF11"'))
    read = rt.load_scene(path)
    assert read.nodes == (400.0, 550.5, 700.0)
    assert read.materials[0].dispersion.name == "N-SF11"
    assert "glass = 'N-SF11'" in read._repr_html_().replace("&#x27;", "'")
    path.write_text(text.replace("WINDOWS", "12").replace("GLASS", "sellmeier = [[1.0396, 0.006], [1.0105, 103.56]]"))
    assert (len(rt.load_scene(path).nodes), len(rt.load_scene(path).materials[0].dispersion.sellmeier)) == (12, 2)
    for windows, glass, fault in (
        ("1", 'glass = "F2"', r"s.toml: windows = 1: it must be a whole number from 2 to 64"),
        (
            "6",
            'glass = "N-SF12"',
            r"s.toml: materials.prism.glass = 'N-SF12': no glass has this name; did you mean 'N-SF",
        ),
        ("6", 'glass = "F2"\nindex = 1.5', r"s.toml: materials.prism.index = 1.5, glass = 'F2': one way to give an"),
        ("6", "sellmeier = [[1.0, 0.25]]", r"s.toml: materials.prism: sellmeier = .*: the index has a pole at 500 nm"),
    ):
        path.write_text(text.replace("WINDOWS", windows).replace("GLASS", glass))
        with pytest.raises(rt.SceneError, match=fault):
            rt.load_scene(path)


def test_nothing_is_extrapolated_and_names_are_hinted_at():
    with pytest.raises(ValueError, match=r"water at 1200 nm: its index is published for 182 … 1129 nm; nothing is"):
        rt.refractive_index("water", [500, 1200])
    with pytest.raises(ValueError, match=r"no glass is called 'BK7': did you mean 'N-BK7'\?"):
        rt.refractive_index("BK7", 500)
    assert window_nodes((400, 700)) == (400.0, 700.0)
    assert Dispersion(cauchy=(1.5,)).index(np.array([400.0])).tolist() == [1.5]


def test_a_material_with_another_glass_is_another_material():
    one, other = (rt.Material("prism", "glass", glass=name) for name in ("F2", "N-BK7"))
    assert one != other
    assert one == rt.Material("prism", "glass", glass="F2")
    trees = [rt.trace(replace(scene(glass="F2"), materials=[material])) for material in (one, other)]
    told = [tree.materials["prism"].signature() for tree in trees]
    assert told[0] != told[1]
    assert re.search(r"index = 1\.6\d+; index by window = \[1\.6\d+, ", told[0])
