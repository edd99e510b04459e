"""Entries of a palette that seem misspelt: no symbol of the scene has their name, but one nearly (before step 3)."""

import difflib
import re
from collections.abc import Collection

from symrt.spectra.palette import Palette
from symrt.symbols import Symbol, named
from symrt.system import LinearSystem


def misspelt(system: LinearSystem, palette: Palette) -> dict[str, str]:
    """Entries of a palette that no scene's symbol has the name of, but one nearly, and that one.

    A palette may serve several scenes: what is like nothing in this one is left alone.

    Examples
    --------
    >>> from scipy import sparse
    >>> system = LinearSystem(sparse.csr_array((1, 0)), (), 1, 1, {"sun": 1.0}, {"brass": "direct = diffuse*n_dot_l"})
    >>> from symrt.spectra.bands import RGB
    >>> misspelt(system, Palette(RGB, {"sun": 1, "sea.diffuse": 1, "bras.diffuse": 1, "brass.difuse": 1}))
    {'bras.diffuse': 'brass.diffuse', 'brass.difuse': 'brass.diffuse'}
    """
    # A material's text holds its formulas, and so the components that it has, whether or not a pixel shows them.
    words = {material: set(re.findall(r"[A-Za-z]\w*", text)) for material, text in system.models.items()}
    known, found = {*system.lights, *system.reflectances}, {}
    for name in palette:
        symbol = Symbol.of(name)

        # Names that are there, and alternatives, are left alone.
        if name in known or symbol.alternative or symbol.component in words.get(symbol.material, ()):
            continue

        # The nearest name of its kind.
        if symbol.light:
            meant = _near(name, known)
        elif symbol.material in words:
            near = _near(symbol.component, words[symbol.material])
            meant = near and named(symbol.material, near)
        else:
            near = _near(symbol.material, words)
            meant = near and named(near, symbol.component)
        if meant:
            found[name] = meant
    return found


def _near(word: str, known: Collection[str]) -> str:
    return next(iter(difflib.get_close_matches(word, sorted(known), n=1, cutoff=0.85)), "")
