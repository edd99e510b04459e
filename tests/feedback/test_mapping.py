"""Filling: order-independent, inside, and as light, or as dark, as can be."""

from dataclasses import replace
from fractions import Fraction
from functools import partial
from itertools import permutations

import numpy as np
import pytest
from feedback.solvers import fairest
from feedback.synthetic import BANDS, MATTE, awkward, palette, system
from scipy import sparse

from symrt.device.inks import load_device
from symrt.feedback.joint import fits
from symrt.feedback.parameters import Scale
from symrt.feedback.ranges import feasible
from symrt.gamut.gamuts import device_gamut
from symrt.interactions import Interaction
from symrt.spectra.display import luminance_weights
from symrt.spectra.palette import Palette
from symrt.spectra.products import gamma
from symrt.spectra.reference import Reference
from symrt.spectra.shading import shade
from symrt.system import LinearSystem

DEVICE = load_device("dye3-endura-premier")
UNIT, ENVELOPE = device_gamut(DEVICE, "unit"), device_gamut(DEVICE, "envelope")
MIRRORED, COLOURS = system(), palette()
MATERIALS = [Scale(name) for name in (*MATTE, "brass")]
fit = partial(fits.fit, objective="lightest")


def reflected(image, colours, white=None):
    white = Reference().white(image, COLOURS) if white is None else white
    return shade(image, colours).values.reshape(-1, 36)[image.object_pixels] / white


def kept(image, found):
    objects = np.flatnonzero(image.object_pixels)
    return ~np.isin(objects, np.concatenate([found.untouched_outside, found.unfixable]))


@pytest.mark.parametrize("objective", ["lightest", "darkest"])
@pytest.mark.parametrize("black", ["clip", "luminance", "strict"])
def test_the_order_of_the_scales_does_not_matter(objective, black):
    options = {"objective": objective, "black": black, "allowed_dark": 0.05, "cap": False}
    first = fit(MIRRORED, COLOURS, ENVELOPE, MATERIALS, **options)
    random = np.random.default_rng(0)
    for _ in range(3):
        order = [MATERIALS[i] for i in random.permutation(len(MATERIALS))]
        other = fit(MIRRORED, COLOURS, ENVELOPE, order, **options)
        assert other.values == first.values
        assert other.reasons == first.reasons


def test_limits_found_one_after_another_would_depend_on_the_order():
    """The reason for filling: the test above can fail."""

    def one_after_another(order):
        colours, values = COLOURS, {}
        for scale in order:
            values[scale.name] = feasible(MIRRORED, colours, ENVELOPE, scale, cap=False).high
            changed = {n: values[scale.name] * colours[n] for n in colours if n.startswith(f"{scale.name}.")}
            colours = replace(colours, spectra={**colours.spectra, **changed}, unphysical=True)
        return values

    few = [Scale("deep"), Scale("shelf"), Scale("brass")]
    assert len({tuple(sorted(one_after_another(order).items())) for order in permutations(few)}) > 1


@pytest.mark.parametrize("mirrors", [False, True])
@pytest.mark.parametrize("gamut", [UNIT, ENVELOPE], ids=["unit", "envelope"])
def test_the_lightest_image_is_inside_and_no_single_scale_can_rise(gamut, mirrors):
    image, colours = system(mirrors=mirrors), palette(mirrors=mirrors)
    found = fit(image, colours, gamut, MATERIALS, cap=False)
    inside = kept(image, found)
    assert not (reflected(image, found.palette)[inside] > gamut.upper).any()
    assert set(found.values) == {s.name for s in MATERIALS}
    for name, value in found.values.items():
        if found.reasons[name].side == "range":
            assert value == 3.0
            continue
        raised = {n: found.palette[n] * (1 + 1e-9) for n in colours if n.startswith(f"{name}.")}
        brighter = replace(found.palette, spectra={**found.palette.spectra, **raised}, unphysical=True)
        over = reflected(image, brighter)[inside] > gamut.upper
        assert over.any(), name
        why = found.reasons[name]
        pixel = np.flatnonzero(np.flatnonzero(image.object_pixels)[inside] == why.y * image.width + why.x)[0]
        assert over[pixel, BANDS.labels.index(why.band)]


