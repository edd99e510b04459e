"""The vector irradiance of a patch of the sky, of its part above a surface's horizon (step 1).

``E = ∫ ω dω`` over the directions ω of the patch that lie above the horizon.  For what is all the way round between two
elevations it is a difference of caps, each in closed form: a cap looks like a disk (`symrt.scene.irradiance`), what is
above both of two horizons gives π/2 times the sum of their normals, and what is more than half a sphere is the whole
less a cap.  For a part of the way round the integral over the azimuth is elementary, and that over the elevation, to
1e-7, is done by Gauss points between the elevations where the horizon enters or leaves the patch.
"""

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from symrt.arrays import Vectors, dot, normalise
from symrt.geometry import Triple
from symrt.geometry.records import column
from symrt.scene.figures import perpendicular
from symrt.scene.irradiance import vector_irradiance
from symrt.scene.outlines import Outline

GAUSS = np.polynomial.legendre.leggauss(24)
"""Gauss points of an elevation, between two at which the horizon crosses the border of the patch."""

Angles = Float[np.ndarray, " n"]


@dataclass(frozen=True)
class Patch:
    """The borders of a patch of the sky, in radians: two elevations and two azimuths."""

    low: float
    high: float
    west: float
    east: float

    @property
    def width(self) -> float:
        """From west to east."""
        return self.east - self.west

    @property
    def whole(self) -> bool:
        """True if it goes all the way round."""
        return self.width >= 2 * np.pi

    def holds(self, azimuth: Angles, sine: Angles) -> Bool[np.ndarray, " n"]:
        """Whether directions, by azimuth and by the sine of the elevation, are in it.

        Its lower and its western border belong to it, and the zenith.
        """
        above = (sine >= math.sin(self.low)) | (self.low <= -math.pi / 2)
        below = (sine < math.sin(self.high)) | (self.high >= np.pi / 2)
        between = (azimuth - self.west) % (2 * np.pi) < self.width
        return above & below & (between | self.whole)


@dataclass(frozen=True, eq=False)
class Axes:
    """The directions east, north and up, perpendicular unit vectors."""

    east: Float[np.ndarray, "3 1"]
    north: Float[np.ndarray, "3 1"]
    up: Float[np.ndarray, "3 1"]

    def out(self, azimuth: Angles, elevation: Angles) -> Vectors:
        """Unit vectors at azimuths and elevations, in radians."""
        along = np.sin(azimuth) * self.east + np.cos(azimuth) * self.north
        return np.cos(elevation) * along + np.sin(elevation) * self.up

    def angles(self, directions: Vectors) -> tuple[Angles, Angles]:
        """The azimuths of directions, in radians, and the sines of their elevations."""
        return np.arctan2(dot(self.east, directions), dot(self.north, directions)), dot(self.up, directions)


def axes_of(up: Triple, north: Triple) -> Axes:
    """The axes for a direction up, and one that is north as far as it is perpendicular to that."""
    upwards = normalise(column(up))
    towards = normalise(column(north))
    towards = normalise(towards - dot(towards, upwards) * upwards)
    return Axes(np.cross(towards, upwards, axis=0), towards, upwards)


def patch_irradiance(patch: Patch, axes: Axes, normals: Vectors) -> Vectors:
    """The vector irradiance of a patch of radiance 1, of its part above the horizon of each unit normal.

    Examples
    --------
    Half of the half sphere is above the horizon of a wall:

    >>> upper = Patch(0.0, np.pi / 2, 0.0, 2 * np.pi)
    >>> wall = np.array([[1.0], [0.0], [0.0]])
    >>> (patch_irradiance(upper, axes_of((0, 1, 0), (0, 0, -1)), wall) / np.pi).T.tolist()
    [[0.5, 0.5, 0.0]]
    """
    if patch.whole:
        return _cap(axes.up, patch.low, normals) - _cap(axes.up, patch.high, normals)
    return _part(patch, axes, normals)


def _cap(up: Float[np.ndarray, "3 1"], low: float, normals: Vectors) -> Vectors:
    """The vector irradiance of all that is higher than an elevation."""
    if low >= np.pi / 2:
        return np.zeros_like(normals)
    if low == 0:
        return np.pi / 2 * (normals + up)
    if low < 0:
        return np.pi * normals - _cap(-up, -low, normals)
    across, along = perpendicular(up)
    centre = np.broadcast_to(np.sin(low) * up, normals.shape)
    return vector_irradiance(Outline(centre, np.cos(low) * across, np.cos(low) * along, -up, circular=True), normals)


def _part(patch: Patch, axes: Axes, normals: Vectors) -> Vectors:
    """The vector irradiance of a patch that is a part of the way round."""
    # Along a circle of elevation e, n·ω = b sin e + h cos e cos(φ − middle).
    b = dot(normals, axes.up)
    h = np.hypot(dot(normals, axes.east), dot(normals, axes.north))
    middle = np.arctan2(dot(normals, axes.east), dot(normals, axes.north))

    # Elevations at which the horizon touches a circle, and at which it crosses the sides of the patch.
    steep = np.arctan2(h, np.abs(b))
    with np.errstate(divide="ignore", invalid="ignore"):
        sides = [np.arctan(-h * np.cos(side - middle) / b) for side in (patch.west, patch.east)]
    places = [np.clip(np.where(np.isfinite(e), e, patch.low), patch.low, patch.high) for e in (-steep, steep, *sides)]
    ends = np.sort([np.full_like(b, patch.low), *places, np.full_like(b, patch.high)], axis=0)

    # Between them the sine of an angle as the variable smooths the square roots at both ends.
    total = np.zeros_like(normals)
    for k in range(len(ends) - 1):
        centre, half = (ends[k] + ends[k + 1]) / 2, (ends[k + 1] - ends[k]) / 2
        for x, weight in zip(*GAUSS, strict=True):
            elevation = centre + half * np.sin(np.pi / 2 * x)
            share = weight * np.pi / 2 * half * np.cos(np.pi / 2 * x) * np.cos(elevation)
            sines, cosines, angle = _lit_azimuths(patch, middle, b * np.sin(elevation), h * np.cos(elevation))
            level = sines * axes.east + cosines * axes.north
            total += share * (np.cos(elevation) * level + np.sin(elevation) * angle * axes.up)
    return total


def _lit_azimuths(patch: Patch, middle: Angles, upright: Angles, level: Angles) -> tuple[Angles, Angles, Angles]:
    """Integrals of sin φ, cos φ and 1 over the azimuths of a circle that are in a patch and above the horizon.

    They are those around `middle` with ``upright + level cos(φ − middle) > 0``.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        cosine = np.where(level > 0, -upright / level, np.where(upright > 0, -1.0, 1.0))
    wide = np.arccos(np.clip(cosine, -1.0, 1.0))

    # In azimuths from the western side on they are one piece, or two where they go past it.
    start = (middle - wide - patch.west) % (2 * np.pi)
    end = start + 2 * wide
    pieces = [
        (np.minimum(start, patch.width), np.minimum(end, patch.width)),
        (np.zeros_like(end), np.clip(end - 2 * np.pi, 0.0, patch.width)),
    ]
    found = [
        (np.cos(patch.west + p) - np.cos(patch.west + q), np.sin(patch.west + q) - np.sin(patch.west + p), q - p)
        for p, q in pieces
    ]
    sines, cosines, angle = (one + other for one, other in zip(*found, strict=True))
    return sines, cosines, angle
