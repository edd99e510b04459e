"""A plain spectral ray tracer: the oracle that symrt's pictures are held against.

One ray at a time, one float at a time, textbook formulas and recursion.  Nothing of symrt is imported, and spectra are
multiplied as the light travels: there are no symbols, no matrix and no arrays here.  A scene file is read directly.

References
----------
.. [1] A. S. Glassner (ed.), "An Introduction to Ray Tracing", Academic Press, 1989.
.. [2] T. Möller and B. Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection", JGT 2(1), 1997, pp. 21-28.
"""

import importlib
import itertools
import math
import re
import tomllib
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import imageio.v3 as imageio
import numpy as np

Vector = tuple[float, float, float]
Spectrum = list[float]
Table = Mapping[str, Any]
RELIEF = Path(__file__).parents[1] / "symrt" / "data" / "relief_30min.npz"


class Hit(NamedTuple):
    """Where a ray meets a shape; `normal` is of the surface itself, `shading` of what it stands for."""

    distance: float
    point: Vector
    normal: Vector
    shading: Vector
    uv: tuple[float, float]
    extent: tuple[float, float]
    material: str


class Illumination(NamedTuple):
    """Unit direction to a light, its distance, and the irradiance on what faces it, per unit of its spectrum."""

    direction: Vector
    distance: float
    irradiance: float


Shape = Callable[[Vector, Vector, float], Hit | None]
Light = Callable[[Vector], Illumination]


class Scene(NamedTuple):
    """A scene file as closures: a shape answers a ray, a light a point, a texture a position on its surface."""

    camera: Table
    shapes: list[Shape]
    lights: dict[str, Light]
    ambient: list[str]
    unshadowed: set[str]
    materials: dict[str, Table]
    textures: dict[str, Callable[[Hit], dict[str, float]]]
    depth: int


# --- Vectors ---------------------------------------------------------------------------------------------------------


def add(a: Sequence[float], b: Sequence[float]) -> Vector:
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


def sub(a: Sequence[float], b: Sequence[float]) -> Vector:
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def scale(k: float, a: Sequence[float]) -> Vector:
    return (k * a[0], k * a[1], k * a[2])


def dot(a: Sequence[float], b: Sequence[float]) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Sequence[float], b: Sequence[float]) -> Vector:
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def unit(a: Sequence[float]) -> Vector:
    return scale(1 / math.sqrt(dot(a, a)), a)


def along(origin: Vector, distance: float, direction: Vector) -> Vector:
    return add(origin, scale(distance, direction))


def mirrored(a: Vector, normal: Vector) -> Vector:
    """A direction away from the surface, mirrored about the normal; it points away from the surface again."""
    return sub(scale(2 * dot(a, normal), normal), a)


# --- Shapes: each closure answers "the nearest hit beyond `low`, or None" --------------------------------------------


def sphere(table: Table) -> Shape:
    centre, radius = table["centre"], table["radius"]
    pole = unit(table.get("pole", (0, 1, 0)))
    meridian = table.get("meridian", (0, 0, 1))
    meridian = unit(sub(meridian, scale(dot(meridian, pole), pole)))
    east = cross(pole, meridian)

    def hit(origin: Vector, direction: Vector, low: float) -> Hit | None:
        between = sub(centre, origin)
        middle = dot(between, direction)
        # The squared distance from the centre to the line, from the perpendicular: no cancellation.
        perpendicular = sub(between, scale(middle, direction))
        inside = radius * radius - dot(perpendicular, perpendicular)
        if inside < 0:
            return None
        half = math.sqrt(inside)
        distance = next((t for t in (middle - half, middle + half) if t > low), None)
        if distance is None:
            return None
        normal = unit(sub(along(origin, distance, direction), centre))
        longitude = math.atan2(dot(normal, east), dot(normal, meridian))
        latitude = math.atan2(dot(normal, pole), math.hypot(dot(normal, east), dot(normal, meridian)))
        uv = ((longitude / (2 * math.pi) + 0.5) % 1.0, 0.5 - latitude / math.pi)
        point = along(centre, radius, normal)
        extent = (2 * math.pi * radius, math.pi * radius)
        return Hit(distance, point, normal, normal, uv, extent, table["material"])

    return hit


