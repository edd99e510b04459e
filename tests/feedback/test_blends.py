"""Linear blends of degree 2 to 4, feasible in several intervals, against 50-digit roots, rationals and counting."""

from fractions import Fraction
from itertools import pairwise

import mpmath
import numpy as np
import pytest
from feedback.synthetic import BANDS
from scipy import sparse

from symrt.device.inks import load_device
from symrt.feedback.parameters import Blend, moved
from symrt.feedback.ranges import feasible
from symrt.gamut.gamuts import device_gamut
from symrt.interactions import Interaction
from symrt.spectra.palette import Palette
from symrt.spectra.reference import Reference
from symrt.spectra.shading import shade
from symrt.system import LinearSystem

ENVELOPE = device_gamut(load_device("dye3-endura-premier"), "envelope")
STRICT = device_gamut(load_device("dye3-endura-premier"), "envelope", "strict")
AB = Blend("a", "b")


def scene(degree, pixels, seed, others=()):
    """Pixels that meet a's two components up to `degree` times; one is bright where the other is dark."""
    random = np.random.default_rng(seed)
    mets = [("a.diffuse",) * i + ("a.mirror",) * (k - i) for k in range(1, degree + 1) for i in range(k + 1)]
    columns = tuple(sorted([*(Interaction("key", met) for met in mets), Interaction("key", ("c.diffuse",)), *others]))
    shape = (pixels, len(columns))
    size = np.array([3.0 ** (len(column.met) - 1) for column in columns])
    weights = random.uniform(0, 1, shape) * size * (random.uniform(size=shape) < 0.4)
    # Products of both components are brightest halfway, where neither is dark.
    both = np.array([{"a.diffuse", "a.mirror"} <= set(column.met) for column in columns])
    weights = np.where(both, weights + 0.5, 0.05 * weights)
    image = LinearSystem(sparse.csr_array(weights), columns, 1, pixels, {"key": 0.5})
    nm = (np.array(BANDS.centres) - 380) / 350

    def spectrum(low, high):
        return low + (high - low) * (0.5 + 0.5 * np.sin(random.uniform(0, 6) + random.uniform(0, 6) * nm))

    spectra = {"a.diffuse": spectrum(0.7, 1), "a.mirror": spectrum(0.02, 0.2), "c.diffuse": spectrum(0, 0.2)}
    spectra |= {"b.diffuse": spectrum(0.02, 0.2), "b.mirror": spectrum(0.7, 1)}
    return image, Palette(BANDS, spectra | {"key": 2.0})


def reflectances(image, colours, t, exposure=1.0):
    shaded = shade(image, moved(image, colours, AB, t)).values.reshape(-1, 36)
    return shaded * exposure / Reference().white(image, colours)


def polynomial(image, colours, pixel, band, number=Fraction):
    """A pixel's radiance in one band, exactly, as coefficients of powers of t."""
    row, total = image.G[[pixel]], [number(0)]
    for column, g in zip(row.indices, row.data.tolist(), strict=True):
        term = [number(g)]
        for name in (image.interactions[column].light, *image.interactions[column].met):
            first = number(float(colours[name][band]))
            last = number(float(colours["b" + name[1:]][band])) if name.startswith("a.") else first
            factor = (first, last - first)
            longer = [number(0)] * (len(term) + 1)
            for k, value in enumerate(term):
                longer[k] += value * factor[0]
                longer[k + 1] += value * factor[1]
            term = longer
        total = [
            (total[k] if k < len(total) else number(0)) + (term[k] if k < len(term) else number(0))
            for k in range(max(len(total), len(term)))
        ]
    while len(total) > 1 and not total[-1]:
        total.pop()
    return total


def value(coefficients, t):
    return sum(c * t**k for k, c in enumerate(coefficients))


