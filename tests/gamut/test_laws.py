"""Laws that gamuts of every model, and their intersections, obey: one test a law, for all of them."""

import numpy as np
import pytest
from gamut.every import EVERY, made

from symrt.gamut import InkGamut
from symrt.gamut.interface import ConvexGamut
from symrt.gamut.intersections import InkIntersection, Intersection

CURVED = {"hull": 2e-7, "hulls": 2e-7, "two hulls": 2e-7, "inks": 2e-9, "printed": 2e-9}
"""How near to the boundary counts as on it, where squares of differences are looked at."""


@pytest.fixture(scope="module", params=EVERY)
def name(request):
    return request.param


@pytest.fixture(scope="module")
def gamut(name):
    return made(name)


@pytest.fixture(scope="module")
def spectra(gamut):
    """Far outside, near the boundary on either side, and prints."""
    draw = np.random.default_rng(0)
    bands = len(gamut.bands)
    samples = (
        np.vstack([device.samples for device in gamut.devices]) if gamut.devices else draw.uniform(0, 0.6, (99, bands))
    )
    prints = samples[draw.integers(0, len(samples), 8)]
    far = draw.uniform(-0.5, 1.5, (8, bands)) * draw.choice([1, 20], (8, 1))
    greys = np.linspace(-0.1, 1.1, 7)[:, None] * np.ones(bands)
    return np.vstack([far, greys, prints, prints + draw.normal(0, 0.02, prints.shape)])


def convex(gamut):
    return not isinstance(gamut, InkGamut | InkIntersection)


def test_every_gamut_says_what_it_is_and_what_being_inside_proves(gamut):
    assert isinstance(gamut, ConvexGamut) == convex(gamut)
    assert gamut.name in repr(gamut)
    assert "necessary" in gamut.label or "sufficient" in gamut.label
    assert gamut.label in repr(gamut)
    assert gamut.model in {"unit", "envelope", "hull", "inks", "colorimetric", "monitor", "intersection"}
    assert type(gamut.under(np.ones(len(gamut.bands)))) is type(gamut)


def test_nothing_is_violated_exactly_where_a_spectrum_is_inside(gamut, spectra):
    tried = np.vstack([spectra, gamut.nearest(spectra)])
    inside = gamut.contains(tried)
    assert 0 < inside.sum() < len(tried)
    violation = gamut.violation(tried)
    assert violation.min() == 0
    np.testing.assert_array_equal(violation == 0, inside)


def test_the_nearest_spectrum_is_inside_and_one_inside_is_its_own_nearest(gamut, spectra):
    nearest = gamut.nearest(spectra)
    assert gamut.contains(nearest).all()
    assert np.isfinite(nearest).all()
    inside = gamut.contains(spectra)
    np.testing.assert_array_equal(nearest[inside], spectra[inside])
    np.testing.assert_array_equal(gamut.nearest(nearest), nearest)


def test_an_answer_does_not_depend_on_what_else_is_asked(gamut, spectra):
    # One at a time sums are rounded otherwise than many at once; no further than that.
    nearest = gamut.nearest(spectra)
    alone = np.vstack([gamut.nearest(spectrum[None]) for spectrum in spectra])
    np.testing.assert_allclose(nearest, alone, rtol=1e-7, atol=1e-7)
    assert gamut.nearest(spectra[:0]).shape == (0, len(gamut.bands))
    assert gamut.contains(spectra[:0]).shape == gamut.violation(spectra[:0]).shape == (0,)


def test_no_spectrum_known_to_be_inside_is_nearer(gamut, spectra):
    nearest = gamut.nearest(spectra)
    far = np.linalg.norm(spectra[:, None] - nearest[None], axis=2)
    if not convex(gamut):
        return  # of inks the nearest print that is found is given, not the nearest of the tolerance around it
    assert np.all(far.min(axis=1) >= np.diag(far) - 1e-7)


def test_a_clipped_line_ends_on_the_boundary(gamut, spectra, name):
    if not convex(gamut):
        return  # lines through what inks print are lists of intervals, looked at in tests of their own
    draw = np.random.default_rng(4)
    start, way = spectra, draw.normal(0, 1, spectra.shape)
    onto, up = gamut.nearest(spectra), draw.uniform(0.3, 1, spectra.shape)
    origin, direction = np.vstack([start, 0.9 * onto, onto]), np.vstack([way, up, way])
    found = gamut.clip(origin, direction)
    met = ~found.empty
    assert met[: 2 * len(start)].sum() > 10
    assert not found.uncertain.any()
    # Near the boundary of what is curved a line that grazes it leaves it slowly.
    step = 1e-3 if name in CURVED else 1e-5
    for end, outwards in ((found.low, -1.0), (found.high, 1.0)):
        finite = met & np.isfinite(end)
        assert finite.any()
        at = origin[finite] + end[finite, None] * direction[finite]
        assert gamut.violation(at).max() <= CURVED.get(name, 1e-12) + 1e-14 * np.abs(end[finite]).max()
        assert not gamut.contains(at + outwards * step * direction[finite]).any()
    ends = np.clip(found.low[met], -1e3, 1e3), np.clip(found.high[met], -1e3, 1e3)
    middle = origin[met] + (ends[0] / 3 + ends[1] * 2 / 3)[:, None] * direction[met]
    assert gamut.violation(middle).max() <= CURVED.get(name, 1e-12)
    missed = np.flatnonzero(found.empty[: len(start)])
    for t in np.linspace(-2, 2, 9):
        assert not gamut.contains(start[missed] + t * way[missed]).any()


