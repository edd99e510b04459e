"""The demo's results before they are drawn: steps 1 to 5 of the paper on one scene, rendered once."""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import permutations
from typing import Any

import numpy as np
from tqdm.auto import tqdm

from symrt.device import load_device
from symrt.feedback import Blend, Feasible, Fit, Scale, feasible, fit
from symrt.gamut import Gamut, device_gamut
from symrt.linear import Formula, formula, render
from symrt.scene import Scene
from symrt.spectra import Palette, SpectralImage, shade
from symrt.symbols import Symbol, named
from symrt.system import LinearSystem

DEVICE = "dye3-endura-premier"
WITHIN = (0.01, 3.0)
"""The scales of the paper's Figure 3."""
FITS: dict[str, dict[str, Any]] = {
    "figure-3a": {"objective": "darkest", "black": "clip"},
    "figure-3a-black": {"objective": "darkest", "black": "luminance"},
    "figure-3b": {"objective": "lightest", "black": "clip"},
}
"""The fits of the paper's Figure 3; its darkest picture also with the device's black respected."""


@dataclass(frozen=True, eq=False)
class Study:
    """The results of all five steps for one scene.

    Parameters
    ----------
    palettes
        The palette in RGB, then the one in wavelengths.
    images
        The same system shaded with each palette.
    ranges
        Feasible ranges, one parameter at a time, without the physical cap.
    fits
        Fits of all scales at once, by the name of the figure that shows them.
    pixel
        Column and row of the pixel whose formula is shown.
    before, after
        Its formula before and after the collapse.
    """

    system: LinearSystem
    palettes: Mapping[str, Palette]
    gamut: Gamut
    images: Mapping[str, SpectralImage]
    ranges: tuple[Feasible, ...]
    fits: Mapping[str, Fit]
    pixel: tuple[int, int]
    before: Formula
    after: Formula

    @property
    def spectral(self) -> Palette:
        """The palette in wavelengths."""
        return list(self.palettes.values())[1]


def study(scene: Scene, palettes: Mapping[str, Palette], progress: bool = True) -> Study:
    """Render a scene once, shade it, and find its ranges, fits and formulas.

    Parameters
    ----------
    palettes
        The scene's palettes, of which the first in RGB and the first in wavelengths are used.
    progress
        True to show a bar on standard error after a second.
    """
    chosen = _two_palettes(palettes)
    spectral = list(chosen.values())[1]
    gamut = device_gamut(load_device(DEVICE, spectral.bands), "envelope")

    # Steps 1 to 3 once, then each question of step 5.
    with tqdm(total=4, desc="demo", unit="step", delay=1, leave=False, disable=not progress) as bar:
        system = render(scene, progress=progress)
        bar.update()
        images = {name: shade(system, palette) for name, palette in chosen.items()}
        bar.update()
        ranges = tuple(feasible(system, spectral, gamut, one, cap=False) for one in _parameters(system, spectral))
        bar.update()
        scales = [Scale(name) for name in materials(system)]
        fits = {
            name: fit(system, spectral, gamut, scales, within=WITHIN, cap=False, **ask) for name, ask in FITS.items()
        }
        bar.update()

    # One pixel's formula.
    x, y = telling_pixel(system)
    before, after = formula(scene, x, y), formula(system, x, y)
    return Study(system, chosen, gamut, images, ranges, fits, (x, y), before, after)


def materials(system: LinearSystem) -> tuple[str, ...]:
    """Names of the materials that some pixel depends on.

    Examples
    --------
    >>> from scipy import sparse
    >>> from symrt.interactions import Interaction
    >>> columns = (Interaction("sun", ("ice.diffuse",)), Interaction("sun", ("sea.diffuse", "sea.mirror")))
    >>> materials(LinearSystem(sparse.csr_array((1, 2)), columns, height=1, width=1, white={"sun": 1.0}))
    ('ice', 'sea')
    """
    symbols = map(Symbol.of, system.reflectances)
    return tuple(dict.fromkeys(symbol.material for symbol in symbols if not symbol.alternative))


def telling_pixel(system: LinearSystem) -> tuple[int, int]:
    """Column and row of the pixel in which most materials meet, then most interactions, then nearest to the middle.

    Examples
    --------
    >>> from scipy import sparse
    >>> from symrt.interactions import Interaction
    >>> columns = (Interaction("sun", ("ice.diffuse",)), Interaction("sun", ("sea.diffuse",)))
    >>> G = sparse.csr_array(np.array([[1.0, 0.0], [0.5, 0.5], [0.0, 0.0]]))
    >>> telling_pixel(LinearSystem(G, columns, height=1, width=3, white={"sun": 1.0}))
    (1, 0)
    """
    names = materials(system)
    seen = [{str(Symbol.of(symbol).surface) for symbol in i.names[1:]} for i in system.interactions]
    meeting = np.zeros(system.height * system.width, dtype=int)
    for name in names:
        meeting += system.pixels_of(np.array([name in surfaces for surfaces in seen]))
    y, x = np.divmod(np.arange(system.height * system.width), system.width)
    away = (2 * x - system.width) ** 2 + (2 * y - system.height) ** 2
    best = np.lexsort((away, -system.term_counts, -meeting))[0]
    return int(x[best]), int(y[best])


def _two_palettes(palettes: Mapping[str, Palette]) -> dict[str, Palette]:
    """The first palette in RGB and the first in wavelengths."""
    kinds = ("rgb", "wavelength")
    found = [next((name for name, p in palettes.items() if p.bands.kind == kind), None) for kind in kinds]
    if None in found:
        raise ValueError(
            f"the scene's palettes are {', '.join(palettes)}: the demo shades with one in RGB and one in wavelengths; "
            "give it both, as scenes/globe.toml does"
        )
    return {name: palettes[name] for name in found if name is not None}


def _parameters(system: LinearSystem, palette: Palette) -> list[Scale | Blend]:
    """The scale of every material and light, and one blend: of the two most unlike spectra of one model."""
    names = materials(system)
    lights = [name for name in system.symbols if name in system.lights]
    diffuse = {name: palette[s] for name in names if (s := named(name, "diffuse")) in palette}
    alike = [(a, b) for a, b in permutations(diffuse, 2) if system.models.get(a) == system.models.get(b)]
    apart = sorted(alike, key=lambda pair: float(np.sum(diffuse[pair[0]] - diffuse[pair[1]])))
    return [*map(Scale, names), *map(Scale, lights), *(Blend(a, b) for a, b in apart[:1])]
