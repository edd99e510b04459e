"""The mixture of some points that is nearest to another: distances to the convex hulls of step 4.

The nearest mixture comes from non-negative least squares [1]_: the v that minimises ``‖(S − r)ᵀ v‖² + (Σ v − 1)²`` has
the weights' ratios.  Only a few prints take part; those that a plane through their mixture leaves outside are brought
in until there are none, and that plane then proves how far the hull is.

References
----------
.. [1] C. L. Lawson and R. J. Hanson, "Solving Least Squares Problems", Prentice-Hall 1974, ch. 23.
.. [2] P. Wolfe, "Finding the nearest point in a polytope", Mathematical Programming 11, 1976, pp. 128-149.
"""

import numpy as np
from jaxtyping import Float, Int
from scipy.optimize import nnls

from symrt.arrays import PerPixel, PixelBands, Spectrum

BROUGHT_IN = 16
"""Prints that join the mixture of a spectrum in each round."""
ROUNDS = 200
EXACT = 1e-7
"""What is outside by less counts as on the boundary: near it the squares of differences are lost in rounding."""
AIM = 1e-11
"""Distances are sought to this, as long as they get less."""
STALLED = 1 - 1e-6
"""Of the distance in the round before: what gets no less has arrived, if its plane says so too."""
SQUARE = 1e-20
"""Of lengths at most 1: a plane this close to the nearest mixture has all points behind it."""
MIXED_AT_ONCE = 2048
"""Spectra whose inner products with all prints are in memory at once."""


def nearest_mixtures(
    samples: Float[np.ndarray, "sample band"], spectra: PixelBands, enough: float | None = None
) -> tuple[PixelBands, PerPixel]:
    """The mixture of samples nearest to each spectrum, and a distance that no mixture comes nearer than.

    Parameters
    ----------
    samples
        Points whose convex hull is meant, one a row.
    spectra
        Points to come near to.
    enough
        Stop where it is certain whether the distance is below or above this; None, go on to the nearest of all.

    Examples
    --------
    >>> corners = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    >>> mixtures, apart = nearest_mixtures(corners, np.array([[1.0, 1.0], [0.2, 0.2]]))
    >>> mixtures.round(9).tolist(), apart.round(6).tolist()
    ([[0.5, 0.5], [0.2, 0.2]], [0.707107, 0.0])
    """
    chunks = range(0, len(spectra), MIXED_AT_ONCE)
    parts = [_nearest(samples, spectra[first : first + MIXED_AT_ONCE], enough) for first in chunks]
    if not parts:
        return spectra.copy(), np.zeros(0)
    return np.vstack([mixtures for mixtures, _ in parts]), np.concatenate([apart for _, apart in parts])


def _nearest(
    samples: Float[np.ndarray, "sample band"], spectra: PixelBands, enough: float | None
) -> tuple[PixelBands, PerPixel]:
    """As `nearest_mixtures`, for a chunk of spectra."""
    # Begin with the samples nearest to each spectrum.
    squares = np.sum(samples**2, axis=1) - 2 * (spectra @ samples.T)
    few = min(BROUGHT_IN, len(samples))
    taking_part = list(np.argpartition(squares, few - 1, axis=1)[:, :few])
    mixtures, apart = spectra.copy(), np.zeros(len(spectra))
    rows, before = np.arange(len(spectra)), np.full(len(spectra), np.inf)
    for _ in range(ROUNDS):
        # SciPy has no batched least squares of this kind; each of these small problems takes some 20 µs.
        for row in rows:
            taking_part[row], mixtures[row] = _mixed(samples, taking_part[row], spectra[row])

        # The plane across the way to the mixture, pushed beyond all samples, bounds the distance from below.
        normals = spectra[rows] - mixtures[rows]
        length = np.linalg.norm(normals, axis=1)
        beyond = normals @ samples.T
        reach = np.sum(normals * spectra[rows], axis=1) - beyond.max(axis=1)
        apart[rows] = np.maximum(apart[rows], reach / np.maximum(length, np.finfo(float).tiny))

        # Arrived is what the bound proves, what gets no nearer, and what is decided.
        open_ = length - apart[rows]
        done = (open_ <= AIM) | ((open_ <= EXACT / 2) & (length > before * STALLED)) | (length >= before)
        if enough is not None:
            done |= (length <= enough) | (apart[rows] > enough + EXACT)
        rows, beyond, before = rows[~done], beyond[~done], length[~done]
        if not rows.size:
            break

        # Bring in the samples that lie farthest beyond the plane.
        for row, newcomers in zip(rows, np.argpartition(-beyond, few - 1, axis=1)[:, :few], strict=True):
            taking_part[row] = np.union1d(taking_part[row], newcomers)
    return mixtures, apart


def _mixed(
    samples: Float[np.ndarray, "sample band"], taking_part: Int[np.ndarray, " few"], spectrum: Spectrum
) -> tuple[Int[np.ndarray, " less"], Spectrum]:
    """The samples that the nearest mixture of a few is made of, and that mixture."""
    # Solve for weights >= 0, with one more equation for their sum, at a scale at which both count alike.
    away = (samples[taking_part] - spectrum).T
    scale = max(float(np.abs(away).max()), np.finfo(float).tiny)
    rows = np.vstack([away / scale, np.ones(len(taking_part))])
    try:
        weights = nnls(rows, np.append(np.zeros(len(spectrum)), 1.0))[0]
    except RuntimeError:  # among nearly equal samples it may go in circles
        weights = _by_corrals(away.T / scale)

    # Only ratios of the weights count.
    used = weights > 0
    weights = weights[used] / weights[used].sum()
    return taking_part[used], weights @ samples[taking_part[used]]


def _by_corrals(points: Float[np.ndarray, "few band"]) -> Float[np.ndarray, " few"]:
    """Weights of the mixture nearest to the origin, by Wolfe's method, which meets no point twice [2]_."""
    weights = np.zeros(len(points))
    weights[np.sum(points**2, axis=1).argmin()] = 1.0
    for _ in range(ROUNDS):
        # Choose the point farthest towards the origin; the mixture is the nearest if none lies before its plane.
        mixture = weights @ points
        along = points @ mixture
        newcomer = int(along.argmin())
        if mixture @ mixture - along[newcomer] <= SQUARE or weights[newcomer] > 0:
            break
        corral = np.append(np.flatnonzero(weights), newcomer)

        # Find the nearest point of the plane through the corral; leave out points until it is a mixture of them.
        while True:
            square = points[corral] @ points[corral].T + 1
            free = np.linalg.lstsq(square, np.ones(len(corral)), rcond=None)[0]
            free /= free.sum()
            falling = free <= 0
            if not falling.any():
                break
            # As far towards the free solution as all weights stay: one of them becomes nothing, and leaves.
            held = weights[corral]
            share = (held[falling] / (held[falling] - free[falling])).min()
            weights[corral] = np.where(falling & (held <= share * (held - free)), 0.0, held + share * (free - held))
            corral = corral[weights[corral] > 0]
        weights[:] = 0
        weights[corral] = free
    return weights
