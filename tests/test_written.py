"""Systems that one writes down, settles and takes rows of."""

import re

import numpy as np
import pytest
from scenes_for_tests import every_scene, small

import symrt as rt
from symrt.interactions import Interaction
from symrt.system import LinearSystem
from symrt.windows import SpectralWindow
from symrt.written import written_terms

WINDOW = re.compile(r"window\(nm, ([^,]+), ([^,]+), ([^)]+)\)")
"""Windows as Python code has them."""


@pytest.mark.parametrize("name", every_scene())
def test_what_formulas_say_is_read_back_as_the_system(name):
    system = rt.collapse(rt.trace(small(name, 12)))
    codes = [rt.formula(system, x, y).code() for y in range(12) for x in range(12)]
    # Code multiplies by matrices with a sign of its own.
    texts = [WINDOW.sub(_window, code.rpartition("return ")[2].replace("@", "*")) for code in codes]
    names = {symbol.replace(".", "_"): symbol for symbol in system.symbols}
    written = [" + ".join(_named(term, names) for term in text.split(" + ")) for text in texts]
    back = LinearSystem.of(*written, white=system.white, width=12)
    columns = [back.interactions.index(i) for i in system.interactions]
    np.testing.assert_array_equal(back.G.toarray()[:, columns], system.G.toarray())


def _window(found):
    return str(SpectralWindow(*map(float, found.groups())))


def _named(term, names):
    """A term of Python code with symbols by their own names; ``0`` is no light at all."""
    if term == "0":
        return "0*sun*none.diffuse"
    factors = [factor.partition("**") for factor in term.replace("**", "^").split("*")]
    return "*".join(names.get(f[0].partition("^")[0], f[0].partition("^")[0]) + _power(f[0]) for f in factors)


def _power(factor):
    return f"**{factor.partition('^')[2]}" if "^" in factor else ""


@pytest.mark.parametrize(
    ("text", "terms"),
    [
        ("sun", [(1.0, ("sun",))]),
        ("-1e-3*sun * a.b**2", [(-1e-3, ("sun", "a.b", "a.b"))]),
        ("- -.5*2*sun+sky", [(1.0, ("sun",)), (1.0, ("sky",))]),
        ("sun*sea>ice.diffuse", [(1.0, ("sun", "sea>ice.diffuse"))]),
    ],
)
def test_a_sum_of_products_is_read(text, terms):
    assert written_terms(text) == terms


@pytest.mark.parametrize(
    "text",
    [
        *("", " ", "sun**0", "sun**1.5", "sun**99999", "sun*", "*sun", "sun sky", "sun+", "(sun)", "sun/2"),
        *("__import__('os')", "a.b.c", "1e999x", "sun*\x1b[2J"),
    ],
)
def test_what_is_no_such_sum_is_refused(text):
    with pytest.raises(ValueError, match="write a sum of terms such as") as caught:
        LinearSystem.of(text)
    assert str(caught.value).isprintable()


@pytest.mark.parametrize(("text", "lights"), [("0.5*sea.diffuse", 0), ("sun*sky", 2), ("sun**2", 2)])
def test_a_term_has_exactly_one_light(text, lights):
    with pytest.raises(ValueError, match=f"{lights} lights in a term"):
        LinearSystem.of(text)


def test_a_system_of_several_rows_is_counted_from_the_top():
    system = LinearSystem.of(*(f"{k}*sun*sea.diffuse" for k in range(1, 7)), width=3, white={"sun": 0.5})
    assert (system.height, system.width, system.white) == (2, 3, {"sun": 0.5})
    assert rt.formula(system, x=1, y=1).text() == "5*sun*sea.diffuse"
    with pytest.raises(ValueError, match="were named"):
        LinearSystem.of("sun", "sun", "sun", width=2)


@pytest.mark.parametrize("exponent", [10.0, 33.3, 80.0])
def test_a_parameter_that_is_settled_gives_the_picture_that_it_gives_free(exponent):
    scene = small("first", 16)
    free = rt.collapse(rt.trace(scene), free={"red.exponent": (10, 80)})
    settled = free.at({"red.exponent": exponent})
    assert not settled.parameters
    assert not any(interaction.nodes for interaction in settled.interactions)
    palette = rt.load_palettes("first")["plain"]
    # But for coefficients that the nodes take below 0, by no more than they are told to err: they are 0.
    shown = rt.shade(free, palette, parameters={"red.exponent": exponent}).values
    raised = rt.shade(settled, palette).values - shown
    most = free.parameters["red.exponent"].error * palette["sun"] * palette["red.specular"]
    assert settled.G.data.min() >= 0
    np.testing.assert_array_less(-1e-12 * shown.max(), raised)
    np.testing.assert_array_less(raised, most + 1e-12 * shown)
    assert (np.abs(raised) <= 1e-12 * np.abs(shown)).mean() > 0.9
    # Against the exponent given before the collapse: the nodes' own error, 1e-6 of a lobe of (s + 2)/2π.
    exact = rt.collapse(rt.trace(scene), values={"red.exponent": exponent})
    assert np.abs(settled.G.toarray() - exact.G.toarray()).max() <= 1e-6 * (80 + 2) / (2 * np.pi)
    for wrong in ({"red.exponent": 5.0}, {"red.shine": 1.0}):
        with pytest.raises(ValueError, match=r"collapsed for|not a free parameter"):
            free.at(wrong)


def test_rows_are_a_picture_of_their_own_with_their_tail():
    system = rt.render(small("spheres", 16), progress=False)
    chosen = np.array([200, 3, 120])
    part = system.rows(chosen)
    np.testing.assert_array_equal(part.G.toarray(), system.G.toarray()[chosen])
    np.testing.assert_array_equal(part.tail.bound.toarray(), system.tail.bound.toarray()[chosen])
    assert (part.height, part.width) == (1, 3)
    assert part.interactions == system.interactions
    assert isinstance(part.interactions[0], Interaction)
