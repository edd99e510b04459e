"""Boxes (step 1): six walls that share their edges, so that no ray leaves a room through a seam.

A box is met as twelve triangles with eight corners between them.  Walls that meet compute the very same function of
their common edge, with opposite sign, so a box is as watertight as any closed mesh: see `symrt.geometry.triangles`.
"""

from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from typing import Any, Literal

import numpy as np
from jaxtyping import Float, Int

from symrt.arrays import PerRay, Point
from symrt.errors import hinting
from symrt.geometry import bvh
from symrt.geometry.culling import Corners, bounds
from symrt.geometry.mesh import rotation, transformed
from symrt.geometry.rays import (
    BLOCK,
    Crossing,
    Kernel,
    Rays,
    Surface,
    clearance,
    encloses,
    intersect,
    leaves,
    surface,
    translate,
)
from symrt.geometry.records import LARGEST, Triple, column, finite, moved, positive, triples
from symrt.geometry.triangle_mesh import TriangleMesh
from symrt.geometry.triangles import first_crossing

FACES = {
    "left": ((0, 0, 1), (0, 1, 0)),
    "right": ((0, 0, -1), (0, 1, 0)),
    "bottom": ((1, 0, 0), (0, 0, 1)),
    "top": ((1, 0, 0), (0, 0, -1)),
    "back": ((-1, 0, 0), (0, 1, 0)),
    "front": ((1, 0, 0), (0, 1, 0)),
}
"""For each face, what is to the right and what is up for whoever sees it from outside: their product points out."""

REST = "others"


@hinting
@dataclass(frozen=True)
class Box:
    """A closed box: a block from outside, a room from inside.

    Parameters
    ----------
    centre
        Its middle, about which it turns.
    size
        Its full lengths along x, y and z before it turns.
    material
        A name for all of it, or one for each of the faces left (−x), right (+x), bottom (−y), top (+y), back (−z) and
        front (+z); ``others`` stands for the faces that are not named.
    rotate
        Degrees about x, then y, then z.

    Notes
    -----
    On each face u runs from 0 to 1 to the right and v downwards for whoever sees it from outside, where the front is
    below the top and above the bottom; the extent is the lengths of its edges.

    Raises
    ------
    ValueError
        If a number is not finite, a size is not positive, or the names of the faces are not those above.

    Examples
    --------
    A room with a red and a green wall:

    >>> room = Box((0, 1, 0), (2, 2, 2), material={"left": "red", "right": "green", "others": "white"})
    >>> room.materials
    ('red', 'green', 'white', 'white', 'white', 'white')
    """

    centre: Triple
    size: Triple
    material: str | dict[str, str]
    rotate: Triple = (0, 0, 0)
    type: Literal["box"] = field(default="box", kw_only=True)

    def __post_init__(self) -> None:
        # Numbers, wherever the corners turn to.
        triples("box", centre=self.centre, size=self.size, rotate=self.rotate)
        finite("box", centre=self.centre, size=self.size, rotate=self.rotate)
        for i, length in enumerate(self.size):
            positive("box", **{f"size[{i}]": length})
        farthest = np.abs(self.centre).max() + np.abs(self.size).sum() / 2
        if farthest > LARGEST:
            raise ValueError(
                f"box: size = {self.size}: its corners must be within {LARGEST}; choose a larger unit of length"
            )

        # A name, or names of faces.
        if isinstance(self.material, dict):
            _named_faces(self.material)
        elif not isinstance(self.material, str):
            raise ValueError(  # noqa: TRY004 -- a bad field is a bad value
                f"box: material = {self.material!r}: it must be a name, or one for each face; "
                "write 'white', or {'left': 'red', 'others': 'white'}"
            )

    def __getstate__(self) -> dict[str, Any]:
        """The record without the triangles, which need not travel to another process."""
        return {f.name: getattr(self, f.name) for f in fields(self)}

    @property
    def materials(self) -> tuple[str, ...]:
        """The material of each face, in the order of the faces."""
        if isinstance(self.material, str):
            return (self.material,) * len(FACES)
        return tuple(self.material.get(face, self.material.get(REST, "")) for face in FACES)

    @property
    def face_material(self) -> Int[np.ndarray, " triangle"]:
        """For each triangle, the face that it is half of."""
        return np.repeat(np.arange(len(FACES)), 2)

    @cached_property
    def mesh(self) -> TriangleMesh:
        """Its walls, two triangles each, with four vertices a wall at the same eight corners."""
        half = column(self.size) / 2
        # Top left, bottom left, bottom right, top right of each face, counter-clockwise seen from outside.
        signs = np.array(
            [
                np.cross(right, up) + x * np.array(right) + y * np.array(up)
                for right, up in FACES.values()
                for x, y in ((-1, 1), (-1, -1), (1, -1), (1, 1))
            ],
            dtype=float,
        ).T
        first = 4 * np.arange(len(FACES))
        halves = np.stack([first, first + 1, first + 2, first, first + 2, first + 3]).reshape(2, 3, -1)
        return TriangleMesh(
            vertices=transformed(self.turn, signs * half) + column(self.centre),
            faces=halves.transpose(1, 2, 0).reshape(3, -1),
            materials=self.materials,
            face_material=self.face_material,
            uv=np.tile([[0.0, 0.0, 1.0, 1.0], [0.0, 1.0, 1.0, 0.0]], len(FACES)),
        )

    @cached_property
    def turn(self) -> Float[np.ndarray, "3 3"]:
        """The rotation that turns it."""
        return rotation(self.rotate)

    @property
    def kernel(self) -> Kernel:
        """Its compiled form, that of its walls."""
        return self.mesh.kernel


