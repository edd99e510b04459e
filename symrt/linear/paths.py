"""Paths from the eye through a tree of rays: where they end, the reflectances they met, and numbers (step 2)."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from symrt.linear.program import Program
from symrt.reflection.polynomials import Monomial
from symrt.tracing.raytree import Branch, Film, Level

Index = Int[np.ndarray, " entry"]
Product = Callable[[Monomial, Monomial], Monomial]
"""The product of the reflectances on a path and of those it meets next, further from the eye."""

VANISHED = np.finfo(float).tiny
"""A bound of products that underflowed to zero though none of their factors is zero."""


def commuting(path: Monomial, met: Monomial) -> Monomial:
    """The product of reflectances that commute, sorted so that their order does not matter."""
    return tuple(sorted(path + met))


def in_order(path: Monomial, met: Monomial) -> Monomial:
    """The product in the order in which light meets the reflectances, from the light to the eye."""
    return met + path


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
    """

    hit: Int[np.ndarray, " path"]
    product: Int[np.ndarray, " path"]
    coefficient: Float[np.ndarray, " path"]
    products: tuple[Monomial, ...]

    def to(self, hit: Int[np.ndarray, " point"]) -> tuple[Index, Index]:
        """Pairs of a point and a path that leads to it: the point's place in `hit`, and the path's index."""
        # The paths to each point's hit stand together: their number, and the first of them.
        size = int(max(self.hit.max(initial=-1), hit.max(initial=-1))) + 1
        count = np.bincount(self.hit, minlength=size)[hit]
        first = np.searchsorted(self.hit, hit)

        # Each point as often as it has paths, and the paths counted on from the first.
        which = np.repeat(np.arange(hit.size), count)
        within = np.arange(which.size) - np.repeat(np.cumsum(count) - count, count)
        return which, first[which] + within


NOWHERE = Paths(np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64), np.empty(0), ())
"""No path at all."""


def from_the_eye(level: Level, film: Film) -> Paths:
    """The paths to the camera's hits: nothing met yet, each with its sample's weight."""
    size = level.size
    return Paths(np.arange(size), np.zeros(size, dtype=np.int64), film.weight[level.sample], ((),))


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
    return _merged(Paths(hits, numbers, values, tuple(numbered)))


def _merged(paths: Paths) -> Paths:
    """Add up paths that lead to one hit by one product, whose number would otherwise double at each bounce."""
    key = paths.hit * len(paths.products) + paths.product
    _, first, same = np.unique(key, return_index=True, return_inverse=True)
    if first.size == key.size:
        return paths

    # Sums run in the order in which paths were found, which is the same in every tile.
    order = np.argsort(first)
    total = np.bincount(same, weights=paths.coefficient)[order]
    return Paths(paths.hit[first[order]], paths.product[first[order]], total, paths.products)
