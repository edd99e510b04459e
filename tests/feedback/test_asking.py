"""Ranges against gamuts of every model, against the gamuts' own answers on a fine grid of values."""

from fractions import Fraction

import numpy as np
import pytest
from feedback.synthetic import BANDS, palette, system
from scipy import sparse

from symrt.device import load_device
from symrt.feedback import Blend, Exposure, Scale, feasible
from symrt.feedback.along import along
from symrt.feedback.asking import drawn, spans_inside_all
from symrt.feedback.limits import limits
from symrt.feedback.parameters import moved, moved_ends
from symrt.feedback.weighing import Weighed
from symrt.gamut import device_gamut
from symrt.interactions import Interaction
from symrt.spectra.palette import Palette
from symrt.spectra.reference import Reference
from symrt.spectra.shading import shade
from symrt.system import LinearSystem

IMAGE, SMALL, COLOURS = system(height=6, width=6, seed=3), system(height=2, width=4, seed=3), palette(seed=3)
LARGER = system(height=8, width=8, seed=3)
MODELS = ("unit", "envelope", "hull", "inks", "colorimetric", "monitor")
SLOW = {"hull", "inks"}
GAMUTS = {
    m: device_gamut(load_device("crt-brainard" if m == "monitor" else "synthetic-cmyk", BANDS), m) for m in MODELS
}
PARAMETERS = {
    "light": Scale("key"),
    "material": Scale("deep"),
    "mirrors": Scale("brass"),
    "exposure": Exposure(),
    "blend": Blend("deep", "ice"),
}


def seen(image, parameter, t):
    """Reflectances of all pixels at one value, shaded anew."""
    white = Reference().white(image, COLOURS)
    return shade(image, moved(image, COLOURS, parameter, t)).values.reshape(-1, len(BANDS)) / white


def asked(model):
    """A picture to ask about: inks take long."""
    return SMALL if model == "inks" else IMAGE


def lighter_than_black(image, gamut, parameter, now):
    """Object pixels that count: all of a monitor's, and for prints those lighter than their black."""
    objects = np.flatnonzero(image.object_pixels)
    if gamut.model in ("unit", "envelope", "monitor"):
        return objects
    weights = device_gamut(gamut.device, "envelope", "luminance").under(Reference().white(image, COLOURS)).weights
    black = (gamut.device.samples @ weights).min()
    return objects[(seen(image, parameter, now) @ weights)[objects] >= black]


@pytest.mark.parametrize(
    ("model", "name"),
    [
        pytest.param(m, n, marks=[pytest.mark.exhaustive] * (m in SLOW and n in {"light", "material"}))
        for m in MODELS
        for n in PARAMETERS
    ],
)
def test_the_range_is_that_of_the_pixels_that_some_value_brings_inside(model, name):
    """§2.3 of the paper: a parameter's segment is clipped for every pixel, whatever the gamut."""
    image, gamut, parameter = asked(model), GAMUTS[model], PARAMETERS[name]
    now, within = (0.0, (0.0, 1.0)) if name == "blend" else (1.0, (0.05, 2.0))
    found = feasible(image, COLOURS, gamut, parameter, within=within, cap=False, most=10_000, progress=False)
    counted = lighter_than_black(image, gamut, parameter, now)
    assert found.objects == len(counted)
    grid = np.linspace(*within, 40)
    under = gamut.under(Reference().white(image, COLOURS))
    inside = np.array([under.contains(seen(image, parameter, t)[counted]) for t in grid])
    fixable = np.isin(counted, np.concatenate([found.unfixable, found.untouched_outside]), invert=True)
    # A pixel that is inside somewhere on the grid is neither unfixable nor outside untouched.
    assert fixable[inside.any(axis=0)].all()
    expected = inside[:, fixable].all(axis=1)
    ends = np.array(found.intervals).reshape(-1, 2)
    answered = ((ends[:, :1] <= grid) & (grid <= ends[:, 1:])).any(axis=0) if len(ends) else np.zeros(40, dtype=bool)
    sure = np.abs(grid[:, None] - ends.ravel()).min(axis=1, initial=1) > 1e-6
    assert (answered == expected)[sure].all()
    share = 1 - inside.mean(axis=1)
    on_step = np.abs(grid[:, None] - found.curve.values).min(axis=1, initial=1) < 1e-6
    np.testing.assert_allclose(found.curve.outside(grid)[~on_step], share[~on_step], atol=1e-12)


