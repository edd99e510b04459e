"""The README's pictures are what the lines beside them make."""

from pathlib import Path

import imageio.v3 as iio
import numpy as np
import pytest
from scenes_for_tests import SCENES, palettes

import symrt as rt

PICTURES = Path(__file__).parent.parent / "notebooks" / "pictures"


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """All three pictures, made anew by the README's lines."""
    scene, given = rt.load_scene(SCENES / "globe.toml"), palettes("globe")
    system = rt.render(scene, progress=False)
    gamut = rt.device_gamut(rt.load_device("dye3-endura-premier"), model="envelope")
    fit = rt.fit(system, given["macbeth"], gamut, [rt.Scale(m.name) for m in scene.materials], cap=False)
    folder = tmp_path_factory.mktemp("pictures")
    for name, palette in (given | {"lightest": fit.palette}).items():
        rt.save_image(folder / f"globe-{name}.png", rt.shade(system, palette))
    return folder


@pytest.mark.parametrize("name", ["rgb", "macbeth", "lightest"])
def test_a_picture_in_the_readme_is_what_its_lines_make(made, name):
    shown, now = (iio.imread(folder / f"globe-{name}.png").astype(int) for folder in (PICTURES, made))
    assert shown.shape == now.shape == (512, 512, 3)
    # Another processor may round a colour to the next code.
    assert np.abs(shown - now).max() <= 1
