"""A gallery shows each scene with the effects that it calls for (issue 11)."""

import imageio.v3 as imageio
import numpy as np
import pytest

import symrt as rt
from symrt.cli import main
from symrt.commands.arguments import scene_of
from symrt.reading import shipped_scenes
from symrt.show.gallery import exhibits, title_of


@pytest.mark.parametrize("name", list(shipped_scenes()))
def test_every_shipped_scene_says_in_a_sentence_what_it_shows(name):
    title = title_of(shipped_scenes()[name])
    assert title.endswith(".")
    assert 20 < len(title) < 160


def test_an_exhibit_is_the_picture_that_shade_makes():
    [shown] = exhibits(["spheres"], width=48, samples=2, progress=False)
    system = rt.render(scene_of("spheres", "48", samples=2), progress=False)
    picture = rt.to_rgb(rt.shade(system, rt.load_palettes("spheres")["macbeth"]))
    assert np.abs(np.asarray(picture, dtype=float) / picture.max() - shown.picture / 255).max() < 1 / 255
    assert (shown.effects, shown.palette, shown.bands) == (("mirrors", "textures"), "macbeth", "36 bands")


def test_the_command_writes_one_picture_and_tells_each_scene(tmp_path, capsys):
    assert main(["gallery", "first", "spheres", "--width", "24", "--samples", "1", "-o", str(tmp_path / "g.png")]) == 0
    said = capsys.readouterr().out.splitlines()
    assert said[0].startswith("first: ")
    assert said[1].startswith("spheres: mirrors, textures; ")
    assert imageio.imread(tmp_path / "g.png").shape[1] > 600


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--width", "0"], "--width 0: give a number of pixels from 1 to 2048"),
        (["globes"], "'globes': no scene of this name comes with symrt; did you mean 'globe'?"),
        (["-o", "gallery.jpg"], "gallery.jpg: the name must end in .png"),
    ],
)
def test_bad_words_are_one_line(words, told, capsys):
    assert main(["gallery", *words]) == 2
    assert told in capsys.readouterr().err
