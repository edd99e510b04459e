"""The vector irradiance that a flat figure gives, in closed form, or by Gauss points where it is small (step 1).

A figure of radiance 1 gives a surface at the origin the vector irradiance ``E = ∫ ω dω`` over the directions ω to it
that lie above the surface's horizon; the surface's irradiance is n·E.  By Stokes' theorem it is an integral along the
border [1]_, ``E = −½ ∮ v × dv / |v|²``: ``½ θ`` times a unit normal for each edge of a polygon, θ the angle that the
edge subtends (Lambert's formula [2]_), and elementary for an arc of a circle (for a whole one [3]_; a sphere looks like
the disk inside of its silhouette, as [4]_ uses it).  Where a figure is small the terms cancel, and Gauss points are
exact to rounding.

References
----------
.. [1] J. R. Howell, M. P. Mengüç, K. Daun and R. Siegel, "Thermal Radiation Heat Transfer", 7th ed., 2020, §4.3.
.. [2] D. R. Baum, H. E. Rushmeier and J. M. Winget, "Improving Radiosity Solutions Through the Use of Analytically
   Determined Form-Factors", SIGGRAPH 1989.
.. [3] M. H. N. Naraghi, "Radiation View Factors from Differential Plane Sources to Disks", J. Thermophysics 2(3), 1988.
.. [4] J. M. Snyder, "Area Light Sources for Real-Time Graphics", Microsoft Research MSR-TR-96-11, 1996.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from jaxtyping import Float

from symrt.arrays import PerRay, Vectors, dot
from symrt.scene.outlines import Axis, Outline

FAR = 16.0
"""Radii of a figure from which on it is small: there Gauss points are exact, and the closed forms begin to cancel."""
SMALL = np.polynomial.legendre.leggauss(6)
"""Gauss points on −1 … 1 across a figure that is small."""
ARC = np.polynomial.legendre.leggauss(14)
"""Gauss points along the arc of a part of a disk, where the square of a sine is integrated too."""


def vector_irradiance(figure: Outline, horizon: Vectors) -> Vectors:
    """The vector irradiance of a figure of radiance 1, of its part above the horizon of a surface with a unit normal.

    To 1e-12 of that of the whole figure.  It is zero on the side that does not shine, and in the figure's own plane.

    Examples
    --------
    A disk that fills the view to 45° on all sides gives π sin² 45°:

    >>> x, y, z = np.eye(3)[:, :, None]
    >>> disk = Outline(y, x, z, -y, circular=True)
    >>> vector_irradiance(disk, y).T.round(12).tolist() == [[0.0, round(np.pi / 2, 12), 0.0]]
    True
    """
    found = np.zeros_like(figure.centre)
    shines = np.flatnonzero(figure.shines)
    figure, horizon = figure.of(shines), horizon[:, shines]

    # Points from which all of the figure, or some of it, is above the horizon.
    height = dot(horizon, figure.centre)
    u, v = np.abs(dot(horizon, figure.across)), np.abs(dot(horizon, figure.up))
    reach = np.hypot(u, v) if figure.circular else u + v
    whole, some = height >= reach, np.abs(height) < reach

    # The near ones in closed form, the far ones by Gauss points.
    size = np.maximum(_size(figure.across), _size(figure.up))
    far = _size(figure.centre) > FAR * size * (1.0 if figure.circular else 1.5)
    near, small = (_round, _small_round) if figure.circular else (_polygon, _small_polygon)
    for chosen, irradiance in (
        (whole & far & (not figure.circular), lambda part, _: _small_rectangle(part)),
        (whole & (~far | figure.circular), lambda part, _: _disk(part) if part.circular else _whole_polygon(part)),
        (some & ~far, near),
        (some & far, small),
    ):
        which = np.flatnonzero(chosen)
        if which.size:
            found[:, shines[which]] = irradiance(figure.of(which), horizon[:, which])
    return found


def _size(v: Vectors) -> PerRay:
    """Lengths, of vectors whose squares are far from over- and underflow, as those of lights and figures are."""
    return np.sqrt(dot(v, v))


def _cross(a: Axis, b: Axis) -> Vectors:
    return np.stack([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


# --- Rectangles -----------------------------------------------------------------------------------------------------


def _whole_polygon(figure: Outline) -> Vectors:
    """Lambert's formula for a rectangle."""
    corners = _corners(figure)
    return sum((_edge(corners[k], corners[(k + 1) % 4]) for k in range(4)), np.zeros_like(figure.centre))


