"""Palettes in files: every form a spectrum may take, every fault in one line, and round trips bit for bit."""

import tomllib

import numpy as np
import pytest

import symrt.spectra.palettes_file as module
from symrt.errors import SceneError
from symrt.spectra.bands import RGB, Bands, wavelengths
from symrt.spectra.library import from_rgb, spectrum
from symrt.spectra.palette import Palette
from symrt.spectra.palettes_file import load_palettes, save_palettes

BANDS = wavelengths(380, 730, 10)


def write(folder, text, name="scene.toml"):
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def load(folder, *lines, bands="[380, 730, 10]"):
    return load_palettes(write(folder, "\n".join(["[palettes.plain]", f"bands = {bands}", *lines])))["plain"]


def fault(folder, *lines, **options):
    """The one line that an error says, without the path."""
    with pytest.raises(SceneError) as caught:
        load(folder, *lines, **options)
    assert len(caught.value.faults) == 1, caught.value
    start = f"{folder / 'scene.toml'}: palettes.plain"
    assert str(caught.value).startswith(start)
    return str(caught.value)[len(start) :]


def test_every_form_of_a_spectrum_is_read(tmp_path):
    (tmp_path / "gold.csv").write_text("nm,value\n# a comment\n370,0.2\n730,0.9\n", encoding="utf-8")
    palette = load(
        tmp_path,
        'sun = "illuminant/D65"',
        'sky = { spectrum = "illuminant/D65", scale = 0.3 }',
        "lamp = { rgb = [2.0, 1.0, 0.5] }",
        '"red.diffuse" = { rgb = [0.8, 0.1, 0.1] }',
        '"red.specular" = 0.04',
        '"sea.diffuse" = "macbeth/Blue"',
        '"gold.specular" = { file = "gold.csv" }',
        f'"list.diffuse" = {[0.5] * 36}',
        '"half.diffuse" = { file = "gold.csv", scale = 0.5 }',
    )
    assert palette.bands == BANDS
    np.testing.assert_array_equal(palette["sun"], spectrum("illuminant/D65", BANDS))
    np.testing.assert_array_equal(palette["sky"], 0.3 * palette["sun"])
    np.testing.assert_array_equal(palette["red.specular"], np.full(36, 0.04))
    np.testing.assert_array_equal(palette["sea.diffuse"], spectrum("macbeth/blue", BANDS))
    np.testing.assert_allclose(palette["gold.specular"], 0.2 + 0.7 * (np.array(BANDS.centres) - 370) / 360, rtol=1e-14)
    np.testing.assert_array_equal(palette["half.diffuse"], palette["gold.specular"] / 2)
    np.testing.assert_array_equal(palette["list.diffuse"], 0.5)
    red = np.array([0.8, 0.1, 0.1])
    np.testing.assert_array_equal(palette["red.diffuse"], from_rgb(red, BANDS, reflectance=True))
    np.testing.assert_array_equal(palette["lamp"], from_rgb(np.array([2.0, 1.0, 0.5]), BANDS, reflectance=False))


def test_rgb_palettes_take_their_numbers_as_they_are(tmp_path):
    palette = load(tmp_path, "sun = 1", '"red.diffuse" = { rgb = [0.8, 0.1, 0] }', "sky = [1, 2, 3]", bands='"rgb"')
    assert palette.bands == RGB
    np.testing.assert_array_equal(palette["red.diffuse"], [0.8, 0.1, 0.0])
    np.testing.assert_array_equal(palette["sky"], [1.0, 2.0, 3.0])


def test_the_rest_of_a_scene_file_is_not_looked_at(tmp_path):
    text = '[camera]\nnonsense = inf\n[palettes.plain]\nbands = "rgb"\nsun = 1.0\n[[shapes]]\ntype = "?"\n'
    assert list(load_palettes(write(tmp_path, text))) == ["plain"]


