"""A share of the pixels left outside: within the budget, never worse than none, exact where that can be known."""

from functools import partial

import numpy as np
import pytest
from feedback.synthetic import BANDS, MATTE, awkward, palette, system
from scipy import sparse

from symrt.device.inks import load_device
from symrt.feedback import Scale, feasible
from symrt.feedback.joint import fits
from symrt.gamut.gamuts import device_gamut
from symrt.interactions import Interaction
from symrt.spectra.display import luminance_weights
from symrt.spectra.palette import Palette
from symrt.spectra.products import gamma
from symrt.spectra.reference import Reference
from symrt.system import LinearSystem

DEVICE = load_device("dye3-endura-premier")
UNIT, ENVELOPE = device_gamut(DEVICE, "unit"), device_gamut(DEVICE, "envelope")
MIRRORED, COLOURS = system(), palette().replace(key=palette()["key"] * 1.8)
MATERIALS = [Scale(name) for name in (*MATTE, "brass")]
FEW = [Scale("key"), Scale("fill"), Scale("brass"), Scale("ice")]
GOALS = ["lightest", "closest", "lexicographic", "brightest", "contrast"]
OBJECTS = np.flatnonzero(MIRRORED.object_pixels)
fit = partial(fits.fit, objective="lightest")


def reflected(image, values, colours=COLOURS):
    """Reflectances of the object pixels, with the products of scales multiplied out."""
    products = gamma(image.interactions, colours) / Reference().white(image, colours)
    factors = [
        np.prod([values.get(n, values.get(n.partition(".")[0], 1.0)) for n in (i.light, *i.met)])
        for i in image.interactions
    ]
    return (image.G[image.object_pixels].toarray() * factors) @ products


def outside(values, upper=ENVELOPE.upper):
    return OBJECTS[(reflected(MIRRORED, values) > upper).any(axis=1)]


def merit(goal, found):
    """What the objective wants large, computed from the scales alone."""
    values = np.array(list(found.values.values()))
    if goal == "lightest":
        return values.min()
    if goal == "closest":
        return -np.sum(np.log(values) ** 2)
    if goal == "lexicographic":
        return min(1.0, values.min())
    white = luminance_weights(BANDS) * Reference().white(MIRRORED, COLOURS)
    light = reflected(MIRRORED, found.values) @ (white / white.sum())
    if goal == "brightest":
        return light.mean()
    given = reflected(MIRRORED, {}) @ (white / white.sum())
    low, high = np.percentile(given, (5, 95))
    return light[given >= high].mean() / light[given <= low].mean()


@pytest.mark.parametrize(
    ("goal", "share"),
    [*((goal, share) for goal in GOALS[:3] for share in (0.004, 0.2)), *((g, 0.03) for g in GOALS[3:])],
)
def test_exactly_the_pixels_named_are_outside_and_it_is_never_worse_than_with_none(goal, share):
    options = {"objective": goal, "cap": False, "least_luminance": 0}
    found = fit(MIRRORED, COLOURS, ENVELOPE, FEW, allowed_out=share, **options)
    assert np.array_equal(outside({n: v * (1 - 1e-15) for n, v in found.values.items()}), np.sort(found.left_out))
    assert found.verdict == "complete"
    assert found.share_out == len(found.left_out) / len(OBJECTS) <= share
    none = fit(MIRRORED, COLOURS, ENVELOPE, FEW, **options)
    assert merit(goal, found) > merit(goal, none)
    if share == 0.2:
        other = fit(MIRRORED, COLOURS, ENVELOPE, FEW[::-1], allowed_out=share, **options)
        assert (other.values, other.reasons) == (found.values, found.reasons)
    assert f"{len(found.left_out)} of {len(OBJECTS)} object pixels are left outside, as allowed." in repr(found)


@pytest.mark.parametrize("share", [0.0, 0.3])
@pytest.mark.parametrize("name", ["key", "brass", "ice"])
def test_a_single_scale_ends_where_its_range_does(name, share):
    alone = feasible(MIRRORED, COLOURS, ENVELOPE, Scale(name), allowed_out=share, cap=False)
    for goal in GOALS[:4]:
        found = fit(
            MIRRORED,
            COLOURS,
            ENVELOPE,
            [Scale(name)],
            objective=goal,
            allowed_out=share,
            cap=False,
            least_luminance=0,
        )
        most = alone.high if goal in ("lightest", "brightest") else min(1.0, alone.high)
        assert found.values[name] == pytest.approx(most, rel=1e-11)
        assert found.verdict == alone.verdict
        # Brass sees itself, and its mean luminance is no linear one.
        assert found.optimum == ("local" if (goal, name) == ("brightest", "brass") else "global")