def _polygon(figure: Outline, horizon: Vectors) -> Vectors:
    """Lambert's formula for the part of a rectangle above the horizon."""
    start, end = _clipped(figure, horizon)
    total = sum((_edge(a, b) for a, b in zip(start, end, strict=True)), np.zeros_like(figure.centre))
    # Where the border is cut the edges are joined along the horizon.
    return total + sum(_edge(end[k], start[(k + 1) % 4]) for k in range(4))


def _edge(a: Vectors, b: Vectors) -> Vectors:
    """An edge's term −½ θ γ; that of an edge without length, or seen end on, is zero."""
    normal = _cross(a, b - a)
    sine = _size(normal)
    return -normal / 2 * np.where(sine > 0, np.arctan2(sine, dot(a, b)) / np.where(sine > 0, sine, 1.0), 0.0)


def _corners(figure: Outline) -> list[Vectors]:
    """The corners, as they go round the normal, whichever way that is turned."""
    across = np.where(dot(_cross(figure.across, figure.up), figure.normal) < 0, -figure.across, figure.across)
    return [figure.centre + i * across + j * figure.up for i, j in ((-1, -1), (1, -1), (1, 1), (-1, 1))]


def _clipped(figure: Outline, horizon: Vectors) -> tuple[list[Vectors], list[Vectors]]:
    """Start and end of what is above the horizon of each edge, in the order in which they go round the normal.

    An edge below the horizon starts and ends where the border went below it.
    """
    corners = _corners(figure)
    heights = [dot(horizon, corner) for corner in corners]

    # The point where each edge crosses the horizon; the border sinks at most once.
    start, end, sunk = [], [], np.zeros_like(figure.centre)
    for k in range(4):
        a, b, above, then = corners[k], corners[(k + 1) % 4], heights[k], heights[(k + 1) % 4]
        crosses = (above >= 0) != (then >= 0)
        share = np.where(crosses, above / np.where(crosses, above - then, 1.0), 0.0)
        crossing = a + share * (b - a)
        start.append(np.where(above >= 0, a, crossing))
        end.append(np.where(then >= 0, b, crossing))
        sunk = np.where((above >= 0) & (then < 0), crossing, sunk)
    for k in range(4):
        below = (heights[k] < 0) & (heights[(k + 1) % 4] < 0)
        start[k], end[k] = (np.where(below, sunk, edge[k]) for edge in (start, end))
    return start, end


def _small_rectangle(figure: Outline) -> Vectors:
    points, weights = SMALL
    total = np.zeros_like(figure.centre)
    for u, a in zip(points, weights, strict=True):
        for v, b in zip(points, weights, strict=True):
            towards = figure.centre + u * figure.across + v * figure.up
            total += a * b / 4 * _from(towards, figure.normal)
    return total * figure.area


def _small_polygon(figure: Outline, horizon: Vectors) -> Vectors:
    """The part of a small rectangle above the horizon, as triangles that share a corner."""
    start, end = _clipped(figure, horizon)
    border = [corner for edge in zip(start, end, strict=True) for corner in edge]
    points, weights = (SMALL[0] + 1) / 2, SMALL[1] / 2
    total = np.zeros_like(figure.centre)
    for b, c in pairwise(border[1:]):
        twice = _size(_cross(b - border[0], c - border[0]))
        for s, p in zip(points, weights, strict=True):
            for t, q in zip(points, weights, strict=True):
                towards = border[0] + s * ((1 - t) * (b - border[0]) + t * (c - border[0]))
                total += p * q * s * twice * _from(towards, figure.normal)
    return total


def _from(towards: Float[np.ndarray, "3 n"], normal: Axis) -> Float[np.ndarray, "3 n"]:
    """Vector irradiance of a unit of area at a place."""
    square = dot(towards, towards)
    return towards * (-dot(towards, normal) / square / square)


# --- Disks ----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class _Frame:
    """A disk's own axes: x to the side on which the point is, z its normal; and the point's place (a, 0, h) there."""

    x: Float[np.ndarray, "3 n"]
    y: Float[np.ndarray, "3 n"]
    z: Axis
    a: Float[np.ndarray, " n"]
    h: Float[np.ndarray, " n"]
    r: Float[np.ndarray, " #n"]

    @property
    def q(self) -> PerRay:
        """Square of the distance to the border, on average over it."""
        return self.h**2 + self.a**2 + self.r**2

    @property
    def t(self) -> PerRay:
        """h² + a² − r², which is negative close to the disk."""
        return self.h**2 + (self.a - self.r) * (self.a + self.r)

    @property
    def s(self) -> PerRay:
        """The product of the nearest and the farthest distance to the border."""
        return np.hypot(self.t, 2 * self.h * self.r)

    def out(self, x: PerRay, y: PerRay, z: PerRay) -> Vectors:
        """A vector of the frame as one of the scene."""
        return x * self.x + y * self.y + z * self.z


