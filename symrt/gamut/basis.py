"""An orthonormal basis for a device's spectra, the constant one first: step 4 of the paper.

Samples S of the device's reflectances (sample × band) give β_0 = 1/√K · 1 exactly, then the principal components of
what is left when that direction is taken out: R = S − (S u) uᵀ.  The samples are not centred, because the neutral axis
passes through black.  Coordinates are ``c = B r`` and spectra ``r = Bᵀ c`` [1]_.

Adding u to a finished set of principal components and running Gram–Schmidt loses orthogonality altogether when the
samples are rank deficient [2]_; deflating first and completing with Householder reflections keeps it.

References
----------
.. [1] The paper, §2.1.
.. [2] L. Giraud, J. Langou, M. Rozložník and J. van den Eshof, "Rounding error analysis of the classical Gram–Schmidt
   orthogonalization process", Numerische Mathematik 101, 2005, pp. 87-100.
"""

import warnings
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Shaped

NOISE = 1e-8
"""Samples that differ from constant spectra by less than this share of their size have no shape, only noise."""

Samples = Float[np.ndarray, "sample band"]


@dataclass(frozen=True, eq=False)
class Basis:
    """Orthonormal spectra β_i, the constant one first.

    Parameters
    ----------
    vectors
        β_i, one a row.
    rank
        Number of components after β_0 that the samples determine; the rest only complete the space.
    singular
        Singular values of the deflated samples, for those `rank` components.
    cosine
        Of the angle between the first principal component, had it been left free, and the constant spectrum.
    rms, rms_plain
        Root mean square error of the samples kept to their first k components, k = 1 … K: with the constant spectrum
        first, and for plain principal components.
    """

    vectors: Float[np.ndarray, "component band"]
    rank: int
    singular: Float[np.ndarray, " rank"]
    cosine: float
    rms: Float[np.ndarray, " component"]
    rms_plain: Float[np.ndarray, " component"]

    def coordinates(self, spectra: Float[np.ndarray, "*n band"]) -> Float[np.ndarray, "*n component"]:
        """Coordinates c = B r of spectra."""
        return spectra @ self.vectors.T

    def spectra(self, coordinates: Float[np.ndarray, "*n k"]) -> Float[np.ndarray, "*n band"]:
        """Spectra Bᵀ c of coordinates; fewer than K coordinates are the first ones, the rest are zero."""
        return coordinates @ self.vectors[: coordinates.shape[-1]]

    def __repr__(self) -> str:
        bands = len(self.vectors)
        return (
            f"Basis({bands} components, {self.rank} from the samples after the constant one; the first principal "
            f"component is {self.cosine:.4f} constant)"
        )


def uniform_first(samples: Samples) -> Basis:
    """The basis of `samples` whose first vector is exactly constant.

    Parameters
    ----------
    samples
        Reflectances, one a row; any number of them, of any rank.

    Raises
    ------
    ValueError
        If a sample is not finite, or there are none.

    Warns
    -----
    UserWarning
        If the samples differ from constant spectra by less than 1e-8 of their size.

    Examples
    --------
    >>> basis = uniform_first(np.array([[0.5, 0.5, 0.5, 0.5], [0.1, 0.1, 0.1, 0.9]]))
    >>> basis.vectors[0].tolist(), basis.rank
    ([0.5, 0.5, 0.5, 0.5], 1)
    >>> basis.vectors[1].round(3).tolist()
    [-0.289, -0.289, -0.289, 0.866]
    """
    # Bring the samples to size 1 and few rows.
    scaled, scale = _scaled(samples)
    # The triangle has the samples' right singular vectors and values, and at most as many rows as there are bands.
    scaled = np.asarray(np.linalg.qr(scaled, mode="r"))

    # Take out the constant direction, and find the principal components of the rest.
    bands = samples.shape[1]
    constant = np.full(bands, 1 / np.sqrt(bands))
    deflated = scaled
    for _ in range(2):  # the second time takes out what rounding left of the first
        deflated = deflated - np.outer(deflated @ constant, constant)
    _, singular, right = np.linalg.svd(deflated, full_matrices=False)

    # Singular values that are no more than rounding, or noise, tell of no component.
    plain = np.linalg.svd(scaled, full_matrices=False)
    size = plain.S[0]
    rank = min(int(np.sum(singular > max(samples.shape) * np.finfo(float).eps * size)), bands - 1)
    if rank and singular[0] < NOISE * size:
        warnings.warn(
            f"the samples differ from constant spectra by {singular[0] / size:.1g} of their size: the components "
            "after the constant one are noise, not a basis; give samples with more colour",
            UserWarning,
            stacklevel=2,
        )

    # Complete the basis, and measure what the first components leave.
    vectors = _completed(constant, right[:rank])
    return Basis(
        vectors=vectors,
        rank=rank,
        singular=singular[:rank] * scale,
        cosine=float(np.abs(plain.Vh[0] @ constant)) if size > 0 else 1.0,
        rms=_tails((scaled @ vectors.T) ** 2, samples.size) * scale,
        rms_plain=_tails(np.pad(plain.S, (0, bands - len(plain.S)))[None] ** 2, samples.size) * scale,
    )


def _scaled(samples: Samples) -> tuple[Samples, float]:
    """Samples divided by a power of two near their largest, so that squares neither overflow nor vanish."""
    if not samples.size:
        raise ValueError(f"samples are {samples.shape[0]} × {samples.shape[1]}: a basis needs at least one spectrum")
    if not np.all(np.isfinite(samples)):
        row, band = np.argwhere(~np.isfinite(samples))[0]
        raise ValueError(f"sample {row}, band {band} is {samples[row, band]}: every reflectance must be finite")
    exponent = int(np.frexp(np.abs(samples).max())[1])
    return np.ldexp(samples, -exponent), float(np.ldexp(1.0, min(exponent, 1023)))


def _completed(
    constant: Float[np.ndarray, " band"], components: Float[np.ndarray, "rank band"]
) -> Float[np.ndarray, "band band"]:
    """The constant spectrum, the components, and a null space that fills the room, orthonormal to rounding.

    Householder reflections stay orthogonal whatever they are given, so this also mends components of tiny singular
    value, which deflation leaves slightly oblique.
    """
    rows = np.vstack([constant, components])
    vectors = np.linalg.qr(rows.T, mode="complete").Q.T
    # Of components equally large up to rounding the first decides, so that the sign does not hang on the last bit.
    large = np.abs(vectors) > (1 - NOISE) * np.abs(vectors).max(axis=1, keepdims=True)
    peaks = vectors[np.arange(len(vectors)), np.argmax(large, axis=1)]
    vectors = vectors * np.where(peaks < 0, -1.0, 1.0)[:, None]
    vectors[0] = constant
    return vectors


def _tails(energies: Shaped[np.ndarray, "sample component"], count: int) -> Float[np.ndarray, " component"]:
    """Root mean square of what the first k components leave, k = 1 … K."""
    energy = energies.sum(axis=0)
    left = np.cumsum(energy[::-1])[::-1]
    return np.sqrt(np.append(left[1:], 0.0) / count)
