"""The pixels that decide for all others: the largest of all is among them, whatever lights and materials."""

import numpy as np
import pytest
from feedback.synthetic import awkward, palette, system
from scipy import sparse

from symrt.device import load_device
from symrt.feedback import Scale, fit
from symrt.feedback.joint import filling, objectives
from symrt.feedback.joint.outermost import outermost
from symrt.gamut import device_gamut
from symrt.interactions import Interaction
from symrt.system import LinearSystem


def unnamed(matrix):
    """A system of one row of pixels, whose columns are lights without names of their own."""
    columns = tuple(Interaction(f"light{k}") for k in range(matrix.shape[1]))
    return LinearSystem(sparse.csr_array(matrix), columns, 1, matrix.shape[0], {i.light: 1.0 for i in columns})


def some_systems():
    random = np.random.default_rng(0)
    dense = random.uniform(0, 1, (3000, 4)) ** 2
    circle = np.column_stack([np.cos(t := np.linspace(0, np.pi / 2, 2000)), np.sin(t)])
    equal = np.repeat([[0.5, 0.25, 0.125]], 300, axis=0)
    flat = np.column_stack([t, 1 - t, np.zeros_like(t)])[t < 1]
    sizes = dense * 10.0 ** np.array([-9, -3, 3, 9])
    return [sparse.csr_array(m) for m in (dense, circle, equal, flat, sizes)] + [system().G, awkward(3)[0].G]


@pytest.mark.parametrize("matrix", some_systems(), ids=lambda matrix: str(matrix.shape))
@pytest.mark.parametrize("upper", [True, False])
def test_the_extreme_of_every_sum_is_among_them(matrix, upper):
    random = np.random.default_rng(1)
    pixels = np.flatnonzero(np.diff(matrix.indptr))
    found = outermost(unnamed(matrix), pixels, upper=upper)
    assert np.isin(found, pixels).all()
    assert (np.diff(found) > 0).all()
    support = np.unique(matrix[pixels].toarray() > 0, axis=0)
    for _ in range(50):
        spectra = random.exponential(1, matrix.shape[1]) ** 3 / np.maximum(matrix.max(axis=0).toarray().ravel(), 1e-12)
        value = matrix @ spectra
        for columns in support:
            same = pixels[((matrix[pixels].toarray() > 0) == columns).all(axis=1)] if len(support) < 4 else pixels
            best, among = value[same], value[np.intersect1d(found, same)]
            if upper:
                assert best.max() <= among.max() * (1 + 1e-14)
            else:
                assert best.min() >= among.min() * (1 - 1e-14)


def test_few_are_left_of_a_smooth_picture_and_one_of_equal_pixels():
    t, s = np.meshgrid(np.linspace(0, 1, 100), np.linspace(0, 1, 100))
    matrix = sparse.csr_array(np.column_stack([(t * s).ravel() + 0.1, (1 - t**2).ravel() + 0.1]))
    assert len(outermost(unnamed(matrix), np.arange(10000))) <= 200
    assert outermost(unnamed(np.ones((50, 3))), np.arange(7, 50)).tolist() == [7]
    assert not len(outermost(unnamed(np.zeros((4, 3))), np.arange(4)))


@pytest.mark.parametrize("black", ["clip", "luminance"])
@pytest.mark.parametrize("goal", ["lightest", "closest", "contrast"])
def test_fits_are_the_same_with_every_pixel(monkeypatch, goal, black):
    image, colours, scales = system(), palette(), [Scale("key"), Scale("brass"), Scale("ice")]
    gamut = device_gamut(load_device("dye3-endura-premier"), "envelope", black)
    few = fit(image, colours, gamut, scales, objective=goal, cap=False)
    for module in (filling, objectives):
        monkeypatch.setattr(module, "outermost", lambda system, pixels, *, upper=True: pixels)  # noqa: ARG005
    every = fit(image, colours, gamut, scales, objective=goal, cap=False)
    assert few.values == pytest.approx(every.values, rel=1e-7 if goal == "contrast" else 1e-11)
    assert few.reasons == every.reasons