def _frame(figure: Outline) -> _Frame:
    r = _size(figure.across)
    e, f = figure.across / r, figure.up / r
    u, v = -dot(figure.centre, e), -dot(figure.centre, f)
    a = np.hypot(u, v)
    # In front of the middle any direction will do.
    cosine, sine = np.where(a > 0, u / np.where(a > 0, a, 1.0), 1.0), np.where(a > 0, v / np.where(a > 0, a, 1.0), 0.0)
    x = cosine * e + sine * f
    return _Frame(x, _cross(figure.normal, x), figure.normal, a, -dot(figure.centre, figure.normal), r)


def _disk(figure: Outline) -> Vectors:
    """The vector irradiance of a whole disk: nothing in it cancels."""
    frame = _frame(figure)
    h, r, s, t = frame.h, frame.r, frame.s, frame.t
    along = 2 * np.pi * h * frame.a * r**2 / (s * (frame.q + s))
    upright = np.where(t > 0, 2 * np.pi * h**2 * r**2 / (s * (s + np.abs(t))), np.pi / 2 * (s - t) / s)
    return frame.out(-along, np.zeros_like(along), -upright)


def _round(figure: Outline, horizon: Vectors) -> Vectors:
    """The part of a disk above the horizon: its arc, and the chord along the horizon."""
    frame = _frame(figure)
    a, h, r, q, s = frame.a, frame.h, frame.r, frame.q, frame.s
    middle, half = _arc(frame, horizon)
    first, last = middle - half, middle + half

    # ∫ dφ, ∫ cosφ dφ and ∫ sinφ dφ over q − p cosφ, the square of the distance to the border.
    p, b = 2 * a * r, 2 * a * r / (q + s)
    turn = [np.arctan2(b * np.sin(phi), 1 - b * np.cos(phi)) for phi in (first, last)]
    divisor = np.where(p > 0, p, 1.0)
    beyond = np.where(p > 0, (turn[1] - turn[0]) / divisor, (np.sin(last) - np.sin(first)) / (q + s))
    ones = (2 * half + 2 * (turn[1] - turn[0])) / s
    cosines = (b * 2 * half + 2 * q * beyond) / s
    ends = [h**2 + (a - r) ** 2 + 2 * p * np.sin(phi / 2) ** 2 for phi in (first, last)]
    change = 2 * np.sin(middle) * np.sin(half) / ends[0]
    little = np.abs(p * change) < 0.5
    sines = np.where(little, np.log1p(np.where(little, p * change, 0.0)), np.log(ends[1] / ends[0])) / divisor
    sines = np.where(p > 0, sines, change)
    arc = frame.out(-h * r * cosines / 2, -h * r * sines / 2, -(r**2 * ones - a * r * cosines) / 2)

    # The chord, from where the border went below the horizon to where it comes up again.
    chord = [frame.out(r * np.cos(phi) - a, r * np.sin(phi), -h) for phi in (last, first)]
    return arc + _edge(*chord)


def _small_round(figure: Outline, horizon: Vectors) -> Vectors:
    """The part of a small disk above the horizon."""
    frame = _frame(figure)
    middle, half = _arc(frame, horizon)
    total = np.zeros_like(figure.centre)
    for t, p in zip((ARC[0] + 1) / 2, ARC[1] / 2, strict=True):
        # A strip across the part, parallel to the chord.
        out, wide = frame.r * np.cos(half * t), frame.r * np.sin(half * t)
        for v, w in zip(*SMALL, strict=True):
            x = out * np.cos(middle) - v * wide * np.sin(middle)
            y = out * np.sin(middle) + v * wide * np.cos(middle)
            towards = frame.out(x - frame.a, y, -frame.h)
            total += p * w * half * wide**2 * _from(towards, figure.normal)
    return total


def _arc(frame: _Frame, horizon: Vectors) -> tuple[PerRay, PerRay]:
    """The middle of the part of a disk's border that is above the horizon, and half its angle."""
    x, y, z = (dot(horizon, axis) for axis in (frame.x, frame.y, frame.z))
    lowest = (x * frame.a + z * frame.h) / frame.r
    return np.arctan2(y, x), np.arccos(np.clip(lowest / np.hypot(x, y), -1.0, 1.0))
