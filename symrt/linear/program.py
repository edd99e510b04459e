"""All materials of a scene compiled: the residue of partial evaluation, to be run on the numbers of a tree (step 2)."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from symrt.lengths import Lengths, lengths_for
from symrt.linear.compiled import Compiled, compile_formula
from symrt.linear.freeing import Free, freed
from symrt.linear.limits import Limits, Materials, limits, parameter_of
from symrt.nodes import Nodes
from symrt.reflection.models import INDEX, LIT
from symrt.symbols import Surface, named
from symrt.tracing.raytree import MaterialRecord

Values = Mapping[str, float | int]
ABSORBING = 1e-3
"""Largest error of lengths in absorbing glass, unless told otherwise."""


@dataclass(frozen=True, eq=False)
class Program:
    """Compiled formulas of each material, with parameters bound.

    Parameters
    ----------
    signatures
        Model and parameters of each material, as text.
    nodes
        Nodes of the parameters that stayed free.
    limits
        Bounds of what the materials send on.
    lengths
        For each transmittance of absorbing glass, the nodes for lengths of paths in it.
    """

    compiled: Mapping[str, Mapping[str, Compiled]]
    signatures: Mapping[str, str]
    nodes: Mapping[str, Nodes]
    limits: Limits
    lengths: Mapping[str, Lengths]


def make_program(
    materials: Materials,
    values: Values | None = None,
    free: Free = (),
    gathered: Collection[str] = (),
    error: float | int | None = None,
    lengths: str = "hats",
) -> Program:
    """Bind parameters to their values, or to nodes where they stay free, and compile.

    Parameters
    ----------
    gathered
        Formulas that lights meet by which effects send rays on, too.

    Examples
    --------
    >>> from symrt.reflection import MODELS
    >>> shiny = MaterialRecord(MODELS["phong"], {"exponent": 40.0})
    >>> make_program({"brass": shiny}, free={"brass.exponent": (10, 160)}).nodes["brass.exponent"].high
    160.0
    """
    # Parameters get their values, or nodes.
    materials = with_values(materials, values or {})
    _check_known(materials, free)
    _check_not_traced(materials, free)
    inside, nodes = _lengths(materials, error, lengths), freed(materials, free, error)

    # What alternatives bring belongs to the material whose place they may take.
    own = {name: record for name, record in materials.items() if not Surface.of(name).alternative}
    return Program(
        compiled={name: _compiled(name, record, nodes) for name, record in materials.items()},
        signatures={name: record.signature() for name, record in own.items()},
        nodes={name: nodes[name] for name in sorted(nodes)},
        limits=limits(materials, nodes, gathered),
        lengths=inside,
    )


def _lengths(materials: Materials, error: float | int | None, scheme: str) -> dict[str, Lengths]:
    """The nodes for lengths in each absorbing glass."""
    inside = {name: record.model.inside for name, record in materials.items() if record.model.inside != 0}
    if not inside:
        return {}
    chosen = lengths_for(ABSORBING if error is None else error, scheme)
    return {named(name, formula.name): chosen for name, formula in sorted(inside.items())}


def with_values(materials: Materials, values: Values) -> Materials:
    """The same materials with other values of some parameters, named ``material.parameter``."""
    _check_known(materials, values)
    _check_not_traced(materials, values)
    for name, value in values.items():
        if not np.isfinite(value):
            raise ValueError(f"{name} = {value}: a parameter must be finite")
    return {
        name: replace(
            record,
            parameters={key: float(values.get(parameter_of(name, key), v)) for key, v in record.parameters.items()},
        )
        for name, record in materials.items()
    }


def _check_known(materials: Materials, names: Sequence[str] | Mapping[str, object]) -> None:
    known = {parameter_of(name, key) for name, record in materials.items() for key in record.parameters}
    if unknown := sorted(set(names) - known):
        there = ", ".join(sorted(known)) or "none"
        raise ValueError(f"no material has the parameter {', '.join(unknown)}; the scene's parameters: {there}")


def _check_not_traced(materials: Materials, names: Sequence[str] | Mapping[str, object]) -> None:
    """Refuse to change what rays were bent by."""
    bent = {parameter_of(name, INDEX) for name, record in materials.items() if record.model.refracts}
    if traced := sorted(bent.intersection(names)):
        raise ValueError(f"{', '.join(traced)}: rays were bent by it; trace the scene again with another index")


def _compiled(name: str, record: MaterialRecord, nodes: Mapping[str, Nodes]) -> dict[str, Compiled]:
    free = {key: nodes[n] for key in record.parameters if (n := parameter_of(name, key)) in nodes}
    compiled = {
        field: compile_formula(formula, name, record.parameters, free)
        for field, formula in record.model.formulas.items()
    }
    if any(index for field, formula in compiled.items() if field not in LIT for _, index in formula.terms):
        raise ValueError(f"{name}: a parameter of what it mirrors cannot stay free; give it a value instead")
    return compiled
