"""Laws of lights: inverse squares, unit directions, and no nan anywhere."""

import math
import pickle
from dataclasses import dataclass

import numpy as np
import pytest

from symrt.scene.lights import AmbientLight, DirectionalLight, Illumination, Light, PointLight, answering

POINTS = np.random.default_rng(4).normal(size=(3, 2000)) * 10.0 ** np.random.default_rng(5).uniform(-8, 8, 2000)


def test_a_point_light_falls_off_with_the_square_of_the_distance():
    lit = PointLight("warm", position=(1, 2, 3)).samples(POINTS)[0]
    for i in range(0, 2000, 97):
        distance = math.dist((1, 2, 3), POINTS[:, i])
        assert lit.distance[i] == pytest.approx(distance, rel=1e-14)
        assert lit.falloff[i] == pytest.approx(1 / distance**2, rel=1e-14)


def test_following_the_direction_for_the_distance_arrives_at_the_light():
    lit = PointLight("warm", position=(1, 2, 3)).samples(POINTS)[0]
    arrived = POINTS + lit.direction * lit.distance
    error = np.abs(arrived - np.array([[1.0], [2.0], [3.0]])).max(axis=0)
    assert np.all(error <= 1e-15 * (lit.distance + 4))


def test_a_directional_light_is_everywhere_the_same_and_points_against_its_travel():
    lit = DirectionalLight("sun", direction=(3, 0, -4)).samples(POINTS)[0]
    np.testing.assert_allclose(lit.direction, np.repeat([[-0.6], [0.0], [0.8]], 2000, axis=1), atol=1e-16)
    assert np.all(np.isinf(lit.distance))
    assert np.all(lit.falloff == 1)


def test_a_point_at_the_light_is_dark_and_not_nan():
    points = np.array([[0.0, 1e-170], [3.0, 0.0], [0.0, 0.0]])
    for light in (PointLight("a", position=(0, 3, 0)), PointLight("b", position=(0, 0, 0))):
        lit = light.samples(points)[0]
        assert np.all(np.isfinite(lit.direction))
        assert np.all(np.isfinite(lit.falloff))
    assert PointLight("a", position=(0, 3, 0)).samples(points)[0].falloff[0] == 0
    assert PointLight("b", position=(0, 0, 0)).samples(points)[0].falloff[1] == 0


def test_white_is_what_a_diffuser_that_faces_the_light_sends_on():
    # A point light of intensity I gives I cosθ/d²; a diffuser sends on 1/π of its irradiance.
    assert PointLight("a", position=(0, 5, 0)).white((0, 1, 0)) == pytest.approx(1 / (16 * math.pi), rel=1e-15)
    assert DirectionalLight("b", direction=(0, -7, 0)).white((9, 9, 9)) == 1 / math.pi
    # Ambient light of radiance L contributes ρ L.
    assert AmbientLight("c").white((0, 0, 0)) == 1


@dataclass(frozen=True)
class Ring:
    """A light of one's own: brightest one unit from the y axis."""

    name: str
    shadows: bool = False

    def samples(self, points):
        count = points.shape[1]
        bright = np.exp(-((np.hypot(points[0], points[2]) - 1) ** 2))
        up = np.repeat([[0.0], [1.0], [0.0]], count, axis=1)
        return (Illumination(up, np.full(count, np.inf), bright),)


LIGHTS = [PointLight("a", position=(1, 2, 3)), DirectionalLight("b", direction=(0, -1, 1)), Ring("c")]


@pytest.mark.parametrize("light", LIGHTS, ids=lambda light: light.name)
def test_a_light_that_moves_with_the_scene_does_the_same_to_it(light):
    by = (4.0, -0.5, 2.0)
    points = np.random.default_rng(7).normal(size=(3, 50))
    shifted = points + np.array(by)[:, None]
    there, here = answering(light).moved(by).samples(shifted)[0], light.samples(points)[0]
    np.testing.assert_allclose(there.direction, here.direction, atol=1e-14)
    np.testing.assert_allclose(there.falloff, here.falloff, rtol=1e-13)
    assert (answering(light).moved(by).name, answering(light).moved(by).shadows) == (light.name, light.shadows)


def test_an_ambient_light_stays_where_it_is():
    assert AmbientLight("sky").moved((1, 2, 3)) == AmbientLight("sky")


@pytest.mark.parametrize("light", [*LIGHTS[:2], AmbientLight("sky")], ids=lambda light: light.name)
def test_lights_travel_to_worker_processes(light):
    assert pickle.loads(pickle.dumps(light)) == light


def test_a_light_of_ones_own_is_a_light_and_is_answered_for():
    assert all(isinstance(light, Light) for light in [*LIGHTS, AmbientLight("sky")])
    own = answering(LIGHTS[2])
    assert (own.via, own.calls_for, own.bound(lambda _: 1.0)) == ("direct", None, np.inf)
    # Seen from the axis, one unit away, its brightness is exp(-1), and a diffuser sends on 1/π of it.
    assert own.white((0, 0, 0)) == pytest.approx(math.exp(-1) / math.pi, rel=1e-15)


def test_the_white_of_several_samples_is_their_sum():
    class Pair:
        name, shadows = "pair", True

        def samples(self, points):
            return tuple(PointLight("one", position=p).samples(points)[0] for p in ((0, 2, 0), (4, 0, 0)))

    assert answering(Pair()).white((0, 0, 0)) == pytest.approx((1 / 4 + 1 / 16) / math.pi, rel=1e-15)


def test_bounds_are_what_the_nearest_surface_receives():
    assert PointLight("a", position=(0, 5, 0)).bound(lambda _: 0.5) == 4.0
    assert PointLight("a", position=(0, 5, 0)).bound(lambda _: 0.0) == np.inf
    assert DirectionalLight("b", direction=(0, -7, 0)).bound(lambda _: 0.5) == 1.0
    assert AmbientLight("c").bound(lambda _: 0.5) == 1.0


@pytest.mark.parametrize(
    ("make", "line"),
    [
        (lambda: PointLight("two words", position=(0, 1, 0)), r"^name = 'two words': a name is a letter"),
        (lambda: PointLight("__import__", position=(0, 1, 0)), r"^name = '__import__': a name is a letter"),
        (lambda: PointLight("a", position=(0, math.nan, 0)), r"^position\[1\] = nan: numbers must be finite"),
        (lambda: PointLight("a", position=(0, 10**400, 0)), r"^position\[1\] = an integer of more than 40 digits"),
        (lambda: DirectionalLight("a", direction=(0, 0, 0)), r"^direction = \[0, 0, 0\]: a direction must not be zero"),
        (lambda: AmbientLight(""), r"^name = '': a name is a letter"),
    ],
)
def test_a_light_that_cannot_shine_says_why(make, line):
    with pytest.raises(ValueError, match=line):
        make()
