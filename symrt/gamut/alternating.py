"""Nearest points, and points deep inside, of the intersection of convex gamuts, for step 4 of the paper.

Parts that are made of slabs are one polyhedron together, whose nearest point is exact.  With other parts, hulls within
a tolerance, Dykstra's projections take turns [1]_: each part moves the point to its own nearest, after what it moved
it by in the last round is taken back.  They stop when those moves change by less than 1e-9 in a round, all together,
which, unlike a point that rests for a while, says that it has arrived [2]_.  What has not after 50 rounds is sought
from outside: the nearest point of a polyhedron that gets one more plane wherever a part is missed by more than 1e-9, so
that nothing in all parts is nearer than it.

What comes out may miss a part by rounding, or by what the stop left; it is moved by as little towards a point deep
inside, until each part contains it.

References
----------
.. [1] J. P. Boyle and R. L. Dykstra, "A method for finding projections onto the intersection of convex sets in Hilbert
   spaces", Lecture Notes in Statistics 37, 1986, pp. 28-47.
.. [2] E. G. Birgin and M. Raydan, "Robust stopping criteria for Dykstra's algorithm", SIAM Journal on Scientific
   Computing 26(4), 2005, pp. 1405-1414.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from jaxtyping import Bool, Int

from symrt.arrays import PerPixel, PixelBands, Spectrum
from symrt.gamut.basis import uniform_first
from symrt.gamut.hull import HullGamut
from symrt.gamut.interface import WIDER, ConvexGamut, SlabGamut, of_one_band
from symrt.gamut.joining import clipped_by_all, merged
from symrt.gamut.polyhedra import Normals, Offsets, deepest, halfspaces, nearest_point

THINNEST = 1e-9
"""An intersection that holds no ball larger than this counts as empty."""
SETTLED = 1e-9
"""Change of the moves in a round, by root of the sum of their squares, at which the projections stop."""
FAR_SHARE = 2.0**-43
"""Share of a spectrum's length that its nearest point may be off by: of what is far away, projections stop there."""
TURNS = 50
PLANES_TRIED = 1000
"""Planes that are tried before a search is given up as hopeless."""
SHRINKS = 60

Project = Callable[[PixelBands], PixelBands]


def deep_inside(parts: Sequence[ConvexGamut]) -> tuple[Spectrum, float]:
    """A point deep inside all, and the radius of a ball around it; not above `THINNEST` if they have nothing in common.

    Where a part is no polyhedron, the ball is one that no plane seen so far cuts.

    Examples
    --------
    >>> from symrt.gamut.gamuts import device_gamut
    >>> from symrt.device.inks import load_device
    >>> device = load_device("dye3-endura-premier")
    >>> deep_inside([device_gamut(device, "unit"), device_gamut(device, "envelope")])[1]
    0.45
    """
    normals, offsets, others = _planes(parts)
    # Within half of a hull's tolerance is well within it; only where there is nothing the whole is looked at.
    half = [replace(part, tolerance=part.tolerance / 2) if isinstance(part, HullGamut) else part for part in others]
    centre, radius = _deepest(normals, offsets, half)
    return (centre, radius) if radius > THINNEST or not others else _deepest(normals, offsets, others)


def nearest_to_all(parts: Sequence[ConvexGamut], inner: Spectrum, spectra: PixelBands) -> PixelBands:
    """The spectrum that all parts contain that is nearest to each; one inside stays as it is, bit for bit.

    Parameters
    ----------
    parts
        Convex gamuts.
    inner
        A point deep inside all of them, see `deep_inside`.
    spectra
        One a row.

    Examples
    --------
    >>> from symrt.gamut.gamuts import device_gamut
    >>> from symrt.device.inks import load_device
    >>> parts = [device_gamut(load_device("dye3-endura-premier"), model) for model in ("unit", "envelope")]
    >>> nearest_to_all(parts, np.full(36, 0.5), np.full((1, 36), 0.95))[0, :3]
    array([0.9, 0.9, 0.9])
    """
    moved = spectra.copy()
    outside = np.flatnonzero(~_in_all(parts, spectra))
    if outside.size:
        moved[outside] = _pulled(parts, inner, _projected(parts, spectra[outside]))
    return moved


def _in_all(parts: Sequence[ConvexGamut], spectra: PixelBands) -> Bool[np.ndarray, " pixel"]:
    return np.all([part.contains(spectra) for part in parts], axis=0)


def _projected(parts: Sequence[ConvexGamut], points: PixelBands) -> PixelBands:
    """The point nearest to each in all parts, or one that misses them by next to nothing."""
    normals, offsets, others = _planes(parts)

    def to_polyhedron(given: PixelBands) -> PixelBands:
        # SciPy has no batched least squares of this kind; each of these small problems takes less than a millisecond.
        return np.array([nearest_point(normals, offsets, point) for point in given])

    turns: list[Project] = [part.nearest for part in others]
    turns += [to_polyhedron] if len(normals) else []
    if len(turns) == 1:
        return turns[0](points)
    found, left = _by_turns(turns, points)
    if left.size:
        found[left] = _from_outside((normals, offsets), others, points[left])
    return found


