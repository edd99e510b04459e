"""The SymPy expression of one pixel, built from the tree that the numbers came from (step 1).

A hit sends on ``Σ weight · (Σ light · irradiance · visible · direct + Σ light · ambient + Σ formula · next hit)``, the
last sum over the rays that it sends on, each by one formula of its material.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import sympy

from symrt.reflection.models import LIT
from symrt.reflection.symbols import Factor, Hat, Light, Ordered, Parameter, Reflectance
from symrt.symbols import Surface, named
from symrt.tracing.raytree import Branch, Emitted, Level, Lit, Points, RayTree

DEEPEST = 65
"""Most levels of a tree whose pixels are written in letters: each nests in the one before, and printing recurses."""


@dataclass(frozen=True, eq=False)
class Letters:
    """The letters of one pixel's formula and their values; two places never share a letter.

    The places are kept as they were told, in parts: the light ``sun`` one bounce deep and the light ``sun_2`` at the
    eye would read alike.  `alike` has, for each letter of a film sample, the letter without the sample's mark.
    """

    values: dict[str, float] = field(default_factory=dict)
    places: dict[tuple[str, ...], str] = field(default_factory=dict)
    alike: dict[str, str] = field(default_factory=dict)

    def letter(self, stem: str, value: float, *place: str) -> Factor:
        """Name the factor `stem` at a place, such as ``n_dot_l`` at ``sun`` and ``2``, and keep its value."""
        name = self.places.get((stem, *place))
        if name is None:
            name = "_".join(part for part in (stem, *place) if part)
            while name in self.values:
                name += "_"
            self.places[stem, *place] = name
            # A place closes with its sample, where there are several.
            bare = (stem, *place[:-1], re.sub(r"(^|_)s\d+$", "", place[-1]) if place else "")
            self.alike[name] = "_".join(part for part in bare if part)
        self.values[name] = float(value)
        return Factor(name)


@dataclass(frozen=True)
class Place:
    """The place of a letter in a tree: the film sample, the number of rays to it, and the branches they took.

    Parameters
    ----------
    trail
        A mark for each ray where a hit sends on several, ``rt`` for a reflected and then a transmitted one; empty
        where there is no choice.
    """

    depth: int = 0
    trail: str = ""
    sample: str = ""

    def __str__(self) -> str:
        here = f"{self.depth + 1}{self.trail}" if self.depth else ""
        return "_".join(part for part in (here, self.sample) if part)

    def beyond(self, mark: str) -> "Place":
        """The place one ray further."""
        return Place(self.depth + 1, self.trail + mark, self.sample)


def tree_expression(tree: RayTree, pixel: int) -> tuple[sympy.Expr, Letters]:
    """The radiance of a pixel in lights, reflectances and geometric letters, and the letters."""
    if len(tree.levels) > DEEPEST:
        raise ValueError(
            f"{len(tree.levels) - 1} bounces are too many for one formula in letters, at most {DEEPEST - 1} nest; "
            "ask for the linear form, formula(collapse(tree), x, y), or trace with a smaller depth"
        )
    letters = Letters()
    if not tree.levels:
        return sympy.Integer(0), letters

    # Each of the pixel's film samples that met something.
    samples = np.flatnonzero(tree.film.pixel == pixel)
    weights = tree.film.weight[samples]
    radiances = []
    for hit in np.flatnonzero(tree.film.pixel[tree.levels[0].sample] == pixel):
        which = int(tree.levels[0].sample[hit]) - int(samples[0])
        place = Place(sample=f"s{which}" if samples.size > 1 else "")
        radiances.append((which, _radiance(tree, int(hit), place, letters)))

    # Samples that count alike are averaged; others come with their weights.
    if np.all(weights == 1 / samples.size):
        return sympy.Add(*(radiance for _, radiance in radiances)) / samples.size, letters
    return sympy.Add(*(number(weights[k]) * radiance for k, radiance in radiances)), letters


def _radiance(tree: RayTree, hit: int, place: Place, letters: Letters) -> sympy.Expr:
    """The radiance from a hit: that of each of its materials, and that which lights send by themselves.

    Absorbing glass on the way from the hit before leaves it a power of its transmittance.
    """
    level = tree.levels[place.depth]

    # Each material with its share, where the hit has several.
    total = []
    for points in level.points:
        for point in np.flatnonzero(points.hit == hit):
            weight, surface = float(points.weight[point]), Surface.of(points.material)
            other = surface.material if surface.alternative else ""
            share = letters.letter("weight", weight, surface.place, other, str(place)) if weight != 1 else 1
            total.append(share * _sent_by_material(tree, points, int(point), place, letters))

    # Lights that shine from the hit.
    for emitted in level.emitted:
        where = (emitted.light if len(level.emitted) > 1 else "", _numbered(emitted, level.emitted), str(place))
        for radiance in emitted.radiance[emitted.hit == hit].tolist():
            # A radiance of exactly 1 is not written, and one of 0 not seen.
            share = letters.letter("radiance", radiance, *where) if radiance not in (0, 1) else number(radiance)
            total.append(Light(emitted.light) * share)

    # The glass that the ray to the hit went through.
    left = [
        _kind(tree)(name) ** letters.letter("d", length[hit], str(place))
        for name, length in level.inside.items()
        if length[hit] > 0 and "absorption" in tree.plan
    ]
    return sympy.Mul(sympy.Add(*total), *left)


def _sent_by_material(tree: RayTree, points: Points, point: int, place: Place, letters: Letters) -> sympy.Expr:
    """The radiance that one material sends to the viewer from one point."""
    # Components and parameters of the material, and the factors that depend on the viewer only.
    bound = _bindings(tree, points)
    view = {Factor(k): letters.letter(k, values[point], str(place)) for k, values in points.view.items()}
    formulas = tree.materials[points.material].model.formulas

    # The light that arrives at it.
    total = [
        light * factor * formulas[lit.via].xreplace(bound | view | at_light)
        for lit in points.lit
        for light, factor, at_light in _arriving(tree, points, lit, point, place, letters)
    ]

    # The radiance that further rays bring; what many paths gather is told by its sums.
    paths: dict[str, list[tuple[float, int]]] = {}
    for mark, branch, ray, below in _rays(tree, place.depth, int(points.hit[point])):
        formula = formulas[branch.via]
        if formula != 0 and branch.sent_by(points):
            if tree.paths and branch.via in LIT:
                paths.setdefault(branch.via, []).append((float(branch.weight[ray]), below))
                continue
            beyond = place.beyond(mark)
            # The ray's cosines belong to the hit it leaves from; where it ends a light has cosines of the same names.
            own = {Factor(k): letters.letter(k, values[ray], "to", str(beyond)) for k, values in branch.factors.items()}
            weight = float(branch.weight[ray])
            share = letters.letter("weight", weight, "", str(beyond)) if weight != 1 else 1
            share *= _window(tree, branch, ray, tree.levels[place.depth])
            # Light meets what lies further from the eye first.
            total.append(share * _radiance(tree, below, beyond, letters) * formula.xreplace(bound | view | own))
    for via, rays in paths.items():
        total.append(_gathered(tree, rays, place, letters) * formulas[via].xreplace(bound | view))
    return sympy.Add(*total)


def _gathered(tree: RayTree, rays: Sequence[tuple[float, int]], place: Place, letters: Letters) -> sympy.Expr:
    """The radiance that paths bring together: for each product of spectra a letter ``E``, the largest first."""
    found: dict[sympy.Expr, float] = {}
    for weight, below in rays:
        own = Letters()
        brought = _radiance(tree, below, place.beyond("a"), own)
        known = {Factor(name): sympy.Float(value) for name, value in own.values.items()} | {
            sympy.pi: sympy.Float(np.pi)
        }
        for product, sum_ in sympy.expand(brought.xreplace(known)).as_coefficients_dict().items():
            # Numbers that are no rational ones stand in the product.
            c, spectra = product.as_coeff_Mul()
            found[spectra] = found.get(spectra, 0.0) + weight * float(sum_ * c)
    order = sorted(((spectra, c) for spectra, c in found.items() if c), key=lambda pair: (-abs(pair[1]), str(pair[0])))
    return sympy.Add(*(spectra * letters.letter("E", c, str(k), str(place)) for k, (spectra, c) in enumerate(order, 1)))


def _window(tree: RayTree, branch: Branch, ray: int, level: Level) -> sympy.Expr:
    """The window of wavelengths that a ray is split off into, or 1 where it is of what its parent is of."""
    if branch.window is None or level.window is None or level.window[branch.parent[ray]] >= 0:
        return sympy.Integer(1)
    return Hat(str(tree.windows[branch.window[ray]]))


def _rays(tree: RayTree, depth: int, hit: int) -> list[tuple[str, Branch, int, int]]:
    """The rays that a hit sends on: a mark, the branch, the ray in it, and the hit on the level below that it met.

    Where the whole level has one branch and every hit sends one ray at most, there is nothing to tell apart.
    """
    if depth + 1 >= len(tree.levels):
        return []
    branches = tree.levels[depth + 1].branches
    alone = len(branches) == 1 and np.unique(branches[0].parent).size == branches[0].size

    # A mark is the first letter of the formula; branches and rays that would share one are numbered.
    found, first = [], 0
    for k, branch in enumerate(branches):
        like = [other for other in branches if other.via[0] == branch.via[0]]
        mark = branch.via[0]
        if len(like) > 1:
            mark += str(1 + sum(other.via[0] == mark for other in branches[:k]))
        rays = np.flatnonzero(branch.parent == hit).tolist()
        for which, ray in enumerate(rays, start=1):
            several = f"{mark}{'_' if len(like) > 1 else ''}{which}" if len(rays) > 1 else mark
            if branch.window is not None and len(rays) > 1:
                several = f"{mark}w{branch.window[ray] + 1}"
            found.append(("" if alone else several, branch, ray, first + ray))
        # Hits of the level below are numbered along its branches.
        first += branch.size
    return found


def _arriving(
    tree: RayTree, points: Points, lit: Lit, point: int, place: Place, letters: Letters
) -> list[tuple[Light, sympy.Expr, dict[sympy.Expr, sympy.Expr]]]:
    """The light, the share of it that arrives, and its cosines; empty where it is behind the surface."""
    found = np.flatnonzero(lit.point == point)
    if not found.size:
        return []
    if lit.via != "direct":
        return [(Light(lit.light), sympy.Integer(1), {})]
    k = int(found[0])

    # A light alone needs no name, and one that reaches the point once no number.
    several = sum(light.via == "direct" for light in tree.lights.values()) > 1
    where = (lit.light if several else "", _numbered(lit, points.lit), str(place))

    # An irradiance of exactly 1 is not written; visibility is always a letter where shadows are simulated.
    arriving = sympy.Integer(1)
    if lit.irradiance[k] != 1:
        arriving *= letters.letter("irradiance", lit.irradiance[k], *where)
    if "shadows" in tree.plan or lit.error is not None:
        arriving *= letters.letter("visible", lit.visible[k], *where)
    cosines = {Factor(name): letters.letter(name, values[k], *where) for name, values in lit.factors.items()}
    return [(Light(lit.light), arriving, cosines)]


def _numbered(one: Lit | Emitted, among: Sequence[Lit] | Sequence[Emitted]) -> str:
    """The mark ``l2`` of the second of several parts of one light; a part alone has none."""
    like = [other is one for other in among if other.light == one.light]
    return f"l{like.index(True) + 1}" if len(like) > 1 else ""


def _kind(tree: RayTree) -> type[Reflectance]:
    """The kind of all reflectances: with a fluorescent material in the scene, none may change places with its own."""
    return Ordered if any(record.model.fluorescent for record in tree.materials.values()) else Reflectance


def _bindings(tree: RayTree, points: Points) -> dict[sympy.Expr, sympy.Expr]:
    record = tree.materials[points.material]
    components = {Reflectance(c): _kind(tree)(named(points.material, c)) for c in record.model.components}
    return components | {Parameter(name): number(value) for name, value in record.parameters.items()}


def number(value: float) -> sympy.Expr:
    """A float as a SymPy number of the same value, whole ones as integers: 60, not 60.0."""
    value = float(value)
    return sympy.Integer(int(value)) if value.is_integer() else sympy.Float(value)