def test_the_lightest_image_is_inside_in_exact_arithmetic():
    found = fit(MIRRORED, COLOURS, ENVELOPE, MATERIALS, cap=False)
    white = [Fraction(w) for w in Reference().white(MIRRORED, COLOURS).tolist()]
    upper = [Fraction(u) for u in ENVELOPE.upper.tolist()]
    spectra = {name: [Fraction(v) for v in found.palette[name].tolist()] for name in found.palette}
    binding = {why.y * MIRRORED.width + why.x for why in found.reasons.values() if why.side == "upper"}
    assert len(binding) >= 3
    for pixel in sorted(binding):
        row = MIRRORED.G[[pixel]]
        for band in range(36):
            value = Fraction(0)
            for column, g in zip(row.indices, row.data.tolist(), strict=True):
                product = Fraction(g)
                for name in (MIRRORED.interactions[column].light, *MIRRORED.interactions[column].met):
                    product *= spectra[name][band]
                value += product
            assert value <= upper[band] * white[band]


@pytest.mark.parametrize("seed", range(4))
def test_filling_is_the_fairest_solution_of_linear_programmes(seed):
    """Random textures of six materials in every pixel, degree 1: oracle is lexicographic max-min by HiGHS."""
    random = np.random.default_rng(seed)
    columns = tuple(Interaction("key", (f"{m}.diffuse",)) for m in sorted(MATTE))
    weights = random.uniform(0, 1, (40, 6)) * (random.uniform(size=(40, 6)) < 0.4)
    image = LinearSystem(sparse.csr_array(weights), columns, 5, 8, {"key": 1.0})
    found = fit(image, COLOURS, ENVELOPE, [Scale(m) for m in MATTE], within=(0.01, 5.0), cap=False)
    products = gamma(columns, COLOURS) / Reference().white(image, COLOURS)
    rows = (weights[:, None, :] * products.T[None]).reshape(-1, 6)
    limits = np.tile(ENVELOPE.upper, 40)
    lit = rows.any(axis=1)
    expected = fairest(rows[lit], limits[lit], [(0.01, 5.0)] * 6)
    np.testing.assert_allclose([found.values[m] for m in sorted(MATTE)], expected, rtol=1e-6)


def test_one_scale_is_filled_to_its_feasible_range():
    for name in ("brass", "ice", "key"):
        found = fit(MIRRORED, COLOURS, ENVELOPE, [Scale(name)], cap=False)
        alone = feasible(MIRRORED, COLOURS, ENVELOPE, Scale(name), cap=False)
        assert found.values[name] == pytest.approx(alone.high, rel=1e-12)
        assert found.reasons[name] == alone.reasons[0][1]


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("black", ["clip", "luminance", "strict"])
def test_awkward_systems_are_filled_and_certified(seed, black):
    image, colours, materials = awkward(seed)
    white = Reference().white(image, colours)
    scales = [Scale(name) for name in materials]
    for objective in ("lightest", "darkest"):
        found = fit(image, colours, UNIT, scales, objective=objective, black=black, allowed_dark=0.1, cap=False)
        assert not (reflected(image, found.palette, white)[kept(image, found)] > 1 + 4e-16).any()
        assert fit(
            image, colours, UNIT, scales[::-1], objective=objective, black=black, allowed_dark=0.1, cap=False
        ).values == (found.values)


def test_lights_are_filled_like_materials():
    found = fit(MIRRORED, COLOURS, ENVELOPE, [Scale("key"), Scale("fill"), Scale("ice")], cap=False)
    assert not (reflected(MIRRORED, found.palette)[kept(MIRRORED, found)] > ENVELOPE.upper).any()


def test_the_darkest_image_with_black_clipped_is_the_low_end():
    found = fit(MIRRORED, COLOURS, ENVELOPE, MATERIALS, objective="darkest", cap=False)
    assert set(found.values.values()) == {0.01}
    assert {why.side for why in found.reasons.values()} == {"range"}


