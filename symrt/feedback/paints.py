"""The values of a blend of paints that each pixel allows: step 5 of the paper, for Kubelka and Munk's mixtures.

A pixel is ``p_n(t) = Σ_i g_{n,i} Γ_i(t)``, where Γ_i(t) is a product of fixed spectra and of mixtures r(t).  Each r(t)
goes one way, so that over a piece of the range every product lies between those of the least and of the largest r: a
piece is inside if both images are, outside if both are beyond one bound, and is halved otherwise.  Where a pixel is
affine in one mixture, and each slab looks at one band, the bound's K/S gives the root ``t = (q* − q_a) / (q_b − q_a)``.
"""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int
from scipy import sparse

from symrt.feedback.along import along_ends
from symrt.feedback.bounds import Bound, Sizes, alike
from symrt.feedback.mixing import absorption, painted
from symrt.feedback.parameters import Ends
from symrt.feedback.polynomials import HALVINGS, joined, placed
from symrt.gamut.interface import ROUNDING
from symrt.gamut.looking import Spans
from symrt.spectra.bands import Number
from symrt.spectra.palette import Palette
from symrt.spectra.products import gamma
from symrt.symbols import Symbol
from symrt.system import LinearSystem

PIXELS_AT_ONCE = 2048
"""Pixels shaded and clipped at a time: their spectra stay in cache."""
ROUNDED = 16
"""Roundings that a mixture r(t) amounts to, of q_a, q_b, their sum, and r, which is less sensitive than q."""

Spectra = Float[np.ndarray, "_ band"]
Slabs = Float[np.ndarray, "row slab"]
Values = Float[np.ndarray, " row"]
Bounds = Float[np.ndarray, " slab"]
Pixels = Int[np.ndarray, " row"]


@dataclass(frozen=True, eq=False)
class Paints:
    """Every pixel along a blend of paints.

    Parameters
    ----------
    part
        The pixels, as a system.
    fixed
        For each interaction the product of its spectra that do not change.
    powers
        Number of times that each mixture occurs in it.
    first, last
        Each mixture at t = 0 and at t = 1.
    matrix
        The weights through which the pixels are seen.
    degrees
        The most mixtures in one interaction of each pixel.
    terms
        Numbers added and multiplied for a pixel, which bound its rounding.
    """

    part: LinearSystem
    fixed: Spectra
    powers: Int[np.ndarray, "_ mixture"]
    first: Float[np.ndarray, "mixture band"]
    last: Float[np.ndarray, "mixture band"]
    matrix: Float[np.ndarray, "band slab"]
    degrees: Int[np.ndarray, " pixel"]
    terms: int

    @property
    def touched(self) -> Bool[np.ndarray, " pixel"]:
        """Pixels that the blend changes."""
        return self.degrees > 0

    @property
    def signed(self) -> bool:
        """True if something is subtracted, so that sums may be smaller than their terms."""
        return bool(self.part.signed) or bool((self.matrix < 0).any())

    def seen(self, matrix: Float[np.ndarray, "band slab"], rows: Pixels) -> "Paints":
        """Some of the pixels, each spectrum times a matrix."""
        added = int((matrix != 0).sum(axis=0).max(initial=0))
        return replace(
            self,
            part=self.part.rows(rows),
            matrix=self.matrix @ matrix,
            degrees=self.degrees[rows],
            terms=self.terms + added,
        )

    def at(self, t: Number, rows: slice = slice(None)) -> Slabs:
        """The pixels at one value of the blend."""
        mixtures = painted(self.first, self.last, np.array([float(t)]))
        return self.part.times(self.products(mixtures)[0] @ self.matrix, rows)

    def points(self, rows: Pixels, t: Values) -> Slabs:
        """Some of the pixels, each at a value of its own."""
        return _image(self, rows, t, t)[0]

    def size(self, t: Number | Values, rows: slice) -> Sizes:  # noqa: ARG002  # as polynomials are asked
        """The largest sum of magnitudes in each of some pixels, at any t; one 0 where nothing cancels."""
        if not self.signed:
            return np.zeros((1, 1))
        most = self.products(np.maximum(self.first, self.last)[None])[0] @ abs(self.matrix)
        return (abs(self.part.G[rows]) @ most).max(axis=1, initial=0)[:, None]

    def products(self, mixtures: Float[np.ndarray, "value mixture band"]) -> Float[np.ndarray, "value _ band"]:
        """Γ for each of some values of all mixtures."""
        found = np.repeat(self.fixed[None], len(mixtures), axis=0)
        for m, column in enumerate(self.powers.T):
            for power in range(1, int(column.max(initial=0)) + 1):
                found[:, column >= power] *= mixtures[:, None, m]
        return found


