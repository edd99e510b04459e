"""The physical cap: no surface reflects more than it receives."""

import numpy as np
import pytest

from symrt.feedback.caps import above_one, physical_cap
from symrt.spectra.bands import RGB
from symrt.spectra.palette import Palette

BRASS = Palette(RGB, {"brass.diffuse": [0.4, 0.3, 0.1], "brass.specular": [0.2, 0.2, 0.2], "brass.f0": [0.5, 0.6, 0.9]})


@pytest.mark.parametrize(
    ("moved", "value", "symbol", "band"),
    [
        (("brass.diffuse", "brass.specular"), 1 / 0.6, "brass", "red"),
        (("brass.diffuse",), 2.0, "brass", "red"),
        (("brass.specular",), 3.0, "brass", "red"),
        (("brass.diffuse", "brass.specular", "brass.f0"), 1 / 0.9, "brass.f0", "blue"),
        (("key",), np.inf, "", ""),
    ],
)
def test_the_cap_is_where_a_sum_of_components_reaches_one(moved, value, symbol, band):
    found = physical_cap(BRASS, moved)
    assert found.value == pytest.approx(value, rel=1e-14)
    assert (found.symbol, found.band) == (symbol, band)


def test_at_the_cap_nothing_is_above_one_and_beyond_it_something_is():
    random = np.random.default_rng(0)
    for _ in range(50):
        spectra = {f"m.{c}": random.uniform(0, 0.3, 3) for c in ("diffuse", "specular", "mirror")}
        moved = [name for name in spectra if random.uniform() < 0.6] or ["m.diffuse"]
        value = physical_cap(Palette(RGB, spectra), moved).value
        for factor, above in ((1.0, ()), (1 + 1e-12, ("m",))):
            scaled = {n: s * (value * factor if n in moved else 1) for n, s in spectra.items()}
            assert above_one(Palette(RGB, scaled, unphysical=True)) == above


def test_a_palette_that_is_unphysical_already_leaves_no_room():
    bright = Palette(RGB, {"brass.diffuse": 0.9, "brass.specular": 0.4})
    assert above_one(bright) == ("brass",)
    assert physical_cap(bright, ("brass.diffuse", "brass.specular")).value == pytest.approx(1 / 1.3)


def test_a_material_that_is_full_and_moves_in_other_bands_leaves_its_room_there():
    # In green nothing moves and nothing is left: 0 / 0 asks for nothing, and warns of nothing.
    brass = Palette(RGB, {"brass.diffuse": [0.5, 0.0, 0.2], "brass.specular": [0.2, 1.0, 0.2]})
    found = physical_cap(brass, ("brass.diffuse",))
    assert (found.value, found.band) == (pytest.approx(1.6, rel=1e-14), "red")


@pytest.mark.parametrize("white", [{"brass.diffuse": 1.0}, {"brass.diffuse": 0.7, "brass.specular": 0.3}])
def test_what_reflects_all_that_it_receives_may_stay_as_it_is(white):
    colours = Palette(RGB, white)
    assert above_one(colours) == ()
    assert physical_cap(colours, tuple(white)).value == 1.0
