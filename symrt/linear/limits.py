"""Bounds of what the materials of a scene send on, for the light that a trace cuts off (step 2)."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass

from symrt.nodes import Nodes
from symrt.reflection.bounds import largest, may_subtract
from symrt.reflection.corners import corners
from symrt.reflection.models import LIT
from symrt.reflection.polynomials import monomials
from symrt.symbols import Surface, fluoresces, named
from symrt.tails import Shares
from symrt.tracing.raytree import MaterialRecord

Materials = Mapping[str, MaterialRecord]


@dataclass(frozen=True, eq=False)
class Limits:
    """Bounds of what the materials of a scene send on.

    Parameters
    ----------
    brightest
        An upper bound, over all materials, of each formula that lights meet, or that surfaces shine by.
    subtracting
        The materials some formula of which may have a term that takes away.
    sent
        For each material of the scene, sums that bound the share that it sends on of what further rays bring.
    lit
        The materials that lights shine on, or that shine themselves.
    fluorescent
        The reflectances that move light from band to band.
    """

    brightest: Mapping[str, float]
    subtracting: tuple[str, ...]
    sent: Mapping[str, tuple[Shares, ...]]
    lit: frozenset[str]
    fluorescent: tuple[str, ...] = ()


def limits(materials: Materials, nodes: Mapping[str, Nodes], gathered: Collection[str] = ()) -> Limits:
    """Bound what materials send on, for all values of parameters between the nodes of those that stayed free.

    Parameters
    ----------
    gathered
        Formulas that lights meet by which effects send rays on, too.
    """
    # The values that each parameter may have, then each bound from them.
    ranges = {name: _ranges(name, record, nodes) for name, record in materials.items()}
    return Limits(
        brightest={field: _brightest(field, materials, ranges) for field in LIT},
        subtracting=tuple(
            sorted(
                {
                    Surface.of(name).material
                    for name, record in materials.items()
                    if any(may_subtract(f, ranges[name]) for f in record.model.formulas.values())
                }
            )
        ),
        sent=_sent(materials, ranges, gathered),
        lit=frozenset(Surface.of(n).place for n, m in materials.items() if any(m.model.formulas[f] != 0 for f in LIT)),
        fluorescent=tuple(sorted(named(n, c) for n, m in materials.items() for c in m.model.fluorescent)),
    )


def parameter_of(surface: str, key: str) -> str:
    """The name of a surface's parameter: its material's, ``ice.exponent`` for the alternative ``sea>ice``."""
    return named(Surface.of(surface).material, key)


def _ranges(name: str, record: MaterialRecord, nodes: Mapping[str, Nodes]) -> dict[str, tuple[float, float]]:
    """The lowest and the highest value of each parameter of a material."""
    ranges = {key: (value, value) for key, value in record.parameters.items()}
    return ranges | {k: (nodes[n].low, nodes[n].high) for k in ranges if (n := parameter_of(name, k)) in nodes}


def _brightest(field: str, materials: Materials, ranges: Mapping[str, Mapping[str, tuple[float, float]]]) -> float:
    """The most that a point sends on, its alternatives added: sea and sea>ice are evaluated at the same points."""
    bounds: dict[str, float] = {}
    for name, record in materials.items():
        formula, place = record.model.formulas[field], Surface.of(name).place
        bound = largest(formula, ranges[name])
        if record.model.fluorescent:
            # Matrices are bounded apart from the spectra beside them: each by the number before it.
            shares = (largest(c, ranges[name]) for met, c in monomials(formula).items() if any(map(fluoresces, met)))
            bound = max(bound, *shares, 0.0)
        bounds[place] = bounds.get(place, 0.0) + bound
    return max(bounds.values(), default=0.0)


def _sent(
    materials: Materials, ranges: Mapping[str, Mapping[str, tuple[float, float]]], gathered: Collection[str]
) -> dict[str, tuple[Shares, ...]]:
    """Bounds of what each material sends on by all its formulas together, its alternatives added."""
    found: dict[str, tuple[Shares, ...]] = {}
    for name, record in materials.items():
        sums = corners(record.model.sent_on(gathered), ranges[name])
        own = tuple(tuple((tuple(named(name, c) for c in met), most) for met, most in shares) for shares in sums)
        place = Surface.of(name).place
        before = found.get(place, ())
        found[place] = tuple(one + other for one in before for other in own) if before and own else before or own
    return found