@pytest.mark.parametrize("share", [0.0, 0.05, 0.3])
def test_the_darkest_image_keeps_pixels_above_the_luminance_of_black(share):
    gamut = device_gamut(DEVICE, "envelope", "luminance")
    found = fit(MIRRORED, COLOURS, gamut, MATERIALS, objective="darkest", allowed_dark=share, cap=False)
    light = fit(MIRRORED, COLOURS, gamut, MATERIALS, objective="lightest", cap=False)
    weights = luminance_weights(BANDS) * Reference().white(MIRRORED, COLOURS)
    weights = weights / weights.sum()
    black = (DEVICE.samples @ weights).min()

    def above(colours):
        return reflected(MIRRORED, colours) @ weights >= black

    given, lightest, darkest = above(COLOURS), above(light.palette), above(found.palette)
    lost = (given & ~darkest).sum()
    assert lost <= max(share * given.sum(), (given & ~lightest).sum())
    assert not (reflected(MIRRORED, found.palette)[kept(MIRRORED, found)] > gamut.upper).any()
    assert found.dark == pytest.approx(1 - darkest.mean())
    for name, value in found.values.items():
        assert value <= light.values[name]
        if found.reasons[name].side == "range":
            assert value == 0.01
            continue
        assert found.reasons[name].side == "luminance"
        lowered = {n: found.palette[n] * (1 - 1e-9) for n in COLOURS if n.startswith(f"{name}.")}
        darker = replace(found.palette, spectra={**found.palette.spectra, **lowered})
        assert (darkest & ~above(darker)).any(), name


def test_the_darkest_image_says_what_would_let_it_sink_further():
    gamut = device_gamut(DEVICE, "envelope", "luminance")
    stopped = fit(MIRRORED, COLOURS, gamut, MATERIALS, objective="darkest", cap=False)
    assert "a larger allowed_dark lets some fall" in " ".join(repr(stopped).split())
    assert "allowed_dark" not in repr(fit(MIRRORED, COLOURS, ENVELOPE, MATERIALS, objective="darkest", cap=False))


def test_more_allowed_in_the_dark_lets_the_image_sink_further():
    gamut = device_gamut(DEVICE, "envelope", "luminance")
    means = []
    for share in (0.0, 0.05, 0.3, 1.0):
        found = fit(MIRRORED, COLOURS, gamut, MATERIALS, objective="darkest", allowed_dark=share, cap=False)
        means.append(reflected(MIRRORED, found.palette).mean())
    assert np.all(np.diff(means) < 0)
    assert set(found.values.values()) == {0.01}


def test_pixels_that_no_scale_brings_inside_are_left_out_and_listed():
    found = fit(MIRRORED, COLOURS, ENVELOPE, MATERIALS, within=(1.3, 3.0), cap=False)
    lowest = {n: COLOURS[n] * (1.0 if n in ("key", "fill") else 1.3) for n in COLOURS}
    over = (reflected(MIRRORED, Palette(BANDS, lowest, unphysical=True)) > ENVELOPE.upper).any(axis=1)
    assert np.array_equal(found.unfixable, np.flatnonzero(MIRRORED.object_pixels)[over])
    assert len(found.unfixable) > 0
    assert found.verdict == "rest-only"
    assert not (reflected(MIRRORED, found.palette)[kept(MIRRORED, found)] > ENVELOPE.upper).any()
    some = fit(MIRRORED, COLOURS.replace(key=9.0), ENVELOPE, [Scale("ice")], cap=False)
    assert len(some.untouched_outside) > 0


def test_the_cap_keeps_every_material_physical():
    found = fit(MIRRORED, COLOURS, UNIT, MATERIALS)
    assert found.above_one == ()
    assert not found.palette.unphysical
    assert "cap" in {why.side for why in found.reasons.values()}
    free = fit(MIRRORED, COLOURS, UNIT, MATERIALS, cap=False)
    assert free.above_one
    assert free.palette.unphysical
    assert all(free.palette[f"{name}.diffuse"].max() > 1 for name in free.above_one if name != "brass")


