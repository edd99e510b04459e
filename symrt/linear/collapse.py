"""Step 2: collapse a ray tree into a linear system, equation (2) of the paper.

A path from the eye has met a product of reflectances and carries a number; each of its points adds, for each sample of
a light and each term of its material's formula, ``path · weight · irradiance · visible · c_k`` to the column of that
light and those reflectances.  All points of a material are done at once.
"""

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from jaxtyping import Float, Int

from symrt.errors import require
from symrt.interactions import Interaction
from symrt.linear.bounces import Bounces
from symrt.linear.ended import Glowing, Index, Lighted, Lost, Pairs
from symrt.linear.freeing import Free
from symrt.linear.halves import joined, noise
from symrt.linear.matrix import Entries, assemble
from symrt.linear.paths import ends
from symrt.linear.products import Product, around_fluorescence, commuting, in_order
from symrt.linear.program import Program, Values, make_program
from symrt.linear.spreading import spread
from symrt.reflection.models import LIT
from symrt.system import LinearSystem
from symrt.tails import Tail
from symrt.tracing.raytree import LightRecord, RayTree
from symrt.windows import SpectralWindow


def collapse(
    tree: RayTree,
    values: Values | None = None,
    free: Free = (),
    *,
    error: float | int | None = None,
    lengths: str = "hats",
    ordered: bool = False,
) -> LinearSystem:
    """Collapse geometry and nonlinear parts, which leaves a linear system in lights and reflectances.

    Parameters
    ----------
    values
        New values of parameters, ``{"brass.exponent": 60}``: they cost a collapse, not a trace.
    free
        Parameters that stay free, by interpolation between nodes: their names, for a range from a quarter to four
        times their value, or a mapping to ``(low, high)``; or to ``"first order"`` around their value, of any smooth
        parameter, and within ``("first order", low, high)`` if a tenth to both sides is not what you want.
    error
        The largest error that interpolation may have: of lengths in absorbing glass 1e-3 if it is not given, a share of
        the light that clear glass would let through; of free parameters as of `Nodes.error`, which is told of each.
    lengths
        How the power of a transmittance for any length is made of a few: ``"hats"``, whose weights are never negative,
        or ``"chebyshev"``, which needs fewer nodes, but makes signed columns.
    ordered
        True to keep the order in which light met the reflectances, from the light to the eye: ``sun * sea.diffuse *
        chrome.mirror`` is then the sea seen in the chrome.  Otherwise reflectances are sorted, and products that
        differ in order only share a column; only where a fluorescent one stands among them the order always counts.

    Examples
    --------
    >>> from symrt.scene import load_scene, shipped_scene
    >>> from symrt.tracing import trace
    >>> system = collapse(trace(load_scene(shipped_scene("first")), window=(120, 90, 140, 110)))
    >>> [str(interaction) for interaction in system.interactions]
    ['sun*red.diffuse', 'sun*red.specular']
    """
    start = time.perf_counter()
    require("tree", tree, RayTree, "a RayTree, trace(scene)")
    gathered = {via for formulas in tree.sending.values() for via in formulas}.intersection(LIT)
    program = make_program(tree.materials, values, free, gathered, error, lengths)
    system = run(program, tree, ordered=ordered)
    return replace(system, seconds={"trace": tree.seconds, "collapse": time.perf_counter() - start})


@dataclass(frozen=True, eq=False)
class Gathering:
    """The state of a collapse: its program and lights, and the entries of G and of the tail gathered so far.

    Parameters
    ----------
    product
        The product of two products of reflectances, sorted or in order.
    clear
        True if absorption was left out: glass is taken for clear, and what it would absorb is bounded.
    windows
        The windows of wavelengths, by number, that paths are of.
    """

    program: Program
    lights: Mapping[str, LightRecord]
    product: Product
    clear: bool
    windows: tuple[SpectralWindow, ...] = ()
    entries: Entries = field(default_factory=Entries)
    tail: Entries = field(default_factory=Entries)
    bounces: Bounces = field(default_factory=Bounces)


def run(program: Program, tree: RayTree, *, ordered: bool = False) -> LinearSystem:
    """Evaluate a compiled program on the numbers of a tree."""
    product = in_order if ordered else around_fluorescence if program.limits.fluorescent else commuting
    found = Gathering(program, tree.lights, product, "absorption" in tree.plan.left_out, tree.windows)
    for end in ends(program, tree, found.product):
        match end:
            case Lighted() if end.bounded:
                _bound_lit(found, end)
            case Lighted():
                _add_lit(found, end)
                if found.clear:
                    _bound_lit(found, replace(end, pairs=_in_glass(end.pairs)))
            case Glowing():
                _add_emitted(found, end)
            case Lost():
                _bound_lost(found, end)

    # G, its columns in canonical order, and the tail; where samples are drawn, of both halves of each pixel.
    halves = tree.film.half is not None
    rows = tree.width * tree.height * (2 if halves else 1)
    (matrix, interactions), (bound, unseen) = assemble(found.entries, rows), assemble(found.tail, rows)
    drawn = noise(matrix, interactions, tree.white) if halves else found.bounces.noise(tree.white)
    matrix, bound = (joined(matrix), joined(bound)) if halves else (matrix, bound)
    limits = program.limits
    reflected, passed = (
        tuple(shares for place in tree.sending if (place in limits.lit) == shone_on for shares in limits.sent[place])
        for shone_on in (True, False)
    )
    return LinearSystem(
        G=matrix,
        interactions=interactions,
        height=tree.height,
        width=tree.width,
        white=tree.white,
        models=program.signatures,
        parameters=program.nodes,
        subtracting=limits.subtracting,
        tail=Tail(bound, unseen, reflected, passed, limits.fluorescent, found.bounces.sums()),
        errors=tree.errors,
        counts=tree.counts,
        noise=drawn,
        glowing=tuple(name for name, light in tree.lights.items() if light.glowing),
        lengths={} if found.clear else program.lengths,
    )


