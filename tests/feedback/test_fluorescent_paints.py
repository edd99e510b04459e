"""Step 5 where a paint moves light between bands: ranges, fits, blends and reasons agree with images shaded anew."""

import math

import numpy as np
import pytest

import symrt as rt
from symrt.feedback.along import along
from symrt.feedback.caps import physical_cap
from symrt.feedback.parameters import moved
from symrt.feedback.sensitivity import sensitivities

NM = rt.wavelengths(400, 700, 20)
SUN = rt.bell(480, 300, NM)
DYE = rt.Fluorescence(rt.bell(450, 60, NM), rt.bell(580, 60, NM), 0.5)
WORDS = (
    "0.22*sun*poster.diffuse + 0.22*sun*poster.fluorescence",
    "0.2*sun*poster.diffuse + 0.2*sun*poster.fluorescence + 0.1*sun*poster.fluorescence*green.mirror*sheet.diffuse",
    "0.25*sun*sheet.diffuse + 0.05*sun*green.mirror*poster.fluorescence*green.mirror",
    "0.15*sun*sheet.diffuse + 0.1*sun*poster.fluorescence*poster.fluorescence",
)
SYSTEM = rt.LinearSystem.of(*WORDS, white={"sun": 0.3})
PALETTE = rt.Palette(
    NM,
    {
        "sun": SUN,
        "poster.diffuse": rt.bell(620, 120, NM) * 0.4 + 0.05,
        "poster.fluorescence": DYE,
        "green.mirror": rt.bell(540, 90, NM) * 0.8,
        "sheet.diffuse": 0.3,
    },
)
WHITE = rt.Reference("sun").kept(SYSTEM, PALETTE)
GAMUT = rt.device_gamut(rt.load_device("dye3-endura-premier", NM), "envelope")


def inside(palette):
    """Whether each pixel is below the upper bounds of the gamut, and not darker than 0."""
    seen = rt.shade(SYSTEM, palette).values[0] / (0.3 * SUN)
    return (seen <= GAMUT.slabs.upper[GAMUT.slabs.bands.argsort()] * (1 + 1e-12)).all(axis=1)


def first_outside(parameter, high):
    """The value at which some pixel that was inside leaves the gamut, by halving."""
    low = 0.01
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if inside(moved(SYSTEM, PALETTE, parameter, middle)).all() else (low, middle)
    return low


@pytest.mark.parametrize("name", ["poster.fluorescence", "poster", "green", "sun", "sheet"])
def test_feasible_ranges_end_where_an_image_shaded_anew_leaves_the_gamut(name):
    found = rt.feasible(SYSTEM, PALETTE, GAMUT, rt.Scale(name), within=(0.01, 20), cap=False, reference=WHITE)
    ((_, high),) = found.intervals
    assert high == pytest.approx(first_outside(rt.Scale(name), 20.0), rel=1e-9)


def test_a_scale_of_a_matrix_is_a_polynomial_of_the_times_it_is_met():
    line = along(SYSTEM, PALETTE, rt.Scale("poster.fluorescence"))
    assert line.form == "power"
    assert line.degrees.tolist() == [1, 1, 1, 2]
    for t in (0.0, 0.4, 1.7):
        again = rt.shade(SYSTEM, moved(SYSTEM, PALETTE, rt.Scale("poster.fluorescence"), t)).values[0]
        np.testing.assert_allclose(line.at(t), again, rtol=1e-12)


def test_a_blend_of_two_fluorescent_paints_is_shaded_as_it_is():
    other = {
        "rival.diffuse": 0.1,
        "rival.fluorescence": rt.Fluorescence(rt.bell(430, 50, NM), rt.bell(520, 40, NM), 0.7),
    }
    palette, blend = PALETTE.add(other), rt.Blend("poster", "rival")
    line = along(SYSTEM, palette, blend)
    for t in (0.0, 0.3, 1.0):
        again = moved(SYSTEM, palette, blend, t)
        np.testing.assert_allclose(
            again["poster.fluorescence"],
            (1 - t) * palette["poster.fluorescence"] + t * palette["rival.fluorescence"],
            rtol=1e-12,
        )
        np.testing.assert_allclose(line.at(t), rt.shade(SYSTEM, again).values[0], rtol=1e-12)
    found = rt.feasible(SYSTEM, palette, GAMUT, blend, within=(0.0, 1.0))
    assert found.verdict in ("complete", "rest-only")


