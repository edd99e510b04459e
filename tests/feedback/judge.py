"""What an image is with some scales, and how good that is: from G and the palette alone, for oracles of the feedback.

Nothing here comes from `symrt.feedback`: products of spectra, powers of scales, merits and random scales that are
really inside are computed anew, for many points at a time.  Points are arrays (point × scale), in the order of the
names.
"""

from dataclasses import dataclass

import numpy as np

from symrt.spectra.display import luminance_weights

TILE = 64
"""Points that are shaded at a time."""
HALVINGS = 14
"""Of a line, which find its last feasible point to 6e-5 of it: near enough to catch what is better by more."""


@dataclass(frozen=True, eq=False)
class Judge:
    """The object pixels of an image under scales of materials, components or lights, seen against the key light."""

    names: tuple[str, ...]
    weights: np.ndarray  # (pixel, interaction)
    products: np.ndarray  # (interaction, band), for a reference white of 1
    degrees: np.ndarray  # (interaction, scale)
    upper: np.ndarray  # (band,)
    luminance: np.ndarray  # (band,)
    pixels: np.ndarray  # their numbers in the picture

    def factors(self, points):
        """What multiplies each interaction, (point × interaction)."""
        return np.exp(np.log(points) @ self.degrees.T)

    def shares(self, points):
        """Each pixel's largest share of an upper bound, (point × pixel); 0 where it is below 1 at all of the points."""
        products = self.products / self.upper

        def shaded(factors, weights):
            terms = (weights * factors[:, None, :]).reshape(-1, weights.shape[1])
            return (terms @ products).max(axis=1).reshape(len(factors), -1)

        # Nothing gets darker as scales rise.
        near = shaded(self.factors(np.max(points, axis=0, keepdims=True)), self.weights)[0] > 1 - 1e-6
        factors, weights, found = self.factors(points), self.weights[near], np.zeros((len(points), len(near)))
        for k in range(0, len(points), TILE):
            found[k : k + TILE, near] = shaded(factors[k : k + TILE], weights)
        return found

    def outside(self, points, rounding=0.0):
        """Whether each pixel is above an upper bound, (point × pixel)."""
        return self.shares(points) > 1 + rounding

    def light(self, points):
        """Luminances of the pixels, (point × pixel)."""
        return (self.factors(points) * (self.products @ self.luminance)) @ self.weights.T

    def point(self, values):
        """The scales of an answer, (1 × scale)."""
        return np.array([[values[name] for name in self.names]])


def judge(image, colours, upper, scales, exposure=1.0):
    """An image, dense."""
    names = tuple(sorted(scale.name for scale in scales))
    white = image.white["key"] * colours["key"]
    mets = [(i.light, *i.met) for i in image.interactions]
    products = np.array([np.prod([colours[n] for n in met], axis=0) for met in mets]) * exposure / white
    degrees = np.array([[sum(name in (n, n.partition(".")[0]) for n in met) for name in names] for met in mets])
    weights = image.G.toarray()
    pixels = np.flatnonzero((weights != 0).any(axis=1))
    luminance = luminance_weights(colours.bands) * white
    return Judge(names, weights[pixels], products, degrees, upper, luminance / luminance.sum(), pixels)


def merit(goal, points, judged, pairs=()):
    """What an objective wants large, first column first, (point × column)."""
    change = np.sum(np.log(points) ** 2, axis=1)
    if goal == "lightest":
        return np.sort(points, axis=1)
    if goal == "darkest":
        return np.sort(-points, axis=1)
    if goal == "closest":
        return -change[:, None]
    if goal == "lexicographic":
        return np.column_stack([np.minimum(1.0, points.min(axis=1)), -change])
    light = judged.light(points)
    if goal == "brightest":
        return light.mean(axis=1)[:, None]
    return np.min([np.log(light[:, a].mean(axis=1) / light[:, b].mean(axis=1)) for a, b in pairs], axis=0)[:, None]


def better(merits, than, rounding=1e-9):
    """Whether each of some merits is larger than another: the first column that differs by more than rounding says."""
    apart = merits - than
    told = np.abs(apart) > rounding * np.abs(than)
    first = np.take_along_axis(apart, told.argmax(axis=1)[:, None], axis=1)[:, 0]
    return told.any(axis=1) & (first > 0)


def extremes(judged):
    """The lightest and the darkest twentieth of the image given, as a pair of regions."""
    light = judged.light(np.ones((1, len(judged.names))))[0]
    low, high = np.percentile(light, (5, 95))
    return [(light >= high, light <= low)]


def shared(judged, within, budget=0):
    """The largest factor that all scales may share with no more than a budget of pixels outside, by halving."""
    low, high = np.log(within)
    for _ in range(60):
        middle = (low + high) / 2
        inside = judged.outside(np.full((1, len(judged.names)), np.exp(middle))).sum() <= budget
        low, high = (middle, high) if inside else (low, middle)
    return float(np.exp(low))


def around(point, within, count, sizes=(1e-3, 0.3), seed=0):
    """Random scales around a point, some near, some far."""
    random = np.random.default_rng(seed)
    size = np.exp(random.uniform(*np.log(sizes), (count, 1)))
    return np.clip(point * np.exp(random.normal(0, 1, (count, point.shape[1])) * size), *within)


def drawn_back(points, anchor, feasible):
    """The points drawn towards one that is feasible, in logarithms, until they are: on the edge of what is."""
    near, far = np.zeros((len(points), 1)), np.ones((len(points), 1))
    near[feasible(points)] = 1.0
    for _ in range(HALVINGS):
        middle = (near + far) / 2
        inside = feasible(anchor ** (1 - middle) * points**middle)[:, None]
        near, far = np.where(inside, middle, near), np.where(inside, far, middle)
    return anchor ** (1 - near) * points**near
