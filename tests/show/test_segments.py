"""Segments of materials in a gamut, and the body that they are drawn in: Figure 1 of the paper."""

from fractions import Fraction
from itertools import combinations, pairwise

import numpy as np
import pytest
from scipy.spatial import ConvexHull

import symrt as rt
from symrt.gamut.basis import uniform_first
from symrt.show import plots
from symrt.show.body import body_of
from symrt.show.segments import blend_segments, diffuse_materials, scale_segments
from symrt.show.solid import View, facets, outline

WITHIN = (0.01, 3.0)


@pytest.fixture(scope="module")
def gamut():
    return rt.device_gamut(rt.load_device("dye3-endura-premier"), "envelope")


@pytest.fixture(scope="module")
def palette():
    return rt.load_palettes("globe")["macbeth"]


@pytest.fixture(scope="module")
def scaled(gamut, palette):
    return scale_segments(gamut, palette, diffuse_materials(palette), palette["key"], WITHIN)


@pytest.fixture(scope="module")
def blended(gamut, palette):
    return blend_segments(gamut, palette, diffuse_materials(palette), palette["key"])


def test_the_part_drawn_inside_is_what_clipping_in_all_bands_says(gamut, palette, scaled):
    # Paper §5: the paired planes that construct the gamut are the clipping planes.
    for segment in scaled:
        r = palette[f"{segment.names[0]}.diffuse"].tolist()
        exact = min(Fraction(high) / Fraction(x) for high, x in zip(gamut.upper.tolist(), r, strict=True) if x)
        ((low, high),) = segment.inside
        assert (low, Fraction(high) <= min(exact, Fraction(WITHIN[1]))) == (WITHIN[0], True)
        assert high == pytest.approx(min(float(exact), WITHIN[1]), rel=1e-12)
        ratios = {
            label: Fraction(high) / Fraction(x)
            for label, high, x in zip(gamut.bands.labels, gamut.upper.tolist(), r, strict=True)
            if x
        }
        assert segment.stops == ((None, None if exact > WITHIN[1] else min(ratios, key=ratios.get)),)


def test_the_parts_of_a_segment_are_all_of_it_and_those_outside_are_outside(gamut, scaled, blended):
    for segment in (*scaled, *blended):
        parts = sorted([*segment.outside, *segment.inside])
        assert [parts[0][0], parts[-1][1]] == list(segment.within)
        assert all(a[1] == b[0] for a, b in pairwise(parts))
        for low, high in segment.outside:
            assert not gamut.contains(segment.at((low + high) / 2)[None])[0]
        for span in segment.inside:
            assert gamut.contains(np.array([segment.at(t) for t in np.linspace(*span, 5)[1:-1]])).all()


@pytest.mark.parametrize("model", ["hull", "inks", "colorimetric"])
def test_segments_are_clipped_by_any_model_of_gamut(palette, model):
    gamut = rt.device_gamut(rt.load_device("dye3-endura-premier"), model)
    white = palette["key"]
    for segment in (
        *scale_segments(gamut, palette, ["shelf", "table"], white, WITHIN),
        *blend_segments(gamut, palette, ["deep", "shelf"], white),
    ):
        inside = np.array([np.linspace(*span, 7)[1:-1] for span in segment.inside]).ravel()
        outside = np.array([np.linspace(*span, 7)[1:-1] for span in segment.outside]).ravel()
        assert gamut.contains(np.array([segment.at(t) for t in inside]).reshape(-1, 36)).all()
        assert not gamut.contains(np.array([segment.at(t) for t in outside]).reshape(-1, 36)).any()
        assert len(segment.stops) == len(segment.inside)


@pytest.mark.parametrize("components", [(0, 1, 2), (4, 1, 7), (9, 0, 3)])
@pytest.mark.parametrize("name", ["envelope", "hull", "both"])
def test_the_body_covers_what_a_gamut_holds_in_any_three_components(name, components):
    dyes, inks = rt.load_device("dye3-endura-premier"), rt.load_device("synthetic-cmyk")
    gamut = {
        "envelope": rt.device_gamut(dyes, "envelope"),
        "hull": rt.device_gamut(inks, "hull"),
        "both": rt.intersection([rt.device_gamut(dyes, "envelope"), rt.device_gamut(inks, "envelope")]),
    }[name]
    body = body_of(gamut, components)
    basis = uniform_first((dyes if name != "hull" else inks).samples).vectors
    assert np.array_equal(body.vectors, basis[list(components)])
    random = np.random.default_rng(0)
    mixed = random.dirichlet(np.full(len(inks.samples), 0.05), 300) @ inks.samples
    spectra = mixed if name == "hull" else gamut.nearest(random.uniform(-0.5, 1.5, (300, 36)))
    planes = ConvexHull(body.solid.vertices).equations
    assert (spectra @ body.vectors.T @ planes[:, :3].T + planes[:, 3]).max() < 1e-9


@pytest.mark.parametrize(
    ("components", "message"), [((0, 1, 1), "different ones"), ((0, 1, 36), "from 0 to 35"), ((0, -1, 2), "from 0")]
)
def test_components_that_there_are_not_are_refused(gamut, palette, components, message):
    with pytest.raises(ValueError, match=message):
        plots.gamut_figure(gamut, palette, components=components)


def test_a_gamut_without_a_body_says_what_has_one(palette):
    flat = rt.device_gamut(rt.load_device("synthetic-cmyk"), "hull")
    with pytest.raises(ValueError, match="choose earlier components"):
        plots.gamut_figure(flat, palette, components=(35, 0, 3))
    monitor = rt.device_gamut(rt.load_device("crt-brainard").on(palette.bands), "monitor")
    with pytest.raises(ValueError, match="draw them in a printer's unit"):
        plots.gamut_figure(monitor, palette)


def test_every_segment_inside_the_gamut_is_drawn_inside_the_shadow(gamut, scaled, blended):
    vectors, view = gamut.basis.vectors[:3], View()
    sides = facets(gamut.shadow(3).polyhedron())
    planes = ConvexHull(outline(sides, view)).equations
    for segment in (*scaled, *blended):
        for span in segment.inside:
            points = np.array([segment.at(t) for t in np.linspace(*span, 9)]) @ vectors.T
            assert all(((points - side.corners[0]) @ side.normal).max() < 1e-9 for side in sides)
            assert (planes[:, :2] @ view.project(points).T + planes[:, 2:]).max() < 1e-9


def test_a_blend_runs_from_one_material_to_the_other(palette, blended):
    assert len(blended) == len(list(combinations(diffuse_materials(palette), 2)))
    for segment in blended:
        ends = [palette[f"{name}.diffuse"] for name in segment.names]
        np.testing.assert_allclose([segment.at(0.0), segment.at(1.0)], ends, rtol=1e-12, atol=1e-15)