def test_a_symbol_without_quotes_is_the_same_symbol(tmp_path):
    palette = load(
        tmp_path, "red.diffuse = 0.5", 'red.specular = { spectrum = "macbeth/white" }', bands="[400, 700, 10]"
    )
    assert palette.reflectances == ("red.diffuse", "red.specular")
    assert "given twice" in fault(tmp_path, "red.diffuse = 0.5", '"red.diffuse" = 0.4')


def test_reflectances_above_one_need_the_word(tmp_path):
    assert "lies in [0, 1]" in fault(tmp_path, '"red.diffuse" = 1.5')
    assert load(tmp_path, "unphysical = true", '"red.diffuse" = 1.5').above_one == ("red.diffuse",)
    assert "write true or false" in fault(tmp_path, "unphysical = 1")


def test_the_example_in_the_module_is_a_palette(tmp_path):
    (tmp_path / "gold.csv").write_text("380 0.2\n730 0.9\n", encoding="utf-8")
    example = module.__doc__.split("```toml")[1].split("```")[0]
    assert set(load_palettes(write(tmp_path, example))["plain"]) == {
        "sun", "sky", "clay.diffuse", "red.diffuse", "red.specular", "gold.specular",
        "lamp", "ink.fluorescence",
    }  # fmt: skip


@pytest.mark.parametrize(
    ("line", "reason"),
    [
        ('"red.diffuse" = "macbeth/redd"', "\"red.diffuse\" = 'macbeth/redd': no spectrum is named"),
        ('"red.diffuse" = true', "not a spectrum"),
        ('"red.diffuse" = 2020-01-01', "no dates"),
        ('"red.diffuse" = [0.1, 0.2]', "2 values where 36 belong"),
        ('"red.diffuse" = [0.1, "a"]', "'a' is not a number"),
        ('"red.diffuse" = []', "0 values where 36 belong"),
        ('"red.diffuse" = nan', "numbers must be finite"),
        ('"red.diffuse" = 1e999', "numbers must be finite"),
        ('"red.diffuse" = -0.5', "no spectrum is negative"),
        ("sun = -1", "no spectrum is negative"),
        ('sun = "macbeth/red"', "is a reflectance, and a light is wanted"),
        ('"red.diffuse" = { spectrun = "macbeth/red", scale = 1 }', "did you mean 'spectrum'?"),
        ('"red.diffuse" = { scale = 1 }', "one of spectrum, rgb and file"),
        ('"red.diffuse" = { rgb = [1, 1, 1], file = "a.csv" }', "one of spectrum, rgb and file"),
        ('"red.diffuse" = { rgb = [1, 1] }', "2 values where 3 belong"),
        ('"red.diffuse" = { rgb = [1, 1, 2] }', "lie in [0, 1]"),
        ('"red.diffuse" = { rgb = "red" }', "0 values where 3 belong"),
        ('"red.diffuse" = { spectrum = 5 }', "write it in quotes"),
        ('"red.diffuse" = { spectrum = "macbeth/red", scale = -1 }', "scale = -1"),
        ('"red.diffuse" = { spectrum = "macbeth/red", scale = 3 }', "lies in [0, 1]"),
        ('"red.diffuse" = { file = "missing.csv" }', "does not exist in the scene's folder"),
        ('"red.diffuse" = { file = "../a.csv" }', "leaves the scene's folder"),
        ('"red.diffuse" = { file = "/etc/hostname" }', "is an absolute path"),
        ("\"__import__('os')\" = 0.5", "a symbol is a light's name"),
        ('"red diffuse" = 0.5', "a symbol is a light's name"),
        ('"red.diffuse\\n" = 0.5', "a symbol is a light's name"),
    ],
)
def test_a_spectrum_that_is_none_is_one_line_with_its_key(tmp_path, line, reason):
    assert reason in fault(tmp_path, line)


