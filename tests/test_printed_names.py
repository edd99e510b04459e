"""Names, titles and provenances that are code, markup or control characters do nothing where they are printed."""

from dataclasses import replace

import pytest
from matplotlib.text import Text
from scipy import sparse

import symrt as rt
from symrt.archives import read_archive, write_archive
from symrt.gamut.files import KIND, load_gamut, save_gamut
from symrt.interactions import Interaction
from symrt.system import LinearSystem
from symrt.table import html_table, text_table

CONTROLS = ("a\x1b]0;owned\x07", "a\x9b2J", "a\nb", "a\u202eb", "\x00")
MARKUP = (r"\href{javascript:alert(1)}{x}", r"$\x$", "<script>", "1", "a b", "")


def formula_of(light):
    """The formula of a system that was made in Python, whose light may be called anything."""
    column = Interaction(light, ("sea.diffuse",))
    return rt.formula(LinearSystem(sparse.csr_array([[0.5]]), (column,), 1, 1, {light: 1.0}), x=0, y=0)


@pytest.mark.parametrize("light", [*CONTROLS, *MARKUP[:5]])
def test_a_formula_s_latex_and_code_obey_no_name(light):
    latex, code = formula_of(light).latex(), formula_of(light).code()
    assert latex.isprintable()
    for command in (r"\href", r"\x", "$", "<s"):
        assert command not in latex.replace(r"\$", "")
    compile(code, "pixel", "exec")
    assert code.replace("\n", "").isprintable()


@pytest.mark.parametrize("text", CONTROLS)
@pytest.mark.parametrize("field", ["name", "title", "provenance"])
def test_a_device_has_no_control_characters_in_its_texts(tmp_path, field, text):
    monitor, printer = rt.load_device("srgb"), rt.load_device("dye3-endura-premier")
    for device in (monitor, printer):
        with pytest.raises(ValueError, match=f"{field} of a device is .*: no control characters"):
            replace(device, **{field: text})
    save_gamut(tmp_path / "a.npz", rt.device_gamut(monitor, "monitor"))
    arrays, header = read_archive(tmp_path / "a.npz", KIND)
    header["devices"][0][field] = text
    write_archive(tmp_path / "b.npz", KIND, {key: header[key] for key in ("devices", "gamuts")}, arrays)
    with pytest.raises(ValueError, match=r"b\.npz: not a whole symrt gamut .*no control characters") as caught:
        load_gamut(tmp_path / "b.npz")
    assert str(caught.value).isprintable()


@pytest.mark.parametrize("text", CONTROLS)
def test_an_ink_has_no_control_characters_in_its_name(tmp_path, text):
    printer = rt.load_device("dye3-endura-premier", rt.wavelengths(400, 700, 100))
    with pytest.raises(ValueError, match=r"an ink's name is .*: no control characters"):
        replace(printer, inks=(text, "m", "y"))
    save_gamut(tmp_path / "a.npz", rt.device_gamut(printer, "envelope"))
    arrays, header = read_archive(tmp_path / "a.npz", KIND)
    header["devices"][0]["inks"][0] = text
    write_archive(tmp_path / "b.npz", KIND, {key: header[key] for key in ("devices", "gamuts")}, arrays)
    with pytest.raises(ValueError, match=r"b\.npz: not a whole symrt gamut .*no control characters"):
        load_gamut(tmp_path / "b.npz")


@pytest.mark.parametrize("name", [*CONTROLS, *MARKUP])
def test_a_table_of_a_notebook_shows_names_and_obeys_none(name):
    assert "<script>" not in html_table(("name",), [(name,)])


@pytest.mark.parametrize("name", CONTROLS)
def test_a_table_at_a_prompt_shows_control_characters_and_obeys_none(name):
    assert text_table(("name",), [(name,)]).replace("\n", "").isprintable()


@pytest.mark.parametrize("name", [r"$\x$", "$a$"])
def test_an_ink_is_drawn_by_its_name_whatever_that_is(name):
    device = rt.load_device("dye3-endura-premier", rt.wavelengths(400, 700, 50))
    named = replace(device, name=name, inks=(name, "m", "y"))
    for model in ("hull", "envelope"):
        figure = rt.plots.body_figure(rt.device_gamut(named, model))
        assert rt.plots.png(figure)[1:4] == b"PNG"
        assert any(name in text.get_text() for text in figure.findobj(Text))