@intersect.register(Box)
def intersect_box(box: Box, rays: Rays, low: float = 0.0) -> Crossing:
    """Nearest crossing with a box beyond `low`, from inside or outside; its primitive is a triangle, two a face.

    Examples
    --------
    >>> ray = Rays(origin=np.zeros((3, 1)), direction=np.array([[0.0], [0.0], [-1.0]]))
    >>> intersect_box(Box((0, 0, 0), (2, 2, 2), "white"), ray).distance
    array([1.])
    """
    distance, primitive = np.full(len(rays), np.inf), np.full(len(rays), -1, np.int32)
    for start in range(0, len(rays), BLOCK):
        block = slice(start, start + BLOCK)
        part = rays[block]
        with np.errstate(all="ignore"):
            ends = np.full(len(part), low), np.full(len(part), np.inf)
            found = first_crossing(box.mesh.corners, box.mesh.unit_normals, part, _candidates(box, part, *ends), *ends)
        distance[block], primitive[block] = found.distance, found.primitive
    return Crossing(distance, primitive)


def _candidates(
    box: Box, rays: Rays, low: PerRay, high: PerRay
) -> tuple[Int[np.ndarray, " pair"], Int[np.ndarray, " pair"]]:
    """Pairs of a ray and a triangle that may meet: the triangles of the faces through which the ray passes.

    Plain arithmetic in the box's own frame tells, with room for its rounding and for that of the edge functions: a few
    units in the last place of all the numbers that make up a point, and as many more as a face is seen from its edge.
    The room is thousands of times as much.  A line almost along a face may meet it anywhere.
    """
    # The rays as the box sees them, and the size of the numbers that rounding is a share of.
    origin = transformed(box.turn.T, rays.origin - column(box.centre))
    direction, half = transformed(box.turn.T, rays.direction), column(box.size) / 2
    reach = np.abs(origin).sum(axis=0) + half.sum() + np.abs(box.centre).sum()

    # A face is asked where the ray passes through it, give or take, or goes along it.
    pairs = []
    for axis in range(3):
        along = np.abs(direction[axis]) < 1e-9
        for side, face in ((-1, 2 * axis), (1, 2 * axis + 1)):
            there = (side * half[axis] - origin[axis]) / direction[axis]
            room = (1e-9 + 1e-12 / np.abs(direction[axis])) * (reach + np.abs(there))
            passing = ~along & (there >= low - room)
            for other in (axis - 2, axis - 1):
                passing &= np.abs(origin[other] + there * direction[other]) <= half[other] + room
            ray = np.flatnonzero(passing | along)
            pairs += [(ray, np.full(ray.size, 2 * face + k)) for k in (0, 1)]
    ray, triangle = (np.concatenate(part) for part in zip(*pairs, strict=True))
    return bvh.confirmed(box.mesh.tree, rays, (ray, triangle), low, high)