def flat(
    point: Sequence[float], normal: Vector, material: str, where: Callable[[Vector], tuple[Any, Any] | None]
) -> Shape:
    """Part of a plane: `where` gives uv and extent of an offset from `point`, or None outside the part."""

    def hit(origin: Vector, direction: Vector, low: float) -> Hit | None:
        slope = dot(direction, normal)
        if slope == 0:
            return None
        distance = dot(sub(point, origin), normal) / slope
        if not distance > low:
            return None
        met = along(origin, distance, direction)
        place = where(sub(met, point))
        return None if place is None else Hit(distance, met, normal, normal, *place, material)

    return hit


def frame(normal: Vector) -> tuple[Vector, Vector]:
    """The u and v axes of a plane: from the z axis, or from the x axis where the normal is mostly along z."""
    sizes = [abs(x) for x in normal]
    helper = (1.0, 0.0, 0.0) if sizes[2] == max(sizes) else (0.0, 0.0, 1.0)
    u = unit(cross(helper, normal))
    return u, cross(normal, u)


def plane(table: Table) -> Shape:
    normal = unit(table["normal"])
    u, v = frame(normal)
    return flat(table["point"], normal, table["material"], lambda p: ((dot(p, u), dot(p, v)), (1.0, 1.0)))


def disk(table: Table) -> Shape:
    normal = unit(table["normal"])
    u, v = frame(normal)
    radius = table["radius"]

    def where(p: Vector) -> tuple[Any, Any] | None:
        return ((dot(p, u), dot(p, v)), (1.0, 1.0)) if dot(p, p) <= radius * radius else None

    return flat(table["centre"], normal, table["material"], where)


def rectangle(table: Table) -> Shape:
    edge_u, edge_v = table["edge_u"], table["edge_v"]
    normal = unit(cross(edge_u, edge_v))
    corner = sub(table["centre"], scale(0.5, add(edge_u, edge_v)))
    # Oblique edges are allowed: solve p = a edge_u + b edge_v by the reciprocal vectors.
    area = dot(cross(edge_u, edge_v), normal)
    for_u, for_v = scale(1 / area, cross(edge_v, normal)), scale(1 / area, cross(normal, edge_u))
    extent = (math.hypot(*edge_u), math.hypot(*edge_v))

    def where(p: Vector) -> tuple[Any, Any] | None:
        a, b = dot(p, for_u), dot(p, for_v)
        return ((a, b), extent) if 0 <= a <= 1 and 0 <= b <= 1 else None

    return flat(corner, normal, table["material"], where)


def cylinder(table: Table) -> Shape:
    base, top, radius = table["base"], table["top"], table["radius"]
    axis, height = unit(sub(top, base)), math.dist(base, top)
    u, v = frame(axis)
    caps = []
    if table.get("capped", True):
        for centre, outward in ((base, scale(-1, axis)), (top, axis)):
            caps.append(disk({"centre": centre, "normal": outward, "radius": radius, "material": table["material"]}))

    def side(origin: Vector, direction: Vector, low: float) -> Hit | None:
        start, across = sub(origin, base), sub(direction, scale(dot(direction, axis), axis))
        out = sub(start, scale(dot(start, axis), axis))
        a, b, c = dot(across, across), dot(across, out), dot(out, out) - radius * radius
        if a == 0 or b * b < a * c:
            return None
        q = -(b + math.copysign(math.sqrt(b * b - a * c), b))
        for distance in sorted((q / a, c / q) if q else (0.0, 0.0)):
            p = along(start, distance, direction)
            along_axis = dot(p, axis)
            if distance > low and 0 <= along_axis <= height:
                normal = unit(sub(p, scale(along_axis, axis)))
                turn = math.atan2(dot(normal, v), dot(normal, u)) / (2 * math.pi) + 0.5
                extent = (2 * math.pi * radius, height)
                uv = (turn % 1.0, 1 - along_axis / height)
                return Hit(distance, along(origin, distance, direction), normal, normal, uv, extent, table["material"])
        return None

    return group([side, *caps])


