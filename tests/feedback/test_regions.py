"""A region with symbols of its own changes names and nothing else, until its spectra change."""

import numpy as np
import pytest
from scenes_for_tests import palettes, small

import symrt as rt
from symrt.feedback import split, with_region


@pytest.fixture(scope="module", params=["globe", "spheres"])
def parted(request):
    name = request.param
    material = {"globe": "upland", "spheres": "red"}[name]
    system = rt.render(small(name, 48), progress=False)
    mask = np.zeros((48, 48), dtype=bool)
    mask[:, 20:] = True
    return system, palettes(name)["macbeth"], material, mask, split(system, material, mask, "region")


def test_with_the_same_spectra_the_image_is_the_same(parted):
    system, palette, material, _, region = parted
    now = rt.shade(region, with_region(palette, material, "region")).values
    np.testing.assert_allclose(now, rt.shade(system, palette).values, rtol=1e-15, atol=0)


def test_a_changed_region_changes_only_where_the_mask_is_true(parted):
    system, palette, material, mask, region = parted
    wide = with_region(palette, material, "region")
    black = wide.replace({s: 0.0 for s in wide.reflectances if s.startswith("region.")})
    changed = (rt.shade(region, black).values != rt.shade(system, palette).values).any(axis=-1)
    assert changed.any()
    assert not changed[~mask].any()


def test_columns_stay_sorted_and_coefficients_keep_their_sum(parted):
    system, _, _, _, region = parted
    assert list(region.interactions) == sorted(region.interactions)
    np.testing.assert_allclose(region.G.sum(axis=1), system.G.sum(axis=1), rtol=1e-14)
    assert region.models["region"] == system.models[parted[2]]


def test_feedback_answers_for_a_region_alone(parted):
    system, palette, material, _, region = parted
    gamut = rt.device_gamut(rt.load_device("dye3-endura-premier"), "envelope")
    wide = with_region(palette, material, "region")
    whole = rt.feasible(system, palette, gamut, rt.Scale(material), cap=False).high
    halves = [rt.feasible(region, wide, gamut, rt.Scale(m), cap=False).high for m in (material, "region")]
    assert max(halves) >= whole
    assert min(halves) == pytest.approx(whole, rel=1e-9) or whole == 3.0


@pytest.mark.parametrize(
    ("material", "name", "says"),
    [("uplands", "bay", "did you mean"), ("upland", "deep", "name of its own"), ("upland", "a.b", "name of its own")],
)
def test_names_that_do_not_fit_are_refused(material, name, says):
    system = rt.render(small("globe", 16), progress=False)
    with pytest.raises(ValueError, match=says):
        split(system, material, np.zeros((16, 16), dtype=bool), name)
    with pytest.raises(ValueError, match="mask"):
        split(system, "upland", np.zeros((4, 4), dtype=bool), "bay")


def test_alternatives_of_a_region_go_with_it():
    scene = small("globe", 32)
    system = rt.collapse(rt.trace(scene, alternatives={"upland": ["brass"]}))
    mask = np.ones((32, 32), dtype=bool)
    region = split(system, "upland", mask, "bay")
    assert "bay>brass.specular" in region.reflectances
    assert not any(name.startswith("upland") for name in region.reflectances)
    assert "brass.specular" in region.reflectances
