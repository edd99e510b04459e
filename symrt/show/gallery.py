"""A gallery: scenes, each rendered and shaded with one of its own palettes, and the effects that it called for."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from jaxtyping import UInt8
from tqdm.auto import tqdm

from symrt.linear import plan, render
from symrt.reading import scene_path
from symrt.scene import load_scene
from symrt.spectra.display import to_rgb8
from symrt.spectra.palettes_file import load_palettes
from symrt.spectra.shading import shade
from symrt.spectra.viewing import linear_rgb

BASIC = {"shadows", "ambient", "supersampling"}
"""Effects that nearly every scene calls for, and that its caption does not name."""


@dataclass(frozen=True, eq=False)
class Exhibit:
    """A scene as it hangs in the gallery.

    Parameters
    ----------
    name
        The scene's name, that of its file.
    title
        The first sentence of its file.
    effects
        The effects that were simulated, but for those that nearly every scene has.
    palette, bands
        The palette that it is shaded with, and its bands in words.
    picture
        sRGB codes.
    seconds
        The time of the render.
    """

    name: str
    title: str
    effects: tuple[str, ...]
    palette: str
    bands: str
    picture: UInt8[np.ndarray, "height width 3"]
    seconds: float


def exhibits(scenes: Sequence[str], width: int, samples: int = 1, *, progress: bool = True) -> Iterator[Exhibit]:
    """Render scenes at a width in pixels, and shade each with its first palette of wavelengths, or else its first.

    Parameters
    ----------
    samples
        Samples along each side of a pixel; a scene that asks for more gets more.

    Examples
    --------
    >>> [first] = exhibits(["first"], width=32, progress=False)
    >>> first.title, first.palette, first.picture.shape
    ('The smallest scene a teacher would show: one sphere, one light.', 'plain', (32, 32, 3))
    """
    for name in tqdm(scenes, desc="gallery", unit="scene", delay=1, leave=False, disable=not progress):
        yield _exhibit(name, width, samples)


def _exhibit(name: str, width: int, samples: int) -> Exhibit:
    # The scene at its width, in its own proportions.
    scene, palettes = load_scene(name), load_palettes(name)
    camera = scene.camera
    height = max(1, round(width * camera.height / camera.width))
    scene = replace(scene, camera=replace(camera, width=width, height=height, samples=max(samples, camera.samples)))
    system = render(scene, progress=False)

    # Its picture with a palette of wavelengths, where there is one.
    spectral = [key for key, palette in palettes.items() if palette.bands.kind == "wavelength"]
    chosen = [*spectral, *palettes][0]
    image = shade(system, palettes[chosen])
    bands = palettes[chosen].bands
    return Exhibit(
        name=Path(name).stem,
        title=title_of(scene_path(name)),
        effects=tuple(effect.name for effect in plan(scene).effects if effect.simulated and effect.name not in BASIC),
        palette=chosen,
        bands=f"{len(bands)} bands" if spectral else "RGB",
        picture=to_rgb8(linear_rgb(image)),
        seconds=system.seconds["render"],
    )


def title_of(path: Path) -> str:
    """The first sentence of the comment that a scene's file opens with; empty where there is none."""
    found = re.match(r"(?:#[^\n]*\n)+", path.read_text(encoding="utf-8"))
    words = " ".join(line.lstrip("# ") for line in found[0].splitlines()).split() if found else []
    return re.split(r"(?<=\.) ", " ".join(words))[0]
