"""Make meridian.obj: the brass ring that holds a desk globe by its poles, its arm and its foot, as one smooth mesh.

Units are the radius of the globe, whose centre is the origin; y points up, the ring stands in the xy plane, and the
poles lie 23.4° from the vertical, to the right.  Run it again after a change: ``python scenes/make_meridian.py``.
"""

from collections.abc import Callable
from pathlib import Path

import numpy as np

TILT = np.radians(23.4)  # of the Earth's axis
INNER = 1.06  # radius of the ring's inner side
FLOOR = -1.47  # where the foot stands

Surface = Callable[[np.ndarray, np.ndarray], np.ndarray]


def ring(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Points of the ring; u runs around it from the north pole over the right, v around its oval section."""
    angle = 2 * np.pi * u
    # The lower right is the arm: there the ring is stronger, and it thins out towards the other side.
    arm = ((1 + np.cos(angle - np.radians(125))) / 2) ** 2
    depth, width = 0.036 + 0.022 * arm, 0.026 + 0.012 * arm
    radius = INNER + depth + depth * np.cos(2 * np.pi * v)
    return np.stack([radius * np.sin(angle + TILT), radius * np.cos(angle + TILT), width * np.sin(2 * np.pi * v)])


def foot(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Points of the turned foot; u runs around the vertical, v from the ring down to the floor."""
    top = -(INNER + 0.03)
    height = top + (FLOOR - top) * v
    bead = 0.05 * np.exp(-(((v - 0.35) / 0.13) ** 2))
    radius = 0.06 + bead + 0.17 * np.clip(v - 0.3, 0, None) ** 3 / 0.7**3
    return np.stack([radius * np.sin(2 * np.pi * u), height, radius * np.cos(2 * np.pi * u)])


def grid(surface: Surface, around: int, steps: int, *, closed: bool) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Vertices, outward unit normals and triangles of a surface; `closed` if v runs around as u does."""
    rows = steps if closed else steps + 1
    u, v = np.meshgrid(np.arange(around) / around, np.arange(rows) / steps, indexing="ij")
    small = 1e-4
    along_u = surface(u + small, v) - surface(u - small, v)
    along_v = surface(u, v + small) - surface(u, v - small)
    normal = np.cross(along_u, along_v, axis=0)
    normal /= np.linalg.norm(normal, axis=0)

    i, j = np.meshgrid(np.arange(around), np.arange(steps), indexing="ij")
    here, right = i * rows + j, (i + 1) % around * rows + j
    below, diagonal = i * rows + (j + 1) % rows, (i + 1) % around * rows + (j + 1) % rows
    faces = np.concatenate([np.stack([here, right, diagonal]), np.stack([here, diagonal, below])], axis=-1)
    return surface(u, v).reshape(3, -1), normal.reshape(3, -1), faces.reshape(3, -1)


def obj(parts: list[tuple[np.ndarray, np.ndarray, np.ndarray]]) -> str:
    """The parts as the text of an OBJ file, with a normal at each vertex."""
    lines = ["# Made by make_meridian.py", "usemtl Brass", "s 1"]
    start = 1
    for vertices, normals, faces in parts:
        lines += ["v {:.6f} {:.6f} {:.6f}".format(*vertex) for vertex in vertices.T]
        lines += ["vn {:.5f} {:.5f} {:.5f}".format(*normal) for normal in normals.T]
        lines += [f"f {a}//{a} {b}//{b} {c}//{c}" for a, b, c in (faces + start).T]
        start += vertices.shape[1]
    return "\n".join(lines) + "\n"


def text() -> str:
    """The whole file."""
    return obj([grid(ring, 128, 16, closed=True), grid(foot, 32, 24, closed=False)])


if __name__ == "__main__":
    Path(__file__).with_name("meridian.obj").write_text(text(), encoding="ascii")
