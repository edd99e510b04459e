"""Shapes that several tests share."""

import numpy as np
import trimesh

from symrt.geometry import Box, Cylinder, Disk, Plane, Rectangle, Sphere, TriangleMesh


def from_trimesh(mesh, scale=1.0, centre=(0, 0, 0)):
    """Our record of a mesh that trimesh made."""
    vertices = np.asarray(mesh.vertices, float).T * scale + np.reshape(centre, (3, 1))
    return TriangleMesh(vertices, np.asarray(mesh.faces).T.astype(np.int64), materials=("a",))


def icosphere(subdivisions, radius=1.0, centre=(0, 0, 0)):
    """A closed, convex ball of 20·4ⁿ triangles."""
    return from_trimesh(trimesh.creation.icosphere(subdivisions=subdivisions), radius, centre)


def torus(around=48, across=24):
    """A closed ring."""
    return from_trimesh(trimesh.creation.torus(1.0, 0.3, major_sections=around, minor_sections=across))


def star(subdivisions, seed):
    """A closed, rough surface that every point near the origin sees from inside."""
    mesh = trimesh.creation.icosphere(subdivisions=subdivisions)
    mesh.vertices *= np.random.default_rng(seed).uniform(0.6, 1.4, (len(mesh.vertices), 1))
    return from_trimesh(mesh)


def random_mesh(faces, seed):
    """Triangles anywhere, in each other's way."""
    generator = np.random.default_rng(seed)
    middle = generator.uniform(-2, 2, (3, 1, faces))
    corners = middle + 0.4 * generator.normal(size=(3, 3, faces))
    indices = np.arange(3 * faces).reshape(3, faces)
    return TriangleMesh(corners.reshape(3, -1), indices, materials=("a",))


def gallery():
    """One shape of each kind, none of them aligned with an axis."""
    return [
        Sphere((-1.5, 0.2, 0.3), 0.9, "a"),
        Plane((0, -2, 0), (0.1, 1, 0.2), "a"),
        Disk((1.4, 0.1, -0.7), (1, 2, 3), 0.8, "a"),
        Rectangle((0.3, 1.9, 0.2), (1.5, 0.3, 0), (0, 0, -1.2), "a"),
        Cylinder((0.9, -1.2, 1.3), (1.2, 0.8, 1.1), 0.4, "a"),
        Cylinder((-0.7, 1.2, -1.6), (0.4, 1.5, -1.8), 0.3, "a", capped=False),
        Box((1.7, 1.6, 1.5), (0.9, 0.6, 1.1), "a", rotate=(20, 30, 40)),
        icosphere(1, 0.7, (-0.5, -1.1, 1.9)),
        torus(16, 8),
    ]
