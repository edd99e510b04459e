"""Disks and spheres that shine, as a scalar tracer sees them that has other formulas, and counts what hides them."""

from dataclasses import replace

import numpy as np
import pytest
import reference
from test_pictures import BALL, disagreement, scene, write_scene

import symrt as rt

SPHERE = {"type": "sphere", "centre": [-2.1, 3.3, 2.2], "radius": 0.8}
DISK = {"type": "disk", "centre": [-2.1, 3.3, 2.2], "normal": [0.5, -0.8, -0.4], "radius": 0.8}
MATTE = BALL | {"material": "blue"}


@pytest.mark.parametrize(
    ("lamp", "shapes", "error"),
    [
        # The sphere's closed form holds below the horizon, too; a polygon that the horizon cuts errs more than a whole.
        (SPHERE, (MATTE,), 1e-9),
        (DISK, (), 1e-9),
        (DISK, (MATTE,), 2e-4),
    ],
    ids=["sphere", "disk", "disk that sets"],
)
def test_nothing_hides_a_round_lamp(lamp, shapes, error, tmp_path):
    write_scene(tmp_path, scene(*shapes) | {"lights": {"lamp": lamp | {"shadows": False}}})
    assert disagreement(tmp_path / "scene.toml", "drawn", 24, 17) <= error


@pytest.mark.parametrize("lamp", [SPHERE, DISK], ids=["sphere", "disk"])
def test_the_share_of_a_round_lamp_that_is_seen_is_what_counting_says(lamp, tmp_path):
    path = tmp_path / "scene.toml"
    write_scene(tmp_path, scene(MATTE) | {"lights": {"lamp": lamp | {"grid": 5, "refinement": 2}}})
    ours = rt.load_scene(path)
    ours = replace(ours, camera=replace(ours.camera, width=12, height=9))
    seen = rt.shade(rt.render(ours, progress=False), rt.load_palettes(path)["drawn"]).values
    expected = np.array(reference.render(path, "drawn", 12, 9))
    open_to_it = reference.load(path)._replace(unshadowed={"lamp"})
    whole = np.array(reference.picture(open_to_it, reference.load_palette(path, "drawn"), 12, 9))
    shares, counted = (np.divide(x, whole, where=whole > 0, out=np.zeros(whole.shape)) for x in (seen, expected))
    assert np.count_nonzero((counted > 0.05) & (counted < 0.95)) > 8
    # Of 2304 places; the grid's own error is told as about as much.
    assert np.abs(shares - counted).max() < 0.03
    assert np.sqrt(np.mean((shares - counted) ** 2)) < 5e-3