def _by_turns(turns: Sequence[Project], points: PixelBands) -> tuple[PixelBands, Int[np.ndarray, " row"]]:
    """Dykstra's projections, and the points that they have not brought to rest."""
    found, rows = points.copy(), np.arange(len(points))
    moves, aim = np.zeros((len(turns), *points.shape)), _aims(points)
    for _ in range(TURNS):
        # Each part projects the points after its own last move is taken back.
        change = np.zeros(len(rows))
        for turn, project in enumerate(turns):
            given = found[rows] - moves[turn, rows]
            found[rows] = project(given)
            change += np.sum((found[rows] - given - moves[turn, rows]) ** 2, axis=1)
            moves[turn, rows] = found[rows] - given

        # Points whose moves hardly change any more have arrived.
        rows = rows[change > aim[rows] ** 2]
        if not rows.size:
            break
    return found, rows


def _aims(points: PixelBands) -> PerPixel:
    return np.maximum(SETTLED, FAR_SHARE * np.linalg.norm(points, axis=1))


def _from_outside(planes: tuple[Normals, Offsets], others: Sequence[ConvexGamut], points: PixelBands) -> PixelBands:
    """The nearest point of a polyhedron, which gets one more plane for every part that the point still misses."""
    known, found, rows = [planes] * len(points), points.copy(), np.arange(len(points))
    aim = _aims(points)
    for _ in range(PLANES_TRIED):
        # Go to the nearest point of what the planes so far enclose.
        for row in rows:
            found[row] = nearest_point(*known[row], points[row])

        # Add a plane for every part that still misses it.
        missed = np.zeros(len(rows), dtype=bool)
        for part in others:
            near = part.nearest(found[rows])
            length = np.linalg.norm(found[rows] - near, axis=1)
            for i in np.flatnonzero(length > aim[rows]):
                ahead = (found[rows[i]] - near[i]) / length[i]
                normals, offsets = known[rows[i]]
                known[rows[i]] = np.vstack([normals, ahead]), np.append(offsets, ahead @ near[i])
            missed |= length > aim[rows]
        rows = rows[missed]
        if not rows.size:
            return found

    raise ArithmeticError(
        f"the spectrum of {others[0].name} nearest to one given was not found in {PLANES_TRIED} rounds"
    )


def _pulled(parts: Sequence[ConvexGamut], inner: Spectrum, points: PixelBands) -> PixelBands:
    """Each point, or the last one inside on the way to it from deep inside."""
    # Clip the way from the inner point.
    rows = np.flatnonzero(~_in_all(parts, points))
    points, start = points.copy(), np.tile(inner, (len(rows), 1))
    way = points[rows] - start
    t = np.minimum(clipped_by_all(parts, start, way).high, 1.0)

    # Step back from the end, by ever more, until each part contains the rounded sum.
    for step in range(SHRINKS):
        tried = start + t[:, None] * way
        left = ~_in_all(parts, tried)
        if not left.any():
            points[rows] = tried
            return points
        # The end is inside, but the sum that gives the point may be rounded out of it.
        t[left] *= 1 - 2.0 ** min(step - 53, -1)
    raise ArithmeticError(f"no point of {parts[0].name} on the way inside was found")


def _planes(parts: Sequence[ConvexGamut]) -> tuple[Normals, Offsets, list[ConvexGamut]]:
    """The half-spaces of the parts that are made of slabs, and the other parts."""
    slabs = [part.slabs for part in parts if isinstance(part, SlabGamut)]
    others = [part for part in parts if not isinstance(part, SlabGamut)]
    if not slabs:
        return np.empty((0, len(parts[0].bands))), np.empty(0), others
    whole = merged(slabs)
    # Slabs of colours are wider than their gamuts, so that lines through the boundary are inside.
    wider = np.where(of_one_band(whole.matrix), 0, WIDER)
    return *halfspaces(whole.matrix, whole.lower + wider, whole.upper - wider), others


def _deepest(normals: Normals, offsets: Offsets, others: Sequence[ConvexGamut]) -> tuple[Spectrum, float]:
    """The deepest point of half-spaces that all other parts contain, by cutting planes."""
    # Enclose the other parts in boxes along their own axes, so that the first point is not far away.
    for part in others:
        axes = uniform_first(part.devices[0].samples).vectors
        directions = np.vstack([axes, -axes])
        normals, offsets = np.vstack([normals, directions]), np.append(offsets, part.support(directions))

    # Cut the point off from every part that does not contain it, until all do or too little is left.
    for _ in range(PLANES_TRIED):
        centre, radius = deepest(normals, offsets)
        beyond = [part for part in others if not part.contains(centre[None])[0]] if radius > THINNEST else []
        if not beyond:
            return centre, radius
        for part in beyond:
            near = part.nearest(centre[None])[0]
            ahead = (centre - near) / np.linalg.norm(centre - near)
            normals, offsets = np.vstack([normals, ahead]), np.append(offsets, ahead @ near)
    raise ArithmeticError(f"no point inside {others[0].name} was found, nor a proof that there is none")