@pytest.mark.parametrize("power", [-600, -40, 300])
def test_a_line_that_is_gone_along_faster_ends_as_much_earlier_bit_for_bit(gamut, spectra, power):
    if not convex(gamut):
        return
    inside = gamut.nearest(spectra)[::4]
    direction = np.random.default_rng(6).normal(0, 1, inside.shape)
    found, faster = gamut.clip(0.9 * inside, direction), gamut.clip(0.9 * inside, np.ldexp(direction, power))
    np.testing.assert_array_equal(np.ldexp(faster.low, power), found.low)
    np.testing.assert_array_equal(np.ldexp(faster.high, power), found.high)


def test_a_line_that_stands_still_is_all_inside_or_all_outside(gamut, spectra):
    if not convex(gamut):
        return
    found = gamut.clip(spectra, np.zeros_like(spectra))
    inside = gamut.contains(spectra)
    np.testing.assert_array_equal(found.low, np.where(inside, -np.inf, np.inf))
    np.testing.assert_array_equal(found.high, np.where(inside, np.inf, -np.inf))


def directions_of(gamut):
    """Directions in which the gamut has an end."""
    draw = np.random.default_rng(5)
    matrix = [gamut.slabs.matrix] if hasattr(gamut, "slabs") else []
    if matrix and np.linalg.matrix_rank(matrix[0]) < len(gamut.bands):
        return draw.normal(size=(10, matrix[0].shape[1])) @ matrix[0].T
    return draw.normal(size=(10, len(gamut.bands)))


def test_the_support_is_beyond_everything_inside_and_reached(gamut, spectra, name):
    if not convex(gamut) or isinstance(gamut, Intersection):
        assert not hasattr(gamut, "support") or isinstance(gamut, Intersection)
        return
    directions = directions_of(gamut)
    support = gamut.support(directions)
    assert np.isfinite(support).all()
    np.testing.assert_allclose(gamut.support(3.0 * directions), 3 * support, rtol=1e-9)
    assert gamut.support(np.zeros((1, len(gamut.bands))))[0] == pytest.approx(0, abs=1e-12)
    inside = gamut.nearest(spectra)
    assert np.all(inside @ directions.T <= support + 1e-9 * np.abs(directions).sum(axis=1))
    if name == "lights":
        return  # so long and thin that no point is far away; a linear programme is asked elsewhere
    # Of a point very far away the nearest is one that goes farthest in its direction.
    reached = gamut.nearest(1e4 * directions / np.linalg.norm(directions, axis=1, keepdims=True))
    np.testing.assert_allclose(np.sum(reached * directions, axis=1), support, rtol=5e-3, atol=5e-3)


@pytest.mark.parametrize("size", [1e-10, 1.0, 1e4, 1e8])
def test_the_nearest_of_what_is_near_and_far_is_inside_asked_together_or_alone(gamut, size):
    far = np.random.default_rng(7).uniform(-1, 1, (6, len(gamut.bands))) * size
    nearest = gamut.nearest(far)
    assert gamut.contains(nearest).all()
    alone = np.concatenate([gamut.contains(spectrum[None]) for spectrum in nearest])
    assert alone.all()
    assert gamut.violation(nearest).max() == 0


def test_a_line_from_the_boundary_begins_there(gamut, spectra):
    if not convex(gamut) or isinstance(gamut, Intersection):
        return  # where two hulls meet, each ends within 1e-7 of where it does, and nothing may be left between
    nearest = gamut.nearest(spectra)
    if gamut.model == "hull":
        # Its lines end where they are inside for certain, a hair before the boundary: begin a hair inside.
        nearest = nearest + 1e-6 * (gamut.device.samples.mean(axis=0) - nearest)
    found = gamut.clip(nearest, np.random.default_rng(8).normal(size=nearest.shape))
    assert found.low.max() <= 0
    assert found.high.min() >= 0


def test_spectra_in_other_bands_and_what_no_reflectance_is_are_refused(gamut):
    asked = [gamut.contains, gamut.violation, gamut.nearest] + ([gamut.support] if hasattr(gamut, "support") else [])
    for ask in asked:
        for shape in ((2, 1), (2, len(gamut.bands) + 1)):
            if isinstance(gamut, Intersection) and ask == gamut.support:
                continue
            with pytest.raises(ValueError, match=rf"spectra are \(2, {shape[1]}\), and the gamut is in .*: give a row"):
                ask(np.full(shape, 0.5))
    for ask in asked[:3]:
        with pytest.raises(ValueError, match=rf"spectrum 1 is 1e\+200 at {gamut.bands.labels[0]}: no reflectance is"):
            ask(np.array([[0.5], [1e200]]) * np.ones(len(gamut.bands)))


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_what_is_no_number_is_neither_inside_nor_outside(gamut, value):
    spectra = np.full((2, len(gamut.bands)), 0.4)
    spectra[1, -1] = value
    asked = [gamut.contains, gamut.violation, gamut.nearest]
    asked += [gamut.support] if convex(gamut) and not isinstance(gamut, Intersection) else []
    for ask in asked:
        with pytest.raises(ValueError, match=rf"spectrum \d is {value} at {gamut.bands.labels[-1]}"):
            ask(spectra)
    if convex(gamut):
        for line in ((spectra, spectra[::-1]), (np.zeros_like(spectra), spectra)):
            with pytest.raises(ValueError, match=rf"pixel \d, slab \d+: the (origin|direction) is {value}"):
                gamut.clip(*line)
