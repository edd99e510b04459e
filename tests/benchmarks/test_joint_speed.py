"""What fits of several scales cost: as a ratio to the whole linear programme; seconds are reported, never asserted."""

import numpy as np
import pytest
from benchmarks.pairs import ratio, seconds
from scipy import sparse
from scipy.optimize import linprog

import symrt as rt
from symrt.feedback.joint import filling, objectives
from symrt.feedback.joint.constraints import joint
from symrt.feedback.joint.filling import Task
from symrt.feedback.joint.objectives import mean_luminance
from symrt.feedback.joint.planes import largest
from symrt.feedback.limits import limits
from symrt.feedback.parameters import moved_ends
from symrt.spectra.products import gamma

pytestmark = pytest.mark.benchmark
GAMUT = rt.device_gamut(rt.load_device("dye3-endura-premier"), "envelope")
BANDS = GAMUT.bands
SPAN = (0.01, 5.0)


def materials(side, count, mirrored, seed=0):
    """Textures: each pixel a mixture of some materials under two lights, perhaps seen in a mirror, too."""
    random = np.random.default_rng(seed)
    names = [f"m{k}" for k in range(count)]
    columns = sorted(rt.Interaction(light, (f"{m}.diffuse",)) for light in ("fill", "key") for m in names)
    if mirrored:
        columns = sorted([*columns, *(rt.Interaction("key", ("m0.mirror", f"{m}.diffuse")) for m in names)])
    weights = random.uniform(0, 1, (side**2, len(columns))) * (random.uniform(size=(side**2, len(columns))) < 0.4)
    system = rt.LinearSystem(sparse.csr_array(weights), tuple(columns), side, side, {"key": 1.0, "fill": 1.0})
    spectra = {"key": random.uniform(1, 3, 36), "fill": random.uniform(0.1, 0.5, 36)}
    spectra |= {name: random.uniform(0.05, 0.6, 36) for name in system.reflectances}
    return system, rt.Palette(BANDS, spectra), names


def task(system, palette, names):
    asked = limits(system, palette, GAMUT)
    symbols = {name: frozenset(moved_ends(system, palette, rt.Scale(name))) for name in sorted(names)}
    return Task(system, palette, asked, symbols, SPAN, cap=False)


def test_an_affine_fit_is_twenty_times_faster_than_the_whole_programme(report, benchmark):
    """128² pixels × 36 bands × 8 materials: 590,000 rows."""
    system, palette, names = materials(128, 8, mirrored=False)
    asked = task(system, palette, names)
    products = gamma(system.interactions, palette) @ asked.asked.upper.matrix
    owner = np.array([names.index(i.met[0].partition(".")[0]) for i in system.interactions])
    rows = np.zeros((system.G.shape[0], products.shape[1], len(names)))
    for k in range(len(names)):
        rows[:, :, k] = system.G[:, owner == k] @ products[owner == k]
    rows, bounds = rows.reshape(-1, len(names)), np.tile(asked.asked.upper.upper, system.G.shape[0])
    found = joint(asked)
    gain = np.exp(mean_luminance(found).logs[0]) @ mean_luminance(found).exponents

    def whole():
        return linprog(-gain, rows, bounds, bounds=[SPAN] * len(names))

    solution = largest(mean_luminance(found), found)
    assert gain @ np.exp(solution.y) == pytest.approx(-whole().fun, rel=1e-7)
    times, slow, quick = ratio(whole, lambda: largest(mean_luminance(found), found), pairs=3)
    benchmark(lambda: largest(mean_luminance(found), found))
    report(
        f"affine fit of {len(rows):,} rows × {len(names)}: {quick:.3f} s in {solution.rounds} programmes, "
        f"{times:.0f} times faster than the whole one ({slow:.2f} s)"
    )
    assert times >= 20


def test_the_whole_fit_in_logarithms(report, benchmark):
    """64² pixels × 36 bands, 7 scales with a mirror among them: 147,000 rows, certified and explained."""
    system, palette, names = materials(64, 5, mirrored=True)
    scales = [rt.Scale(name) for name in (*names, "key", "fill")]
    options = {"within": SPAN, "cap": False, "least_luminance": 0}
    for objective in ("closest", "lexicographic", "brightest"):
        spent = [
            seconds(lambda o=objective: rt.fit(system, palette, GAMUT, scales, objective=o, **options))
            for _ in range(3)
        ]
        found = rt.fit(system, palette, GAMUT, scales, objective=objective, **options)
        report(
            f"{objective} fit of {36 * 64**2:,} rows × {len(scales)}: {min(spent):.2f} s "
            f"({found.rounds} programmes of up to {found.rows} rows, {found.optimum})"
        )
    filling = seconds(lambda: rt.fit(system, palette, GAMUT, scales, objective="lightest", **options))
    closest = benchmark(lambda: seconds(lambda: rt.fit(system, palette, GAMUT, scales, objective="closest", **options)))
    assert closest <= 5 * filling


def test_the_safe_box_of_the_globe(system, palette, report, benchmark):
    scales = [rt.Scale(name) for name in sorted({s.partition(".")[0] for s in system.reflectances})]
    rt.safe_box(system, palette, GAMUT, scales, cap=False)
    pair = ratio(
        lambda: rt.safe_box(system, palette, GAMUT, scales, cap=False),
        lambda: rt.fit(system, palette, GAMUT, scales, objective="lightest", cap=False),
        pairs=3,
    )
    benchmark.pedantic(lambda: rt.safe_box(system, palette, GAMUT, scales, cap=False), rounds=1)
    report(
        f"safe box of {len(scales)} scales, globe 512²: {pair[1]:.2f} s, "
        f"{pair[0]:.2f} times the lightest fit ({pair[2]:.2f} s)"
    )
    assert pair[0] <= 4


def test_pixels_that_decide_for_all_others_make_a_fit_faster(system, palette, report, benchmark, monkeypatch):
    names = {*(s.partition(".")[0] for s in system.reflectances), *system.lights}
    gamut = rt.device_gamut(rt.load_device("dye3-endura-premier"), "envelope", "strict")

    def fitted():
        return rt.fit(
            system, palette, gamut, [rt.Scale(name) for name in sorted(names)], objective="contrast", cap=False
        )

    def with_every_pixel():
        with monkeypatch.context() as patch:
            for module in (filling, objectives):
                patch.setattr(module, "outermost", lambda coefficients, pixels, *, upper=True: pixels)  # noqa: ARG005
            return fitted()

    assert fitted().values == pytest.approx(with_every_pixel().values, rel=1e-6)
    pair = ratio(with_every_pixel, fitted, pairs=2)
    benchmark.pedantic(fitted, rounds=1)
    report(
        f"contrast of {len(names)} scales with black kept, globe 512²: {pair[2]:.2f} s, {pair[0]:.1f} times faster "
        f"than with every pixel ({pair[1]:.2f} s)"
    )
    assert pair[0] >= 2
