"""Step 2: collapse a ray tree into a linear system, equation (2) of the paper.

A path from the eye has met a product of mirrors and carries a number; each of its points adds, for each light and each
term of its material's formula, ``path · weight · irradiance · visible · c_k`` to the column of that light and those
reflectances.  All points of a material are done at once.
"""

import time
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float, Int

from symrt.linear.compiled import Compiled
from symrt.linear.matrix import Entries, assemble
from symrt.linear.program import Free, Program, Values, make_program
from symrt.reflection.polynomials import Monomial
from symrt.system import Interaction, LinearSystem, Tail
from symrt.tracing.raytree import Level, Points, RayTree

__all__ = ["collapse", "run"]

Index = Int[np.ndarray, " entry"]


@dataclass(frozen=True, eq=False)
class Paths:
    """Paths from the eye to the hits of one level.

    Parameters
    ----------
    hit
        Where each path ends, ascending; a hit that several products lead to stands several times.
    product
        Index into `products`: the mirrors it met.
    coefficient
        Product of the numbers on the way.
    """

    hit: Int[np.ndarray, " path"]
    product: Int[np.ndarray, " path"]
    coefficient: Float[np.ndarray, " path"]
    products: tuple[Monomial, ...]

    def to(self, hit: Int[np.ndarray, " point"]) -> tuple[Index, Index]:
        """For each pair of a point and a path that leads to it: the point's place in `hit`, and the path."""
        size = int(max(self.hit.max(initial=-1), hit.max(initial=-1))) + 1
        count = np.bincount(self.hit, minlength=size)[hit]
        first = np.searchsorted(self.hit, hit)
        which = np.repeat(np.arange(hit.size), count)
        within = np.arange(which.size) - np.repeat(np.cumsum(count) - count, count)
        return which, first[which] + within


def collapse(tree: RayTree, values: Values | None = None, free: Free = ()) -> LinearSystem:
    """Collapse geometry and nonlinear parts, which leaves a linear system in lights and reflectances.

    Parameters
    ----------
    values
        New values of parameters, ``{"brass.exponent": 60}``: they cost a collapse, not a trace.
    free
        Parameters that stay free, by interpolation between nodes: their names, for a range from a quarter to four
        times their value, or a mapping to ``(low, high)``.

    Examples
    --------
    >>> from symrt.scene import load_scene, shipped_scene
    >>> from symrt.tracing import trace
    >>> system = collapse(trace(load_scene(shipped_scene("first")), window=(120, 90, 140, 110)))
    >>> [str(interaction) for interaction in system.interactions]
    ['sun*red.diffuse', 'sun*red.specular']
    """
    start = time.perf_counter()
    program = make_program(tree.materials, values, free)
    system = run(program, tree)
    return replace(system, seconds={"trace": tree.seconds, "collapse": time.perf_counter() - start})


def run(program: Program, tree: RayTree) -> LinearSystem:
    """Evaluate a compiled program on the numbers of a tree."""
    entries, tail = Entries(), Entries()
    paths = _camera_paths(tree)
    for depth, level in enumerate(tree.levels):
        for points in level.points:
            compiled = program.compiled[points.material]
            _add_direct(tree, compiled["direct"], level, points, paths, entries)
            _add_ambient(tree, compiled["ambient"], level, points, paths, entries)
        if depth == tree.depth:
            _cut_off(tree, program, level, paths, tail)
        elif depth + 1 < len(tree.levels):
            paths = _onwards(program, level, tree.levels[depth + 1], paths)
    matrix, interactions = assemble(entries, tree.width * tree.height)
    return LinearSystem(
        G=matrix,
        interactions=interactions,
        height=tree.height,
        width=tree.width,
        white=tree.white,
        models=program.signatures,
        parameters=program.nodes,
        tail=Tail(
            *assemble(tail, tree.width * tree.height), tuple(program.reflected[name] for name in tree.reflecting)
        ),
    )


def _camera_paths(tree: RayTree) -> Paths:
    size = tree.levels[0].size if tree.levels else 0
    return Paths(np.arange(size), np.zeros(size, dtype=np.int64), np.full(size, 1 / tree.samples**2), ((),))


