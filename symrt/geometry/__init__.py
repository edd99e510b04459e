"""Where rays go: shapes, textures and the rays that meet them (step 1)."""

from symrt.geometry.box import Box
from symrt.geometry.cylinder import Cylinder
from symrt.geometry.meeting import nearest, occluded, surfaces
from symrt.geometry.mesh import Mesh, load_mesh
from symrt.geometry.pictures import LabelImage, WeightImage, load_texture
from symrt.geometry.planes import Disk, Plane
from symrt.geometry.rays import (
    Crossing,
    Hits,
    Rays,
    Surface,
    clearance,
    encloses,
    intersect,
    spawn,
    surface,
    translate,
)
from symrt.geometry.records import Triple
from symrt.geometry.rectangle import Rectangle
from symrt.geometry.sphere import Sphere
from symrt.geometry.textures import BandedRelief, Checker, weights
from symrt.geometry.triangle_mesh import TriangleMesh

__all__ = [
    "BandedRelief",
    "Box",
    "Checker",
    "Crossing",
    "Cylinder",
    "Disk",
    "Hits",
    "LabelImage",
    "Mesh",
    "Plane",
    "Rays",
    "Rectangle",
    "Sphere",
    "Surface",
    "TriangleMesh",
    "Triple",
    "WeightImage",
    "clearance",
    "encloses",
    "intersect",
    "load_mesh",
    "load_texture",
    "nearest",
    "occluded",
    "spawn",
    "surface",
    "surfaces",
    "translate",
    "weights",
]
