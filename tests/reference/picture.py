"""Pictures: the camera's rays through the samples of the film, and the mean over each pixel."""

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from reference.files import grid_of, load, load_palette, traced
from reference.lenses import through_a_lens
from reference.records import Sample, Scene, Spectrum, Table
from reference.tracer import radiance
from reference.vectors import Vector, add, cross, dot, scale, sub, unit


def render(path: str | Path, palette: str, width: int, height: int, **camera: Any) -> list[list[Spectrum]]:
    """A scene file under one of its palettes, as rows of pixels of bands, in a size and with a camera of one's own.

    Where an index changes with the wavelength there is a picture for each of some wavelengths, and between two of them
    a mixture of theirs.
    """
    spectra, nodes, grid = load_palette(path, palette), traced(path), grid_of(path, palette)
    scenes = [load(path, nm) for nm in nodes or [None]]
    pictures = [picture(one._replace(camera=one.camera | camera), spectra, width, height) for one in scenes]
    if not nodes:
        return pictures[0]
    return [[mixed([one[y][x] for one in pictures], nodes, grid) for x in range(width)] for y in range(height)]


def mixed(pixels: list[Spectrum], nodes: list[float], grid: list[float]) -> Spectrum:
    """At each wavelength of a grid the mixture of the pixels of the two wavelengths around it."""
    found = []
    for band, nm in enumerate(grid):
        k = min(max(j for j, node in enumerate(nodes) if node <= nm), len(nodes) - 2)
        part = (nm - nodes[k]) / (nodes[k + 1] - nodes[k])
        found.append((1 - part) * pixels[k][band] + part * pixels[k + 1][band])
    return found


def picture(scene: Scene, spectra: Mapping[str, Spectrum], width: int, height: int) -> list[list[Spectrum]]:
    """A scene under some spectra, as rows of pixels of bands."""
    return [[pixel(scene, spectra, x, y, width, height) for x in range(width)] for y in range(height)]


def pixel(scene: Scene, spectra: Mapping[str, Spectrum], x: int, y: int, width: int, height: int) -> Spectrum:
    """Radiance of the pixel in column `x` and row `y`, both from 0: the mean over its samples."""
    n = scene.camera.get("samples", 1)
    samples = scene.film(x, y) if scene.film else regular(x, y, n)
    if scene.camera.get("aperture", 0):
        places = 2 * math.ceil(scene.camera.get("lens_samples", 64) / n**2 / 2)
        samples = through_a_lens(samples, places, y * width + x)
    total = [0.0] * len(next(iter(spectra.values())))
    for sample in samples:
        ray = camera_ray(scene.camera, sample.across / width, sample.down / height, width, height, sample.lens)
        seen = radiance(scene, spectra, *ray, scene.depth)
        total = [a + sample.weight * b for a, b in zip(total, seen, strict=True)]
    return total


def regular(x: int, y: int, n: int) -> list[Sample]:
    """The middles of the n × n parts of a pixel, along its rows, all of one weight."""
    return [Sample(x + (i + 0.5) / n, y + (j + 0.5) / n, 1 / n**2) for j in range(n) for i in range(n)]


def camera_ray(
    camera: Table, across: float, down: float, width: int, height: int, lens: tuple[float, float]
) -> tuple[Vector, Vector]:
    """The ray through a film position, both from 0 to 1, from the left and from the top; pixels are square."""
    position, target = camera["position"], camera["target"]
    forward = unit(sub(target, position))
    right = unit(cross(forward, camera.get("up", (0, 1, 0))))
    up = cross(right, forward)
    if camera.get("type", "perspective") == "orthographic":
        half = camera["view_width"] / 2
    else:
        half = math.tan(math.radians(camera.get("field_of_view", 40)) / 2)
    offset = add(scale((2 * across - 1) * half, right), scale((1 - 2 * down) * half * height / width, up))
    parallel = camera.get("type", "perspective") == "orthographic"
    origin, direction = (add(position, offset), forward) if parallel else (position, unit(add(forward, offset)))

    # From a place on the lens to where this ray meets the plane that is sharp.
    radius = camera.get("aperture", 0.0) / 2
    focus = camera.get("focus", math.dist(position, target))
    sharp = add(origin, scale(focus / dot(direction, forward), direction))
    origin = add(origin, add(scale(radius * lens[0], right), scale(radius * lens[1], up)))
    return origin, unit(sub(sharp, origin))
