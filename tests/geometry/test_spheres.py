"""Spheres against exact rationals (hit or miss) and 50 digits (distance): hard cases G1 to G3, and coordinates."""

import numpy as np
import pytest
from geometry.both import intersect, nearest
from geometry.oracles import across, digits, directions, inner, minus, rational, rays, sphere_distance, ulps

from symrt.geometry import Sphere, clearance, encloses, surfaces, translate
from symrt.geometry.sphere import _surely_outside

DRAWS = [2_000, pytest.param(100_000, marks=pytest.mark.exhaustive)]
RAYS = 50
"""Rays for each sphere that is drawn."""


def check(generator, draws, aim, most=10, least=0.1):
    """Hit or miss as in exact arithmetic, distances within `most` ulp, for rays that `aim` draws at a unit sphere."""
    worst = hits = 0
    for _ in range(draws // RAYS):
        radius = float(10 ** generator.uniform(-3, 3))
        centre = directions(generator, 1) * radius * generator.uniform(0, 3)
        start, direction = aim()
        ray = rays(centre + radius * start, direction)
        found = intersect(Sphere(tuple(centre[:, 0].tolist()), radius, "red"), ray).distance
        for k in range(RAYS):
            true = sphere_distance(ray.origin[:, k], ray.direction[:, k], centre[:, 0], radius)
            assert np.isfinite(found[k]) == (true is not None), f"{found[k]} against {true}"
            if true is not None:
                worst, hits = max(worst, ulps(found[k], true)), hits + 1
    assert hits >= least * draws
    assert worst <= most, f"{worst} ulp"


def passing(generator, impact, distance):
    """Rays whose lines pass the origin at `impact`, from `distance` before it."""
    direction = directions(generator, RAYS)
    return impact * across(generator, direction) - distance * direction, direction


@pytest.mark.parametrize("draws", DRAWS)
@pytest.mark.parametrize("distance", [2.5, 10.0, 1e4, 1e8])
def test_far_spheres_are_hit_or_missed_as_in_exact_arithmetic(distance, draws):
    generator = np.random.default_rng(1)
    check(generator, draws, lambda: passing(generator, generator.uniform(0, 1.3, RAYS), distance))


@pytest.mark.parametrize("draws", DRAWS)
@pytest.mark.parametrize(("distance", "least"), [(1e14, 0.1), (1e15, 0.1), (1e16, 0.0), (1e18, 0.0)])
def test_spheres_so_far_that_the_line_itself_is_rounded_are_decided_as_in_exact_arithmetic(distance, least, draws):
    # The origin's own spacing is a radius or more at 1e16: hardly a ray hits, and rounding noise must not say it does.
    generator = np.random.default_rng(6)
    check(generator, draws, lambda: passing(generator, generator.uniform(0, 1.3, RAYS), distance), least=least)


def test_a_line_that_passes_four_radii_away_misses_from_1e17_too():
    ray = rays(np.array([[6e16], [8e16], [0.0]]), np.array([[-0.6], [-0.8], [0.0]]))
    assert intersect(Sphere((0, 0, 0), 1, "a"), ray).distance[0] == np.inf


def roundings(m, d):
    """The part of each rounding in the plain distance to a unit sphere, to first order: its relative error over u."""

    def distance(at):
        number = iter(range(100))

        def rounded(value):
            return value * (1 + 1e-5) if next(number) == at else value

        def product(a, b):
            return rounded(rounded(rounded(a[0] * b[0]) + rounded(a[1] * b[1])) + rounded(a[2] * b[2]))

        n = [rounded(component) for component in m]
        across = [rounded(rounded(n[i] * d[j]) - rounded(n[j] * d[i])) for i, j in ((1, 2), (2, 0), (0, 1))]
        square, radius, a, b, c = product(across, across), rounded(1.0), product(d, d), product(n, d), product(n, n)
        q = rounded(-b + rounded(np.sqrt(rounded(rounded(a * radius) - square))))
        return rounded(rounded(c - radius) / q), next(number)

    exact, count = distance(-1)
    return [(distance(at)[0] - exact) / exact * 1e5 for at in range(count)]


@pytest.mark.parametrize("draws", DRAWS)
def test_the_roundings_of_plain_arithmetic_sum_to_less_than_18(draws):
    # Worst at the rim of what `_plain` lets through: two radii from the centre, 0.75 of the squared radius aside.
    generator = np.random.default_rng(8)
    away = np.where(generator.uniform(size=draws) < 0.5, 2.0, 2 * 10 ** generator.uniform(0, 3, draws))
    aside = np.sqrt(np.where(generator.uniform(size=draws) < 0.5, 0.75, 0.75 * generator.uniform(size=draws)))
    way = directions(generator, draws)
    m = aside * across(generator, way) - np.sqrt(away**2 - aside**2) * way
    worst = np.sum(np.abs(roundings(m, way)), axis=0).max()
    assert 14 < worst < 18


@pytest.mark.parametrize("draws", DRAWS)
def test_where_the_roundings_of_plain_arithmetic_add_up_distances_keep_to_10_ulp(draws):
    generator = np.random.default_rng(9)
    rim = 2 * (1 + 1e-3 * generator.uniform(size=RAYS))
    check(generator, draws, lambda: passing(generator, np.sqrt(0.75 * (1 - 1e-3)), np.sqrt(rim**2 - 0.75)), least=0.9)


@pytest.mark.parametrize("draws", DRAWS)
def test_grazed_spheres_are_hit_or_missed_as_in_exact_arithmetic(draws):
    generator = np.random.default_rng(2)

    def aim():
        impact = 1 + generator.choice([-1, 1], RAYS) * 10 ** generator.uniform(-14, -3, RAYS)
        return passing(generator, impact, 10 ** generator.uniform(0.5, 8, RAYS))

    check(generator, draws, aim)


@pytest.mark.parametrize("draws", DRAWS)
def test_spheres_around_or_behind_the_origin_of_a_ray(draws):
    generator = np.random.default_rng(3)
    check(generator, draws, lambda: passing(generator, generator.uniform(0, 1, RAYS), generator.uniform(-3, 3, RAYS)))


@pytest.mark.parametrize("draws", DRAWS)
def test_rays_that_start_a_hair_from_the_surface(draws):
    generator = np.random.default_rng(4)

    def aim():
        above = 1 + generator.choice([-1, 1], RAYS) * 10 ** generator.uniform(-15, -3, RAYS)
        return above * directions(generator, RAYS), directions(generator, RAYS)

    check(generator, draws, aim)


@pytest.mark.parametrize("draws", DRAWS)
def test_what_plain_arithmetic_calls_outside_is_outside_in_exact_arithmetic(draws):
    generator = np.random.default_rng(7)
    told = 0
    for _ in range(draws // RAYS):
        radius = float(10 ** generator.uniform(-30, 30))
        centre = directions(generator, 1) * radius * 10 ** generator.uniform(-3, 12)
        above = 1 + generator.choice([-1, 1], RAYS) * 10 ** generator.uniform(-17, -10, RAYS)
        origin = centre + radius * above * directions(generator, RAYS)
        sure = _surely_outside(Sphere(tuple(centre[:, 0].tolist()), radius, "a"), origin - centre)
        for k in np.flatnonzero(sure):
            m = minus(rational(origin[:, k]), rational(centre))
            assert inner(m, m) > rational(radius)[0] ** 2
        told += np.count_nonzero(sure)
    assert told > draws / 10


def test_a_line_that_touches_is_a_hit():
    # Exactly representable: the squared distance of the line from the centre is 3² + 4² = 5².
    ray = rays(np.array([[3.0], [4.0], [0.0]]), np.array([[0.0], [0.0], [-1.0]]))
    assert intersect(Sphere((0, 0, -7), 5, "red"), ray).distance[0] == 7.0
    assert intersect(Sphere((0, 0, -7), np.nextafter(5.0, 0.0), "red"), ray).distance[0] == np.inf


def test_points_lie_on_the_sphere_within_their_stated_error():
    generator = np.random.default_rng(5)
    for k in range(300):
        radius = float(10 ** generator.uniform(-8, 8))
        centre = generator.normal(size=3) * 10 ** generator.uniform(-8, 8)
        sphere = Sphere(tuple(centre.tolist()), radius, "red")
        direction = directions(generator, 8)
        origin = centre[:, None] + radius * (0.9 * across(generator, direction) - 4 * direction)
        found = surfaces([sphere], rays(origin, direction), nearest([sphere], rays(origin, direction)))
        for j in np.flatnonzero(found.error):
            off = minus(rational(found.point[:, j]), rational(centre))
            squares = inner(off, off) - rational(radius)[0] ** 2
            # |p − c| − r = (|p − c|² − r²) / (|p − c| + r)
            assert abs(float(digits(squares))) / radius <= 2 * found.error[j] * (1 + found.error[j] / radius), k


def test_longitude_and_latitude_are_those_of_the_earth():
    globe = Sphere((0, 0, 0), 2, "earth", pole=(0, 1, 0), meridian=(0, 0, 1))
    # 0° N 0° E faces +z; 0° N 90° E is to the right of a viewer at +z whose up is the pole, so +x.
    places = {(0, 0): (0, 0, 1), (0, 90): (1, 0, 0), (0, -90): (-1, 0, 0), (45, 0): (0, 1, 1), (-45, 90): (1, -1, 0)}
    for (latitude, longitude), towards in places.items():
        out = np.array(towards, float).reshape(3, 1) / np.linalg.norm(towards)
        found = surfaces([globe], rays(5 * out, -out), nearest([globe], rays(5 * out, -out)))
        expected = [(longitude + 180) / 360, (90 - latitude) / 180]
        np.testing.assert_allclose(found.uv[:, 0], expected, rtol=1e-12)
        np.testing.assert_allclose(found.extent[:, 0], [4 * np.pi, 2 * np.pi], rtol=1e-12)


def test_the_date_line_has_u_zero():
    globe = Sphere((0, 0, 0), 1, "earth")
    ray = rays(np.array([[0.0], [0.0], [-3.0]]), np.array([[0.0], [0.0], [1.0]]))
    assert surfaces([globe], ray, nearest([globe], ray)).uv[0, 0] == 0.0


def test_the_meridian_is_made_perpendicular_to_a_tilted_pole():
    tilted = Sphere((0, 0, 0), 1, "earth", pole=(0, 1, 1), meridian=(0, 0, 5))
    out = np.array([[0.0], [-1.0], [1.0]]) / np.sqrt(2)
    found = surfaces([tilted], rays(3 * out, -out), nearest([tilted], rays(3 * out, -out)))
    np.testing.assert_allclose(found.uv[:, 0], [0.5, 0.5], rtol=1e-12)


def test_inside_and_clearance():
    ball = Sphere((1, 2, 3), 2, "red")
    assert encloses(ball, np.array([1.0, 2.0, 4.9]))
    assert not encloses(ball, np.array([1.0, 2.0, 5.1]))
    assert clearance(ball, np.array([1.0, 2.0, 13.0])) == 8.0
    assert translate(ball, np.array([-1.0, -2.0, -3.0])).centre == (0.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"radius": 0}, "radius = 0: it must be greater than 0"),
        ({"radius": -1.0}, "greater than 0"),
        ({"radius": float("nan")}, "radius = nan: it must be finite"),
        ({"centre": (0, float("inf"), 0)}, "centre"),
        ({"pole": (0, 0, 0)}, "zero or parallel"),
        ({"meridian": (0, 2, 0)}, "zero or parallel"),
    ],
)
def test_a_sphere_that_cannot_be_is_refused(wrong, said):
    with pytest.raises(ValueError, match=said):
        Sphere(**({"centre": (0, 0, 0), "radius": 1, "material": "red"} | wrong))
