"""The spectral basis (the paper, §2.1), against exact rationals and closed forms."""

import numpy as np
import pytest
from flint import fmpq, fmpq_mat

from symrt.gamut.basis import uniform_first

UNIT = 2.0**-53


def worst_orthogonality(vectors):
    """‖Q Qᵀ − I‖ with the products summed exactly: oracle Q."""
    size = len(vectors)
    exact = fmpq_mat(size, vectors.shape[1], [fmpq(*float(v).as_integer_ratio()) for v in vectors.ravel()])
    error = exact * exact.transpose() - fmpq_mat(
        size, size, [fmpq(int(i == j)) for i in range(size) for j in range(size)]
    )
    values = [int(e.p) / int(e.q) for e in error.entries()]
    return np.linalg.norm(np.reshape(values, (size, size)), 2)


def hard_samples():
    random = np.random.default_rng(4)
    colours = random.uniform(0.02, 0.95, (60, 36))
    smooth = random.uniform(0, 1, (200, 4)) @ random.uniform(0, 0.25, (4, 36))
    yield "colours", colours
    yield "rank deficient", smooth
    yield "duplicates", np.repeat(colours[:3], 20, axis=0)
    yield "constant", np.full((9, 36), 0.37)
    yield "single", colours[:1]
    yield "single band", colours[:, :1]
    yield "two bands", colours[:, :2]
    yield "fewer samples than bands", colours[:5]
    yield "huge", smooth * 1e200
    yield "tiny", smooth * 1e-200
    yield "huge and tiny", np.vstack([smooth * 1e200, smooth * 1e-200])
    yield "graded", smooth @ np.diag(np.geomspace(1, 1e-13, 36))
    yield "zero", np.zeros((3, 36))
    yield "flat ends", np.pad(colours[:, 3:33], ((0, 0), (3, 3)), mode="edge")


@pytest.mark.parametrize(("name", "samples"), list(hard_samples()))
def test_basis_is_orthonormal_to_eight_rounding_errors_a_band(name, samples):
    basis = uniform_first(samples)
    bands = samples.shape[1]
    assert basis.vectors.shape == (bands, bands)
    assert worst_orthogonality(basis.vectors) <= 8 * bands * UNIT, name


@pytest.mark.parametrize(("name", "samples"), list(hard_samples()))
def test_first_vector_is_bitwise_constant(name, samples):
    first = uniform_first(samples).vectors[0]
    assert np.all(first == first[0]), name
    assert first[0] == 1 / np.sqrt(samples.shape[1])


def test_hundreds_of_bands_stay_orthonormal():
    samples = np.random.default_rng(5).uniform(0, 1, (40, 401))
    basis = uniform_first(samples)
    assert np.linalg.norm(basis.vectors @ basis.vectors.T - np.eye(401), 2) <= 8 * 401 * UNIT
    assert basis.rank == 40


def test_thirty_six_bands_give_one_sixth_and_white_has_coordinate_six():
    # The paper, §2.1: k = 1/36^(1/2) = 1/6, c_0 in [0, 6].
    basis = uniform_first(np.random.default_rng(6).uniform(0, 1, (50, 36)))
    assert np.all(basis.vectors[0] == 1 / 6)
    white = basis.coordinates(np.ones((1, 36)))[0]
    assert abs(white[0] - 6) <= 4 * np.spacing(6.0)
    assert np.all(np.abs(white[1:]) <= 36 * 8 * UNIT)


@pytest.mark.parametrize(
    ("samples", "rank"),
    [
        (np.full((9, 36), 0.37), 0),
        (np.zeros((3, 36)), 0),
        (np.repeat(np.random.default_rng(1).uniform(0, 1, (3, 36)), 5, axis=0), 3),
        (np.random.default_rng(1).uniform(0, 1, (3, 36)) * 1e200, 3),
        (np.random.default_rng(1).uniform(0, 1, (300, 36)), 35),
        (np.random.default_rng(1).uniform(0, 1, (30, 1)), 0),
        (np.vstack([np.full(36, 0.2), np.linspace(0, 1, 36)]), 1),
    ],
)
def test_rank_counts_what_the_samples_determine(samples, rank):
    assert uniform_first(samples).rank == rank


def test_noise_is_not_a_basis():
    noise = np.random.default_rng(2).normal(0, 1e-12, (50, 36))
    with pytest.warns(UserWarning, match="noise, not a basis"):
        uniform_first(0.5 + noise)


def test_permuted_samples_span_the_same_subspaces():
    random = np.random.default_rng(3)
    samples = random.uniform(0, 1, (80, 6)) * [1, 0.5, 0.2, 0.1, 0.05, 0.02] @ random.uniform(0, 1, (6, 36))
    one, other = (uniform_first(s).vectors for s in (samples, samples[random.permutation(80)]))
    for k in range(1, 7):
        cosines = np.linalg.svd(one[:k] @ other[:k].T)[1]
        assert np.all(np.abs(cosines - 1) < 1e-12)


def test_the_largest_component_of_each_vector_is_positive():
    vectors = uniform_first(np.random.default_rng(7).uniform(0, 1, (80, 36))).vectors
    assert np.all(vectors[np.arange(36), np.argmax(np.abs(vectors), axis=1)] > 0)


def test_error_of_k_components_is_that_of_the_spectra_they_give_back():
    samples = np.random.default_rng(8).uniform(0, 1, (30, 12))
    basis = uniform_first(samples)
    coordinates = basis.coordinates(samples)
    for k in range(1, 13):
        left = samples - basis.spectra(coordinates[:, :k])
        assert np.sqrt(np.mean(left**2)) == pytest.approx(basis.rms[k - 1], rel=1e-9, abs=1e-14)
    centred_not = np.linalg.svd(samples, compute_uv=False)
    assert basis.rms_plain[0] == pytest.approx(np.sqrt(np.sum(centred_not[1:] ** 2) / samples.size), rel=1e-12)
    assert np.all(basis.rms_plain <= basis.rms + 1e-14), "principal components are the best of all bases"


def test_bad_samples_are_named():
    with pytest.raises(ValueError, match="sample 1, band 2 is nan"):
        uniform_first(np.array([[0.1, 0.2, 0.3], [0.1, 0.2, np.nan]]))
    with pytest.raises(ValueError, match="at least one spectrum"):
        uniform_first(np.zeros((0, 36)))