def test_an_image_outside_by_no_more_than_is_allowed_stays_as_it_is():
    out = len(outside({})) / len(OBJECTS)
    for goal in ("closest", "lexicographic"):
        found = fit(MIRRORED, COLOURS, ENVELOPE, MATERIALS, objective=goal, allowed_out=out + 1e-9, cap=False)
        assert set(found.values.values()) == {1.0}
        assert np.array_equal(found.left_out, outside({}))
        assert found.optimum == "global"


def test_pixels_that_no_scale_brings_inside_are_counted_first():
    bright = COLOURS.replace(key=9.0)
    none = fit(MIRRORED, bright, ENVELOPE, [Scale("ice")], cap=False)
    lost = len(none.untouched_outside) + len(none.unfixable)
    assert lost
    less = fit(MIRRORED, bright, ENVELOPE, [Scale("ice")], allowed_out=(lost - 1) / len(OBJECTS), cap=False)
    assert (less.verdict, less.values) == ("rest-only", none.values)
    same = fit(MIRRORED, bright, ENVELOPE, [Scale("ice")], allowed_out=lost / len(OBJECTS), cap=False)
    assert (same.verdict, same.values) == ("complete", none.values)
    more = fit(MIRRORED, bright, ENVELOPE, [Scale("ice")], allowed_out=(lost + 3) / len(OBJECTS), cap=False)
    assert len(more.left_out) == 3
    assert more.values["ice"] > none.values["ice"]


@pytest.mark.parametrize("goal", GOALS)
@pytest.mark.parametrize("seed", [0, 9])
def test_awkward_systems_leave_out_no_more_than_allowed(goal, seed):
    image, colours, materials = awkward(seed)
    options = {"objective": goal, "cap": seed % 2 == 0, "least_luminance": 0, "allowed_out": 0.25}
    try:
        found = fit(image, colours, UNIT, [Scale(m) for m in materials], **options)
    except ValueError as error:
        assert "has no light" in str(error)  # noqa: PT017 -- the other seeds have
        return
    out = np.concatenate([found.untouched_outside, found.unfixable, found.left_out])
    kept = ~np.isin(np.flatnonzero(image.object_pixels), out)
    assert not (reflected(image, found.values, colours)[kept] > 1 + 1e-14).any()
    assert len(np.unique(out)) == len(out)
    assert found.verdict == ("complete" if len(out) <= 0.25 * found.objects else "rest-only")


@pytest.mark.parametrize("goal", ["lightest", "lexicographic", "contrast"])
def test_pixels_above_black_stay_so(goal):
    gamut = device_gamut(DEVICE, "envelope", "luminance")
    found = fit(MIRRORED, COLOURS, gamut, FEW, objective=goal, allowed_out=0.03, cap=False)
    light = fit(MIRRORED, COLOURS, gamut, FEW, cap=False)
    white = luminance_weights(BANDS) * Reference().white(MIRRORED, COLOURS)
    white = white / white.sum()

    def above(values):
        return reflected(MIRRORED, values) @ white >= (DEVICE.samples @ white).min()

    assert len(found.left_out) > 0
    assert (above({}) & above(light.values) & ~above(found.values)).sum() == 0
    assert np.isin(outside({n: v * (1 - 1e-15) for n, v in found.values.items()}), found.left_out).all()


def test_a_bound_on_luminance_is_kept_with_pixels_left_out():
    """A white wall of which the lamp shines on one pixel a hundred times: leave that out, and the rest may stay."""
    column = (Interaction("key", ("wall.diffuse",)),)
    image = LinearSystem(sparse.csr_array([[100.0], [1.0], [1.0]]), column, 1, 3, {"key": 1.0})
    colours = Palette(BANDS, {"key": 1.0, "wall.diffuse": 0.8})
    for goal in ("lightest", "closest", "lexicographic", "brightest"):
        found = fit(image, colours, ENVELOPE, [Scale("key")], objective=goal, within=(1e-4, 3), allowed_out=0.34)
        assert (found.verdict, found.left_out.tolist()) == ("complete", [0])
        assert found.luminance >= 0.5


def test_a_share_is_a_share():
    with pytest.raises(ValueError, match="allowed_out = 5"):
        fit(MIRRORED, COLOURS, UNIT, MATERIALS, allowed_out=5)
