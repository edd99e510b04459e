"""Lights with an area: their irradiance against quadrature, to 1e-12 of the vector irradiance, and what they refuse."""

import math
import pickle
from dataclasses import replace
from itertools import pairwise

import mpmath
import numpy as np
import pytest

import symrt as rt
from symrt.arrays import dot
from symrt.scene.figures import begins
from symrt.scene.lights import answering
from symrt.scene.wide_lights import AreaLight

RECTANGLE = rt.RectangleLight("lamp", centre=(0.25, 0.5, 0.125), edge_u=(2, 0, 0), edge_v=(0, 0.75, -1))
DISK = rt.DiskLight("lamp", centre=(0.25, 0.5, 0.125), normal=(1, -2, 0.5), radius=0.75)
BULB = rt.SphereLight("lamp", centre=(0.25, 0.5, 0.125), radius=0.75)
X, Y, Z = np.eye(3)


def unit(v):
    return np.asarray(v, dtype=float) / np.linalg.norm(v)


def normal_of(light):
    return unit(np.cross(light.edge_u, light.edge_v) if light.type == "rectangle" else light.normal)


# --- Oracles: quadrature over what is above the horizon, in parameters in which it is smooth -------------------------

NODES, WEIGHTS = np.polynomial.legendre.leggauss(16)


def integral(f, low=(0.0, 0.0), high=(1.0, 1.0), depth=0):
    """The integral of a vector over a rectangle of parameters, cut in four until nothing changes."""
    coarse = _gauss(f, low, high)
    middle = ((low[0] + high[0]) / 2, (low[1] + high[1]) / 2)
    parts = [
        (tuple(np.where(corner, middle, low)), tuple(np.where(corner, high, middle)))
        for corner in ((0, 0), (0, 1), (1, 0), (1, 1))
    ]
    fine = sum(_gauss(f, *part) for part in parts)
    if np.abs(fine - coarse).max() <= 1e-15 or depth == 14:
        return fine
    return sum(integral(f, *part, depth + 1) for part in parts)


def _gauss(f, low, high):
    s, t = (a + (b - a) * (NODES + 1) / 2 for a, b in zip(low, high, strict=True))
    w = np.outer(WEIGHTS, WEIGHTS) * (high[0] - low[0]) * (high[1] - low[1]) / 4
    return np.tensordot(f(s[:, None], t[None, :]), w, axes=2)


def from_places(towards, normal, area):
    """The vector irradiance of places, each of an area."""
    square = np.sum(towards**2, axis=0)
    return towards * (-np.tensordot(normal, towards, 1) / square**2 * area)


