"""Step 2: collapse a ray tree into a linear system, equation (2) of the paper.

A path from the eye has met a product of reflectances and carries a number; each of its points adds, for each sample of
a light and each term of its material's formula, ``path · weight · irradiance · visible · c_k`` to the column of that
light and those reflectances.  All points of a material are done at once.
"""

import time
from dataclasses import dataclass, field, replace
from itertools import zip_longest

import numpy as np
from jaxtyping import Float

from symrt.errors import require
from symrt.interactions import Interaction
from symrt.linear.matrix import Entries, assemble
from symrt.linear.paths import (
    NOWHERE,
    VANISHED,
    Index,
    Passing,
    Paths,
    Product,
    commuting,
    continued,
    from_the_eye,
    in_order,
    passing,
)
from symrt.linear.program import Free, Program, Values, make_program
from symrt.system import LinearSystem, Tail
from symrt.tracing.raytree import Emitted, Level, Lit, Points, RayTree


def collapse(tree: RayTree, values: Values | None = None, free: Free = (), *, ordered: bool = False) -> LinearSystem:
    """Collapse geometry and nonlinear parts, which leaves a linear system in lights and reflectances.

    Parameters
    ----------
    values
        New values of parameters, ``{"brass.exponent": 60}``: they cost a collapse, not a trace.
    free
        Parameters that stay free, by interpolation between nodes: their names, for a range from a quarter to four
        times their value, or a mapping to ``(low, high)``.
    ordered
        True to keep the order in which light met the reflectances, from the light to the eye: ``sun * sea.diffuse *
        chrome.mirror`` is then the sea seen in the chrome.  Otherwise reflectances are sorted, and products that
        differ in order only share a column.

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
    program = make_program(tree.materials, values, free)
    system = run(program, tree, ordered=ordered)
    return replace(system, seconds={"trace": tree.seconds, "collapse": time.perf_counter() - start})


@dataclass(frozen=True, eq=False)
class Gathering:
    """The state of a collapse: its program and tree, and the entries of G and of the tail gathered so far.

    Parameters
    ----------
    product
        The product of two products of reflectances, sorted or in order.
    """

    program: Program
    tree: RayTree
    product: Product
    entries: Entries = field(default_factory=Entries)
    tail: Entries = field(default_factory=Entries)


def run(program: Program, tree: RayTree, *, ordered: bool = False) -> LinearSystem:
    """Evaluate a compiled program on the numbers of a tree."""
    found = Gathering(program, tree, in_order if ordered else commuting)
    paths = from_the_eye(tree.levels[0], tree.film) if tree.levels else NOWHERE
    for level, below in zip_longest(tree.levels, tree.levels[1:]):
        # Light that reaches the eye from the points of this level.
        for points in level.points:
            for lit in points.lit:
                _add_lit(found, level, points, lit, paths)
            for lit in points.cut:
                _bound_lit(found, level, points, lit, paths)
        for emitted in level.emitted:
            _add_emitted(found, level, emitted, paths)

        # Light of rays that were cut off is bounded; light of rays that were followed is found on the level below.
        for branch in level.cut:
            for part in passing(program, level, branch, paths):
                value = np.where(part.vanished, VANISHED, np.abs(part.value))
                _bound(found, paths, part, _pixels_of(tree, level, branch.parent[part.ray]), value)
        if below is not None:
            paths = _onwards(found, level, below, paths)

    # G, its columns in canonical order, and the tail.
    matrix, interactions = assemble(found.entries, tree.width * tree.height)
    reflected, passed = (
        tuple(shares for place in tree.sending if (place in program.lit) == shone_on for shares in program.sent[place])
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
        subtracting=program.subtracting,
        tail=Tail(*assemble(found.tail, tree.width * tree.height), reflected, passed),
        errors=tree.errors,
    )


def _pixels_of(tree: RayTree, level: Level, hit: Index) -> Index:
    return tree.film.pixel[level.sample[hit]]


def _add_lit(found: Gathering, level: Level, points: Points, lit: Lit, paths: Paths) -> None:
    """Add the light that one sample of a light sends to the eye by way of one material."""
    compiled = found.program.compiled[points.material][lit.via]
    if not compiled.terms:
        return

    # Each pair of a point and a path to it, and the geometric factors at the points.
    point = lit.point
    which, path, carried = _carried(points, lit, paths)
    pixel = _pixels_of(found.tree, level, points.hit[point])
    factors = {name: values[point] for name, values in points.view.items()} | dict(lit.factors)

    # One coefficient a term, to the column of the light and all reflectances on the way.
    for (met, nodes), c in zip(compiled.terms, compiled.coefficients(factors, point.size), strict=True):
        columns = [Interaction(lit.light, found.product(product, met), nodes) for product in paths.products]
        found.entries.add(columns, paths.product[path], pixel[which], carried * c[which])


def _bound_lit(found: Gathering, level: Level, points: Points, lit: Lit, paths: Paths) -> None:
    """Bound the change that an effect which was left out would make to a sample of a light."""
    which, path, carried = _carried(points, lit, paths)
    brightest = found.program.brightest[lit.via]
    columns = [Interaction(lit.light, product) for product in paths.products]
    pixel = _pixels_of(found.tree, level, points.hit[lit.point])
    found.tail.add(columns, paths.product[path], pixel[which], np.abs(carried) * brightest)


def _carried(points: Points, lit: Lit, paths: Paths) -> tuple[Index, Index, Float[np.ndarray, " entry"]]:
    """Pairs of a point that a light's sample reaches and a path to it, and the number that each pair carries."""
    arriving = points.weight[lit.point] * lit.irradiance * lit.visible
    which, path = paths.to(points.hit[lit.point])
    return which, path, paths.coefficient[path] * arriving[which]


def _add_emitted(found: Gathering, level: Level, emitted: Emitted, paths: Paths) -> None:
    """Add the light that hits send to the eye by themselves."""
    which, path = paths.to(emitted.hit)
    columns = [Interaction(emitted.light, product) for product in paths.products]
    pixel = _pixels_of(found.tree, level, emitted.hit)
    found.entries.add(columns, paths.product[path], pixel[which], paths.coefficient[path] * emitted.radiance[which])


def _onwards(found: Gathering, level: Level, below: Level, paths: Paths) -> Paths:
    """The paths on to the level below; those whose numbers underflowed to zero on the way are bounded."""
    parts = [list(passing(found.program, level, branch, paths)) for branch in below.branches]
    for branch, of_branch in zip(below.branches, parts, strict=True):
        for part in of_branch:
            if part.vanished.any():
                pixel = _pixels_of(found.tree, level, branch.parent[part.ray])
                _bound(found, paths, part, pixel, np.where(part.vanished, VANISHED, 0.0))
    return continued(below, parts, paths, found.product)


def _bound(found: Gathering, paths: Paths, part: Passing, pixel: Index, value: Float[np.ndarray, " entry"]) -> None:
    """Bound the light that rays might have brought: that of the brightest surface possible, lit by every light."""
    present = np.flatnonzero(value)
    for name, light in found.tree.lights.items():
        brightest = found.program.brightest[light.via]
        # 0 · inf: where no formula reflects the light, an unbounded irradiance adds nothing.
        if brightest:
            columns = [Interaction(name, found.product(product, part.met)) for product in paths.products]
            unseen = value[present] * (brightest * light.bound)
            found.tail.add(columns, paths.product[part.path[present]], pixel[present], unseen)
