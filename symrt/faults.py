"""Faults of a linear system: names and numbers that no scene gives, and parts that contradict each other."""

from collections.abc import Iterator

import numpy as np
from scipy import sparse

from symrt.columns import wrong_lengths
from symrt.errors import plain, shown
from symrt.symbols import NAME, OF_MATERIAL, RESERVED, Symbol
from symrt.system import LinearSystem
from symrt.tails import Tail

LONGEST = 1 << 16
"""Letters of a model's formulas."""


def faults(system: LinearSystem) -> Iterator[str]:
    """Names and numbers that no scene gives, and parts that contradict each other: those of saved and loaded alike."""
    tail = system.tail or Tail(sparse.csr_array((0, 0)))
    yield from _wrong_names(system, tail)
    yield from _wrong_columns(system, tail)
    yield from wrong_lengths((*system.interactions, *tail.interactions))
    yield from _wrong_numbers(system, tail)


def _wrong_names(system: LinearSystem, tail: Tail) -> Iterator[str]:
    """Names against the rule for scene files, and against each other."""
    # Every name that occurs.
    columns = (*system.interactions, *tail.interactions, *tail.gathered)
    shares = (*tail.reflected, *tail.passed)
    met = {name for i in columns for name in i.names[1:]} | {name for s in shares for names, _ in s for name in names}
    symbols = [Symbol.of(name) for name in met if OF_MATERIAL.fullmatch(name)]
    materials = {name for symbol in symbols for name in (symbol.material, symbol.place)} | set(system.models)

    # Each as the rule for its kind has it.
    for kind, names, rule in (
        ("light", system.white, NAME),
        ("material", system.models, NAME),
        ("material", system.subtracting, NAME),
        ("reflectance", sorted(met), OF_MATERIAL),
        ("reflectance", tail.fluorescent, OF_MATERIAL),
        ("transmittance", system.lengths, OF_MATERIAL),
        ("parameter", system.parameters, OF_MATERIAL),
        ("parameter", sorted({name for by in system.interpolated.values() for name in by}), OF_MATERIAL),
        ("step", system.seconds, NAME),
        ("formula", sorted({way for count in system.counts.effects.values() for way in count.ways}), NAME),
    ):
        yield from (f"a {kind} is called {shown(name)}" for name in names if not rule.fullmatch(name))

    for name in sorted({*tail.fluorescent, *met} - set(system.white)):
        if OF_MATERIAL.fullmatch(name) and Symbol.of(name).fluorescent != (name in tail.fluorescent):
            yield f"{name} is {'not ' if name in tail.fluorescent else ''}fluorescent, against their list"

    # Lights and materials that are there, each with a name of its own, and formulas of one line.
    yield from (f"a light is called {name}, a word of palette files" for name in RESERVED if name in system.white)
    yield from (f"no light is called {shown(i.light)}" for i in columns if i.light not in system.white)
    told = (*system.errors, *system.noise, *system.glowing)
    yield from (f"no light is called {shown(name)}" for name in told if name not in system.white)
    yield from (f"{name} is a light and a material" for name in sorted(materials & set(system.white)))
    yield from (f"an effect is called {shown(n)}" for n in system.counts.effects if plain(n) != n or len(n) > LONGEST)
    for name, text in system.models.items():
        if plain(text) != text or len(text) > LONGEST:
            yield f"the model of {name} is {shown(text)}, not a line of formulas"


def _wrong_columns(system: LinearSystem, tail: Tail) -> Iterator[str]:
    """Columns of one name, in no order, or at nodes that there are not."""
    # Columns once each.
    for kind, several in (("interactions", system.interactions), ("cut-off interactions", tail.interactions)):
        if len(set(several)) < len(several):
            yield f"two {kind} are the same"
    yield from (f"what was cut off has nodes, in {i}" for i in tail.interactions if i.nodes)
    windows = {i.window for i in (*system.interactions, *tail.interactions) if i.window}
    yield from (f"a window is {list(window)}: {window.fault}" for window in sorted(windows) if window.fault)

    # Columns that were interpolated.
    columns = set(system.interactions)
    for interaction, names in system.interpolated.items():
        if interaction not in columns:
            yield f"{interaction} was interpolated, and is not there"
        if not names or len(set(names)) < len(names) or not set(names).isdisjoint(system.parameters):
            yield f"{interaction} was interpolated in {', '.join(names) or 'nothing'}"

    # Nodes of parameters that are there.
    for interaction in system.interactions:
        if len({name for name, _ in interaction.nodes}) < len(interaction.nodes):
            yield f"{interaction} names two nodes of one parameter"
        for name, j in interaction.nodes:
            if name not in system.parameters or not 0 <= j < system.parameters[name].count:
                yield f"{interaction} names a node that is not there"


def _wrong_numbers(system: LinearSystem, tail: Tail) -> Iterator[str]:
    """Numbers that are not finite, or below 0 where light is counted."""
    for what, numbers in (("white", system.white), ("seconds", system.seconds)):
        yield from (f"the {what} of {n} is {v}: not a number from 0" for n, v in numbers.items() if not 0 <= v < np.inf)
    for name, error in (*system.errors.items(), *system.noise.items()):
        if error.count < 0 or not 0 <= error.rms <= error.largest < np.inf:
            yield f"the error of {name} is {error}: not numbers from 0, the largest last"
    for name, count in system.counts.effects.items():
        if not 0 <= count.seconds < np.inf:
            yield f"the seconds of {name} are {count.seconds}: not a number from 0"
    if not all(np.isfinite(sums).all() for sums in tail.gathered.values()):
        yield "the sums of gathered light are not finite"
    if not np.all(np.isfinite(system.G.data)):
        yield "the coefficients of G are not finite float64 numbers"
    # A bound on what was cut off may be infinite: nothing is known then.
    bounds = [np.array([c for _, c in shares]) for shares in (*tail.reflected, *tail.passed) if shares]
    if not np.all(tail.bound.data >= 0) or any(np.isnan(c).any() or c.max() < 0 for c in bounds):
        yield "a bound on what was cut off is below 0, or not a number"