@surface.register(Box)
def surface_box(box: Box, rays: Rays, distance: PerRay, primitive: Int[np.ndarray, " ray"]) -> Surface:
    """Surface of a box where rays meet it.

    Examples
    --------
    >>> ray = Rays(origin=np.zeros((3, 1)), direction=np.array([[0.0], [0.0], [-1.0]]))
    >>> room = Box((0, 0, 0), (4, 3, 2), "white")
    >>> found = intersect_box(room, ray)
    >>> surface_box(room, ray, found.distance, found.primitive).extent.T
    array([[4., 3.]])
    """
    right, up = np.abs(np.array(list(FACES.values()))[primitive // 2]).transpose(1, 2, 0)
    size = column(box.size)
    extent = np.stack([(right * size).sum(axis=0), (up * size).sum(axis=0)])
    found = surface(box.mesh, rays, distance, primitive)
    return replace(found, uv=np.clip(found.uv, 0.0, 1.0), extent=extent)


@bounds.register(Box)
def bounds_box(box: Box) -> Corners:
    """The box, along the axes, around one that is turned.

    Examples
    --------
    >>> bounds_box(Box((0, 1, 0), (2, 2, 2), "white")).tolist()
    [[-1.0, 0.0, -1.0], [1.0, 2.0, 1.0]]
    """
    return bounds(box.mesh)


@translate.register(Box)
def translate_box(box: Box, by: Point) -> Box:
    """The box moved `by` a vector.

    Examples
    --------
    >>> translate_box(Box((0, 1, 0), (2, 2, 2), "white"), np.array([0.0, 2.0, 0.0])).centre
    (0.0, 3.0, 0.0)
    """
    return replace(box, centre=moved(box.centre, by))


@leaves.register(Box)
def leaves_box(box: Box) -> tuple[bool, bool]:  # noqa: ARG001
    """A box is convex.

    Examples
    --------
    >>> leaves_box(Box((0, 0, 0), (2, 2, 2), "white"))
    (True, False)
    """
    return True, False


@encloses.register(Box)
def encloses_box(box: Box, point: Point) -> bool:
    """Whether `point` is inside the box, not on its walls.

    Examples
    --------
    >>> encloses_box(Box((0, 0, 0), (2, 2, 2), "white", rotate=(0, 45, 0)), np.array([1.2, 0.0, 0.0]))
    True
    """
    offset = transformed(box.turn.T, point.reshape(3, 1) - column(box.centre))
    return bool(np.all(np.abs(offset) < column(box.size) / 2))


@clearance.register(Box)
def clearance_box(box: Box, point: Point) -> float:
    """Distance from `point` to the nearest wall, from inside or outside.

    Examples
    --------
    >>> room = Box((0, 0, 0), (4, 3, 2), "white")
    >>> clearance_box(room, np.zeros(3)), clearance_box(room, np.array([5.0, 5.5, 0.0]))
    (1.0, 5.0)
    """
    return clearance(box.mesh, point)


def _named_faces(material: dict[str, str]) -> None:
    """Refuse faces that a box does not have, and faces without a material."""
    for face in material:
        if face not in (*FACES, REST):
            raise ValueError(
                f"box: material = {material}: there is no face {face!r}; "
                f"name {', '.join(FACES)}, or {REST} for the rest"
            )
    missing = [face for face in FACES if face not in material]
    if missing and REST not in material:
        raise ValueError(
            f"box: material = {material}: {', '.join(missing)} must have a material, too; "
            f"name them, or give {REST} for the rest"
        )
