"""Interactions: the names of a linear system's columns, as they are written and grouped (between steps 2 and 3)."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Int

from symrt.errors import shown
from symrt.symbols import Symbol
from symrt.windows import EVERYWHERE, Window
from symrt.written import written_terms

BLACK = (0.0, ())
"""A term that is written as 0."""


@dataclass(frozen=True, order=True)
class Interaction:
    """One light and the reflectances it met on its way to the eye: the name of a column of G.

    Parameters
    ----------
    light
        Name of the light.
    met
        Names of the reflectance symbols, ``material.component``: sorted, because they commute, or in the order in which
        light met them where that was asked for.
    nodes
        ``(parameter, index)`` for each free parameter whose node this column belongs to.
    window
        The part of the spectrum that took this way, where glass bends wavelengths apart; empty for all of it.  It is a
        fixed symbol: of degree 0, and multiplied by no scale.

    Examples
    --------
    >>> str(Interaction("sun", ("sea.diffuse", "sea.mirror", "sea.mirror")))
    'sun*sea.diffuse*sea.mirror**2'
    >>> str(Interaction("sun", ("sea.diffuse",), window=Window(400, 500, 600)))
    'sun*sea.diffuse*[400 … 500 … 600 nm]'
    """

    light: str
    met: tuple[str, ...] = ()
    nodes: tuple[tuple[str, int], ...] = ()
    window: Window | tuple[()] = EVERYWHERE

    def __str__(self) -> str:
        powers = [f"{name}**{k}" if (k := self.met.count(name)) > 1 else name for name in dict.fromkeys(self.met)]
        window = [str(self.window)] if self.window else []
        return "*".join([self.light, *powers, *window, *(f"node({name},{j})" for name, j in self.nodes)])

    @property
    def degree(self) -> int:
        """Number of reflectances met, with repetition."""
        return len(self.met)

    @property
    def symbols(self) -> tuple[str, ...]:
        """The light and the reflectances met, with repetition: the spectra that are multiplied."""
        return (self.light, *self.met)


@dataclass(frozen=True, eq=False)
class Blocks:
    """Columns by their degrees in some groups of symbols: those of one block change alike when the groups are scaled.

    Parameters
    ----------
    degrees
        Of each block, in each group, sorted; the first are 0, whether or not there is such a column.
    of
        For each column, the number of its block.
    """

    degrees: Int[np.ndarray, "block group"]
    of: Int[np.ndarray, " interaction"]


def blocks_of(interactions: Sequence[Interaction], groups: Sequence[Collection[str]]) -> Blocks:
    """Columns by their degrees in groups of symbols.

    Examples
    --------
    >>> columns = [Interaction("sun", ("brass.mirror", "sea.diffuse")), Interaction("sun", ("sea.diffuse",))]
    >>> blocks = blocks_of(columns, [{"brass.mirror"}])
    >>> blocks.degrees.tolist(), blocks.of.tolist()
    ([[0], [1]], [1, 0])
    """
    degrees = [[sum(name in group for name in i.symbols) for group in groups] for i in interactions]
    rows = np.array([[0] * len(groups), *degrees], dtype=int)
    found, of = np.unique(rows, axis=0, return_inverse=True)
    return Blocks(found, of.reshape(-1)[1:])


def written(text: str) -> list[tuple[Interaction, float]]:
    """The terms of a pixel that one writes down; those that are written as 0 are none.

    Raises
    ------
    ValueError
        If a term is not the product of a number, one light, reflectances, and perhaps a window.

    Examples
    --------
    >>> written("0.5*sun*sea.diffuse + 0")
    [(Interaction(light='sun', met=('sea.diffuse',), nodes=(), window=()), 0.5)]
    """
    found = []
    for coefficient, factors in (term for term in written_terms(text) if term != BLACK):
        windows = [Window.of(factor) for factor in factors if factor.startswith("[")]
        names = [factor for factor in factors if not factor.startswith("[")]
        symbols = [Symbol.of(name) for name in names]
        lights = [symbol.light for symbol in symbols if symbol.light]
        if len(lights) != 1:
            raise ValueError(
                f"{shown(text)}: {len(lights)} lights in a term; every path of light starts at exactly one"
            )
        if len(windows) > 1:
            raise ValueError(f"{shown(text)}: {len(windows)} windows of wavelengths in a term; light has one at most")
        met = sorted(name for name, symbol in zip(names, symbols, strict=True) if symbol.reflectance)
        window = windows[0] if windows else EVERYWHERE
        found.append((Interaction(lights[0], tuple(met), window=window), coefficient))
    return found