@pytest.mark.parametrize(
    ("bands", "reason"),
    [
        ("[0.38, 0.73, 0.01]", "micrometres"),
        ("[380, 730]", "give first, last and step"),
        ('"RGB?"', "give first, last and step"),
        ("36", "give first, last and step"),
        ("[380, 730, 0]", "a step above 0"),
        ("{ centres = [500, 400] }", "must increase"),
        ("{ centres = [] }", "no bands"),
        ('{ centres = ["a"] }', "give first, last and step"),
    ],
)
def test_bands_that_are_none_are_one_line(tmp_path, bands, reason):
    assert reason in fault(tmp_path, "sun = 1.0", bands=bands)


def test_missing_bands_and_missing_palettes_are_told(tmp_path):
    with pytest.raises(SceneError, match=r"palettes\.plain: bands missing"):
        load_palettes(write(tmp_path, "[palettes.plain]\nsun = 1.0"))
    for text in ("", "[camera]\nwidth = 1", "palettes = 3", "[palettes]"):
        with pytest.raises(SceneError, match=r"add a table \[palettes\.plain\]"):
            load_palettes(write(tmp_path, text))
    with pytest.raises(SceneError, match=r"palettes\.plain: = 3: a palette is a table"):
        load_palettes(write(tmp_path, "[palettes]\nplain = 3"))
    with pytest.raises(SceneError, match="not a name"):
        load_palettes(write(tmp_path, '[palettes."a b"]\nbands = "rgb"'))


def test_all_faults_of_all_palettes_come_at_once(tmp_path):
    text = (
        '[palettes.one]\nbands = "rgb"\nsun = -1\n"red.diffuse" = "macbeth/redd"\n"sea.diffuse" = 7\n'
        '[palettes.two]\nbands = 5\n[palettes.three]\nbands = "rgb"\nsun = 1.0\n'
    )
    with pytest.raises(SceneError) as caught:
        load_palettes(write(tmp_path, text))
    assert len(caught.value.faults) == 4
    assert all(line.startswith(str(tmp_path / "scene.toml") + ": palettes.") for line in caught.value.faults)


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        ("", "has 0 samples"),
        ("380,0.5", "has 1 samples"),
        ("380,0.5\n730,0.6,0.7", "line 2"),
        ("380,0.5\nfoo,0.6", "line 2"),
        ("380;0,5\n730;0,6", "line 1"),
        ("380,0.5\n730", "line 2"),
        ("380,0.5\n730,nan", "is nan at"),
        ("nan,0.5\n730,0.5", "wavelength nan"),
        ("0.38,0.5\n0.73,0.5", "look like micrometres"),
        ("3.8e-7,0.5\n7.3e-7,0.5", "look like metres: multiply by 1e9"),
        ("730,0.5\n380,0.5", "730 nm comes before 380 nm"),
        ("380,0.5\n380,0.6\n730,0.5", "380 nm appears twice"),
        ("400,0.5\n700,0.6", "nothing is extrapolated"),
        ("380,50\n730,60", "percent"),
        ("380,-0.1\n730,0.5", "no spectrum is negative"),
        ("__import__('os'),1\n380,0.5\nexec,2", "line 1"),
    ],
)
def test_a_table_that_is_no_spectrum_is_one_line(tmp_path, content, reason):
    (tmp_path / "gold.csv").write_text(content, encoding="utf-8")
    assert reason in fault(tmp_path, '"gold.diffuse" = { file = "gold.csv" }')


def test_tables_of_other_alphabets_and_sizes_are_refused(tmp_path):
    (tmp_path / "gold.csv").write_bytes(b"380,0.5\n\xff\xfe")
    assert "not UTF-8" in fault(tmp_path, '"gold.diffuse" = { file = "gold.csv" }')
    (tmp_path / "gold.csv").write_bytes(b" " * ((1 << 20) + 1))
    assert "larger than 1 MiB" in fault(tmp_path, '"gold.diffuse" = { file = "gold.csv" }')


