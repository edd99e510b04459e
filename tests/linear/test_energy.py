"""No model sends on more light than it receives, or the plan says so."""

from dataclasses import replace

import numpy as np
import pytest
from scenes_for_tests import mirrors, small

import symrt as rt
from symrt.linear.energy import brightening
from symrt.reflection import diffuse, mirror, n_dot_l


def told(model, **parameters):
    return list(brightening(mirrors(model=model, **parameters)))


@pytest.mark.parametrize("exponent", [5, 10, 40])
def test_blinns_highlights_are_as_much_too_bright_as_their_integral_says(exponent):
    # Seen along the normal, where the light is: ∫ (n·h)^s n·v dω = 8π (2^(-s/2) + s) / ((s + 2)(s + 4)), and the model
    # has (s + 8) / 8π before it.
    s = exponent
    more = (s + 8) * (2 ** (-s / 2) + s) / ((s + 2) * (s + 4)) - 1
    assert told("blinn_phong", exponent=s) == [
        f"ball: of the light of lamps up to {100 * more:.2g} % more is sent on than is received, where specular is 1."
    ]


@pytest.mark.parametrize(
    "model", ["lambert", "mirror", ["lambert", "mirror"], "metal", "phong", "glass", ["phong", "mirror"]]
)
def test_models_that_brighten_nothing_are_not_told_of(model):
    parameters = {"exponent": 12} if "phong" in model else {"index": 1.5} if model == "glass" else {}
    assert told(model, **parameters) == []


def test_a_users_own_model_that_sends_on_too_much_is_told_of():
    bright = rt.Model(direct=1.3 * diffuse * n_dot_l / np.pi, ambient=1.3 * diffuse, reflected=1.1 * mirror)
    assert told(bright) == [
        "ball: of the light of lamps up to 30 % more is sent on than is received, where diffuse is 1.",
        "ball: of the light of other surfaces up to 10 % more is sent on than is received, where mirror is 1.",
        "ball: of the light of a sky up to 30 % more is sent on than is received, where diffuse is 1.",
    ]
    # What no surface is made of is not told of, and what is so stands in the plan.
    assert list(brightening(replace(mirrors(), materials=[*mirrors().materials, rt.Material("x", model=bright)]))) == []
    assert rt.plan(mirrors(model=bright)).remarks == tuple(told(bright))


def test_the_papers_highlights_brighten_where_light_grazes():
    # Light at 89° from the normal: plain sums over the hemisphere of (r·v)^s n·v / (π n·l).
    light = np.radians(89)
    z, angle = np.meshgrid((np.arange(800) + 0.5) / 800, 2 * np.pi * (np.arange(800) + 0.5) / 800)
    x = np.sqrt(1 - z * z) * np.cos(angle)
    r_dot_v = np.clip(-np.sin(light) * x + np.cos(light) * z, 0, 1)
    share = 2 * np.mean(r_dot_v**5 * z) / np.cos(light)
    (said,) = told("phong_plain", exponent=5)
    assert float(said.split("up to ")[1].split(" %")[0]) == pytest.approx(100 * (share - 1), rel=0.02)


def test_shipped_scenes_say_what_their_highlights_do():
    assert list(brightening(small("first", 8))) == []
    assert "where specular is 1" in " ".join(str(rt.plan(small("spheres", 8))).split())