def test_two_components_of_one_material_share_its_cap():
    columns = (Interaction("key", ("m.diffuse",)), Interaction("key", ("m.specular",)))
    image = LinearSystem(sparse.csr_array([[0.1, 0.1]]), columns, 1, 1, {"key": 1.0})
    colours = Palette(BANDS, {"key": 1.0, "m.diffuse": 0.25, "m.specular": 0.25})
    found = fit(image, colours, UNIT, [Scale("m.diffuse"), Scale("m.specular")])
    assert found.values == pytest.approx({"m.diffuse": 2.0, "m.specular": 2.0})
    assert found.reasons["m.diffuse"].side == "cap"


def test_materials_that_no_pixel_binds_reach_the_end_of_the_range():
    dim = COLOURS.replace(key=1e-3, fill=1e-3)
    found = fit(MIRRORED, dim, UNIT, MATERIALS, cap=False, reference=Reference("key", exposure=1e-3))
    assert set(found.values.values()) == {3.0}


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"scales": [Scale("brass"), Scale("brass.specular")]}, "both multiply brass.specular"),
        ({"scales": []}, "no scales to fit"),
        ({"scales": [Scale("bras")]}, "did you mean 'brass'"),
        ({"within": (3.0, 1.0)}, r"within = \(3.0, 1.0\)"),
        ({"system": replace(MIRRORED, G=-MIRRORED.G)}, "one scale at a time"),
        ({"allowed_dark": 2.0}, "allowed_dark"),
    ],
)
def test_bad_questions_are_answered_in_one_line(change, message):
    question = {"system": MIRRORED, "palette": COLOURS, "gamut": UNIT, "scales": MATERIALS} | change
    with pytest.raises(ValueError, match=message) as error:
        fit(**question)
    assert "\n" not in str(error.value)


def test_the_answer_reads_like_a_sentence():
    found = fit(MIRRORED, COLOURS, ENVELOPE, MATERIALS, cap=False)
    text = repr(found)
    assert text.startswith("The lightest image inside with scales in 0.01 … 3 (complete).")
    row = next(line for line in text.splitlines() if line.startswith("brass"))
    assert row.split("  ", 1)[1].split() == [f"{found.values['brass']:.4g}", *found.reasons["brass"].short.split()]
    assert "modelled" in text
    assert "<table>" in found._repr_html_()


@pytest.mark.parametrize("objective", ["lightest", "closest", "lexicographic"])
def test_a_range_that_begins_above_what_is_physical_is_refused_with_the_remedy(objective):
    column = Interaction("key", ("a.diffuse",))
    image = LinearSystem(sparse.csr_array([[0.1]]), (column,), 1, 1, white={"key": 1.0})
    colours = Palette(UNIT.bands, {"key": 1.0, "a.diffuse": 0.5})
    assert not feasible(image, colours, UNIT, Scale("a"), within=(2.5, 3)).intervals
    with pytest.raises(ValueError, match=r"at 2.5 more would be reflected than received by a: begin lower"):
        fit(image, colours, UNIT, [Scale("a")], objective=objective, within=(2.5, 3))
    assert fit(image, colours, UNIT, [Scale("a")], objective=objective, within=(2.5, 3), cap=False).values["a"] >= 2.5


def test_a_cap_that_leaves_no_room_is_named():
    column = Interaction("key", ("a.diffuse",))
    image = LinearSystem(sparse.csr_array([[0.1]]), (column,), 1, 1, white={"key": 1.0})
    found = fit(image, Palette(UNIT.bands, {"key": 1.0, "a.diffuse": 1.0}), UNIT, [Scale("a")], within=(1, 3))
    assert found.reasons["a"].side == "cap"
    assert "a.diffuse would reflect more" in str(found.reasons["a"]) or "a would reflect more" in str(
        found.reasons["a"]
    )
