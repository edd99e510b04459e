"""Paths from the eye through a tree of rays, and their ends: lights, glowing hits, and rays cut off (step 2)."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import zip_longest

import numpy as np
from jaxtyping import Bool, Float, Int

from symrt import fast
from symrt.linear.ended import Glowing, Index, Inside, Lighted, Lost, Pairs
from symrt.linear.products import Product
from symrt.linear.program import Program
from symrt.reflection.polynomials import Monomial
from symrt.tracing.raytree import Branch, Film, Level, Lit, Points, RayTree

VANISHED = np.finfo(float).tiny
"""A bound of products that underflowed to zero though none of their factors is zero."""


@dataclass(frozen=True, eq=False)
class Paths:
    """Paths from the eye to the hits of one level.

    Parameters
    ----------
    hit
        The hit where each path ends, ascending; a hit that several products lead to stands several times.
    product
        Index into `products` of the reflectances that each path met.
    coefficient
        Product of the numbers on the way.
    products
        Distinct products of reflectances.
    inside
        The lengths to each hit of the level in absorbing materials.
    window
        The window of wavelengths that each hit of the level is seen in, −1 for all of them; None where there are none.
    """

    hit: Int[np.ndarray, " path"]
    product: Int[np.ndarray, " path"]
    coefficient: Float[np.ndarray, " path"]
    products: tuple[Monomial, ...]
    inside: Inside = field(default_factory=dict)
    window: Index | None = None

    @cached_property
    def starts(self) -> Int[np.ndarray, " hit_and_two"]:
        """The number of paths before those to each hit; no path leads to the hit after the last."""
        total = self.hit.size
        return np.concatenate([[0], np.cumsum(np.bincount(self.hit)), [total]])

    def to(self, hit: Int[np.ndarray, " point"]) -> tuple[Index, Index]:
        """Pairs of a point and a path that leads to it: the point's place in `hit`, and the path's index."""
        # The paths to each point's hit stand together: the first of them, and their number.
        starts = self.starts
        after = np.minimum(hit, starts.size - 2)
        first = starts[after]
        count = starts[after + 1] - first
        if (count == 1).all():
            return np.arange(hit.size), first

        # Each point as often as it has paths, and the paths counted on from the first.
        which = np.repeat(np.arange(hit.size), count)
        within = np.arange(which.size) - np.repeat(np.cumsum(count) - count, count)
        return which, first[which] + within


NOWHERE = Paths(np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64), np.empty(0), ())
"""No path at all."""


@dataclass(frozen=True, eq=False)
class Passing:
    """Paths continued along the rays of a branch by one term of a formula.

    Parameters
    ----------
    met
        The reflectances in the term.
    ray, path
        For each entry the ray of the branch, and the path that it continues.
    value
        The number that the continued path carries.
    vanished
        True where the value is zero only because a product of numbers that are not zero underflowed.
    """

    met: Monomial
    ray: Index
    path: Index
    value: Float[np.ndarray, " entry"]
    vanished: Bool[np.ndarray, " entry"]


def ends(program: Program, tree: RayTree, product: Product) -> Iterator[Lighted | Glowing | Lost]:
    """The ends of all paths, level by level from the eye."""
    paths = from_the_eye(tree.levels[0], tree.film) if tree.levels else NOWHERE
    for level, below in zip_longest(tree.levels, tree.levels[1:]):
        # Light that reaches the eye from this level, and light of rays that were cut off there.
        pixel = tree.film.row[level.sample]
        yield from _told(_lights(level, paths, pixel), level, tree.paths)
        for branch in level.cut:
            for part in passing(program, level, branch, paths):
                value = np.where(part.vanished, VANISHED, np.abs(part.value))
                yield _lost(part, value, paths, pixel, branch)
        if below is None:
            return

        # The paths on to the level below; those whose numbers underflowed to zero on the way are lost.
        parts = [list(passing(program, level, branch, paths)) for branch in below.branches]
        for branch, of_branch in zip(below.branches, parts, strict=True):
            for part in of_branch:
                if part.vanished.any():
                    yield _lost(part, np.where(part.vanished, VANISHED, 0.0), paths, pixel, branch)
        paths = continued(below, parts, paths, product)


def _lights(level: Level, paths: Paths, pixel: Int[np.ndarray, " hit"]) -> Iterator[Lighted | Glowing]:
    """Paths that end at a level where a light reaches a point, or a hit glows."""
    for points in level.points:
        for lit in points.lit:
            yield Lighted(points, lit, _lighted(points, lit, paths, pixel), bounded=False)
        for lit in points.cut:
            yield Lighted(points, lit, _lighted(points, lit, paths, pixel), bounded=True)
    for emitted in level.emitted:
        yield Glowing(emitted.light, emitted.hit, _pairs(emitted.hit, emitted.radiance, paths, pixel), bounded=False)
    for emitted in level.unlit:
        yield Glowing(emitted.light, emitted.hit, _pairs(emitted.hit, emitted.radiance, paths, pixel), bounded=True)


def _told(found: Iterator[Lighted | Glowing], level: Level, paths: int) -> Iterator[Lighted | Glowing]:
    """The ends of paths with what they gathered, where any did."""
    if level.gathered is None or level.path is None:
        yield from found
        return
    # Each half's mean counts for half of the whole: of 7 paths the first 3 for 7/6 each, the others for 7/8.
    first = paths // 2
    sizes = np.array([paths / (2 * first) if first else 0.0, -paths / (2 * (paths - first)) if first else 0.0])
    half = np.where(level.gathered > 0, sizes[(level.path >= first).astype(np.int64)], 0.0)
    for end in found:
        hit = end.points.hit[end.lit.point] if isinstance(end, Lighted) else end.hit
        hit = hit[end.pairs.which]
        yield replace(end, pairs=replace(end.pairs, gathered=level.gathered[hit], half=half[hit]))


def _lighted(points: Points, lit: Lit, paths: Paths, pixel: Int[np.ndarray, " hit"]) -> Pairs:
    """Pairs of a path and of a point that a light's sample reaches."""
    arriving = points.weight[lit.point] * lit.irradiance * lit.visible
    return _pairs(points.hit[lit.point], arriving, paths, pixel)