def _add(found: Gathering, columns: Sequence[Interaction], pairs: Pairs, value: Float[np.ndarray, " entry"]) -> None:
    """Add numbers to G, each to the column of its product; light in glass is shared out to powers of lengths."""
    columns, which, pairs, value = _shared(found, columns, pairs, value, bounding=False)
    found.entries.add(columns, which, pairs.pixel, value)
    found.bounces.add(columns, which, pairs, value)


def _bound(found: Gathering, columns: Sequence[Interaction], pairs: Pairs, value: Float[np.ndarray, " entry"]) -> None:
    """Add numbers to the tail, as `_add` does to G; what glass leaves of them is bounded by the node below."""
    columns, which, pairs, value = _shared(found, columns, pairs, value, bounding=True)
    found.tail.add(columns, which, pairs.pixel, value)


def _shared(
    found: Gathering,
    columns: Sequence[Interaction],
    pairs: Pairs,
    value: Float[np.ndarray, " entry"],
    *,
    bounding: bool,
) -> tuple[Sequence[Interaction], Int[np.ndarray, " part"], Pairs, Float[np.ndarray, " part"]]:
    """Columns, those of the numbers, and the numbers: within windows, and shared out by lengths in glass."""
    columns, which = _within(found, columns, pairs)
    if not pairs.inside or found.clear:
        return columns, which, pairs, value
    parts = spread(columns, which, pairs.inside, found.program.lengths, bounding=bounding)
    share = value[parts.origin] if bounding else value[parts.origin] * parts.share
    return parts.columns, parts.which, pairs.of(parts.origin), share


def _within(found: Gathering, columns: Sequence[Interaction], pairs: Pairs) -> tuple[Sequence[Interaction], Index]:
    """The columns of all products within all windows of wavelengths, and which of them each pair is of."""
    if found.program.limits.fluorescent:
        _check_order(found, pairs)
    if pairs.window is None:
        return columns, pairs.product
    split = [(column, *(replace(column, window=window) for window in found.windows)) for column in columns]
    which = pairs.product * (1 + len(found.windows)) + 1 + pairs.window
    return [column for each in split for column in each], which


def _check_order(found: Gathering, pairs: Pairs) -> None:
    """Refuse paths by way of a fluorescent surface and of coloured or dispersive glass, whose order is not kept."""
    moving = [name for name in found.program.limits.fluorescent if any(name in product for product in pairs.products)]
    through = np.array([not set(moving).isdisjoint(product) for product in pairs.products], dtype=bool)
    bent = [] if pairs.window is None else [pairs.window >= 0]
    for glass in ([length > 0 for length in pairs.inside.values()] if not found.clear else []) + bent:
        if moving and (glass & through[pairs.product]).any():
            raise ValueError(
                f"{moving[0]} sends light on at other wavelengths, and glass takes some of them before or behind: "
                "columns do not keep which; leave one of the two out, with force={'absorption': False}, "
                "{'dispersion': False} or {'interreflection': False}"
            )


def _in_glass(pairs: Pairs) -> Pairs:
    """The pairs whose paths go through absorbing glass."""
    through = [length > 0 for length in pairs.inside.values()]
    return pairs.of(np.flatnonzero(np.any(through, axis=0)) if through else np.empty(0, dtype=np.int64))


def _add_lit(found: Gathering, end: Lighted) -> None:
    """Add the light that one sample of a light sends to the eye by way of one material."""
    points, lit, pairs = end.points, end.lit, end.pairs
    compiled = found.program.compiled[points.material][lit.via]
    if not compiled.terms:
        return

    # The geometric factors at the points, and one coefficient a term, to the column of the light and all reflectances
    # on the way.
    factors = {name: values[lit.point] for name, values in points.view.items()} | dict(lit.factors)
    for (met, nodes), c in zip(compiled.terms, compiled.coefficients(factors, lit.point.size), strict=True):
        columns = [Interaction(lit.light, found.product(product, met), nodes) for product in pairs.products]
        _add(found, columns, pairs, pairs.value * c[pairs.which])


def _bound_lit(found: Gathering, end: Lighted) -> None:
    """Bound the change that an effect which was left out would make to a sample of a light."""
    lit, pairs = end.lit, end.pairs
    columns = [Interaction(lit.light, product) for product in pairs.products]
    _bound(found, columns, pairs, np.abs(pairs.value) * found.program.limits.brightest[lit.via])


def _add_emitted(found: Gathering, end: Glowing) -> None:
    """Add the light that hits send to the eye by themselves, to what is seen or to what is cut off."""
    pairs = end.pairs
    columns = [Interaction(end.light, product) for product in pairs.products]
    if end.bounded:
        _bound(found, columns, pairs, np.abs(pairs.value))
        return
    _add(found, columns, pairs, pairs.value)
    if found.clear:
        through = _in_glass(pairs)
        _bound(found, columns, through, np.abs(through.value))


def _bound_lost(found: Gathering, end: Lost) -> None:
    """Bound the light that rays might have brought: that of the brightest surface possible, lit by every light.

    Or that of a lamp itself, which is no surface, where it is brighter.
    """
    pairs = end.pairs
    for name, light in found.lights.items():
        # 0 · inf: where no formula reflects the light, an unbounded irradiance adds nothing.
        brightest = found.program.limits.brightest[light.via]
        most = max(brightest * light.bound if brightest else 0.0, light.shown)
        if most:
            columns = [Interaction(name, found.product(product, end.met)) for product in pairs.products]
            _bound(found, columns, pairs, pairs.value * most)