def test_paints_that_are_stirred_are_refused_where_they_move_light():
    other = {"rival.diffuse": 0.1, "rival.fluorescence": DYE}
    with pytest.raises(ValueError, match=r"poster\.fluorescence: Kubelka.*mix 'linear'"):
        rt.feasible(SYSTEM, PALETTE.add(other), GAMUT, rt.Blend("poster", "rival", mixing="kubelka-munk"))
    # Behind a mixture light moves between bands; in front of one it does no harm.
    behind, before = (
        rt.LinearSystem.of(text, white={"sun": 0.3})
        for text in ("sun*sheet.diffuse*poster.fluorescence", "sun*poster.fluorescence*sheet.diffuse")
    )
    stirred = rt.Blend("sheet", "card", mixing="kubelka-munk")
    palette = PALETTE.add({"card.diffuse": 0.2})
    with pytest.raises(ValueError, match=r"sun\*sheet.diffuse\*poster.fluorescence: .*mix 'linear'"):
        rt.feasible(behind, palette, GAMUT, stirred)
    assert rt.feasible(before, palette, GAMUT, stirred).verdict


def test_the_physical_cap_is_that_of_the_energy_that_leaves():
    palette = PALETTE.replace({"poster.diffuse": 0.4})
    found = physical_cap(palette, ("poster.fluorescence",))
    # Most is taken in at 460 nm, next to the peak of 450: 0.5 of it, where 0.6 is left.
    assert (found.symbol, found.band) == ("poster", "440 nm")
    assert found.value == pytest.approx(0.6 / (0.5 * 2 ** -((10 / 30) ** 2)), rel=1e-12)
    more = moved(SYSTEM, palette, rt.Scale("poster.fluorescence"), 1.01 * found.value)
    assert more.unphysical
    assert not moved(SYSTEM, palette, rt.Scale("poster.fluorescence"), 0.99 * found.value).unphysical


@pytest.mark.parametrize("pixel", range(4))
def test_sensitivities_are_those_of_differences(pixel):
    slab = np.linspace(1, 2, len(NM))
    parameter, t = rt.Scale("green" if pixel in (1, 2) else "poster.fluorescence"), 0.8

    def seen(palette, value):
        return float(rt.shade(SYSTEM, moved(SYSTEM, palette, parameter, value)).values[0, pixel] @ slab)

    small, found = 1e-4, {}
    for name in ("sun", "poster", "green", "sheet"):
        more, less = (moved(SYSTEM, PALETTE, rt.Scale(name), 1 + s) for s in (small, -small))
        by_s = (seen(more, t) - seen(less, t)) / (2 * small)
        by_t = (seen(PALETTE, t + small) - seen(PALETTE, t - small)) / (2 * small)
        found[name] = -by_s / (t * by_t)
    told = {s.name: s.change for s in sensitivities(SYSTEM, PALETTE, parameter, t, pixel, slab)}
    for name, change in told.items():
        if name in found:
            assert change == pytest.approx(found[name], rel=1e-6)
    assert set(told) >= {"sun"}


@pytest.mark.parametrize("objective", ["lightest", "closest", "brightest"])
def test_a_fit_of_fluorescent_paints_is_inside_and_cannot_rise(objective):
    scales = [rt.Scale("poster"), rt.Scale("sheet")]
    found = rt.fit(SYSTEM, PALETTE, GAMUT, scales, within=(0.01, 20), objective=objective, cap=False, reference=WHITE)
    assert inside(found.palette).all()
    assert found.palette.fluorescent == ("poster.fluorescence",)
    if objective == "lightest":
        for scale in scales:
            assert not inside(moved(SYSTEM, found.palette, scale, 1.001)).all()
    again = rt.shade(SYSTEM, found.palette).values
    assert np.isfinite(again).all()


def test_safe_boxes_and_reports_answer():
    box = rt.safe_box(
        SYSTEM, PALETTE, GAMUT, [rt.Scale("poster"), rt.Scale("sheet")], within=(0.01, 10), reference=WHITE
    )
    corner = PALETTE
    for name, (_, high) in box.box.items():
        corner = moved(SYSTEM, corner, rt.Scale(name), high)
    assert inside(corner).all()
    brighter = moved(SYSTEM, PALETTE, rt.Scale("poster"), 1.5)
    (told,) = rt.report(SYSTEM, brighter, [GAMUT], reference=WHITE).verdicts
    assert 0 < told.inside < 1
    assert told.inside == GAMUT.contains(rt.shade(SYSTEM, brighter).values[0] / (0.3 * SUN)).mean()


def test_a_region_keeps_the_order_of_what_it_renames():
    parted = rt.split(SYSTEM, "poster", np.array([[False, True, False, True]]), "aaa")
    texts = [str(i) for i in parted.interactions]
    assert "sun*aaa.fluorescence*green.mirror*sheet.diffuse" in texts
    assert "sun*green.mirror*poster.fluorescence*green.mirror" in texts
    palette = rt.with_region(PALETTE, "poster", "aaa")
    np.testing.assert_allclose(rt.shade(parted, palette).values, rt.shade(SYSTEM, PALETTE).values, rtol=1e-12)
    assert math.isfinite(rt.shade(parted, palette).values.max())