def _pairs(
    hit: Int[np.ndarray, " thing"], value: Float[np.ndarray, " thing"], paths: Paths, pixel: Int[np.ndarray, " hit"]
) -> Pairs:
    """Pairs of a path and of a thing at the hit where it ends."""
    kernels = fast.kernels("symrt.linear.fast.gathering", hit.size)
    if kernels and value.dtype == np.float64:
        which, product, on = np.empty((3, kernels.count(hit, paths.starts)), np.int64)
        carried = np.empty(which.size)
        along = paths.starts, paths.product, paths.coefficient
        kernels.pairs(hit, value, *along, pixel, which, product, on, carried)
    else:
        which, path = paths.to(hit)
        product, on, carried = paths.product[path], pixel[hit][which], paths.coefficient[path] * value[which]
    inside = {name: length[hit][which] for name, length in paths.inside.items()}
    window = None if paths.window is None else paths.window[hit][which]
    return Pairs(which, product, on, carried, paths.products, inside, window)


def _lost(
    part: Passing, value: Float[np.ndarray, " entry"], paths: Paths, pixel: Int[np.ndarray, " hit"], branch: Branch
) -> Lost:
    """Paths that were continued along a branch, and end at the hits that its rays left from."""
    some = np.flatnonzero(value)
    ray = part.ray[some]
    hit = branch.parent[ray]
    inside = {name: length[hit] for name, length in paths.inside.items()}
    # A ray may be split off into a window where it starts.
    window = None if paths.window is None else paths.window[hit] if branch.window is None else branch.window[ray]
    pairs = Pairs(ray, paths.product[part.path[some]], pixel[hit], value[some], paths.products, inside, window)
    return Lost(part.met, pairs)


