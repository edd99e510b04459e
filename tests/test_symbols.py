"""A symbol's text and its parts say the same, and no other text is a symbol's."""

import string

import pytest
from hypothesis import given
from hypothesis import strategies as st

from symrt.symbols import Surface, Symbol, named

names = st.text(string.ascii_letters + string.digits + "_", max_size=63).map("n".__add__)


@given(names, names, names)
def test_a_text_has_the_parts_that_it_was_put_together_from(place, material, component):
    light, own, other = map(Symbol.of, (place, f"{material}.{component}", f"{place}>{material}.{component}"))
    assert (light.light, light.material, light.place, light.component) == (place, "", "", "")
    assert (own.light, own.material, own.place, own.component) == ("", material, material, component)
    assert (other.light, other.material, other.place, other.component) == ("", material, place, component)
    assert [s.reflectance for s in (light, own, other)] == [False, True, True]
    assert [s.alternative for s in (light, own, other)] == [False, False, True]


@given(names, names, names)
def test_a_symbol_gives_its_text_back(place, material, component):
    # A material that is its own alternative, sea>sea, is another symbol than sea.
    for text in (place, f"{material}.{component}", f"{place}>{material}.{component}", f"{place}>{place}.{component}"):
        assert str(Symbol.of(text)) == text
        assert Symbol.of(text).surface.alternative == (">" in text)
    for text in (place, f"{place}>{material}", f"{place}>{place}"):
        assert str(Surface.of(text)) == text
        assert str(Symbol.of(named(text, component)).surface) == text


@pytest.mark.parametrize(
    "text",
    [
        *("", "1", "a b", "sea.", ".diffuse", "sea..diffuse", "sea.diffuse.x", "sea>ice", ">ice.diffuse"),
        *("sea>.diffuse", "sea>ice>fog.diffuse", "sea.diffuse\n", "é.diffuse", "a" * 65, "sea." + "a" * 65, "_a.b"),
    ],
)
def test_no_other_text_is_a_symbol(text):
    with pytest.raises(ValueError, match=r"a symbol is a light's name, or material\.component") as caught:
        Symbol.of(text)
    assert str(caught.value).isprintable()


@pytest.mark.parametrize("text", ["", "sea>", ">sea", "a>b>c", "sea.diffuse", "a b", "sea\n"])
def test_no_other_text_is_a_surface(text):
    with pytest.raises(ValueError, match="give a material's name, or place>material"):
        Surface.of(text)
