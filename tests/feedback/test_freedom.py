"""The safe box: every point of it is inside, nothing can be added to any side, and no other box is larger."""

from dataclasses import replace
from functools import cache
from itertools import product

import numpy as np
import pytest
from feedback.synthetic import BANDS, MATTE, awkward, palette, system
from scipy import sparse

from symrt.device.inks import load_device
from symrt.feedback import Scale, feasible, safe_box
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


def scaled(colours, values):
    spectra = {n: colours[n] * values.get(n, values.get(n.partition(".")[0], 1.0)) for n in colours}
    return Palette(BANDS, spectra, unphysical=True)


def reflected(image, values, colours=COLOURS):
    radiance = shade(image, scaled(colours, values)).values.reshape(-1, 36)
    return radiance[image.object_pixels] / Reference().white(image, colours)


def at_all(image, several, colours=COLOURS):
    """The same for many points, with the products of scales multiplied out."""
    products = gamma(image.interactions, colours) / Reference().white(image, colours)
    matrix = image.G[image.object_pixels].toarray()
    for values in several:
        factors = [
            np.prod([values.get(n, values.get(n.partition(".")[0], 1.0)) for n in (i.light, *i.met)])
            for i in image.interactions
        ]
        yield (matrix * factors) @ products


@cache
def boxed(black, cap=False):
    return safe_box(MIRRORED, COLOURS, ENVELOPE, MATERIALS, black=black, cap=cap)


def points(box, count, seed=0):
    """Corners and points between, drawn at random."""
    random = np.random.default_rng(seed)
    low, high = np.array(list(box.values())).T
    share = random.uniform(size=(count, len(low)))
    share[::2] = random.integers(0, 2, share[::2].shape)
    for values in low + share * (high - low):
        yield dict(zip(box, np.clip(values, low, high).tolist(), strict=True))


@pytest.mark.parametrize("cap", [False, True])
def test_every_corner_and_every_point_between_is_inside(cap):
    found = boxed("clip", cap)
    assert (found.verdict, found.optimum) == ("complete", "global")
    several = list(points(found.box, 2000))
    assert all(values in found for values in several)
    for reflectances in at_all(MIRRORED, several):
        assert not (reflectances > ENVELOPE.upper * (1 + 1e-14)).any()
    for values in several[:20]:
        assert not (reflected(MIRRORED, values) > ENVELOPE.upper).any()


def test_any_side_made_longer_leaves_the_gamut_at_the_pixel_and_band_named():
    found = boxed("clip")
    top = {name: high for name, (_, high) in found.box.items()}
    objects = np.flatnonzero(MIRRORED.object_pixels)
    for name, (below, above) in found.reasons.items():
        assert below.side == "range"
        assert above.side == "upper"
        over = reflected(MIRRORED, {**top, name: top[name] * (1 + 1e-9)}) > ENVELOPE.upper
        pixel = np.flatnonzero(objects == above.y * MIRRORED.width + above.x)[0]
        assert over[pixel, BANDS.labels.index(above.band)], name


@pytest.mark.parametrize("black", ["clip", "luminance", "strict"])
def test_the_order_of_the_scales_does_not_matter(black):
    first = boxed(black)
    other = safe_box(MIRRORED, COLOURS, ENVELOPE, MATERIALS[::-1], black=black, cap=False)
    assert other.box == first.box
    assert other.reasons == first.reasons


@pytest.mark.parametrize("seed", range(6))
def test_renamed_and_permuted_systems_have_the_same_box(seed):
    """The search runs through its scales in the order of their names: other names, the same box."""
    random = np.random.default_rng(seed)
    order = random.permutation(6)
    names = dict(zip(MATTE, (f"z{k}" for k in order), strict=True))
    weights = random.uniform(0, 1, (40, 6)) * (random.uniform(size=(40, 6)) < 0.4)

    def asked(called):
        columns = [Interaction("key", (f"{called[m]}.diffuse",)) for m in MATTE]
        ranked = sorted(range(6), key=lambda k: columns[k])
        image = LinearSystem(
            sparse.csr_array(weights[:, ranked]), tuple(columns[k] for k in ranked), 5, 8, {"key": 1.0}
        )
        spectra = {f"{called[m]}.diffuse": COLOURS[f"{m}.diffuse"] for m in MATTE}
        colours = Palette(BANDS, {"key": COLOURS["key"], **spectra})
        return safe_box(image, colours, ENVELOPE, [Scale(called[m]) for m in MATTE], cap=False).box

    one, other = asked({m: m for m in MATTE}), asked(names)
    for name in MATTE:
        assert other[names[name]] == pytest.approx(one[name], rel=1e-9)


