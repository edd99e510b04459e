"""The flat figures that area lights look like, as they are seen from points, and directions to the sky (step 1)."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from symrt.arrays import PerRay, Vectors, dot, length

Share = Float[np.ndarray, " n"]
Axis = Float[np.ndarray, "3 #n"]
"""A vector for each point, or one for all of them."""

ROOM = 2.0**-50
"""Share of a figure's distance and size that counts as its own plane."""
DARK = np.array([[0.0], [1.0], [0.0]])
"""Any direction, for light that does not arrive."""


@dataclass(frozen=True, eq=False)
class Outline:
    """A parallelogram or an ellipse of a light as it is seen from some points, each in coordinates of its own.

    Parameters
    ----------
    centre
        Vectors from the points to its middle.
    across, up
        Vectors from its middle to the middle of two edges, perpendicular to each other; of a disk to its border, of
        equal length.  A column serves all points.
    normal
        Unit vectors on the side that shines.
    circular
        True for a disk; otherwise it is a rectangle.
    ball
        The radius of the sphere whose silhouette it is, else 0.

    Examples
    --------
    A square of edge 2, one unit above the origin:

    >>> one, zero = np.ones(1), np.zeros(1)
    >>> x, y, z = np.eye(3)[:, :, None]
    >>> square = Outline(y, x, z, -y, circular=False)
    >>> towards, weight = place(square, one, zero)
    >>> towards.T.tolist(), weight.round(3).tolist()
    ([[1.0, 1.0, 0.0]], [0.354])
    """

    centre: Float[np.ndarray, "3 n"]
    across: Axis
    up: Axis
    normal: Axis
    circular: bool
    ball: float = 0.0

    def of(self, chosen: Int[np.ndarray, " chosen"]) -> "Outline":
        """The figure as seen from some of the points."""
        across, up, normal = (
            axis if axis.shape[1] == 1 else axis.take(chosen, axis=1) for axis in (self.across, self.up, self.normal)
        )
        return Outline(self.centre.take(chosen, axis=1), across, up, normal, self.circular, self.ball)

    @property
    def area(self) -> PerRay:
        """Its area."""
        return length(self.across) * length(self.up) * (np.pi if self.circular else 4.0)

    @property
    def shines(self) -> Bool[np.ndarray, " n"]:
        """True for the points on the side that shines, farther from the figure's plane than rounding may take them."""
        room = ROOM * (length(self.centre) + length(self.across) + length(self.up))
        return -dot(self.centre, self.normal) > room


@dataclass(frozen=True, eq=False)
class Directions:
    """The directions that stand for a region of the sky, so that it can be found which of them are free.

    Parameters
    ----------
    towards
        Unit vectors.
    weight
        The solid angle that each stands for, times the region's radiance there.
    lowest, highest
        Sines of the elevations between which all of the region is, above the horizon of `up`.
    """

    towards: Float[np.ndarray, "3 direction"]
    weight: Float[np.ndarray, " direction"]
    lowest: float
    highest: float
    up: Float[np.ndarray, "3 1"]

    def of(self, chosen: object) -> "Directions":  # noqa: ARG002  the sky looks the same from everywhere
        """The directions themselves: the sky looks the same from all points."""
        return self


def place(figure: Outline, u: Share, v: Share) -> tuple[Vectors, PerRay]:
    """Vectors to a place of a figure for each point, and cosθ/d² there, θ the angle at the light.

    The coordinates run from −1 to 1 over a rectangle; on a disk they are those of the square that is mapped onto it,
    circles for squares, so that equal areas stay equal [1]_.

    References
    ----------
    .. [1] P. Shirley and K. Chiu, "A Low Distortion Map Between Disk and Square", J. Graphics Tools 2(3), 1997.
    """
    if figure.circular:
        # The larger coordinate is the radius; the other one over it is at most an eighth of a turn.
        steep = np.abs(u) < np.abs(v)
        radius, other = np.where(steep, v, u), np.where(steep, u, v)
        angle = np.pi / 4 * other / np.where(radius == 0, 1.0, radius)
        near, off = radius * np.cos(angle), radius * np.sin(angle)
        u, v = np.where(steep, off, near), np.where(steep, near, off)
    towards = figure.centre + u * figure.across + v * figure.up
    square = dot(towards, towards)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        weight = -dot(towards, figure.normal) / np.sqrt(square) / square
    return towards, np.where(np.isfinite(weight), np.maximum(weight, 0.0), 0.0)


def begins(figure: Outline, towards: Vectors) -> tuple[Vectors, PerRay]:
    """Unit vectors to places of a figure, and the distances at which the light begins there.

    A ball begins in front of the disk of its silhouette.
    """
    distance = np.sqrt(dot(towards, towards))
    direction = np.where(distance > 0, towards, DARK) / np.where(distance > 0, distance, 1.0)
    if figure.ball:
        far, wide = length(figure.centre), length(figure.across)
        away = far + wide**2 / far
        along = -dot(direction, figure.normal)
        beside = np.maximum(1 - along**2, 0.0) * away**2
        distance = away * along - np.sqrt(np.maximum(figure.ball**2 - beside, 0.0))
    return direction, distance
