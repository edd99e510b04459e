"""Columns of systems and nodes of parameters in files: rows of texts and numbers (between steps 2 and 3)."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from symrt.headers import count_of, list_of, text_of
from symrt.interactions import Interaction
from symrt.nodes import Nodes
from symrt.windows import EVERYWHERE, SpectralWindow


def row_of(interaction: Interaction) -> list[Any]:
    """A column as a file has it; of one without window and lengths it is what it was before there were any."""
    row = [interaction.light, list(interaction.met), [list(node) for node in interaction.nodes]]
    window = [float(nm).hex() for nm in interaction.window]
    powers = [[name, float(length).hex()] for name, length in interaction.powers]
    return [*row, *([window] if window or powers else []), *([powers] if powers else [])]


def columns_of(rows: list[Any]) -> tuple[Interaction, ...]:
    """The columns that rows of a file name; each part of a row is checked to be of its kind."""
    return tuple(
        Interaction(
            text_of(light),
            tuple(map(text_of, list_of(met))),
            tuple((text_of(name), count_of(j)) for name, j in list_of(nodes)),
            _window(*more[:1]),
            _powers(*more[1:]),
        )
        for light, met, nodes, *more in map(list_of, list_of(rows))
    )


def _window(parts: Any = None) -> SpectralWindow | tuple[()]:
    if parts is None or parts == []:
        return EVERYWHERE
    low, centre, high = (float.fromhex(text_of(part)) for part in list_of(parts))
    return SpectralWindow(low, centre, high)


def _powers(rows: Any = None) -> tuple[tuple[str, float], ...]:
    pairs = [] if rows is None else map(list_of, list_of(rows))
    return tuple((text_of(name), float.fromhex(text_of(length))) for name, length in pairs)


def wrong_lengths(interactions: tuple[Interaction, ...]) -> Iterator[str]:
    """Lengths of ways through glass that are none, or two for one glass."""
    for interaction in interactions:
        glasses = [name for name, _ in interaction.powers]
        if glasses != sorted(set(glasses)) or not all(0 < length < np.inf for _, length in interaction.powers):
            yield f"the lengths of {interaction} are not above 0, once for each glass, in their order"


def nodes_row(nodes: Nodes) -> list[Any]:
    """A parameter's nodes as a file has them; without a known error they are what they were before there were any."""
    row: list[Any] = [nodes.parameter, nodes.low.hex(), nodes.high.hex(), nodes.count, nodes.scale]
    told = [] if np.isinf(nodes.error) and nodes.around is None else [float(nodes.error).hex()]
    return row + told + ([] if nodes.around is None else [nodes.around.hex()])


def nodes_of(name: Any, low: Any, high: Any, count: Any, scale: Any, *told: Any) -> Nodes:
    """The nodes that a row of a file names."""
    ends = float.fromhex(text_of(low)), float.fromhex(text_of(high))
    known = [float.fromhex(text_of(number)) for number in told]
    error, around = known[0] if known else np.inf, known[1] if len(known) > 1 else None
    return Nodes(text_of(name), *ends, count_of(count), text_of(scale), error, around)  # type: ignore[arg-type]  # Nodes checks it
