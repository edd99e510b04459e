"""Blends of paints: Kubelka and Munk's mixtures against 50 digits, their feasible values against dense shading."""

from dataclasses import replace

import mpmath
import numpy as np
import pytest
from feedback.synthetic import BANDS, palette, system
from scipy import sparse

import symrt as rt
from symrt.device.inks import load_device
from symrt.feedback.along import along
from symrt.feedback.intervals import intervals
from symrt.feedback.limits import limits
from symrt.feedback.lines import line_of
from symrt.feedback.mixing import absorption, mixed, painted, reflected, slopes
from symrt.feedback.parameters import Blend, moved
from symrt.feedback.ranges import feasible
from symrt.gamut.gamuts import device_gamut
from symrt.gamut.hull import hull_gamut
from symrt.interactions import Interaction
from symrt.spectra.display import luminance_weights
from symrt.spectra.palette import Palette
from symrt.spectra.reference import Reference
from symrt.spectra.shading import shade
from symrt.system import LinearSystem

DEVICE = load_device("dye3-endura-premier")
UNIT, ENVELOPE = device_gamut(DEVICE, "unit"), device_gamut(DEVICE, "envelope")
STRICT = device_gamut(DEVICE, "envelope", "strict")
KM = "kubelka-munk"


def exact(first, last, t):
    """The mixture to 50 digits and more, by the textbook's formula, which cancels where a paint is nearly black."""
    with mpmath.workdps(150):
        a, b, t = (mpmath.mpf(float(v)) for v in (first, last, t))
        q = (1 - t) * (1 - a) ** 2 / (2 * a) + t * (1 - b) ** 2 / (2 * b)
        return 1 + q - mpmath.sqrt(q * q + 2 * q)


def test_mixtures_are_those_of_fifty_digits():
    random = np.random.default_rng(0)
    first, last = random.uniform(1e-6, 1, 200), 10 ** random.uniform(-9, 0, 200)
    first[:20], last[20:40], first[40:60] = 1.0, 1 - 1e-12, 1e-30
    for t in (0.0, 1e-9, 0.3, 0.999, 1 - 1e-13, 1.0):
        found = mixed(first, last, t, KM)
        truth = np.array([float(exact(a, b, t)) for a, b in zip(first, last, strict=True)])
        np.testing.assert_allclose(found, truth, rtol=16 * 2.0**-53)


def test_a_mixture_ends_at_its_paints_to_the_last_bit_and_is_darker_than_the_line_between():
    random = np.random.default_rng(1)
    first, last = random.uniform(0.01, 1, 50), random.uniform(0.01, 1, 50)
    assert np.array_equal(mixed(first, last, 0.0, KM), first)
    assert np.array_equal(mixed(first, last, 1.0, KM), last)
    assert np.array_equal(mixed(first, first, 0.3, KM), first)
    steps = painted(first, last, np.linspace(0, 1, 101))
    assert (np.diff(steps, axis=0) * np.sign(last - first) > 0).all()
    for t in (0.1, 0.5, 0.9):
        assert (mixed(first, last, t, KM) < mixed(first, last, t)).all()


def test_white_and_black_have_mixtures_only_with_what_allows_them():
    assert mixed(np.ones(2), np.ones(2), 0.4, KM).tolist() == [1.0, 1.0]
    assert mixed(np.zeros(2), np.zeros(2), 0.4, KM).tolist() == [0.0, 0.0]
    with pytest.raises(ValueError, match="reflects nothing where the other does"):
        mixed(np.array([0.5, 0.0]), np.array([0.5, 0.2]), 0.4, KM)
    with pytest.raises(ValueError, match="reflects nothing"):
        mixed(np.array([1e-200]), np.array([0.5]), 0.4, KM)
    with pytest.raises(ValueError, match="more than it receives"):
        mixed(np.array([1.5]), np.array([0.5]), 0.4, KM)


def test_absorption_and_reflectance_undo_each_other():
    r = np.linspace(0.001, 1, 300)
    np.testing.assert_allclose(reflected(absorption(r)), r, rtol=1e-14)


@pytest.mark.parametrize("t", [0.0, 0.2, 0.9, 1.0])
def test_slopes_are_differences(t):
    random = np.random.default_rng(2)
    first, last = random.uniform(0.05, 0.95, 30), random.uniform(0.05, 0.95, 30)
    first[0] = last[0]
    by_t, by_first, by_last = slopes(first, last, t, KM)
    with mpmath.workdps(50):
        h = mpmath.mpf(10) ** -20
        for k, (a, b) in enumerate(zip(first.tolist(), last.tolist(), strict=True)):

            def value(factor_a=1, factor_b=1, dt=0, a=a, b=b):
                a, b, s = factor_a * mpmath.mpf(a), factor_b * mpmath.mpf(b), mpmath.mpf(t) + dt
                q = (1 - s) * (1 - a) ** 2 / (2 * a) + s * (1 - b) ** 2 / (2 * b)
                return 1 + q - mpmath.sqrt(q * q + 2 * q)

            for found, up, down in (
                (by_t[k], value(dt=h), value(dt=-h)),
                (by_first[k], value(factor_a=1 + h), value(factor_a=1 - h)),
                (by_last[k], value(factor_b=1 + h), value(factor_b=1 - h)),
            ):
                assert found == pytest.approx(float((up - down) / (2 * h)), rel=1e-9, abs=1e-12)