def rectangle_by_quadrature(light, point, horizon):
    """Triangles of the clipped rectangle (Sutherland and Hodgman), each as a square with one side drawn to a corner."""
    normal = normal_of(light)
    c, u, v = (np.array(w) for w in (light.centre, light.edge_u, light.edge_v))
    corners = [c + (i * u + j * v) / 2 - point for i, j in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    kept = []
    for a, b in zip(corners, corners[1:] + corners[:1], strict=True):
        above, then = horizon @ a, horizon @ b
        kept += [a] if above >= 0 else []
        kept += [a + above / (above - then) * (b - a)] if (above >= 0) != (then >= 0) else []
    # The triangles meet where the integrand is steepest, so that the square is finest there.
    foot = min(range(len(kept)), key=lambda k: np.linalg.norm(kept[k]), default=0)
    kept = kept[foot:] + kept[:foot]
    total = np.zeros(3)
    for a, b in pairwise(kept[1:]):
        e, f = a - kept[0], b - kept[0]
        twice = np.linalg.norm(np.cross(e, f))

        def vector(s, t, e=e, f=f, twice=twice):
            towards = kept[0][:, None, None] + s * ((1 - t) * e[:, None, None] + t * f[:, None, None])
            return from_places(towards, normal, twice * s * np.ones_like(t))

        total += integral(vector)
    return total


def disk_by_quadrature(light, point, horizon):
    """Chords of the disk across the direction in which it rises most."""
    normal = normal_of(light)
    rise = horizon - normal * (horizon @ normal)
    rise = unit(rise if np.linalg.norm(rise) > 1e-9 else np.cross(normal, unit([0.3, 0.5, 0.8])))
    beside, centre = np.cross(normal, rise), np.array(light.centre) - point
    cut = np.clip(-(horizon @ centre) / max(light.radius * (horizon @ rise), 1e-300), -1, 1)
    end = math.acos(cut)

    def vector(s, t):
        angle = end * s
        along, across = np.cos(angle) * np.ones_like(t), np.sin(angle) * (2 * t - 1)
        towards = centre[:, None, None] + light.radius * (along * rise[:, None, None] + across * beside[:, None, None])
        return from_places(towards, normal, 2 * end * light.radius**2 * np.sin(angle) ** 2 * np.ones_like(t))

    return integral(vector)


def bulb_by_quadrature(light, point, horizon):
    """Irradiance of a surface: cosines over circles around the middle, each in closed form as far as it is above."""
    towards = np.array(light.centre) - point
    distance = np.linalg.norm(towards)
    mpmath.mp.dps = 25
    cosine = mpmath.mpf(min(1.0, float(horizon @ towards / distance)))
    sine, widest = mpmath.sqrt(1 - cosine**2), mpmath.asin(mpmath.mpf(light.radius) / mpmath.mpf(float(distance)))

    def circle(alpha):
        up, out = mpmath.cos(alpha) * cosine, mpmath.sin(alpha) * sine
        lowest = min(1, max(-1, -up / out)) if out else (-1 if up > 0 else 1)
        half = mpmath.acos(lowest)
        return 2 * (half * up + out * mpmath.sin(half)) * mpmath.sin(alpha)

    bend = abs(mpmath.pi / 2 - mpmath.acos(cosine))
    return float(mpmath.quad(circle, [0, bend, widest] if bend < widest else [0, widest]))


def places(light, seed, distances):
    """Points before a light, and horizons: all of it above, and cutting it in many ways."""
    random = np.random.default_rng(seed)
    front = normal_of(light) if light.type != "sphere" else None
    for distance in distances:
        for tilt in (None, 0.0, 0.3, -0.3, 0.9):
            way = unit(random.normal(size=3))
            if front is not None:
                way = unit(way + (0.2 - min(way @ front, 0.2)) * front)
            point = np.array(light.centre) + distance * way
            if front is not None and distance < 1:
                # Not always before the middle.
                aside = 0.6 * random.uniform(-1, 1, 3)
                point = point + aside - (aside @ front) * front
            towards = unit(np.array(light.centre) - point)
            across = unit(np.cross(towards, random.normal(size=3)))
            # The tilt is the height of the light's middle above the horizon, in its own sizes.
            yield point, towards if tilt is None else unit(across + tilt / max(distance, 0.5) * towards)


@pytest.mark.parametrize(
    ("light", "oracle"), [(RECTANGLE, rectangle_by_quadrature), (DISK, disk_by_quadrature)], ids=["rectangle", "disk"]
)
@pytest.mark.parametrize("distance", [0.05, 0.4, 1.0, 5.0, 15.0, 40.0, 3000.0])
def test_the_vector_irradiance_is_that_of_quadrature(light, oracle, distance):
    for point, horizon in places(light, 7, [distance]):
        found = light.facing(point[:, None], horizon[:, None])
        whole = np.linalg.norm(oracle(light, point, unit(np.array(light.centre) - point)))
        expected = oracle(light, point, horizon)
        np.testing.assert_allclose((found.falloff * found.direction)[:, 0], expected, rtol=0, atol=1e-12 * whole)


@pytest.mark.parametrize("distance", [0.7500001, 0.76, 1.0, 5.0, 40.0, 3000.0])
def test_a_bulbs_irradiance_is_that_of_quadrature(distance):
    for point, horizon in places(BULB, 8, [distance]):
        found = BULB.facing(point[:, None], horizon[:, None])
        irradiance = float((found.falloff * dot(found.direction, horizon[:, None]))[0])
        whole = math.pi * (BULB.radius / distance) ** 2
        assert irradiance == pytest.approx(bulb_by_quadrature(BULB, point, horizon), rel=0, abs=1e-12 * whole)


# --- Known configurations ---------------------------------------------------------------------------------------------


def test_a_rectangle_over_a_corner_is_the_handbooks_configuration_factor():
    # Howell, A Catalog of Radiation Heat Transfer Configuration Factors, B-4, element parallel to a rectangle a × b at
    # a distance c, below one of its corners.
    a, b, c = 1.5, 0.7, 0.9
    x, y = a / c, b / c
    factor = (
        x / math.sqrt(1 + x * x) * math.atan(y / math.sqrt(1 + x * x))
        + y / math.sqrt(1 + y * y) * math.atan(x / math.sqrt(1 + y * y))
    ) / (2 * math.pi)
    lamp = rt.RectangleLight("lamp", centre=(a / 2, c, b / 2), edge_u=(a, 0, 0), edge_v=(0, 0, b))
    found = lamp.facing(np.zeros((3, 1)), Y[:, None])
    assert float((found.falloff * found.direction[1])[0]) == pytest.approx(math.pi * factor, rel=1e-14)


def test_a_tiny_light_is_a_point_light():
    size = 1e-5
    square = rt.RectangleLight("lamp", centre=(1, 3, 2), edge_u=(size, 0, 0), edge_v=(0, 0, size))
    points = np.random.default_rng(3).uniform(-2, 2, (3, 50))
    normals = np.repeat(Y[:, None], 50, axis=1)
    found, bulb = square.facing(points, normals), rt.PointLight("lamp", position=(1, 3, 2)).samples(points)[0]
    facing = np.where(points[1] < 3, (3 - points[1]) / bulb.distance, 0.0)
    np.testing.assert_allclose(found.falloff, facing * np.where(points[1] < 3, bulb.falloff, 0) * size**2, rtol=1e-9)


@pytest.mark.parametrize("light", [RECTANGLE, DISK, BULB], ids=lambda light: light.type)
def test_gauss_points_have_the_lights_vector_irradiance(light):
    light = replace(light, points=12)
    # Three sizes away; nearer they lose digits.
    point = np.array(light.centre)[:, None] + 4 * unit([0.5, -1, 0.3] if light is DISK else [0.1, 0.8, 0.6])[:, None]
    point = point if light is not DISK else np.array(light.centre)[:, None] + 4 * unit([1, -1, 0.3])[:, None]
    found = light.facing(point, -unit(point[:, 0] - light.centre)[:, None])
    total = sum(one.falloff * one.direction for one in light.samples(point))
    np.testing.assert_allclose(total, found.falloff * found.direction, rtol=0, atol=1e-9 * found.falloff[0])


@pytest.mark.parametrize("light", [RECTANGLE, DISK, BULB], ids=lambda light: light.type)
def test_points_on_a_light_in_its_plane_and_behind_it_are_numbers(light):
    centre = np.array(light.centre)
    if light.type == "rectangle":
        u, v = (np.array(edge) / 2 for edge in (light.edge_u, light.edge_v))
    else:
        u = unit(np.cross(normal_of(light) if light.type == "disk" else X, Z)) * light.radius
        v = unit(np.cross(normal_of(light) if light.type == "disk" else Z, u)) * light.radius
    on = [centre, centre + u, centre - v, centre + u + v, centre + 2 * u, centre + 0.5 * v, centre + 1e-300 * u]
    front = unit(np.cross(u, v)) * 1e-13
    points = np.stack([*on, *(place + front for place in on), *(place - front for place in on)], axis=1)
    for normal in (X, Y, Z, unit([1, 1, 1]), unit(front), -unit(front)):
        normals = np.repeat(normal[:, None], points.shape[1], axis=1)
        for sample in (light.facing(points, normals), *light.samples(points)):
            assert np.all(np.isfinite(sample.falloff))
            assert np.all(np.isfinite(sample.direction))
            assert np.all(sample.falloff >= 0)
        whole = light.facing(points, normals)
        assert np.all(whole.falloff <= np.pi * (1 + 1e-9))
        assert np.all(whole.falloff * dot(whole.direction, normals) >= -1e-15)


def test_what_is_behind_or_below_is_dark():
    behind = np.array(DISK.centre)[:, None] - 2 * normal_of(DISK)[:, None]
    assert DISK.facing(behind, normal_of(DISK)[:, None]).falloff[0] == 0
    assert BULB.facing(np.array(BULB.centre)[:, None] + 0.1, Y[:, None]).falloff[0] == 0
    below = np.array([[0.0], [5.0], [0.0]])
    assert BULB.facing(below, Y[:, None]).falloff[0] == 0


def test_a_bulb_begins_in_front_of_its_silhouette():
    figure = BULB.outline(np.array(BULB.centre)[:, None] + np.array([[0.0], [3.0], [0.0]]))
    direction, distance = begins(figure, figure.centre)
    np.testing.assert_allclose(direction[:, 0], -Y, atol=1e-15)
    assert distance[0] == pytest.approx(3 - BULB.radius, rel=1e-14)


# --- As lights ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("light", [RECTANGLE, DISK, BULB], ids=lambda light: light.type)
def test_an_area_light_is_a_light(light):
    assert isinstance(light, AreaLight)
    assert answering(light) is light
    assert pickle.loads(pickle.dumps(light)) == light
    by = (4.0, -0.5, 2.0)
    points = np.array(light.centre)[:, None] + np.random.default_rng(7).normal(size=(3, 50)) * 3
    normals = np.repeat(Y[:, None], 50, axis=1)
    here, there = light.facing(points, normals), light.moved(by).facing(points + np.array(by)[:, None], normals)
    np.testing.assert_allclose(there.falloff, here.falloff, rtol=1e-12, atol=1e-14)
    assert light.bound(lambda _: 0.0) == 2 * np.pi * 16
    # Nothing is nearer than 10: what a surface there receives is below the bound.
    front = (normal_of(light) if light.type != "sphere" else Y)[:, None]
    facing = light.facing(np.array(light.centre)[:, None] + 10 * front, -front)
    assert 0.7 * light.bound(lambda _: 10.0) < facing.falloff[0] <= light.bound(lambda _: 10.0)


def test_the_white_faces_the_light():
    assert BULB.white((0.25, 0.5, 3.125)) == pytest.approx((0.75 / 3) ** 2, rel=1e-14)
    disk = rt.DiskLight("lamp", centre=(0, 2, 0), normal=(0, -1, 0), radius=1)
    assert disk.white((0, 0, 0)) == pytest.approx(1 / 5, rel=1e-14)
    assert disk.white((0, 3, 0)) == 0
    assert disk.white((0, 2, 0)) == 0


SIZE = 'the light would have no size that can be computed with; give .* type = "point"'


@pytest.mark.parametrize(
    ("make", "line"),
    [
        (lambda: replace(RECTANGLE, edge_u=(0, 0, 0)), rf"^edge_u = \[0, 0, 0\]: {SIZE}$"),
        (
            lambda: replace(RECTANGLE, edge_v=(1, 1, 0)),
            r"^edge_v = \[1, 1, 0\]: it is not perpendicular to edge_u .*turn",
        ),
        (lambda: replace(RECTANGLE, edge_v=(0, math.inf, 0)), r"^edge_v\[1\] = inf: numbers must be finite"),
        (lambda: replace(DISK, normal=(0, 0, 0)), r"^normal = \[0, 0, 0\]: a direction must not be zero; write"),
        (lambda: replace(DISK, radius=0), rf"^radius = 0: {SIZE}$"),
        (lambda: replace(BULB, radius=-1.0), rf"^radius = -1.0: {SIZE}$"),
        (lambda: replace(BULB, radius="1"), r"^radius = '1': it must be a number"),
        (lambda: replace(BULB, grid=1), r"^grid = 1: it must be a whole number from 2 to 33$"),
        (lambda: replace(BULB, refinement=9), r"^refinement = 9: it must be a whole number from 0 to 5$"),
        (lambda: replace(BULB, points=0), r"^points = 0: it must be a whole number from 1 to 32$"),
        (lambda: replace(BULB, centre=(0, 1)), r"^centre = \[0, 1\]: it must be three numbers"),
    ],
)
def test_a_light_that_has_no_area_says_so(make, line):
    with pytest.raises(ValueError, match=line) as caught:
        make()
    assert "\n" not in str(caught.value)


FILE = """
[camera]
position = [0, 3, 8]
target = [0, 1, 0]
width = 8
height = 8
[[shapes]]
type = "sphere"
centre = [0, 1, 0]
radius = 1
material = "red"
[materials.red]
[lights.a]
type = "rectangle"
centre = [0, 4, 0]
edge_u = [1, 0, 0]
edge_v = [0, 0, 2]
grid = 4
[lights.b]
type = "disk"
centre = [0, 4, 0]
normal = [0, -1, 0]
radius = 0.5
[lights.c]
type = "sphere"
centre = [0, 4, 0]
radius = 1
shadows = false
"""


def test_area_lights_are_read_from_files(tmp_path):
    (tmp_path / "scene.toml").write_text(FILE)
    assert rt.load_scene(tmp_path / "scene.toml").lights == (
        rt.RectangleLight("a", centre=(0, 4, 0), edge_u=(1, 0, 0), edge_v=(0, 0, 2), grid=4),
        rt.DiskLight("b", centre=(0, 4, 0), normal=(0, -1, 0), radius=0.5),
        rt.SphereLight("c", centre=(0, 4, 0), radius=1, shadows=False),
    )


def test_area_lights_in_files_say_what_is_wrong_with_them(tmp_path):
    bad = FILE.replace("edge_v = [0, 0, 2]", "edge_v = [1, 1, 0]").replace("grid", "gird").replace("0.5", "0")
    (tmp_path / "scene.toml").write_text(bad)
    with pytest.raises(ValueError, match="gird") as caught:
        rt.load_scene(tmp_path / "scene.toml")
    lines = [line.partition("scene.toml: ")[2] for line in str(caught.value).splitlines()]
    assert lines == [
        "lights.a.gird: there is no such key; did you mean 'grid'?",
        "lights.b.radius = 0: the light would have no size that can be computed with; give one above 0, or take "
        'type = "point"',
    ]
    (tmp_path / "scene.toml").write_text(bad.replace("gird", "grid").replace("radius = 0", "radius = 0.5"))
    with pytest.raises(ValueError, match=r"lights\.a\.edge_v = \[1, 1, 0\]: it is not perpendicular to edge_u"):
        rt.load_scene(tmp_path / "scene.toml")