def paints(system: LinearSystem, palette: Palette, ends: Mapping[str, Ends]) -> Paints:
    """Every pixel's radiance along a blend of paints, from each symbol's spectra at its ends.

    Examples
    --------
    >>> from symrt.spectra.bands import RGB
    >>> system = LinearSystem.of("2*key*sea.diffuse", white={"key": 1.0})
    >>> palette = Palette(RGB, {"key": 1.0, "sea.diffuse": 1.0})
    >>> found = paints(system, palette, {"sea.diffuse": (np.full(3, 1.0), np.full(3, 0.5))})
    >>> found.at(0.5).round(4)
    array([[1.2192, 1.2192, 1.2192]])
    """
    # As polynomials the pixels have other values between the ends, but the same degrees and as many terms.
    line = along_ends(system, palette, ends)

    # Part the spectra of each interaction into fixed ones, multiplied, and mixtures, counted.
    moving = [name for name, (first, last) in ends.items() if (first != last).any()]
    bands = len(palette.bands)
    _check_bands_apart(system, moving)
    still = [replace(i, met=tuple(name for name in i.met if name not in moving)) for i in system.interactions]
    fixed = gamma(still, palette)
    blocks = system.blocks(*([name] for name in moving))
    return Paints(
        part=replace(system, tail=None),
        fixed=fixed.reshape(-1, bands),
        powers=blocks.degrees[blocks.of],
        first=np.array([ends[name][0] for name in moving]).reshape(-1, bands),
        last=np.array([ends[name][1] for name in moving]).reshape(-1, bands),
        matrix=np.eye(bands),
        degrees=line.degrees,
        terms=line.terms + ROUNDED * int(line.degrees.max(initial=0)),
    )


def _check_bands_apart(system: LinearSystem, moving: Collection[str]) -> None:
    """Refuse interactions whose light moves between bands after it met a mixture, which is mixed band by band."""
    for interaction in system.interactions:
        met = [name in moving for name in interaction.met]
        first = met.index(True) if any(met) else len(met)
        if any(Symbol.of(name).fluorescent for name in interaction.met[first:]):
            raise ValueError(
                f"{interaction}: Kubelka and Munk's theory mixes bands one by one, and light moves between them behind "
                f"{interaction.met[first]}: mix 'linear'"
            )


def painted_intervals(line: Paints, bound: Bound, within: tuple[Number, Number]) -> Spans:
    """The parts of `within` that keep each row of `line`, already seen through the bound's matrix, inside.

    Rows that no value keeps inside do not occur in the result.
    """
    # Rows of about the same size have their bounds moved by as much.
    tiles = [Spans(np.zeros(0, dtype=int), np.zeros(0), np.zeros(0))]
    for start in range(0, len(line.degrees), PIXELS_AT_ONCE):
        rows = np.arange(start, min(start + PIXELS_AT_ONCE, len(line.degrees)))
        size = np.broadcast_to(_rows(line, rows).size(1.0, slice(None)), (len(rows), 1))
        for group, most in alike(size, bound):
            tile, room = _rows(line, rows[group]), _room(line, bound, most)
            # Solve the rows that allow it, and halve the range for the others.
            solved, rest = _solved(tile, room, within)
            halved = _halved(_rows(tile, rest), room, within)
            tiles += [
                solved._replace(pixel=rows[group[solved.pixel]]),
                halved._replace(pixel=rows[group[rest[halved.pixel]]]),
            ]

    pixel, low, high = (np.concatenate(column) for column in zip(*tiles, strict=True))
    order = np.lexsort((low, pixel))
    return Spans(pixel[order], low[order], high[order])


class _Room(NamedTuple):
    """Bounds to aim at, and bounds within which what is computed is certainly, or perhaps, inside."""

    aim: tuple[Bounds, Bounds]
    sure: tuple[Bounds, Bounds]
    perhaps: tuple[Bounds, Bounds]


def _room(line: Paints, bound: Bound, size: float) -> _Room:
    error = line.terms * ROUNDING

    def inward(times: float) -> tuple[Bounds, Bounds]:
        down, up = (np.where(np.isfinite(b), np.abs(b) + size, 0.0) for b in (bound.lower, bound.upper))
        return bound.lower + times * error * down, bound.upper - times * error * up

    return _Room(inward(2.0), inward(1.0), inward(-1.0))


def _rows(line: Paints, rows: Pixels) -> Paints:
    return replace(line, part=line.part.rows(rows), degrees=line.degrees[rows])


def _solved(line: Paints, room: _Room, within: tuple[Number, Number]) -> tuple[Spans, Pixels]:
    """Intervals of the rows that are affine in one mixture, and the rows that are not."""
    pixels = np.arange(len(line.degrees))
    found = [Spans(pixels[:0], np.zeros(0), np.zeros(0))]
    rest = np.ones(len(pixels), dtype=bool)
    if not line.signed and ((line.matrix != 0).sum(axis=0) == 1).all():
        sees = line.part.times(line.powers.astype(float)) > 0
        for m in range(len(line.first)):
            rows = np.flatnonzero((line.degrees == 1) & sees[:, m] & (sees.sum(axis=1) == 1))
            low, high, known = _roots(_rows(line, rows), m, room, within)
            rest[rows[known]] = False
            kept = known & (low <= high)
            found.append(Spans(rows[kept], low[kept], high[kept]))
    return Spans(*(np.concatenate(column) for column in zip(*found, strict=True))), pixels[rest]