def scene(seed, mirrors=True, signed=False):
    """Pixels of a, of b, and of c, some seeing a twice or through a mirror."""
    random = np.random.default_rng(seed)
    names = [(light, (f"{m}.diffuse",)) for light in ("fill", "key") for m in "abc"]
    if mirrors:
        names += [("key", ("a.diffuse", "a.mirror")), ("key", ("a.mirror", "c.diffuse")), ("key", ("a.mirror",))]
        names += [("key", ("a.diffuse", "a.diffuse", "a.mirror"))]
    columns = tuple(sorted(Interaction(light, tuple(sorted(met))) for light, met in names))
    shape = (60, len(columns))
    weights = random.uniform(0, 1.5, shape) * (random.uniform(size=shape) < 0.3)
    if signed:
        weights *= np.where(random.uniform(size=shape) < 0.15, -0.2, 1)
    image = LinearSystem(sparse.csr_array(weights), columns, 6, 10, {"key": 0.5, "fill": 0.5})
    symbols = [f"{m}.diffuse" for m in "abc"] + ["a.mirror", "b.mirror"] * mirrors
    nm = np.array(BANDS.centres)

    def smooth():
        low, high = random.uniform(0.02, 1, 2)
        return low + (high - low) * np.exp(-(((nm - random.uniform(400, 700)) / random.uniform(40, 150)) ** 2))

    return image, Palette(BANDS, {"key": 2.0, "fill": 0.7} | {name: smooth() for name in symbols})


def textbook(image, colours, t):
    """Reflectances with a's spectra mixed by the textbook's formula, not by symrt's."""
    spectra = dict(colours.spectra)
    for name in [s for s in colours if s.startswith("a.")]:
        a, b = colours[name], colours["b" + name[1:]]
        q = (1 - t) * (1 - a) ** 2 / (2 * a) + t * (1 - b) ** 2 / (2 * b)
        spectra[name] = 1 + q - np.sqrt(q * q + 2 * q)
    shaded = shade(image, Palette(BANDS, spectra, unphysical=True)).values.reshape(-1, 36)
    return (shaded / Reference().white(image, colours))[image.object_pixels]


def outside(gamut, spectra, slack=0.0):
    """With black clipped, nothing is too dark."""
    return (spectra > gamut.upper * (1 + slack)).any(axis=1)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("kind", ["matte", "mirrors", "signed"])
@pytest.mark.parametrize("share", [0.0, 0.15])
def test_feasible_values_of_a_blend_of_paints_are_those_of_dense_shading(seed, kind, share):
    image, colours = scene(seed, mirrors=kind != "matte", signed=kind == "signed")
    found = feasible(image, colours, ENVELOPE, Blend("a", "b", KM), allowed_out=share)
    objects = np.flatnonzero(image.object_pixels)
    kept = ~np.isin(objects, np.concatenate([found.untouched_outside, found.unfixable]))
    for t in np.linspace(0, 1, 101):
        spectra = textbook(image, colours, t)
        out, near = outside(ENVELOPE, spectra, 1e-9), outside(ENVELOPE, spectra, -1e-9)
        assert out.mean() - 1e-12 <= found.curve.outside(np.array([t]))[0] <= near.mean() + 1e-12
        held = any(low <= t <= high for low, high in found.intervals)
        if share == 0 and held != (not near[kept].any()):
            assert near[kept].any() != out[kept].any()  # a pixel on its bound
    for t in np.ravel(found.intervals):
        assert not outside(ENVELOPE, textbook(image, colours, t)[kept], 1e-15).any() or share > 0
        # What is shaded with the palette moved is what was answered for.
        shaded = shade(image, moved(image, colours, Blend("a", "b", KM), t)).values.reshape(-1, 36)
        np.testing.assert_allclose(
            (shaded / Reference().white(image, colours))[objects], textbook(image, colours, t), rtol=1e-9, atol=1e-12
        )


