"""The SymPy expression of one pixel, built from the tree that the numbers came from (step 1).

A hit sends on ``Σ weight · (Σ light · irradiance · visible · direct + Σ light · ambient + reflected · next hit)``.
"""

from dataclasses import dataclass, field

import numpy as np
import sympy

from symrt.reflection.symbols import Factor, Light, Parameter, Reflectance
from symrt.tracing.raytree import Lit, Points, RayTree

DEEPEST = 65
"""Levels of a tree whose pixels are written in letters: each is nested in the one before, and printing recurses."""


@dataclass(frozen=True, eq=False)
class Letters:
    """The letters of one pixel's formula and their values; two places never share a letter."""

    values: dict[str, float] = field(default_factory=dict)
    places: dict[tuple[str, str], str] = field(default_factory=dict)

    def letter(self, stem: str, place: str, value: float) -> Factor:
        """The factor `stem` at `place`, ``n_dot_l`` at ``sun_2``, whose value is kept."""
        name = self.places.get((stem, place))
        if name is None:
            name = f"{stem}_{place}" if place else stem
            while name in self.values:
                name += "_"
            self.places[stem, place] = name
        self.values[name] = float(value)
        return Factor(name)


def tree_expression(tree: RayTree, pixel: int) -> tuple[sympy.Expr, dict[str, float]]:
    """Radiance of a pixel in lights, reflectances and geometric letters, and the letters' values."""
    if len(tree.levels) > DEEPEST:
        raise ValueError(
            f"{len(tree.levels) - 1} bounces are too many for one formula in letters, at most {DEEPEST - 1} nest; "
            "ask for the linear form, formula(collapse(tree), x, y), or trace with a smaller depth"
        )
    letters = Letters()
    if not tree.levels:
        return sympy.Integer(0), {}
    samples = np.flatnonzero(tree.film.pixel == pixel)
    squared = samples.size
    hits = np.flatnonzero(tree.film.pixel[tree.levels[0].sample] == pixel)
    radiances = []
    for hit in hits:
        sample = int(tree.levels[0].sample[hit]) - int(samples[0])
        radiances.append(_radiance(tree, 0, int(hit), f"s{sample}" if squared > 1 else "", letters))
    return sympy.Add(*radiances) / squared, letters.values


def _radiance(tree: RayTree, depth: int, hit: int, sample: str, letters: Letters) -> sympy.Expr:
    level = tree.levels[depth]
    place = "_".join(part for part in (str(depth + 1) if depth else "", sample) if part)
    total = []
    for points in level.points:
        for point in np.flatnonzero(points.hit == hit):
            weight = float(points.weight[point])
            share = letters.letter(f"weight_{points.material.replace('>', '_')}", place, weight) if weight != 1 else 1
            total.append(share * _sent(tree, depth, points, int(point), sample, place, letters))
    return sympy.Add(*total)


def _sent(
    tree: RayTree, depth: int, points: Points, point: int, sample: str, place: str, letters: Letters
) -> sympy.Expr:
    """What one material sends to the viewer from one point."""
    bound = _bindings(tree, points)
    view = {Factor(k): letters.letter(k, place, values[point]) for k, values in points.view.items()}
    formulas = tree.materials[points.material].model.formulas
    total = [
        light * factor * formulas["direct"].xreplace(bound | view | at_light)
        for lit in points.lit
        if lit.via == "direct"
        for light, factor, at_light in _arriving(tree, lit, point, place, letters)
    ]
    total += [
        Light(light) * formulas["ambient"].xreplace(bound | view)
        for light, record in tree.lights.items()
        if record.via == "ambient"
    ]
    below = _child(tree, depth, int(points.hit[point])) if formulas["reflected"] != 0 else None
    if below is not None:
        total.append(formulas["reflected"].xreplace(bound | view) * _radiance(tree, depth + 1, below, sample, letters))
    return sympy.Add(*total)


def _arriving(
    tree: RayTree, lit: Lit, point: int, place: str, letters: Letters
) -> list[tuple[Light, sympy.Expr, dict[sympy.Expr, sympy.Expr]]]:
    """The light, what of it arrives, and its cosines; nothing where it is behind the surface."""
    found = np.flatnonzero(lit.point == point)
    if not found.size:
        return []
    k = int(found[0])
    several = sum(light.via == "direct" for light in tree.lights.values()) > 1
    where = "_".join(part for part in (lit.light if several else "", place) if part)
    arriving = sympy.Integer(1)
    if lit.irradiance[k] != 1:
        arriving *= letters.letter("irradiance", where, lit.irradiance[k])
    if tree.rays.get("shadows"):
        arriving *= letters.letter("visible", where, lit.visible[k])
    cosines = {Factor(name): letters.letter(name, where, values[k]) for name, values in lit.factors.items()}
    return [(Light(lit.light), arriving, cosines)]


def _bindings(tree: RayTree, points: Points) -> dict[sympy.Expr, sympy.Expr]:
    record = tree.materials[points.material]
    components = {Reflectance(c): Reflectance(f"{points.material}.{c}") for c in record.model.components}
    return components | {Parameter(name): number(value) for name, value in record.parameters.items()}


def number(value: float) -> sympy.Expr:
    """A float as SymPy's own, whole ones as integers: 60, not 60.0; the value is the same."""
    value = float(value)
    return sympy.Integer(int(value)) if value.is_integer() else sympy.Float(value)


def _child(tree: RayTree, depth: int, hit: int) -> int | None:
    if depth + 1 >= len(tree.levels):
        return None
    found = np.flatnonzero(tree.levels[depth + 1].branches[0].parent == hit)
    return int(found[0]) if found.size else None