@pytest.mark.parametrize("separator", [",", "\t", " ; ", "  "])
@pytest.mark.parametrize("head", ["", "wavelength{0}reflectance\n", "\ufeffnm{0}R\n\n# from a book\n"])
def test_tables_may_be_separated_as_people_do(tmp_path, separator, head):
    text = head.format(separator) + f"380{separator}0.25\r\n730{separator}0.25\n"
    (tmp_path / "gold.csv").write_text(text, encoding="utf-8")
    np.testing.assert_array_equal(load(tmp_path, '"gold.diffuse" = { file = "gold.csv" }')["gold.diffuse"], 0.25)


def test_a_link_out_of_the_folder_is_refused(tmp_path):
    inner = tmp_path / "inner"
    inner.mkdir()
    (tmp_path / "secret.csv").write_text("380,0.5\n730,0.5", encoding="utf-8")
    (inner / "gold.csv").symlink_to(tmp_path / "secret.csv")
    assert "is a link out" in fault(inner, '"gold.diffuse" = { file = "gold.csv" }')


def random_palettes():
    rng = np.random.default_rng(0)
    uneven = Bands(tuple(np.sort(rng.uniform(380, 730, 7)).tolist()))
    return {
        "even": Palette(BANDS, {"sun": rng.random(36) * 1e300, "sea.diffuse": rng.random(36), "sky": 5e-324}),
        "fine": Palette(wavelengths(400, 401, 0.1), {"sun": 1 / 3, "sea>ice.diffuse": rng.random(11)}),
        "uneven": Palette(uneven, {"sun": rng.random(7), "sea.diffuse": 3.0 * rng.random(7)}, unphysical=True),
        "rgb": Palette(RGB, {"sun": [1, 0.9, 0.1 + 0.2], "sea.diffuse": 0.0}),
        "one": Palette(Bands((555.5,)), {"sun": 1.0}),
    }


def test_saved_palettes_come_back_bit_for_bit(tmp_path):
    palettes = random_palettes()
    save_palettes(tmp_path / "p.toml", palettes)
    back = load_palettes(tmp_path / "p.toml")
    assert list(back) == list(palettes)
    for name, palette in palettes.items():
        assert back[name].bands == palette.bands
        assert back[name].unphysical == palette.unphysical
        assert list(back[name]) == list(palette)
        for symbol in palette:
            assert back[name][symbol].tobytes() == palette[symbol].tobytes()
    assert [p.name for p in tmp_path.iterdir()] == ["p.toml"]


def test_saving_never_destroys_a_scene(tmp_path):
    path = write(tmp_path, '[camera]\nwidth = 3\n[palettes.old]\nbands = "rgb"\nsun = 1.0\n')
    before = path.read_bytes()
    with pytest.raises(ValueError, match="holds a scene too"):
        save_palettes(path, random_palettes())
    assert path.read_bytes() == before
    with pytest.raises(ValueError, match="cannot name a palette"):
        save_palettes(tmp_path / "p.toml", {"a b": random_palettes()["rgb"]})
    assert [p.name for p in tmp_path.iterdir()] == ["scene.toml"]


def test_what_is_written_is_plain_toml(tmp_path):
    save_palettes(tmp_path / "p.toml", random_palettes())
    tables = tomllib.loads((tmp_path / "p.toml").read_text(encoding="utf-8"))
    assert tables["palettes"]["rgb"] == {"bands": "rgb", "sun": [1.0, 0.9, 0.1 + 0.2], "sea.diffuse": 0.0}
    assert tables["palettes"]["even"]["bands"] == [380.0, 730.0, 10.0]


def test_a_palette_that_is_not_there_is_named_with_the_nearest():
    with pytest.raises(KeyError, match="no palette 'Macbeth': did you mean 'macbeth'"):
        load_palettes("globe")["Macbeth"]


def test_a_light_cannot_be_called_as_a_key_of_the_file():
    for name in ("bands", "unphysical"):
        with pytest.raises(ValueError, match="palette files have a key of this name"):
            Palette(RGB, {name: 1.0})