def test_ends_are_where_the_named_pixel_meets_the_named_band_to_fifty_digits():
    met = 0
    for seed in range(12):
        image, colours = scene(seed, mirrors=seed % 2 == 0)
        found = feasible(image, colours, ENVELOPE, Blend("a", "b", KM), allowed_out=0.3)
        for ends, reasons in zip(found.intervals, found.reasons, strict=True):
            for t, why in zip(ends, reasons, strict=True):
                if why.side == "range":
                    continue
                band, row = BANDS.labels.index(why.band), image.G[[why.y * 10 + why.x]]
                with mpmath.workdps(50):
                    value = mpmath.mpf(0)
                    for column, g in zip(row.indices, row.data.tolist(), strict=True):
                        term = mpmath.mpf(g)
                        for name in (image.interactions[column].light, *image.interactions[column].met):
                            other = "b" + name[1:]
                            moving = name.startswith("a.")
                            term *= (
                                exact(colours[name][band], colours[other][band], t)
                                if moving
                                else float(colours[name][band])
                            )
                        value += term
                    room = ENVELOPE.upper[band] - value / float(Reference().white(image, colours)[band])
                assert 0 <= room < 1e-9  # certainly inside, and as near as the range is halved
                met += 1
    assert met > 5


@pytest.mark.parametrize("seed", [3, 4])
def test_lower_bounds_hold_for_all_but_the_share_allowed_that_were_above_black(seed):
    image, colours = scene(seed)
    found = feasible(image, colours, STRICT, Blend("a", "b", KM), allowed_out=0.2, allowed_dark=0.1)
    lit = (textbook(image, colours, 0.0) >= STRICT.lower).all(axis=1)
    for t in np.ravel(found.intervals):
        fallen = (textbook(image, colours, t)[lit] < STRICT.lower * (1 - 1e-12)).any(axis=1)
        assert fallen.mean() <= 0.1
    assert found.intervals


@pytest.mark.parametrize("seed", [3, 4, 5])
def test_bounds_of_several_bands_at_once_are_those_of_dense_shading(seed):
    image, colours = scene(seed)
    monitor = rt.device_gamut(rt.load_device("crt-brainard").on(BANDS), "monitor")
    bound = limits(image, colours, monitor).upper
    line = line_of(image, colours, Blend("a", "b", KM))
    rows = np.flatnonzero(line.touched)
    spans = intervals(line.seen(bound.matrix, rows), bound, (0.0, 1.0))
    white, objects = Reference().white(image, colours), np.flatnonzero(image.object_pixels)
    seen = 0
    for t in np.linspace(0, 1, 64):
        drive = (textbook(image, colours, t) * white)[np.isin(objects, rows)] @ bound.matrix
        room = np.minimum(drive - bound.lower, bound.upper - drive).min(axis=1)
        held = np.isin(np.arange(len(rows)), spans.pixel[(spans.low <= t) & (t <= spans.high)])
        assert np.array_equal(held[abs(room) > 1e-8], (room > 0)[abs(room) > 1e-8])
        seen += held.sum()
    assert 64 < seen < 64 * len(rows)


def test_a_hull_of_prints_is_asked_along_paints_too():
    image, colours = scene(4)
    hull = hull_gamut(DEVICE)
    found = feasible(image, colours, hull, Blend("a", "b", KM), allowed_out=0.9)
    seen = textbook(image, colours, 0.0) @ (luminance_weights(BANDS) * Reference().white(image, colours))
    asked = seen >= (DEVICE.samples @ (luminance_weights(BANDS) * Reference().white(image, colours))).min()
    assert found.objects == asked.sum()
    for t in (0.0, 0.37, 1.0):
        inside = hull.contains(textbook(image, colours, t)[asked])
        assert found.curve.outside(np.array([t]))[0] == pytest.approx(1 - inside.mean(), abs=1e-12)


def test_a_product_of_paints_can_be_feasible_in_several_intervals():
    columns = (Interaction("key", ("a.diffuse", "a.mirror")),)
    image = LinearSystem(sparse.csr_array([[1.0]]), columns, 1, 1, {"key": 1.0})
    colours = Palette(BANDS, {"key": 1.0, "a.diffuse": 1.0, "a.mirror": 0.1, "b.diffuse": 0.1, "b.mirror": 1.0})

    def product(t):
        return exact(1.0, 0.1, t) * exact(0.1, 1.0, t)

    level = float(product(0.5)) * 1.05
    low = replace(UNIT, upper=np.full(36, level))
    found = feasible(image, colours, low, Blend("a", "b", KM))
    # By the symmetry of the two, what is kept is symmetrical as well: here a dip, in one piece around the middle.
    assert found.intervals[0][0] == pytest.approx(1 - found.intervals[-1][1], abs=1e-9)
    for t in np.linspace(0, 1, 201):
        held = any(low <= t <= high for low, high in found.intervals)
        assert held == (float(product(t)) <= level) or abs(float(product(t)) - level) < 1e-9
    # A third factor that rises and falls: bounded from below instead, the same product leaves two intervals.
    thin = replace(UNIT, lower=np.full(36, level), black="strict")
    both = feasible(image, colours, thin, Blend("a", "b", KM))
    assert len(both.intervals) == 2
    assert both.intervals[0][1] == pytest.approx(found.intervals[0][0], abs=1e-9)