@pytest.mark.parametrize("model", ["hull", "inks", "colorimetric"])
def test_beyond_an_end_the_pixel_named_is_outside(model):
    image, gamut = asked(model), GAMUTS[model]
    found = feasible(image, COLOURS, gamut, Scale("key"), allowed_out=0.6, cap=False, most=10_000, progress=False)
    assert found.intervals
    for (low, high), (below, above) in zip(found.intervals, found.reasons, strict=True):
        for t, why, beyond in ((low, below, 0.998), (high, above, 1.002)):
            if why.side == "range":
                continue
            pixel = why.y * image.width + why.x
            assert gamut.contains(seen(image, Scale("key"), t)[[pixel]])[0]
            assert not gamut.contains(seen(image, Scale("key"), t * beyond)[[pixel]])[0]
            assert why.of
            assert (why.band is None) == (model == "colorimetric")


def test_pixels_extreme_in_a_band_are_asked_wherever_they_are():
    """More pixels are extreme in some direction than are asked about: the last rows count as much as the first."""
    random, materials = np.random.default_rng(4), [f"m{k}" for k in range(12)]
    columns = tuple(Interaction("sun", (f"{m}.diffuse",)) for m in sorted(materials))
    coefficients = random.uniform(0, 0.1, (3000, 12))
    coefficients[-3:, 4:7] = 5 * np.eye(3)
    image = LinearSystem(sparse.csr_array(coefficients), columns, 30, 100, white={"sun": 1.0})
    bumps = {c.met[0]: np.exp(-(((np.arange(36) - 3 * k) / 2.0) ** 2)) for k, c in enumerate(columns)}
    colours = Palette(BANDS, {"sun": 1.0, **bumps})
    line, asked = along(image, colours, Scale("sun")), limits(image, colours, GAMUTS["hull"])
    taken = drawn(line, asked, Weighed(np.arange(3000)), 1.0, most=200, extremes=True).pixels
    assert {2997, 2998, 2999} <= set(taken)
    assert len(taken) <= 200


def test_few_pixels_are_asked_and_it_is_said_which():
    found = feasible(IMAGE, COLOURS, GAMUTS["hull"], Scale("key"), cap=False, most=16, progress=False)
    assert found.objects <= 16
    assert "extreme ones and others drawn evenly" in found.note
    share = feasible(IMAGE, COLOURS, GAMUTS["hull"], Scale("key"), allowed_out=0.5, cap=False, most=16, progress=False)
    assert "pixels, drawn evenly" in share.note


def test_the_least_share_outside_is_named_where_no_value_serves_all():
    found = feasible(IMAGE, COLOURS, GAMUTS["colorimetric"], Scale("brass"), cap=False)
    grid = np.linspace(*found.within, 4000)
    t, share = found.curve.least(found.within)
    assert share <= found.curve.outside(grid).min()
    assert found.curve.outside(np.array([t]))[0] == share


@pytest.mark.parametrize("name", ["light", "mirrors", "blend"])
@pytest.mark.parametrize("model", ["monitor", "colorimetric"])
def test_ends_are_inside_in_exact_rationals_where_weights_have_both_signs(model, name):
    parameter = PARAMETERS[name]
    asked = limits(LARGER, COLOURS, GAMUTS[model])
    bound = asked.solids[0].bound if asked.solids else asked.upper
    found = feasible(LARGER, COLOURS, GAMUTS[model], parameter, allowed_out=0.5, cap=False)
    outside = set(found.untouched_outside.tolist()) | set(found.unfixable.tolist())
    line = along(LARGER, COLOURS, parameter)
    pixels = np.setdiff1d(np.flatnonzero(line.touched & LARGER.object_pixels), sorted(outside))
    spans = spans_inside_all(line, asked, pixels[:10], found.within)
    assert len(spans.pixel) > 3
    for pixel, *ends in zip(pixels[spans.pixel], spans.low, spans.high, strict=True):
        for t in ends:
            moving = moved_ends(LARGER, COLOURS, parameter)
            radiance = exact_pixel(LARGER.G[[pixel]], LARGER.interactions, moving, Fraction(float(t)))
            for column, a, b in zip(bound.matrix.T, bound.lower, bound.upper, strict=True):
                value = sum(Fraction(float(w)) * r for w, r in zip(column, radiance, strict=True))
                assert a == -np.inf or value >= Fraction(float(a))
                assert b == np.inf or value <= Fraction(float(b))


def exact_pixel(row, interactions, moving, t):
    """A pixel's radiance in rationals: the products of the spectra, summed with the coefficients."""
    total = [Fraction(0)] * len(BANDS)
    for column, g in zip(row.indices, row.data, strict=True):
        names = (interactions[column].light, *interactions[column].met)
        for band in range(len(BANDS)):
            product = Fraction(float(g))
            for symbol in names:
                first, last = moving.get(symbol, (COLOURS[symbol], COLOURS[symbol]))
                product *= (1 - t) * Fraction(float(first[band])) + t * Fraction(float(last[band]))
            total[band] += product
    return total
