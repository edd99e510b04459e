"""How fast shading is, as a ratio to the bare sparse product of the same matrices in the same run."""

import time

import numpy as np
import pytest
from scipy import sparse

import symrt as rt
from symrt.interactions import Interaction
from symrt.spectra.bands import wavelengths
from symrt.spectra.palette import Palette
from symrt.spectra.products import gamma
from symrt.spectra.shading import preview, shade
from symrt.system import LinearSystem

SIDE = 512
LIGHTS = ("fill", "key")
MATERIALS = tuple(f"m{k:02d}" for k in range(20))


def globe_like():
    """As many pixels, columns and coefficients as a globe: 30 % background, else 1 to 8 of 40 interactions."""
    rng = np.random.default_rng(0)
    interactions = tuple(Interaction(light, (f"{material}.diffuse",)) for light in LIGHTS for material in MATERIALS)
    counts = rng.integers(1, 9, SIDE**2) * (rng.random(SIDE**2) < 0.7)
    indptr = np.concatenate([[0], np.cumsum(counts)])
    columns = rng.integers(0, len(interactions), indptr[-1])
    matrix = sparse.csr_array((rng.random(indptr[-1]), columns, indptr), shape=(SIDE**2, len(interactions)))
    system = LinearSystem(matrix, interactions, SIDE, SIDE, dict.fromkeys(LIGHTS, 1 / np.pi))
    spectra = dict.fromkeys(LIGHTS, "illuminant/D65") | {f"{m}.diffuse": rng.random(36) for m in MATERIALS}
    return system, Palette(wavelengths(380, 730, 10), spectra)


def interleaved(*actions, rounds=15):
    """The fastest of some rounds for each action, taken in turns so that a busy machine is busy for all of them."""
    best = [np.inf] * len(actions)
    for _ in range(rounds):
        for k, action in enumerate(actions):
            start = time.perf_counter()
            action()
            best[k] = min(best[k], time.perf_counter() - start)
    return best


@pytest.mark.benchmark(group="shade 36 bands, 512²")
def test_shading_costs_at_most_half_more_than_the_bare_product(benchmark):
    system, palette = globe_like()
    spectra = gamma(system.interactions, palette)
    bare, shaded = interleaved(lambda: system.G @ spectra, lambda: shade(system, palette))
    benchmark.extra_info |= {"ratio to bare CSR": round(shaded / bare, 3), "bare ms": round(1e3 * bare, 1)}
    benchmark(shade, system, palette)
    assert shaded <= 1.5 * bare


@pytest.mark.benchmark(group="shade 36 bands, many lights")
def test_shading_a_million_coefficients_takes_at_most_twenty_milliseconds(benchmark):
    # Processor time, which another program on the same machine does not lengthen as much.
    system, palette = (
        rt.render(rt.load_scene("many_lights"), progress=False),
        rt.load_palettes("many_lights")["macbeth"],
    )
    spent = []
    for _ in range(9):
        start = time.process_time()
        shade(system, palette)
        spent.append(time.process_time() - start)
    benchmark.extra_info |= {"ms a million": round(1e9 * min(spent) / system.G.nnz, 1), "columns": system.G.shape[1]}
    benchmark(shade, system, palette)
    assert min(spent) <= 0.020 * system.G.nnz / 1e6


@pytest.mark.benchmark(group="sRGB preview, 512²")
def test_a_preview_takes_at_most_fifteen_milliseconds(benchmark):
    system, palette = globe_like()
    benchmark(preview, system, palette)
    assert interleaved(lambda: preview(system, palette))[0] <= 0.015