def box(table: Table) -> Shape:
    """Six walls; u runs to the right and v downwards on each, seen from outside."""
    turn, middle, size = rotation(table.get("rotate", (0, 0, 0))), table["centre"], table["size"]
    names = table["material"]
    x, y, z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
    to_the_right = {"front": (x, y), "back": (scale(-1, x), y), "right": (scale(-1, z), y), "left": (z, y)}
    seen = {**to_the_right, "top": (x, scale(-1, z)), "bottom": (x, z)}

    def wall(face: str) -> Shape:
        right, up = seen[face]
        out, wide, high = cross(right, up), abs(dot(right, size)), abs(dot(up, size))
        centre = add(middle, turn(scale(0.5 * abs(dot(out, size)), out)))
        right, up = turn(right), turn(up)

        def where(p: Vector) -> tuple[Any, Any] | None:
            u, v = dot(p, right) / wide + 0.5, 0.5 - dot(p, up) / high
            return ((u, v), (wide, high)) if 0 <= u <= 1 and 0 <= v <= 1 else None

        return flat(centre, turn(out), names if isinstance(names, str) else names.get(face, names.get("others")), where)

    return group([wall(face) for face in seen])


def group(shapes: list[Shape]) -> Shape:
    """The nearest hit of several shapes."""

    def hit(origin: Vector, direction: Vector, low: float) -> Hit | None:
        hits = [found for shape in shapes if (found := shape(origin, direction, low)) is not None]
        return min(hits, key=lambda found: found.distance, default=None)

    return hit


# --- Meshes: Wavefront OBJ, triangles in a tree of boxes -------------------------------------------------------------


class Corner(NamedTuple):
    """A corner of a triangle."""

    position: Vector
    uv: tuple[float, float]
    normal: Vector | None


def mesh(table: Table, folder: Path) -> Shape:
    turn = rotation(table.get("rotate", (0, 0, 0)))
    size, shift, names = table.get("scale", 1), table.get("translate", (0, 0, 0)), table["material"]

    def placed(corner: Corner) -> Corner:
        normal = None if corner.normal is None else unit(turn(corner.normal))
        return Corner(add(turn(scale(size, corner.position)), shift), corner.uv, normal)

    return boxed(
        [
            triangle(*(placed(corner) for corner in corners), names if isinstance(names, str) else names[name])
            for corners, name in read_obj(folder / table["file"])
        ]
    )


def rotation(degrees: Sequence[float]) -> Callable[[Vector], Vector]:
    """About x first, then y, then z."""
    (ax, ay, az) = (math.radians(angle) for angle in degrees)

    def turn(p: Vector) -> Vector:
        x, y, z = p
        y, z = y * math.cos(ax) - z * math.sin(ax), y * math.sin(ax) + z * math.cos(ax)
        z, x = z * math.cos(ay) - x * math.sin(ay), z * math.sin(ay) + x * math.cos(ay)
        x, y = x * math.cos(az) - y * math.sin(az), x * math.sin(az) + y * math.cos(az)
        return (x, y, z)

    return turn


def read_obj(path: Path) -> Iterable[tuple[tuple[Corner, Corner, Corner], str]]:
    """Triangles of a file and the file's name of their material; polygons become fans."""
    positions: list[Vector] = []
    uvs: list[Vector] = []
    normals: list[Vector] = []
    name = ""
    for line in path.read_text().splitlines():
        word, *rest = line.split() or ["#"]
        if word == "v":
            positions.append((float(rest[0]), float(rest[1]), float(rest[2])))
        elif word == "vt":  # v counts up from the bottom in the file, and down from the top here
            uvs.append((float(rest[0]), 1 - float(rest[1]), 0.0))
        elif word == "vn":
            normals.append((float(rest[0]), float(rest[1]), float(rest[2])))
        elif word == "usemtl":
            name = " ".join(rest)
        elif word == "f":
            corners = [_corner(text, positions, uvs, normals) for text in rest]
            for second, third in itertools.pairwise(corners[1:]):
                yield (corners[0], second, third), name


def _corner(text: str, positions: list[Vector], uvs: list[Vector], normals: list[Vector]) -> Corner:
    """From its numbers ``position/uv/normal``, the last two may be missing; they count from 1, or from the end."""
    position, uv, normal = (*text.split("/"), "", "")[:3]

    def pick(items: list[Vector], number: str) -> Vector:
        return items[int(number) - 1 if int(number) > 0 else int(number)]

    u, v, _ = pick(uvs, uv) if uv else (0.0, 0.0, 0.0)
    return Corner(pick(positions, position), (u, v), pick(normals, normal) if normal else None)