def test_paints_of_one_component_are_solved_and_not_halved():
    """The closed form is as good as rounding, far better than the width at which halving ends."""
    columns = (Interaction("key", ("a.diffuse",)),)
    image = LinearSystem(sparse.csr_array([[0.5]]), columns, 1, 1, {"key": 0.5})
    colours = Palette(BANDS, {"key": 2.0, "a.diffuse": 0.3, "b.diffuse": 0.95})
    found = feasible(image, colours, replace(UNIT, upper=np.full(36, 0.6)), Blend("a", "b", KM))
    with mpmath.workdps(50):
        q = [(1 - mpmath.mpf(r)) ** 2 / (2 * mpmath.mpf(r)) for r in (0.6, 0.3, 0.95)]
        root = float((q[0] - q[1]) / (q[2] - q[1]))
    assert found.high == pytest.approx(root, rel=1e-13)
    assert found.high <= root


def test_limits_of_a_blend_of_paints_move_as_differences_say():
    image, colours = scene(5)
    white = Reference("key")
    found = feasible(image, colours, ENVELOPE, Blend("a", "b", KM), allowed_out=0.3, reference=white)
    compared = 0
    for name, symbols in {
        "fill": ["fill"],
        "c": ["c.diffuse"],
        "a": ["a.diffuse", "a.mirror"],
        "b": ["b.diffuse", "b.mirror"],
    }.items():
        ends = [
            feasible(
                image,
                colours.replace({s: colours[s] * factor for s in symbols}),
                ENVELOPE,
                Blend("a", "b", KM),
                allowed_out=0.3,
                reference=white,
            ).intervals
            for factor in (
                np.exp(-1e-4),
                np.exp(1e-4),
            )
        ]
        change = (np.array(ends[1]) - np.array(ends[0])) / 2e-4
        for sides, row in zip(found.sensitivities, change, strict=True):
            for side, value in zip(sides, row, strict=True):
                if side:
                    assert {one.name: one.change for one in side}.get(name, 0.0) == pytest.approx(
                        value, rel=1e-4, abs=2e-6
                    )
                    compared += 1
    assert compared >= 4


def test_untouched_pixels_and_pixels_of_another_material_are_as_before():
    image, colours = system(), palette()
    linear = feasible(image, colours, ENVELOPE, Blend("deep", "ice"), allowed_out=0.1)
    paint = feasible(image, colours, ENVELOPE, Blend("deep", "ice", KM), allowed_out=0.1)
    assert np.array_equal(linear.untouched_outside, paint.untouched_outside)
    assert linear.objects == paint.objects
    assert str(paint.parameter) == "blend from deep to ice, mixed as paints"
    bound = limits(image, colours, ENVELOPE).upper
    rows = np.flatnonzero(image.object_pixels)
    for t in (0.0, 1.0):
        np.testing.assert_allclose(
            line_of(image, colours, Blend("deep", "ice", KM)).seen(bound.matrix, rows).at(t),
            line_of(image, colours, Blend("deep", "ice")).seen(bound.matrix, rows).at(t),
            rtol=1e-13,
            atol=1e-300,
        )


def test_what_cannot_be_mixed_as_paints_is_refused_in_one_line():
    image, colours = scene(0)
    with pytest.raises(ValueError, match=r"mixing = 'paint': there are 'linear' and 'kubelka-munk'"):
        Blend("a", "b", "paint")
    with pytest.raises(ValueError, match=r"a.diffuse: one of two paints reflects nothing"):
        feasible(image, colours.replace({"a.diffuse": 0.0}), UNIT, Blend("a", "b", KM))
    with pytest.raises(ValueError, match="only a 'linear' blend joins them"):
        feasible(image, colours, UNIT, Blend("a", "c", KM))
    with pytest.raises(ValueError, match="makes no polynomials"):
        along(image, colours, Blend("a", "b", KM))


def test_a_blend_of_paints_that_are_alike_touches_nothing():
    image, colours = system(), palette()
    alike = colours.replace({"ice.diffuse": colours["deep.diffuse"]})
    found, linear = (feasible(image, alike, ENVELOPE, Blend("deep", "ice", how)) for how in (KM, "linear"))
    assert found.intervals == linear.intervals == ((0.0, 1.0),)
    assert np.array_equal(found.untouched_outside, linear.untouched_outside)
    assert found.verdict == linear.verdict