@pytest.mark.parametrize("black", ["luminance", "strict"])
def test_a_box_that_keeps_black_is_above_it_at_the_bottom_and_inside_at_the_top(black):
    gamut = device_gamut(DEVICE, "envelope", black)
    found = boxed(black)
    assert found.optimum == "local"
    assert found.volume > 0
    weights = luminance_weights(BANDS) * Reference().white(MIRRORED, COLOURS)
    weights = weights / weights.sum()

    def above(values):
        if black == "strict":
            return (reflected(MIRRORED, values) >= gamut.lower).all(axis=1)
        return reflected(MIRRORED, values) @ weights >= (DEVICE.samples @ weights).min()

    bottom = {name: low for name, (low, _) in found.box.items()}
    top = {name: high for name, (_, high) in found.box.items()}
    kept, given = above(bottom), above({})
    assert (given & kept).sum() > 0.9 * given.sum()
    for values in points(found.box, 60):
        assert above(values)[kept].all()
        assert not (reflected(MIRRORED, values) > gamut.upper * (1 + 1e-14)).any()
    for name, (below, _) in found.reasons.items():
        if below.side in ("lower", "luminance"):
            lost = kept & ~above({**bottom, name: bottom[name] * (1 - 1e-9)})
            pixel = np.flatnonzero(np.flatnonzero(MIRRORED.object_pixels) == below.y * MIRRORED.width + below.x)[0]
            assert lost[pixel], name
    assert {below.side for below, _ in found.reasons.values()} != {"range"}
    assert top != bottom


@pytest.mark.parametrize("seed", range(8))
def test_no_box_of_a_grid_is_larger(seed):
    """Brute force over two scales, products of up to degree 3."""
    random = np.random.default_rng(seed)
    columns = sorted(
        Interaction("key", tuple(sorted(met)))
        for met in (("a.diffuse",), ("b.diffuse",), ("a.mirror", "b.diffuse"), ("a.mirror", "a.mirror", "b.diffuse"))
    )
    image = LinearSystem(sparse.csr_array(random.uniform(0, 0.6, (6, 4))), tuple(columns), 2, 3, {"key": 1.0})
    colours = Palette(BANDS, {"key": 1.0, **{n: random.uniform(0.2, 0.9, 36) for n in image.reflectances}})
    found = safe_box(image, colours, UNIT, [Scale("a"), Scale("b")], within=(0.1, 4.0), cap=False)
    best = found.volume
    grid = product(np.linspace(0.1, 4.0, 60), repeat=2)
    larger = [{"a": a, "b": b} for a, b in grid if (a - 0.1) * (b - 0.1) > best * (1 + 1e-9)]
    assert larger
    assert all((reflectances > 1).any() for reflectances in at_all(image, larger, colours))


def test_no_random_box_inside_is_larger():
    found = boxed("clip")
    top = np.array([high for _, high in found.box.values()])
    random, tried = np.random.default_rng(3), 0
    for _ in range(300):
        other = np.minimum(top * np.exp(random.normal(0, 0.02, len(top)) - 0.01), 3.0)
        values = dict(zip(found.box, other.tolist(), strict=True))
        if not (reflected(MIRRORED, values) > ENVELOPE.upper).any():
            tried += 1
            assert np.log(other - 0.01).sum() <= np.log(top - 0.01).sum()
    assert tried > 5


