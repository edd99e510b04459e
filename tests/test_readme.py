"""The README's pictures are what the lines beside them make."""

import shlex
from pathlib import Path

import imageio.v3 as iio
import numpy as np
import pytest
from scenes_for_tests import SCENES, palettes

import symrt as rt
from symrt.cli import main

PICTURES = Path(__file__).parent.parent / "notebooks" / "pictures"


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """All four pictures, made anew by the README's lines."""
    scene, given = rt.load_scene(SCENES / "globe.toml"), palettes("globe")
    system = rt.render(scene, progress=False)
    gamut = rt.device_gamut(rt.load_device("dye3-endura-premier"), model="envelope")
    fit = rt.fit(
        system, given["macbeth"], gamut, [rt.Scale(m.name) for m in scene.materials], objective="lightest", cap=False
    )
    folder = tmp_path_factory.mktemp("pictures")
    for name, palette in (given | {"lightest": fit.palette}).items():
        rt.save_image(folder / f"globe-{name}.png", rt.shade(system, palette))
    half, pair = rt.Reference(exposure=0.5), (rt.Scale("brass.diffuse"), rt.Scale("brass.specular"))
    region = rt.joint_region(system, given["macbeth"], gamut, *pair, reference=half, cap=False, progress=False)
    figure = rt.plots.joint_region_figure(region, system, given["macbeth"], half)
    (folder / "region.png").write_bytes(rt.plots.png(figure, dpi=100))
    return folder


@pytest.mark.parametrize("name", ["rgb", "macbeth", "lightest"])
def test_a_picture_in_the_readme_is_what_its_lines_make(made, name):
    shown, now = (iio.imread(folder / f"globe-{name}.png").astype(int) for folder in (PICTURES, made))
    assert shown.shape == now.shape == (512, 512, 3)
    # Another processor may round a colour to the next code.
    assert np.abs(shown - now).max() <= 1


def test_the_region_in_the_readme_is_what_its_lines_draw(made):
    shown, now = (iio.imread(folder / "region.png").astype(int) for folder in (PICTURES, made))
    assert shown.shape == now.shape
    # Another version of matplotlib may set its letters by a fraction of a pixel elsewhere.
    assert np.abs(shown - now).mean() < 2


def test_the_readmes_commands_run(tmp_path, monkeypatch, capsys):
    text = (SCENES.parent / "README.md").read_text()
    block = text.partition("## On the command line")[2].split("```")[1]
    lines = [line for line in block.splitlines() if line.startswith("symrt ")]
    assert len(lines) == 12
    monkeypatch.chdir(tmp_path)
    for line in lines:
        assert main(shlex.split(line.partition("#")[0])[1:]) == 0, line
    for name in ("globe", "region", "curve", "fit", "moved", "prints", "segments", "outside"):
        assert (tmp_path / f"{name}.png").stat().st_size > 10_000
    assert '"intervals"' in capsys.readouterr().out
