"""Samples of lights that look like a figure: one that stands for all of it, or Gauss points on it (step 1)."""

from collections.abc import Iterator

import numpy as np

from symrt.arrays import PerRay, Vectors, dot, length, normalise
from symrt.scene.irradiance import vector_irradiance
from symrt.scene.lights import Illumination, Points
from symrt.scene.outlines import DARK, Outline, begins, place


def as_a_whole(figure: Outline, normals: Points) -> Illumination:
    """One sample that stands for a whole figure, exact for diffusers: its vector irradiance above their horizons."""
    irradiance = vector_irradiance(figure, normals)
    size = length(irradiance)
    direction = normalise(np.where(size > 0, irradiance, DARK))
    return Illumination(direction, length(figure.centre), size, figure)


def gauss_points(figure: Outline, count: int) -> Iterator[Illumination]:
    """About count × count places of a figure, whose weights give a smooth function's mean over it."""
    area = figure.area
    for u, v, weight in _disk_points(count) if figure.circular else _square_points(count):
        towards = figure.centre + u * figure.across + v * figure.up
        direction, distance = begins(figure, towards)
        square = dot(towards, towards)
        facing = np.maximum(-dot(direction, figure.normal), 0.0) * figure.shines
        # Close to a place its part of the figure still fills no more than the half space.
        falloff = weight * area * facing / np.where(square > 0, square, np.inf)
        yield Illumination(direction, distance, np.minimum(falloff, 2 * np.pi))


def drawn_place(figure: Outline, u: PerRay, v: PerRay) -> Illumination:
    """One place of a figure for each point, by its coordinates from −1 to 1, that stands for all of the figure.

    Over places that are drawn anew it is right on average.
    """
    towards, weight = place(figure, u, v)
    direction, distance = begins(figure, towards)
    # Close to a place the figure still fills no more than the half space.
    return Illumination(direction, distance, np.minimum(figure.area * weight * figure.shines, 2 * np.pi))


def _square_points(count: int) -> list[tuple[float, float, float]]:
    x, w = np.polynomial.legendre.leggauss(count)
    return [(u, v, p * q / 4) for u, p in zip(x, w, strict=True) for v, q in zip(x, w, strict=True)]


def _disk_points(count: int) -> list[tuple[float, float, float]]:
    """Rings at Gauss points of the square of the radius, each with as many places at equal angles."""
    rings = max(1, count // 2)
    turns = -(-(count**2) // rings)
    x, w = np.polynomial.legendre.leggauss(rings)
    angles = 2 * np.pi * (np.arange(turns) + 0.5) / turns
    radii = zip(np.sqrt((x + 1) / 2), w / 2, strict=True)
    return [(r * np.cos(phi), r * np.sin(phi), p / turns) for r, p in radii for phi in angles]


def perpendicular(axis: Vectors) -> tuple[Vectors, Vectors]:
    """Two unit vectors perpendicular to each unit vector and to each other."""
    slight = np.abs(axis[0]) < 0.5
    other = np.stack([slight, ~slight, np.zeros_like(slight)]).astype(float)
    across = normalise(np.cross(other, axis, axis=0))
    return across, np.cross(axis, across, axis=0)