def test_separate_ranges_do_not_go_together():
    """Two lights on one pixel: each range alone assumes the other light as it is."""
    columns = (Interaction("fill", ("m.diffuse",)), Interaction("key", ("m.diffuse",)))
    image = LinearSystem(sparse.csr_array([[0.5, 0.5]]), columns, 1, 1, {"key": 1.0, "fill": 1.0})
    colours = Palette(BANDS, {"key": 1.0, "fill": 1.0, "m.diffuse": 0.5})
    found = safe_box(image, colours, UNIT, [Scale("key"), Scale("fill")], within=(0, 4), samples=1000)
    # Inside means key + fill <= 4: the box is 2 × 2; each alone may go to 3, and of that square 7/9 is inside.
    assert found.box == {"fill": (0.0, pytest.approx(2)), "key": (0.0, pytest.approx(2))}
    assert found.separate == {"fill": (0.0, pytest.approx(3)), "key": (0.0, pytest.approx(3))}
    assert found.separate_inside == pytest.approx(7 / 9, abs=0.05)
    assert "of it is inside" in repr(found)


def test_one_scale_has_its_feasible_range():
    for name in ("brass", "ice", "key"):
        found = safe_box(MIRRORED, COLOURS, ENVELOPE, [Scale(name)], cap=False)
        alone = feasible(MIRRORED, COLOURS, ENVELOPE, Scale(name), cap=False)
        assert found.box[name] == (0.01, pytest.approx(alone.high, rel=1e-12))
        assert found.reasons[name][1] == alone.reasons[0][1]


@pytest.mark.parametrize("seed", [*range(14), *(pytest.param(k, marks=pytest.mark.exhaustive) for k in range(14, 40))])
def test_awkward_systems_have_boxes_whose_corners_are_inside(seed):
    image, colours, materials = awkward(seed)
    scales = [Scale(m) for m in materials]
    found = safe_box(image, colours, UNIT, scales, cap=seed % 2 == 0)
    top = {name: high for name, (_, high) in found.box.items()}
    out = np.concatenate([found.untouched_outside, found.unfixable])
    kept = ~np.isin(np.flatnonzero(image.object_pixels), out)
    assert not (reflected(image, top, colours)[kept] > 1 + 1e-14).any()
    assert all(low <= high for low, high in found.box.values())


@pytest.mark.parametrize("short", [1e-12, 1e-9, 1e-7])
def test_a_box_that_is_empty_by_little_is_not_called_complete(short):
    image = LinearSystem(sparse.csr_array([[1.0]]), (Interaction("key", ("m.diffuse",)),), 1, 1, {"key": 1.0})
    colours = Palette(BANDS, {"key": 1.0, "m.diffuse": 1.0})
    found = safe_box(image, colours, UNIT, [Scale("m")], within=(1 + short, 2), cap=False)
    assert (found.verdict, found.unfixable.tolist()) == ("rest-only", [0])
    exactly = safe_box(image, colours, UNIT, [Scale("m")], within=(1 - 1e-13, 2), cap=False)
    assert exactly.volume == 0
    assert exactly.reasons["m"][1].side == "upper"


def test_coefficients_of_very_different_size_do_not_disturb_the_box():
    sizes = 10.0 ** np.arange(-12, 13, 4)
    columns = tuple(Interaction("key", (f"m{k}.diffuse",)) for k in range(len(sizes)))
    image = LinearSystem(sparse.csr_array(np.diag(sizes / 2)), columns, 1, len(sizes), {"key": 1.0})
    colours = Palette(
        BANDS, {"key": 1.0, **{f"m{k}.diffuse": 1 / size for k, size in enumerate(sizes)}}, unphysical=True
    )
    found = safe_box(image, colours, UNIT, [Scale(f"m{k}") for k in range(len(sizes))], cap=False)
    assert [high for _, high in found.box.values()] == pytest.approx([2.0] * len(sizes), rel=1e-12)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"scales": []}, "no scales"),
        ({"within": (1.0, 1.0)}, "needs room"),
        ({"system": replace(MIRRORED, G=-MIRRORED.G)}, "negative coefficients"),
    ],
)
def test_bad_questions_are_answered_in_one_line(change, message):
    question = {"system": MIRRORED, "palette": COLOURS, "gamut": UNIT, "scales": MATERIALS} | change
    with pytest.raises(ValueError, match=message):
        safe_box(**question)


def test_the_answer_reads_like_a_sentence():
    found = boxed("clip")
    assert repr(found).startswith("All scales may move freely in this box and keep the image inside (complete; none")
    assert "<table>" in found._repr_html_()
