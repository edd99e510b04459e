"""Interactions: the names of a linear system's columns, as they are written and grouped (between steps 2 and 3)."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import groupby

import numpy as np
from jaxtyping import Float, Int
from scipy import sparse

from symrt.errors import shown
from symrt.symbols import Symbol
from symrt.windows import EVERYWHERE, SpectralWindow
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
        light met them where that was asked for.  A fluorescent one commutes with none: it stays between those that
        light met before and after it, see `normal_order`.
    nodes
        ``(parameter, index)`` for each free parameter whose node this column belongs to.
    window
        The part of the spectrum that took this way, where glass bends wavelengths apart; empty for all of it.  It is a
        fixed symbol: of degree 0, and multiplied by no scale.
    powers
        ``(name, length)`` for each transmittance that was met on the way through some length of glass: it counts with
        the length as its power.

    Examples
    --------
    >>> str(Interaction("sun", ("sea.diffuse", "sea.mirror", "sea.mirror")))
    'sun*sea.diffuse*sea.mirror**2'
    >>> str(Interaction("sun", ("sea.diffuse",), window=SpectralWindow(400, 500, 600)))
    'sun*sea.diffuse*[400 … 500 … 600 nm]'
    >>> str(Interaction("sun", ("sea.diffuse",), powers=(("wine.transmittance", 1.413),)))
    'sun*sea.diffuse*wine.transmittance**1.413'
    """

    light: str
    met: tuple[str, ...] = ()
    nodes: tuple[tuple[str, int], ...] = ()
    window: SpectralWindow | tuple[()] = EVERYWHERE
    powers: tuple[tuple[str, float], ...] = ()

    def __str__(self) -> str:
        runs = [(name, len(list(run))) for name, run in groupby(self.met)]
        met = [f"{name}**{count}" if count > 1 else name for name, count in runs]
        through = [f"{name}**{length!r}" for name, length in self.powers]
        window = [str(self.window)] if self.window else []
        return "*".join([self.light, *met, *through, *window, *(f"node({name},{j})" for name, j in self.nodes)])

    @property
    def degree(self) -> int:
        """Number of reflectances met, with repetition."""
        return len(self.met)

    @property
    def symbols(self) -> tuple[str, ...]:
        """The light and the reflectances met, with repetition: the spectra that are multiplied as they are."""
        return (self.light, *self.met)

    @property
    def names(self) -> tuple[str, ...]:
        """The light, the reflectances met, and the transmittances of glass on the way: all it depends on."""
        return (self.light, *self.met, *(name for name, _ in self.powers))


def normal_order(met: Iterable[str]) -> tuple[str, ...]:
    """Reflectances, from the light to the eye, in the one order that all equal products share.

    Spectra commute, and are sorted; a fluorescent one is a matrix, which none may pass: they are sorted before and
    after it.

    Examples
    --------
    >>> normal_order(["sea.mirror", "sea.diffuse"])
    ('sea.diffuse', 'sea.mirror')
    >>> normal_order(["sea.mirror", "paint.fluorescence", "sea.mirror", "ice.diffuse"])
    ('sea.mirror', 'paint.fluorescence', 'ice.diffuse', 'sea.mirror')
    """
    runs = groupby(met, key=lambda name: Symbol.of(name).fluorescent)
    return tuple(name for fluorescent, run in runs for name in (run if fluorescent else sorted(run)))


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

    Raises
    ------
    ValueError
        If a group has a transmittance that some column raises to the power of a length.

    Examples
    --------
    >>> columns = [Interaction("sun", ("brass.mirror", "sea.diffuse")), Interaction("sun", ("sea.diffuse",))]
    >>> blocks = blocks_of(columns, [{"brass.mirror"}])
    >>> blocks.degrees.tolist(), blocks.of.tolist()
    ([[0], [1]], [1, 0])
    """
    powers = {name for i in interactions for name, _ in i.powers}
    if found := sorted(name for group in groups for name in powers.intersection(group)):
        raise ValueError(
            f"{found[0]}: light that goes a length d through it is left with its power d, no polynomial of a factor on "
            f"it: shade with another, palette.replace({{{found[0]!r}: …}}), or move other symbols"
        )
    degrees = [[sum(name in group for name in i.symbols) for group in groups] for i in interactions]
    rows = np.array([[0] * len(groups), *degrees], dtype=int)
    distinct, of = np.unique(rows, axis=0, return_inverse=True)
    return Blocks(distinct, of.reshape(-1)[1:])


def settled(
    interactions: Sequence[Interaction], weights: Mapping[str, Float[np.ndarray, " node"]]
) -> tuple[list[Interaction], list[Interaction], sparse.csr_array]:
    """Columns without the nodes of parameters that got values, and the matrix that sums them by the nodes' weights.

    Returns
    -------
    tuple
        For each column what is left of it; the distinct ones of these, sorted; and the matrix from the ones to the
        others.

    Examples
    --------
    >>> columns = [Interaction("sun", (), (("brass.exponent", j),)) for j in range(2)]
    >>> left, sums, to = settled(columns, {"brass.exponent": np.array([0.25, 0.75])})
    >>> [str(column) for column in sums], to.toarray().tolist()
    (['sun'], [[0.25], [0.75]])
    """
    left = [replace(i, nodes=tuple((name, j) for name, j in i.nodes if name not in weights)) for i in interactions]
    counts = [np.prod([weights[name][j] for name, j in i.nodes if name in weights]) for i in interactions]
    sums = sorted(set(left))
    place = {interaction: k for k, interaction in enumerate(sums)}
    to = (np.arange(len(left)), [place[i] for i in left])
    return left, sums, sparse.csr_array((counts, to), shape=(len(left), len(sums)))


def written(text: str) -> list[tuple[Interaction, float]]:
    """The terms of a pixel that one writes down, light first; those that are written as 0 are none.

    Raises
    ------
    ValueError
        If a term is not the product of a number, one light, reflectances, and perhaps a window.

    Examples
    --------
    >>> written("0.5*sun*sea.diffuse + 0")
    [(Interaction(light='sun', met=('sea.diffuse',), nodes=(), window=(), powers=()), 0.5)]
    >>> str(written("0.5*sun*sea.diffuse*wine.transmittance**1.5")[0][0])
    'sun*sea.diffuse*wine.transmittance**1.5'
    """
    found = []
    for coefficient, factors in (term for term in written_terms(text) if term != BLACK):
        words = [factor for factor in factors if isinstance(factor, str)]
        windows = [SpectralWindow.of(word) for word in words if word.startswith("[")]
        names = [word for word in words if not word.startswith("[")]
        symbols = [Symbol.of(name) for name in names]
        lights = [symbol.light for symbol in symbols if symbol.light]
        if len(lights) != 1:
            raise ValueError(
                f"{shown(text)}: {len(lights)} lights in a term; every path of light starts at exactly one"
            )
        if len(windows) > 1:
            raise ValueError(f"{shown(text)}: {len(windows)} windows of wavelengths in a term; light has one at most")
        met = normal_order(name for name, symbol in zip(names, symbols, strict=True) if symbol.reflectance)
        window = windows[0] if windows else EVERYWHERE

        # Lengths in one glass are added up.
        through: dict[str, float] = {}
        for name, length in (factor for factor in factors if not isinstance(factor, str)):
            through[name] = through.get(name, 0.0) + length
        powers = tuple(sorted(through.items()))
        found.append((Interaction(lights[0], met, window=window, powers=powers), coefficient))
    return found
