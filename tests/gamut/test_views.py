"""The slice and the shadow of a gamut, against linear programmes and the volume of a zonotope."""

from itertools import combinations

import numpy as np
import pytest
from scipy.optimize import linprog

from symrt.device.inks import load_device
from symrt.gamut.gamuts import device_gamut
from symrt.gamut.views import Shadow, Slice


@pytest.fixture(scope="module", params=["unit", "envelope"])
def gamut(request):
    return device_gamut(load_device("dye3-endura-premier"), request.param, "strict")


def test_the_slice_lies_in_the_shadow_and_both_are_convex_solids(gamut):
    cut, shadow = gamut.slice(3).polyhedron(), gamut.shadow(3).polyhedron()
    directions = np.random.default_rng(0).normal(size=(500, 3))
    reach = (directions @ cut.vertices.T).max(axis=1)
    assert np.all(reach <= gamut.shadow(3).support(directions) + 1e-9)
    # On three-dye models the volumes were seen to differ two- to fourfold.
    assert 1 < shadow.volume / cut.volume < 10


def test_corners_of_the_shadow_reach_its_support(gamut):
    shadow = gamut.shadow(3)
    directions = np.random.default_rng(1).normal(size=(500, 3))
    corners = shadow.polyhedron().vertices
    reach = (directions @ corners.T).max(axis=1)
    # Corners are told apart after rounding to 12 digits.
    np.testing.assert_allclose(reach, shadow.support(directions), rtol=1e-9, atol=1e-11)


def test_volume_of_the_shadow_is_the_sum_over_triples_of_bands(gamut):
    """A zonotope's volume is Σ |det(g_i, g_j, g_k)| (Shephard, Canad. J. Math. 26, 1974, eq. 57)."""
    shadow = gamut.shadow(3)
    edges = ((shadow.upper - shadow.lower) * shadow.vectors).T
    volume = sum(abs(np.linalg.det(edges[list(three)])) for three in combinations(range(36), 3))
    assert shadow.polyhedron().volume == pytest.approx(volume, rel=1e-9)


def test_support_of_the_shadow_is_the_optimum_of_a_linear_programme(gamut):
    shadow = gamut.shadow(3)
    for direction in np.random.default_rng(2).normal(size=(10, 3)):
        best = linprog(-(direction @ shadow.vectors), bounds=list(zip(shadow.lower, shadow.upper, strict=True)))
        assert shadow.support(direction[None])[0] == pytest.approx(-best.fun, rel=1e-9)


def test_corners_of_the_slice_are_where_spectra_touch_three_bounds(gamut):
    cut = gamut.slice(3)
    corners = cut.polyhedron().vertices
    spectra = corners @ cut.vectors
    assert np.all(spectra >= cut.lower - 1e-9)
    assert np.all(spectra <= cut.upper + 1e-9)
    touching = (np.abs(spectra - cut.lower) < 1e-8) | (np.abs(spectra - cut.upper) < 1e-8)
    assert np.all(touching.sum(axis=1) >= 3)


def test_slice_contains_what_its_spectra_say():
    cut = Slice(np.array([[0.6, 0.8]]), np.zeros(2), np.ones(2))
    assert cut.contains(np.array([[1.25], [-1e-9], [0.0]])).tolist() == [True, False, True]


def test_faces_and_edges_make_one_closed_surface(gamut):
    for solid in (gamut.slice(3).polyhedron(), gamut.shadow(3).polyhedron()):
        sides = np.sort(np.vstack([solid.faces[:, pair] for pair in ([0, 1], [1, 2], [2, 0])]), axis=1)
        unique, count = np.unique(sides, axis=0, return_counts=True)
        assert np.all(count == 2)
        assert len(solid.vertices) - len(unique) + len(solid.faces) == 2
        assert {tuple(e) for e in solid.edges} <= {tuple(e) for e in unique}


def test_a_cube_with_parallel_and_coplanar_edges_has_twelve_of_them():
    # Four bands, two of which have the same coordinates: a box of 2 × 1 × 1.
    vectors = np.array([[1.0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
    box = Shadow(vectors, np.zeros(4), np.ones(4)).polyhedron()
    assert box.volume == pytest.approx(2)
    assert (len(box.vertices), len(box.edges), len(box.faces)) == (8, 12, 12)
    # A fourth edge in the plane of two others gives two faces six corners each.
    vectors = np.array([[1.0, 1, 0, 0], [0, 1, 1, 0], [0, 0, 0, 1]])
    prism = Shadow(vectors, np.zeros(4), np.ones(4)).polyhedron()
    assert (len(prism.vertices), len(prism.edges)) == (12, 18)
    assert prism.volume == pytest.approx(3)


def test_only_three_dimensions_make_a_solid(gamut):
    for view in (gamut.slice(4), gamut.shadow(2)):
        with pytest.raises(ValueError, match=r"k = \d: only three"):
            view.polyhedron()


def test_any_components_can_be_chosen_and_impossible_ones_are_refused():
    gamut = device_gamut(load_device("dye3-endura-premier"), "envelope")
    assert np.array_equal(gamut.shadow((0, 1, 2)).vectors, gamut.shadow(3).vectors)
    chosen = gamut.shadow((5, 2, 9))
    inside = np.random.default_rng(2).uniform(gamut.lower, gamut.upper, (200, 36))
    directions = np.random.default_rng(3).normal(size=(50, 3))
    reach = (directions @ (inside @ gamut.basis.vectors[[5, 2, 9]].T).T).max(axis=1)
    assert np.all(reach <= chosen.support(directions))
    for wrong in ((0, 0, 1), (0, 1, 36), (-1, 0, 1), ()):
        with pytest.raises(ValueError, match="from 0 to 35"):
            gamut.shadow(wrong)


def test_a_shadow_without_volume_is_said_to_be_flat():
    vectors = np.linalg.qr(np.random.default_rng(0).normal(size=(5, 5)))[0][:3]
    for free in (0, 1, 2):
        upper = np.where(np.arange(5) < free, 1.0, 0.3)
        with pytest.raises(ValueError, match="the shadow is flat"):
            Shadow(vectors, np.full(5, 0.3), upper).polyhedron()
    assert Shadow(vectors, np.full(5, 0.3), np.where(np.arange(5) < 3, 1.0, 0.3)).polyhedron().volume > 0
