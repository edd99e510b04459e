"""Objectives of a fit: inside, best as far as they say so, whatever the order, and never the trivial black image."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from feedback.synthetic import BANDS, MATTE, awkward, palette, system
from scipy import sparse
from scipy.optimize import linprog, minimize

from symrt.device.inks import load_device
from symrt.feedback import Exposure, Scale, feasible, fit
from symrt.gamut.gamuts import device_gamut
from symrt.interactions import Interaction
from symrt.spectra.display import luminance_weights
from symrt.spectra.palette import Palette
from symrt.spectra.products import gamma
from symrt.spectra.reference import Reference
from symrt.system import LinearSystem

DEVICE = load_device("dye3-endura-premier")
UNIT, ENVELOPE = device_gamut(DEVICE, "unit"), device_gamut(DEVICE, "envelope")
MIRRORED, COLOURS = system(), palette().replace(key=palette()["key"] * 1.3)
LIGHTS = [Scale("key"), Scale("fill")]
MATERIALS = [Scale(name) for name in (*MATTE, "brass")]
FEW = [*LIGHTS, Scale("brass"), Scale("ice")]
GOALS = ["closest", "lexicographic", "brightest", "contrast"]
WHITE = Reference().white(MIRRORED, COLOURS)
LUMINANCE = luminance_weights(BANDS) * WHITE / (luminance_weights(BANDS) * WHITE).sum()


def reflected(image, values, colours=COLOURS):
    """Reflectances of the object pixels, with the products of scales multiplied out."""
    products = gamma(image.interactions, colours) / Reference().white(image, colours)
    factors = [
        np.prod([values.get(n, values.get(n.partition(".")[0], 1.0)) for n in (i.light, *i.met)])
        for i in image.interactions
    ]
    return (image.G[image.object_pixels].toarray() * factors) @ products


def inside(image, values, colours=COLOURS, upper=ENVELOPE.upper):
    return not (reflected(image, values, colours) > upper).any()


def change(values):
    return sum(np.log(v) ** 2 for v in values.values())


def nearby(found, count, size, seed=0):
    """Other scales around those found, inside the range."""
    random = np.random.default_rng(seed)
    for _ in range(count):
        factors = np.exp(random.normal(0, size * random.uniform(), len(found.values)))
        yield {n: float(np.clip(v * f, *found.within)) for (n, v), f in zip(found.values.items(), factors, strict=True)}


@pytest.mark.parametrize("goal", GOALS)
@pytest.mark.parametrize("scales", [MATERIALS, LIGHTS, FEW], ids=["materials", "lights", "both"])
def test_every_objective_is_inside(goal, scales):
    found = fit(MIRRORED, COLOURS, ENVELOPE, scales, objective=goal, cap=False)
    assert found.verdict == "complete"
    assert inside(MIRRORED, {n: v * (1 - 1e-15) for n, v in found.values.items()})
    assert found.rounds >= 1 or found.reasons["key"].side == "upper"


def test_the_closest_never_brightens_an_image_that_is_outside():
    for scales in (MATERIALS, LIGHTS, MATERIALS + LIGHTS):
        found = fit(MIRRORED, COLOURS, ENVELOPE, scales, objective="closest", cap=False)
        assert found.optimum == "global"
        assert all(value <= 1 for value in found.values.values())


def test_the_closest_agrees_with_another_solver():
    """Sequential quadratic programming with every row of the image at once."""
    image = replace(MIRRORED, G=MIRRORED.G[:48], height=2, width=24)
    found = fit(image, COLOURS, UNIT, LIGHTS + MATERIALS, objective="closest", cap=False)
    names = list(found.values)

    def room(y):
        return 1 - reflected(image, dict(zip(names, np.exp(y), strict=True))).max(axis=1)

    answer = minimize(
        lambda y: y @ y / 2,
        np.full(len(names), -1.0),
        jac=lambda y: y,
        constraints={"type": "ineq", "fun": room},
        method="SLSQP",
        options={"ftol": 1e-14, "maxiter": 500},
    )
    # The other solver's own accuracy, with differences for derivatives.
    np.testing.assert_allclose(list(found.values.values()), np.exp(answer.x), rtol=1e-5)
    assert change(found.values) <= answer.x @ answer.x * (1 + 1e-7)


def test_an_image_that_is_inside_already_stays_as_it_is():
    dim = COLOURS.replace(key=1.0, fill=0.2)
    for goal in ("closest", "lexicographic"):
        found = fit(
            MIRRORED, dim, ENVELOPE, MATERIALS, objective=goal, cap=False, reference=Reference("key", exposure=0.1)
        )
        assert set(found.values.values()) == {1.0}
        assert {why.side for why in found.reasons.values()} == {"objective"}
        assert found.luminance == pytest.approx(1)


def test_the_lexicographic_answer_keeps_the_exposure_first():
    everything = LIGHTS + [Scale(f"{m}.diffuse") for m in MATTE]
    found = fit(MIRRORED, COLOURS, ENVELOPE, everything, objective="lexicographic", cap=False)
    closest = fit(MIRRORED, COLOURS, ENVELOPE, everything, objective="closest", cap=False)
    level = min(fit(MIRRORED, COLOURS, ENVELOPE, everything, cap=False).values.values())
    assert min(found.values.values()) == pytest.approx(level, rel=1e-12)
    assert min(closest.values.values()) < level
    assert change(closest.values) < change(found.values) < len(everything) * np.log(level) ** 2
    dimmed = feasible(MIRRORED, COLOURS, ENVELOPE, Exposure()).high
    lights = fit(MIRRORED, COLOURS, ENVELOPE, LIGHTS, objective="lexicographic", cap=False)
    assert min(lights.values.values()) == pytest.approx(dimmed, rel=1e-12)


@pytest.mark.parametrize("seed", range(6))
def test_the_brightest_agrees_with_the_whole_linear_programme(seed):
    random = np.random.default_rng(seed)
    columns = tuple(Interaction("key", (f"{m}.diffuse",)) for m in sorted(MATTE))
    weights = random.uniform(0, 1, (60, 6)) * (random.uniform(size=(60, 6)) < 0.5)
    image = LinearSystem(sparse.csr_array(weights), columns, 6, 10, {"key": 1.0})
    found = fit(
        image, COLOURS, ENVELOPE, [Scale(m) for m in MATTE], objective="brightest", within=(0.01, 5.0), cap=False
    )
    products = gamma(columns, COLOURS) / Reference().white(image, COLOURS)
    rows = (weights[:, None, :] * products.T[None]).reshape(-1, 6)
    white = luminance_weights(BANDS) * Reference().white(image, COLOURS)
    gain = weights.sum(axis=0) * (products @ (white / white.sum()))
    oracle = linprog(-gain, rows, np.tile(ENVELOPE.upper, 60), bounds=[(0.01, 5.0)] * 6)
    reached = gain @ [found.values[m] for m in sorted(MATTE)]
    assert found.optimum == "global"
    # HiGHS may pass its bounds by 1e-7.
    assert reached == pytest.approx(-oracle.fun, rel=1e-7)
    # SciPy's interior-point solver, without the crossover, is no help to 1e-9: the vertex of the oracle's rows is.
    tight = np.argsort(oracle.ineqlin.residual)[: int((np.abs(oracle.ineqlin.marginals) > 1e-9).sum())]
    free = (oracle.x < 5.0 - 1e-6) & (oracle.x > 0.01 + 1e-6)
    if len(tight) == free.sum():
        x = oracle.x.copy()
        x[free] = np.linalg.solve(
            rows[tight][:, free], np.tile(ENVELOPE.upper, 60)[tight] - rows[tight][:, ~free] @ x[~free]
        )
        assert reached == pytest.approx(gain @ x, rel=1e-9)


def test_no_other_objective_is_brighter_than_the_brightest():
    for scales in (MATERIALS, LIGHTS, FEW):
        found = fit(MIRRORED, COLOURS, ENVELOPE, scales, objective="brightest", cap=False)
        for goal in ("lightest", "closest", "lexicographic", "contrast"):
            other = fit(MIRRORED, COLOURS, ENVELOPE, scales, objective=goal, cap=False)
            assert other.luminance <= found.luminance * (1 + 1e-9)


def test_contrast_is_the_largest_nearby_and_regions_are_the_callers():
    random = np.random.default_rng(0)
    objects = np.flatnonzero(MIRRORED.object_pixels)

    def mask(some):
        found = np.zeros(24 * 24, dtype=bool)
        found[some] = True
        return found.reshape(24, 24)

    chosen = [random.choice(objects, 40, replace=False) for _ in range(3)]
    regions = [(mask(a), mask(b)) for a, b in pairwise(chosen)]

    def least(values):
        light = np.zeros(24 * 24)
        light[objects] = reflected(MIRRORED, values) @ LUMINANCE
        return min(np.log(light[a.ravel()].mean() / light[b.ravel()].mean()) for a, b in regions)

    found = fit(
        MIRRORED, COLOURS, ENVELOPE, MATERIALS, objective="contrast", regions=regions, cap=False, least_luminance=0
    )
    assert found.optimum == "local"
    given = fit(MIRRORED, COLOURS, ENVELOPE, MATERIALS, objective="closest", cap=False)
    assert least(found.values) > least(given.values)
    for values in nearby(found, 150, 0.02):
        if inside(MIRRORED, values):
            # The search ends where a step brings less than 1e-7.
            assert least(values) <= least(found.values) + 1e-5


def test_a_bound_on_luminance_is_kept_where_some_image_keeps_it():
    free = fit(MIRRORED, COLOURS, ENVELOPE, MATERIALS, objective="contrast", cap=False, least_luminance=0)
    bound = fit(MIRRORED, COLOURS, ENVELOPE, MATERIALS, objective="contrast", cap=False, least_luminance=0.9)
    assert free.luminance < 0.9
    assert bound.luminance == pytest.approx(0.9, rel=1e-6)
    assert (bound.verdict, bound.optimum) == ("complete", "local")


@pytest.mark.parametrize("goal", ["lightest", *GOALS])
def test_black_is_no_acceptable_solution(goal):
    """A white wall whose lamp shines on one pixel a hundred times: only darkness would do."""
    column = (Interaction("key", ("wall.diffuse",)),)
    image = LinearSystem(sparse.csr_array([[100.0], [1.0], [1.0]]), column, 1, 3, {"key": 1.0})
    colours = Palette(BANDS, {"key": 1.0, "wall.diffuse": 0.9})
    options = {"objective": goal, "cap": False, "within": (1e-4, 3)}
    options |= {"regions": [(np.array([[1, 0, 0]], bool), np.array([[0, 1, 1]], bool))]} if goal == "contrast" else {}
    found = fit(image, colours, ENVELOPE, [Scale("key")], **options)
    assert found.verdict == "unacceptable"
    assert repr(found).startswith("No acceptable solution")
    told = fit(image, colours, ENVELOPE, [Scale("key")], least_luminance=0, **options)
    assert told.verdict == "complete"
    assert told.luminance < 0.5


@pytest.mark.parametrize(
    ("goal", "seed"),
    [(g, s) for g in GOALS[:2] for s in range(6)]
    + [(g, s) for g in GOALS[2:] for s in (0, 3, 9)]
    + [pytest.param(g, s, marks=pytest.mark.exhaustive) for g in GOALS for s in range(6, 15) if s != 9],
)
def test_awkward_systems_are_fitted_inside(goal, seed):
    image, colours, materials = awkward(seed)
    options = {"objective": goal, "cap": seed % 2 == 0, "least_luminance": 0}
    try:
        found = fit(image, colours, UNIT, [Scale(m) for m in materials] + LIGHTS[: seed % 3], **options)
    except ValueError as error:
        assert "has no light" in str(error)  # noqa: PT017 -- the other seeds have
        return
    out = np.concatenate([found.untouched_outside, found.unfixable])
    kept = ~np.isin(np.flatnonzero(image.object_pixels), out)
    assert not (reflected(image, found.values, colours)[kept] > 1 + 1e-14).any()
    if options["cap"] and not colours.unphysical:
        assert all(m not in found.above_one or found.values[m] <= 0.01 for m in materials)


@pytest.mark.parametrize("black", ["luminance", "strict"])
@pytest.mark.parametrize("goal", GOALS)
def test_pixels_above_black_stay_so(goal, black):
    gamut = device_gamut(DEVICE, "envelope", black)
    found = fit(MIRRORED, COLOURS, gamut, MATERIALS, objective=goal, cap=False)
    light = fit(MIRRORED, COLOURS, gamut, MATERIALS, cap=False)

    def above(values):
        if black == "strict":
            return (reflected(MIRRORED, values) >= gamut.lower).all(axis=1)
        return reflected(MIRRORED, values) @ LUMINANCE >= (DEVICE.samples @ LUMINANCE).min()

    assert (above({}) & above(light.values) & ~above(found.values)).sum() == 0
    assert inside(MIRRORED, {n: v * (1 - 1e-15) for n, v in found.values.items()})


@pytest.mark.parametrize("goal", ["closest", "brightest"])
def test_duplicates_empty_rows_and_sizes_of_any_kind_do_not_disturb_the_optimum(goal):
    sizes = 10.0 ** np.arange(-12, 13, 4)
    columns = tuple(Interaction("key", (f"m{k}.diffuse",)) for k in range(len(sizes) + 1))
    matrix = np.zeros((3 * len(sizes), len(sizes) + 1))
    matrix[: len(sizes), : len(sizes)] = np.diag(sizes * 2)
    matrix[len(sizes) : 2 * len(sizes)] = matrix[: len(sizes)]
    image = LinearSystem(sparse.csr_array(matrix), columns, 1, 3 * len(sizes), {"key": 1.0})
    reflectances = {f"m{k}.diffuse": 1 / size for k, size in enumerate(sizes)}
    unseen = f"m{len(sizes)}.diffuse"
    colours = Palette(BANDS, {"key": 1.0, **reflectances, unseen: 0.5}, unphysical=True)
    scales = [Scale(f"m{k}") for k in range(len(sizes) + 1)]
    found = fit(image, colours, UNIT, scales, objective=goal, cap=False)
    assert list(found.values.values())[:-1] == pytest.approx([0.5] * len(sizes), rel=1e-11)


@pytest.mark.parametrize("goal", GOALS)
@pytest.mark.parametrize("short", [1e-12, 1e-9, 1e-7])
def test_what_is_empty_by_little_is_not_called_complete(goal, short):
    column = (Interaction("key", ("m.diffuse",)),)
    image = LinearSystem(sparse.csr_array([[1.0], [0.5]]), column, 1, 2, {"key": 1.0})
    colours = Palette(BANDS, {"key": 1.0, "m.diffuse": 1.0})
    found = fit(image, colours, UNIT, [Scale("m")], objective=goal, within=(1 + short, 1.5), cap=False)
    assert (found.verdict, found.unfixable.tolist()) == ("rest-only", [0])
    exactly = fit(image, colours, UNIT, [Scale("m")], objective=goal, within=(1 - 1e-13, 1.5), cap=False)
    assert exactly.verdict == "complete"
    assert exactly.values["m"] <= 1


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"regions": [], "objective": "closest"}, "does not look at"),
        ({"objective": "contrast", "regions": [(np.ones((2, 2), bool),) * 2]}, "one value a pixel"),
        ({"objective": "contrast", "regions": [(np.zeros((24, 24), bool),) * 2]}, "has no light"),
        ({"least_luminance": 2.0}, "least_luminance"),
        ({"objective": "closest", "system": replace(MIRRORED, G=-MIRRORED.G)}, "one scale at a time"),
    ],
)
def test_bad_questions_are_answered_in_one_line(change, message):
    question = {"system": MIRRORED, "palette": COLOURS, "gamut": UNIT, "scales": MATERIALS} | change
    with pytest.raises(ValueError, match=message) as error:
        fit(**question)
    assert "\n" not in str(error.value)


def test_the_answer_says_what_it_is_and_what_it_took():
    text = repr(fit(MIRRORED, COLOURS, ENVELOPE, MATERIALS, objective="brightest", cap=False))
    answer = "The brightest image inside with scales in 0.01 … 3 (complete; none nearby is better)."
    assert " ".join(text.split()).startswith(answer)
    assert "of up to" in text
    assert "mean luminance" in text