def from_the_eye(level: Level, film: Film) -> Paths:
    """The paths to the camera's hits: nothing met yet, each with its sample's weight."""
    size = level.size
    product, weight = np.zeros(size, dtype=np.int64), film.weight[level.sample]
    return Paths(np.arange(size), product, weight, ((),), level.inside, level.window)


def passing(program: Program, level: Level, branch: Branch, paths: Paths) -> Iterator[Passing]:
    """Continue paths along a branch, by material and by term."""
    for points in level.points:
        compiled = program.compiled[points.material][branch.via]
        if not compiled.terms or not branch.sent_by(points):
            continue
        if free := sorted({parameter for _, nodes in compiled.terms for parameter, _ in nodes}):
            raise ValueError(
                f"{free[0]} cannot stay free: rays are sent on by the formula {branch.via}, whose paths keep no nodes; "
                "give it a value instead"
            )

        # The branch's rays that leave from points of this material.
        point_of = np.full(level.size, -1)
        point_of[points.hit] = np.arange(points.hit.size)
        ray = np.flatnonzero(point_of[branch.parent] >= 0)
        point = point_of[branch.parent[ray]]

        # The formula there, and the paths that it continues.
        factors = {name: values[point] for name, values in points.view.items()}
        factors |= {name: values[ray] for name, values in branch.factors.items()}
        share = points.weight[point] * branch.weight[ray]
        which, path = paths.to(points.hit[point])
        carried = paths.coefficient[path] * share[which]
        for (met, _), c in zip(compiled.terms, compiled.coefficients(factors, ray.size), strict=True):
            value = carried * c[which]
            vanished = (value == 0) & (c[which] != 0) & (share[which] != 0)
            yield Passing(met, ray[which], path, value, vanished)


def continued(below: Level, parts: Sequence[Sequence[Passing]], paths: Paths, product: Product) -> Paths:
    """The paths to the hits of the level below, gathered from those continued along each of its branches."""
    # Number hits along the branches, and products as they turn up; paths that carry nothing are dropped.
    numbered: dict[Monomial, int] = {}
    hit, number, coefficient = [], [], []
    first = 0
    for branch, of_branch in zip(below.branches, parts, strict=True):
        for part in of_branch:
            present = np.flatnonzero(part.value)
            renumbered = [numbered.setdefault(product(path, part.met), len(numbered)) for path in paths.products]
            hit.append(first + part.ray[present])
            number.append(np.array(renumbered, dtype=np.int64)[paths.product[part.path[present]]])
            coefficient.append(part.value[present])
        first += branch.size
    if not hit:
        return NOWHERE

    # Sort paths by hit, those of one hit in the order in which they were found.
    order = np.argsort(np.concatenate(hit), kind="stable")
    hits, numbers, values = (np.concatenate(found)[order] for found in (hit, number, coefficient))
    inside = _lengthened(paths.inside, below)
    return _merged(Paths(hits, numbers, values, tuple(numbered), inside, below.window))


def _lengthened(before: Inside, below: Level) -> Inside:
    """Lengths to the hits of the level below: those to the hits that its rays left from, and what they went since."""
    names = sorted({*before, *below.inside})
    if not names:
        return {}
    parent = np.concatenate([branch.parent for branch in below.branches])
    nothing = np.zeros(below.size)
    return {
        name: (before[name][parent] if name in before else nothing) + below.inside.get(name, nothing) for name in names
    }


def _merged(paths: Paths) -> Paths:
    """Add up paths that lead to one hit by one product, whose number would otherwise double at each bounce."""
    key = paths.hit * len(paths.products) + paths.product
    _, first, same = np.unique(key, return_index=True, return_inverse=True)
    if first.size == key.size:
        return paths

    # Sums run in the order in which paths were found, which is the same in every tile.
    order = np.argsort(first)
    total = np.bincount(same, weights=paths.coefficient)[order]
    return replace(paths, hit=paths.hit[first[order]], product=paths.product[first[order]], coefficient=total)
