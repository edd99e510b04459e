"""A region with symbols of its own changes names and nothing else, until its spectra change."""

import numpy as np
import pytest
from feedback.synthetic import palette, system
from scenes_for_tests import palettes, small

import symrt as rt
from symrt.device import load_device
from symrt.feedback import split, with_region
from symrt.gamut import device_gamut


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


RENAMED, COLOURED = system(height=10, width=12, seed=5), palette(seed=5)
ENVELOPE = device_gamut(load_device("dye3-endura-premier"), "envelope")
OTHERS = [rt.Scale(name) for name in ("key", "brass", "ice")]
BRIGHT = {"cap": False, "reference": rt.Reference(exposure=1.4), "progress": False}
VERBS = {
    "lightest": lambda *q: rt.fit(*q, objective="lightest", **BRIGHT).values,
    "closest": lambda *q: rt.fit(*q, objective="closest", **BRIGHT).values,
    "lexicographic": lambda *q: rt.fit(*q, **BRIGHT).values,
    "brightest": lambda *q: rt.fit(*q, objective="brightest", **BRIGHT).values,
    "some left out": lambda *q: rt.fit(*q, objective="lightest", allowed_out=0.1, **BRIGHT).values,
    "lower ends": lambda *q: {n: side[0] for n, side in rt.safe_box(*q, **BRIGHT).box.items()},
    "upper ends": lambda *q: {n: side[1] for n, side in rt.safe_box(*q, **BRIGHT).box.items()},
    "adapted": lambda *q: {"level": rt.adapt(*q, **BRIGHT).exposure},
}


@pytest.mark.parametrize("verb", VERBS)
def test_a_region_that_is_all_of_a_material_is_that_material_by_another_name(verb):
    """Splitting everything off renames: every verb answers the same numbers, whatever comes first in the alphabet."""
    part = split(RENAMED, "ice", np.ones((10, 12), dtype=bool), "aaa")
    wide = with_region(COLOURED, "ice", "aaa")
    named = [rt.Scale("aaa" if scale.name == "ice" else scale.name) for scale in OTHERS]
    before, after = VERBS[verb](RENAMED, COLOURED, ENVELOPE, OTHERS), VERBS[verb](part, wide, ENVELOPE, named)
    renamed = {"aaa" if name == "ice" else name: value for name, value in before.items()}
    # Where a posynomial's best is only approached, the search depends on the order of the scales.
    assert after == pytest.approx(renamed, rel=1e-6 if verb == "brightest" else 1e-9)


@pytest.mark.parametrize("verb", ["lightest", "closest", "lexicographic", "brightest"])
def test_a_fit_of_regions_is_inside_and_no_worse_than_one_of_the_whole(verb):
    """A region may always do what the material does, so that two symbols reach at least as far as one."""
    mask = np.zeros((10, 12), dtype=bool)
    mask[:5] = True
    part, wide = split(RENAMED, "ice", mask, "bay"), with_region(COLOURED, "ice", "bay")
    one = rt.fit(RENAMED, COLOURED, ENVELOPE, OTHERS, objective=verb, **BRIGHT)
    two = rt.fit(part, wide, ENVELOPE, [*OTHERS, rt.Scale("bay")], objective=verb, **BRIGHT)
    white = BRIGHT["reference"].white(part, wide) / 1.4
    seen = (rt.shade(part, two.palette).values / white).reshape(-1, 36)
    assert np.delete(seen <= ENVELOPE.upper, np.concatenate([two.unfixable, two.untouched_outside]), axis=0).all()
    if verb == "brightest":
        assert two.luminance >= one.luminance * (1 - 1e-6)
    elif verb in ("lexicographic", "lightest"):
        assert min(two.values.values()) >= min(one.values.values()) * (1 - 1e-9)
    else:
        whole, parted = (sum(np.log(v) ** 2 for v in f.values.values()) for f in (one, two))
        same = whole + np.log(one.values["ice"]) ** 2
        assert parted <= same * (1 + 1e-9)


def test_maps_and_reports_do_not_see_names():
    mask = np.zeros((10, 12), dtype=bool)
    mask[:5] = True
    part, wide = split(RENAMED, "ice", mask, "bay"), with_region(COLOURED, "ice", "bay")
    maps = [rt.map_pixels(*q, ENVELOPE, reference=BRIGHT["reference"]) for q in ((RENAMED, COLOURED), (part, wide))]
    np.testing.assert_allclose(maps[1].image.values, maps[0].image.values, rtol=1e-14)
    said = [rt.report(*q, [ENVELOPE], BRIGHT["reference"]) for q in ((RENAMED, COLOURED), (part, wide))]
    assert said[0].verdicts[0].inside == said[1].verdicts[0].inside < 1
    ice, (kept, bay) = said[0].verdicts[0].materials["ice"], (said[1].verdicts[0].materials[n] for n in ("ice", "bay"))
    assert min(kept, bay) <= ice <= max(kept, bay)


def test_a_region_keeps_the_spectra_of_its_alternatives_and_of_no_one_else_s():
    # sea>ice.diffuse is met at points of the sea, brass>sea.diffuse at points of the brass: only the first is renamed.
    image = rt.LinearSystem.of("0.5*sun*sea.diffuse + 0.25*sun*sea>ice.diffuse + 0.125*sun*brass>sea.diffuse")
    spectra = {"sea.diffuse": 0.5, "sea>ice.diffuse": 0.25, "brass>sea.diffuse": 0.125, "sun": 1.0}
    colours = rt.Palette(rt.RGB, spectra)
    bay = rt.split(image, "sea", np.array([[True]]), "bay")
    assert [str(i) for i in bay.interactions] == ["sun*bay.diffuse", "sun*bay>ice.diffuse", "sun*brass>sea.diffuse"]
    wide = rt.with_region(colours, "sea", "bay")
    assert set(wide) - set(colours) == {"bay.diffuse", "bay>ice.diffuse"}
    # 0.5 * 0.5 + 0.25 * 0.25 + 0.125 * 0.125, exact in binary.
    assert rt.shade(bay, wide).values.tolist() == rt.shade(image, colours).values.tolist() == [[[0.328125] * 3]]