@pytest.mark.parametrize("degree", [2, 3, 4])
@pytest.mark.parametrize("exposure", [0.5, 3.0])
def test_intervals_of_one_pixel_lie_between_its_roots(degree, exposure):
    several = 0
    for seed in range(3):
        image, colours = scene(degree, 1, seed)
        white = Reference().white(image, colours)
        level = np.quantile([reflectances(image, colours, t).max() for t in np.linspace(0, 1, 41)], 0.4)
        gamut = type(ENVELOPE)(**{**vars(ENVELOPE), "upper": np.full(36, float(level) * exposure)})
        found = feasible(image, colours, gamut, AB, reference=Reference(exposure=exposure))
        bounds = [
            Fraction(u) * Fraction(w) / Fraction(exposure)
            for u, w in zip(gamut.upper.tolist(), white.tolist(), strict=True)
        ]
        lines = [polynomial(image, colours, 0, band) for band in range(36)]
        assert max(len(line) for line in lines) == degree + 1
        with mpmath.workdps(50):
            roots = [mpmath.mpf(0), mpmath.mpf(1)]
            for line, bound in zip(lines, bounds, strict=True):
                shifted = [mpmath.mpf(c.numerator) / c.denominator for c in (line[0] - bound, *line[1:])]
                found_roots = mpmath.polyroots(shifted[::-1], maxsteps=500, extraprec=300)
                roots += [r.real for r in found_roots if abs(r.imag) < 1e-30 and 0 < r.real < 1]
            roots = sorted(roots)
        expected = []
        for low, high in pairwise(roots):
            middle = Fraction(float((low + high) / 2))
            if high - low > 1e-8 and all(value(line, middle) <= b for line, b in zip(lines, bounds, strict=True)):
                joined = expected and expected[-1][1] == low
                expected = [*expected[:-1], (expected[-1][0], high)] if joined else [*expected, (low, high)]
        np.testing.assert_allclose(found.intervals, [[float(v) for v in pair] for pair in expected], atol=1e-9)
        for t in np.ravel(found.intervals).tolist():
            assert all(value(line, Fraction(t)) <= b for line, b in zip(lines, bounds, strict=True))
        several += len(found.intervals) > 1
    assert several


@pytest.mark.parametrize("degree", [2, 3, 4])
@pytest.mark.parametrize("share", [0.0, 0.2, 0.5])
@pytest.mark.parametrize("exposure", [0.3, 1.0])
def test_an_image_is_inside_where_dense_shading_says_so(degree, share, exposure):
    image, colours = scene(degree, 40, seed=degree)
    found = feasible(image, colours, ENVELOPE, AB, allowed_out=share, reference=Reference(exposure=exposure))
    for t in np.linspace(0, 1, 61):
        spectra = reflectances(image, colours, t, exposure)
        most, least = ((spectra > ENVELOPE.upper * (1 + s)).any(axis=1).mean() for s in (-1e-9, 1e-9))
        assert least - 1e-12 <= found.curve.outside(np.array([t]))[0] <= most + 1e-12
        held = any(low <= t <= high for low, high in found.intervals)
        if found.verdict == "complete" and most == least:
            assert held == (least <= share)


@pytest.mark.parametrize("degree", [2, 3, 4])
def test_a_share_allowed_leaves_several_intervals(degree):
    """Dim where a's or b's own spectra rule alone: somewhere in between, or on both sides, enough pixels are inside."""
    counts = []
    for exposure in (0.2, 0.3, 0.6, 1.2):
        image, colours = scene(degree, 12, degree)
        grid = np.linspace(0, 1, 101)
        out = [(reflectances(image, colours, t, exposure) > ENVELOPE.upper).any(axis=1).mean() for t in grid]
        for share in (0.0, 0.3, 0.4, 0.6):
            found = feasible(image, colours, ENVELOPE, AB, allowed_out=share, reference=Reference(exposure=exposure))
            if found.verdict == "complete":
                inside = np.array(out) <= share
                runs = int(inside[0]) + int(np.sum(inside[1:] & ~inside[:-1]))
                assert len(found.intervals) >= runs  # the grid may miss a short one
                counts.append(runs)
    assert max(counts) >= 2


def test_lower_bounds_of_a_blend_hold_between_its_roots_too():
    image, colours = scene(3, 30, seed=1)
    found = feasible(image, colours, STRICT, AB, allowed_out=1.0, allowed_dark=0.1, reference=Reference(exposure=0.12))
    dark = [(reflectances(image, colours, t, 0.12) < STRICT.lower).any(axis=1) for t in np.linspace(0, 1, 101)]
    lit = ~dark[0]
    assert 0 < lit.sum() < 30
    seen = set()
    for t, fallen in zip(np.linspace(0, 1, 101), dark, strict=True):
        held = any(low <= t <= high for low, high in found.intervals)
        assert held == (fallen[lit].mean() <= 0.1)
        seen.add(held)
    assert True in seen


def test_columns_of_alternatives_are_blended_to_the_same_degree():
    """(1 − t)^i t^j of a's own columns and of those that b would have there."""
    others = [
        Interaction("key", ("a>b.diffuse",)),
        Interaction("key", ("a.mirror", "a>b.diffuse")),
        Interaction("key", ("a>b.diffuse", "a>b.mirror")),
    ]
    image, colours = scene(3, 40, seed=7, others=others)
    found = feasible(image, colours, ENVELOPE, AB, allowed_out=0.3)
    for t in np.linspace(0, 1, 101):
        spectra = reflectances(image, colours, t)
        most, least = ((spectra > ENVELOPE.upper * (1 + s)).any(axis=1).mean() for s in (-1e-9, 1e-9))
        assert least - 1e-12 <= found.curve.outside(np.array([t]))[0] <= most + 1e-12