class Bounded(NamedTuple):
    """A shape and the box around it."""

    low: Vector
    high: Vector
    shape: Shape


def triangle(a: Corner, b: Corner, c: Corner, material: str) -> Bounded:
    """Möller and Trumbore's test [2]_, with the tolerance that keeps a ray from slipping between two neighbours."""
    origin, edge_b, edge_c = a.position, sub(b.position, a.position), sub(c.position, a.position)
    area = cross(edge_b, edge_c)
    slack = 1e-12

    def hit(start: Vector, direction: Vector, low: float) -> Hit | None:
        across = cross(direction, edge_c)
        volume = dot(edge_b, across)
        if volume == 0:
            return None
        offset = sub(start, origin)
        v = dot(offset, across) / volume
        if v < -slack or v > 1 + slack:
            return None
        sideways = cross(offset, edge_b)
        w = dot(direction, sideways) / volume
        if w < -slack or v + w > 1 + slack:
            return None
        distance = dot(edge_c, sideways) / volume
        if not distance > low:
            return None
        normal = unit(area)
        point = add(origin, add(scale(v, edge_b), scale(w, edge_c)))
        shading = normal
        if a.normal is not None and b.normal is not None and c.normal is not None:
            shading = unit(add(scale(1 - v - w, a.normal), add(scale(v, b.normal), scale(w, c.normal))))
        uv = tuple((1 - v - w) * a.uv[k] + v * b.uv[k] + w * c.uv[k] for k in range(2))
        return Hit(distance, point, normal, shading, uv, (1.0, 1.0), material)  # type: ignore[arg-type]

    corners = [a.position, b.position, c.position]
    return Bounded(tuple(map(min, *corners)), tuple(map(max, *corners)), hit)  # type: ignore[arg-type]


def boxed(parts: list[Bounded]) -> Shape:
    """A tree of boxes, halved at the median along its longest side; a ray asks only the boxes that it passes."""
    return _tree(parts).shape