def _roots(
    line: Paints, mixture: int, room: _Room, within: tuple[Number, Number]
) -> tuple[Values, Values, Bool[np.ndarray, " row"]]:
    """One interval for each row, and whether both its ends are certainly inside; empty ones are low > high."""
    # Part each row into a constant and a multiple of the mixture, band by band.
    order = line.powers.sum(axis=1)
    still, moving = (line.part.times(np.where((order == k)[:, None], line.fixed, 0) @ line.matrix) for k in (0, 1))
    band = line.matrix.argmax(axis=0)
    r0, r1 = line.first[mixture], line.last[mixture]
    a, b = r0[band], r1[band]

    # Slabs that do not change allow all of the range, or none.
    fixed = (moving == 0) | (a == b)
    inside = _between(still + moving * a, room.perhaps)
    low, high = np.full(len(still), float(within[0])), np.full(len(still), float(within[1]))
    high[(fixed & ~inside).any(axis=1)] = -np.inf

    # Solve for the t at which each slab meets its bound.
    with np.errstate(divide="ignore", invalid="ignore"):
        # A lower bound on a mixture that darkens ends its interval above, as an upper one on one that lightens.
        for limit, sign in zip(room.aim, (-1, 1), strict=True):
            met = (limit - still) / moving
            t = (absorption(np.clip(met, np.minimum(a, b), np.maximum(a, b))) - absorption(a)) / (
                absorption(b) - absorption(a)
            )
            never = ~fixed & (sign * met < np.minimum(sign * a, sign * b))
            some = ~fixed & ~never & (sign * met < np.maximum(sign * a, sign * b))
            above = sign * (b - a) > 0
            high = np.minimum(high, np.where(some & above, t, np.inf).min(axis=1, initial=np.inf))
            low = np.maximum(low, np.where(some & ~above, t, -np.inf).max(axis=1, initial=-np.inf))
            high[never.any(axis=1)] = -np.inf

    # Evaluate the ends once more: only those that are certainly inside are known.
    known = np.ones(len(low), dtype=bool)
    for t in (low, high):
        values = still + moving * painted(r0, r1, np.where(low <= high, t, 0.0))[:, band]
        known &= (low > high) | (fixed | _between(values, room.sure)).all(axis=1)
    return low, high, known


def _halved(line: Paints, room: _Room, within: tuple[Number, Number]) -> Spans:
    """Intervals of any rows, by halving the range where the images of its pieces leave the answer open."""
    low, high = float(within[0]), float(within[1])
    pixel = np.arange(len(line.degrees))
    start, found = np.zeros(len(pixel)), []
    # What does not change with t is not asked to keep away from its bounds.
    least, largest = _image(line, pixel, np.full(len(pixel), low), np.full(len(pixel), high))
    still = (least == largest) & _between(least, room.perhaps)

    for level in range(HALVINGS + 1):
        # Enclose each piece between two images, and judge it by them.
        width = 0.5**level
        least, largest = _image(line, pixel, placed(start, low, high), placed(start + width, low, high))
        passes = _between(least, room.aim) & _between(largest, room.aim)
        inside = (passes | still[pixel]).all(axis=1)
        outside = (((least > room.aim[1]) | (largest < room.aim[0])) & ~still[pixel]).any(axis=1)
        found.append((pixel[inside], start[inside], start[inside] + width))

        # Halve the pieces that are neither.
        open_ = ~(inside | outside)
        if not open_.any():
            break
        pixel, start = np.tile(pixel[open_], 2), np.concatenate([start[open_], start[open_] + width / 2])
    return joined(found, within)


def _image(line: Paints, pixel: Pixels, low: Values, high: Values) -> tuple[Slabs, Slabs]:
    """Bounds on some pixels while t is between `low` and `high`, which `low` determines."""
    # Each product lies between those of the least and of the largest mixtures.
    _, first, which = np.unique(low, return_index=True, return_inverse=True)
    ends = [painted(line.first, line.last, t[first]) for t in (low, high)]
    dark, light = (line.products(choose(*ends)) for choose in (np.minimum, np.maximum))
    plus, minus = np.maximum(line.matrix, 0), np.minimum(line.matrix, 0)
    least, largest = dark @ plus + light @ minus, light @ plus + dark @ minus

    # Negative coefficients take the other side.
    rows = line.part.G[pixel]
    # One row a piece, one column an interaction over one of the pieces of the range.
    column = np.repeat(which, np.diff(rows.indptr)) * rows.shape[1] + rows.indices
    found = []
    for below, above in ((least, largest), (largest, least)):
        products = [side.reshape(-1, line.matrix.shape[1]) for side in (below, above)]
        parts = [
            sparse.csr_array((part, column, rows.indptr), shape=(len(pixel), len(products[0])))
            for part in (np.maximum(rows.data, 0), np.minimum(rows.data, 0))
        ]
        found.append(parts[0] @ products[0] + (parts[1] @ products[1] if line.signed else 0.0))
    return found[0], found[1]


def _between(values: Slabs, bounds: tuple[Bounds, Bounds]) -> Bool[np.ndarray, "row slab"]:
    return (bounds[0] <= values) & (values <= bounds[1])