def _add_direct(
    tree: RayTree, compiled: Compiled, level: Level, points: Points, paths: Paths, entries: Entries
) -> None:
    pixel = level.sample[points.hit] // tree.samples**2
    for lit in points.lit:
        point = lit.point
        factors = {name: values[point] for name, values in points.view.items()} | dict(lit.factors)
        arriving = points.weight[point] * lit.irradiance * lit.visible
        which, path = paths.to(points.hit[point])
        carried = paths.coefficient[path] * arriving[which]
        for (met, nodes), c in zip(compiled.terms, compiled.coefficients(factors, point.size), strict=True):
            columns = [Interaction(lit.light, tuple(sorted(product + met)), nodes) for product in paths.products]
            entries.add(columns, paths.product[path], pixel[point][which], carried * c[which])


def _add_ambient(
    tree: RayTree, compiled: Compiled, level: Level, points: Points, paths: Paths, entries: Entries
) -> None:
    ambient = [light for light, everywhere in tree.lights.items() if everywhere]
    if not ambient or not compiled.terms:
        return
    pixel = level.sample[points.hit] // tree.samples**2
    which, path = paths.to(points.hit)
    carried = paths.coefficient[path] * points.weight[which]
    coefficients = compiled.coefficients(points.view, points.hit.size)
    for light in ambient:
        for (met, nodes), c in zip(compiled.terms, coefficients, strict=True):
            columns = [Interaction(light, tuple(sorted(product + met)), nodes) for product in paths.products]
            entries.add(columns, paths.product[path], pixel[which], carried * c[which])


def _onwards(program: Program, level: Level, below: Level, paths: Paths) -> Paths:
    """The paths that mirrors send on to the hits of the level below."""
    child_of = np.full(level.size, -1)
    child_of[below.parent] = np.arange(below.size)
    products: dict[Monomial, int] = {}
    hit, product, coefficient = [], [], []
    for points, met, which, path, value in _reflections(program, level, paths):
        child = child_of[points.hit[which]]
        present = np.flatnonzero((child >= 0) & (value != 0))
        renumbered = [products.setdefault(tuple(sorted(before + met)), len(products)) for before in paths.products]
        hit.append(child[present])
        product.append(np.array(renumbered)[paths.product[path[present]]])
        coefficient.append(value[present])
    order = np.argsort(np.concatenate(hit), kind="stable")
    hits, numbers, values = (np.concatenate(parts)[order] for parts in (hit, product, coefficient))
    return _merged(Paths(hits, numbers, values, tuple(products)))


def _merged(paths: Paths) -> Paths:
    """Add up paths that lead to one hit by one product: two terms would else double them at each bounce."""
    key = paths.hit * len(paths.products) + paths.product
    _, first, same = np.unique(key, return_index=True, return_inverse=True)
    if first.size == key.size:
        return paths
    # In the order in which they were found, which no tile changes.
    order = np.argsort(first)
    total = np.bincount(same, weights=paths.coefficient)[order]
    return Paths(paths.hit[first[order]], paths.product[first[order]], total, paths.products)


def _cut_off(tree: RayTree, program: Program, level: Level, paths: Paths, tail: Entries) -> None:
    """Bound what the mirrors of the last level would have shown: at most the brightest surface there can be."""
    for points, met, which, path, value in _reflections(program, level, paths):
        pixel = level.sample[points.hit[which]] // tree.samples**2
        for light, everywhere in tree.lights.items():
            brightest = program.brightest["ambient" if everywhere else "direct"]
            columns = [Interaction(light, tuple(sorted(product + met))) for product in paths.products]
            # Nothing times an unknown irradiance is nothing.
            present = value != 0 if brightest else np.zeros(value.size, dtype=bool)
            unseen = np.abs(value[present]) * (brightest * tree.irradiance[light])
            tail.add(columns, paths.product[path[present]], pixel[present], unseen)


def _reflections(
    program: Program, level: Level, paths: Paths
) -> list[tuple[Points, Monomial, Index, Index, Float[np.ndarray, " entry"]]]:
    """For each term that a material reflects by: its points, the mirrors in it, and the paths through them."""
    found = []
    for points in level.points:
        compiled = program.compiled[points.material]["reflected"]
        if not compiled.terms:
            continue
        which, path = paths.to(points.hit)
        carried = paths.coefficient[path] * points.weight[which]
        for (met, _), c in zip(compiled.terms, compiled.coefficients(points.view, points.hit.size), strict=True):
            found.append((points, met, which, path, carried * c[which]))
    return found