def _tree(parts: list[Bounded]) -> Bounded:
    low: Vector = tuple(min(part.low[k] for part in parts) for k in range(3))  # type: ignore[assignment]
    high: Vector = tuple(max(part.high[k] for part in parts) for k in range(3))  # type: ignore[assignment]
    if len(parts) > 4:
        axis = max(range(3), key=lambda k: high[k] - low[k])
        ordered = sorted(parts, key=lambda part: part.low[axis] + part.high[axis])
        parts = [_tree(ordered[: len(ordered) // 2]), _tree(ordered[len(ordered) // 2 :])]
    inner = group([part.shape for part in parts])
    margin = 1e-9 * max(map(abs, (*low, *high)))

    def hit(origin: Vector, direction: Vector, least: float) -> Hit | None:
        enter, leave = least, math.inf
        for k in range(3):
            if direction[k] == 0:
                if not low[k] - margin <= origin[k] <= high[k] + margin:
                    return None
                continue
            first, second = (low[k] - margin - origin[k]) / direction[k], (high[k] + margin - origin[k]) / direction[k]
            enter, leave = max(enter, min(first, second)), min(leave, max(first, second))
        return inner(origin, direction, least) if enter <= leave else None

    return Bounded(low, high, hit)


# --- Textures: each closure gives the weights of materials at a hit --------------------------------------------------


def checker(table: Table) -> Callable[[Hit], dict[str, float]]:
    def weights(hit: Hit) -> dict[str, float]:
        steps = sum(math.floor(x * length / table["size"]) for x, length in zip(hit.uv, hit.extent, strict=True))
        return {table["materials"][steps % 2]: 1.0}

    return weights


def banded_relief(table: Table) -> Callable[[Hit], dict[str, float]]:
    with np.load(RELIEF) as file:
        rows: list[list[int]] = file["e"].tolist()
    levels, materials, blend = table["levels"], table["materials"], table["blend"]

    def height(u: float, v: float) -> float:
        """Metres, bilinear between the centres of cells; row 0 is the southernmost, column 0 begins at 180° W."""
        x, y = u * len(rows[0]) - 0.5, (1 - v) * len(rows) - 0.5
        y = min(max(y, 0.0), len(rows) - 1.0)
        column, row = math.floor(x), min(math.floor(y), len(rows) - 2)
        right, up = x - column, y - row
        west, east = column % len(rows[0]), (column + 1) % len(rows[0])
        south = rows[row][west] * (1 - right) + rows[row][east] * right
        north = rows[row + 1][west] * (1 - right) + rows[row + 1][east] * right
        return south * (1 - up) + north * up

    def weights(hit: Hit) -> dict[str, float]:
        e = height(*hit.uv)
        above = [1.0, *(min(max((e - level + blend) / (2 * blend), 0.0), 1.0) for level in levels), 0.0]
        return {name: above[k] - above[k + 1] for k, name in enumerate(materials) if above[k] > above[k + 1]}

    return weights


def label_image(table: Table, folder: Path) -> Callable[[Hit], dict[str, float]]:
    """The element that the point falls in, u to the right and v down from the top, holds the number of its material."""
    pixels = imageio.imread(folder / table["file"]).tolist()

    def weights(hit: Hit) -> dict[str, float]:
        row = pixels[math.floor(hit.uv[1] * len(pixels)) % len(pixels)]
        return {table["materials"][row[math.floor(hit.uv[0] * len(row)) % len(row)]]: 1.0}

    return weights


def weight_image(table: Table, folder: Path) -> Callable[[Hit], dict[str, float]]:
    """Each element's channels, divided by their sum, are weights; between the elements' centres they are blended.

    One channel serves two materials: black is the first, white the second.
    """
    pixels = imageio.imread(folder / table["file"])
    most = np.iinfo(pixels.dtype).max
    rows = [[[most - p, p] if isinstance(p, int) else p for p in row] for row in pixels.tolist()]

    def weights(hit: Hit) -> dict[str, float]:
        x, y = hit.uv[0] * len(rows[0]) - 0.5, hit.uv[1] * len(rows) - 0.5
        right, down = x - math.floor(x), y - math.floor(y)
        shares = dict.fromkeys(table["materials"], 0.0)
        for i, share_of_column in ((0, 1 - right), (1, right)):
            for j, share_of_row in ((0, 1 - down), (1, down)):
                channels = rows[(math.floor(y) + j) % len(rows)][(math.floor(x) + i) % len(rows[0])]
                for name, part in zip(table["materials"], channels, strict=True):
                    shares[name] += share_of_column * share_of_row * part / sum(channels)
        return shares

    return weights


# --- Lights ----------------------------------------------------------------------------------------------------------


def point_light(table: Table) -> Light:
    def at(point: Vector) -> Illumination:
        to_light = sub(table["position"], point)
        distance = math.sqrt(dot(to_light, to_light))
        return Illumination(scale(1 / distance, to_light), distance, 1 / distance**2)

    return at


def directional_light(table: Table) -> Light:
    towards = unit(scale(-1, table["direction"]))
    return lambda _: Illumination(towards, math.inf, 1.0)


# --- Materials: components and their share of the light that a model sends to the viewer -----------------------------


def direct(material: Table, normal: Vector, to_light: Vector, to_eye: Vector) -> list[tuple[str, float]]:
    """Radiance per irradiance on a surface that faces the light, as (component, factor), for each model stacked."""
    n_l = dot(normal, to_light)
    r_v = max(0.0, dot(mirrored(to_light, normal), to_eye))
    s = material.get("exponent")
    found = []
    for model in models(material):
        if model != "mirror":
            found.append(("diffuse", n_l / math.pi))
        if model == "phong":
            found.append(("specular", (s + 2) / (2 * math.pi) * r_v**s * n_l))
        if model == "phong_plain":
            found.append(("specular", r_v**s / math.pi))
        if model == "blinn_phong":
            n_h = max(0.0, dot(normal, unit(add(to_light, to_eye))))
            found.append(("specular", (s + 8) / (8 * math.pi) * n_h**s * n_l))
    return found


def models(material: Table) -> list[str]:
    named = material.get("model", "lambert")
    return [named] if isinstance(named, str) else named


# --- The tracer ------------------------------------------------------------------------------------------------------


def radiance(
    scene: Scene, spectra: Mapping[str, Spectrum], origin: Vector, direction: Vector, bounces: int
) -> Spectrum:
    """What arrives against `direction`, in every band; `bounces` mirrors may still be followed."""
    total = [0.0] * len(next(iter(spectra.values())))
    hit = nearest(scene, origin, direction)
    if hit is None:
        return total
    to_eye = scale(-1, direction)
    normal = turned(hit.normal, to_eye)
    hit = hit._replace(normal=normal, shading=turned(hit.shading, normal))
    weights = scene.textures[hit.material](hit) if hit.material in scene.textures else {hit.material: 1.0}
    for name, weight in weights.items():
        from_lights(total, scene, spectra, hit, to_eye, name, weight)
    mirrors = {name: weight for name, weight in weights.items() if "mirror" in models(scene.materials[name])}
    onward = mirrored(to_eye, hit.shading)
    if mirrors and bounces > 0 and dot(onward, hit.normal) > 0:
        seen = radiance(scene, spectra, hit.point, onward, bounces - 1)
        for name, weight in mirrors.items():
            gather(total, weight, seen, spectra[f"{name}.mirror"])
    return total


def turned(normal: Vector, towards: Vector) -> Vector:
    return normal if dot(normal, towards) >= 0 else scale(-1, normal)


def from_lights(
    total: Spectrum, scene: Scene, spectra: Mapping[str, Spectrum], hit: Hit, to_eye: Vector, name: str, weight: float
) -> None:
    """Add what one material sends to the eye of the light that reaches it from the lights themselves."""
    material = scene.materials[name]
    for light in scene.lights:
        to_light, irradiance = arriving(scene, light, hit)
        if irradiance > 0:
            for component, share in direct(material, hit.shading, to_light, to_eye):
                gather(total, weight * irradiance * share, spectra[light], spectra[f"{name}.{component}"])
    for _ in (model for model in models(material) if model != "mirror"):
        for light in scene.ambient:
            gather(total, weight, spectra[light], spectra[f"{name}.diffuse"])


def gather(total: Spectrum, weight: float, first: Spectrum, second: Spectrum) -> None:
    for k, (a, b) in enumerate(zip(first, second, strict=True)):
        total[k] += weight * a * b


def nearest(scene: Scene, origin: Vector, direction: Vector) -> Hit | None:
    """The nearest surface that is not the one the ray starts on."""
    return group(scene.shapes)(origin, direction, 1e-9 * (1 + max(map(abs, origin))))


def arriving(scene: Scene, light: str, hit: Hit) -> tuple[Vector, float]:
    """Direction to a light and the irradiance it brings to a surface that faces it: 0 from behind or in shadow."""
    to_light, distance, irradiance = scene.lights[light](hit.point)
    if dot(to_light, hit.normal) <= 0 or dot(to_light, hit.shading) <= 0:
        return to_light, 0.0
    blocker = None if light in scene.unshadowed else nearest(scene, hit.point, to_light)
    return to_light, irradiance if blocker is None or blocker.distance >= distance else 0.0


# --- The camera ------------------------------------------------------------------------------------------------------


def camera_ray(camera: Table, across: float, down: float, width: int, height: int) -> tuple[Vector, Vector]:
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
    if camera.get("type", "perspective") == "orthographic":
        return add(position, offset), forward
    return add(position, (0.0, 0.0, 0.0)), unit(add(forward, offset))


def pixel(scene: Scene, spectra: Mapping[str, Spectrum], x: int, y: int, width: int, height: int) -> Spectrum:
    """Radiance of the pixel in column `x` and row `y`, both from 0: the mean over its n × n samples."""
    n = scene.camera.get("samples", 1)
    total = [0.0] * len(next(iter(spectra.values())))
    for i in range(n):
        for j in range(n):
            film = (x + (i + 0.5) / n) / width, (y + (j + 0.5) / n) / height
            seen = radiance(scene, spectra, *camera_ray(scene.camera, *film, width, height), scene.depth)
            total = [a + b / n**2 for a, b in zip(total, seen, strict=True)]
    return total


def render(path: str | Path, palette: str, width: int, height: int) -> list[list[Spectrum]]:
    """A scene file under one of its palettes, as rows of pixels of bands, in a size of one's own."""
    scene, spectra = load(path), load_palette(path, palette)
    return [[pixel(scene, spectra, x, y, width, height) for x in range(width)] for y in range(height)]


# --- Files -----------------------------------------------------------------------------------------------------------


def load(path: str | Path) -> Scene:
    """Read a scene file, which is taken to be right: symrt is the one that checks."""
    file, folder = tomllib.loads(Path(path).read_text()), Path(path).parent
    kinds = {"sphere": sphere, "plane": plane, "disk": disk, "rectangle": rectangle, "cylinder": cylinder, "box": box}
    lights = {"point": point_light, "directional": directional_light}
    from_file = {"label_image": label_image, "weight_image": weight_image}
    computed = {"checker": checker, "banded_relief": banded_relief}
    textures = file.get("textures", {})
    return Scene(
        camera=file["camera"],
        shapes=[mesh(t, folder) if t["type"] == "mesh" else kinds[t["type"]](t) for t in file["shapes"]],
        lights={name: lights[t["type"]](t) for name, t in file["lights"].items() if t["type"] != "ambient"},
        ambient=[name for name, t in file["lights"].items() if t["type"] == "ambient"],
        unshadowed={name for name, t in file["lights"].items() if not t.get("shadows", True)},
        materials=file["materials"],
        textures={
            name: from_file[t["type"]](t, folder) if t["type"] in from_file else computed[t["type"]](t)
            for name, t in textures.items()
        },
        depth=file.get("depth", 4),
    )


def load_palette(path: str | Path, name: str) -> dict[str, Spectrum]:
    """The spectra of a palette by symbol: numbers, lists, or names of tables in colour-science."""
    table = tomllib.loads(Path(path).read_text())["palettes"][name]
    bands = table["bands"]
    grid = (
        None
        if bands == "rgb"
        else [bands[0] + k * bands[2] for k in range(round((bands[1] - bands[0]) / bands[2]) + 1)]
    )
    return {symbol: spectrum(value, grid) for symbol, value in table.items() if symbol != "bands"}


def spectrum(value: Any, grid: list[float] | None) -> Spectrum:
    """Values on a grid of wavelengths in nm; None stands for red, green and blue.

    A table is read at its own wavelengths only: what would have to be interpolated is a `KeyError`.

    Examples
    --------
    >>> spectrum(0.5, [400, 500])
    [0.5, 0.5]
    """
    if isinstance(value, int | float):
        return [float(value)] * (3 if grid is None else len(grid))
    if isinstance(value, list):
        return [float(x) for x in value]
    if isinstance(value, dict):
        return [value["scale"] * x for x in spectrum(value["spectrum"], grid)]
    family, name = value.split("/")
    if family == "illuminant":
        light = colour_science().SDS_ILLUMINANTS[name]
        return [x / luminance(light) for x in on_grid(light, grid)]
    chart = colour_science().SDS_COLOURCHECKERS["BabelColor Average"]
    # A grey's notation and density may be left out: white is "white 9.5 (.05 D)".
    (patch,) = (
        sd
        for title, sd in chart.items()
        if name in (title, re.sub(r"( [\d.]+)? \(.*", "", title), title.split(" (")[0])
    )
    return on_grid(patch, grid)


def colour_science() -> Any:
    """The library, imported late: it takes a second, and would change how NumPy prints."""
    with np.printoptions():
        return importlib.import_module("colour")


def on_grid(table: Any, grid: list[float] | None) -> Spectrum:
    assert grid is not None, "a table of wavelengths has no red, green and blue here"
    measured = dict(zip(table.wavelengths.tolist(), table.values.tolist(), strict=True))
    return [measured[nm] for nm in grid]


def luminance(light: Any) -> float:
    """Of an illuminant, against an equal-energy light of constant 1: CIE 1931 2° observer, nm by nm."""
    observer = colour_science().MSDS_CMFS["CIE 1931 2 Degree Standard Observer"]
    nm, y = observer.wavelengths, observer.values[:, 1]
    values = np.interp(nm, light.wavelengths, light.values, left=0, right=0)
    return math.fsum((values * y).tolist()) / math.fsum(y.tolist())
