"""Every pixel as a polynomial in one parameter: step 5 of the paper.

Scalars factor out of the products of spectra, so that a pixel is a polynomial in each parameter ``t`` whose
coefficients are spectra,

    p_n(t) = Σ_k t^k q_k        (a scale)        p_n(t) = Σ_k C(D, k) (1 − t)^(D−k) t^k b_k        (a blend)

of the total degree of what the parameter moves.  With g ≥ 0 no q_k and no b_k is negative: a scale moves every band
one way, and a blend stays between the least and the largest of its b_k (Bernstein's form).
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import comb
from typing import Literal

import numpy as np
from jaxtyping import Bool, Float, Int
from scipy import sparse

from symrt.feedback.bounds import Sizes
from symrt.feedback.parameters import Ends, Parameter, mixing_of, moved_ends
from symrt.interactions import Interaction
from symrt.spectra.bands import Number
from symrt.spectra.fluorescence import times
from symrt.spectra.hats import hats
from symrt.spectra.palette import Palette
from symrt.spectra.powers import power_of
from symrt.spectra.products import gamma
from symrt.symbols import Symbol
from symrt.system import LinearSystem

Gamma = Float[np.ndarray, "_ band"]


@dataclass(frozen=True, eq=False)
class Along:
    """Every pixel as a polynomial in one parameter.

    Parameters
    ----------
    form
        ``"power"``: Σ t^k q_k.  ``"bernstein"``: Σ C(D, k) (1 − t)^(D−k) t^k b_k.
    parts
        For each k the part of G and of Γ whose product is q_k or b_k.
    degrees
        Of each pixel's own polynomial.
    terms
        The most numbers that are added or multiplied for one coefficient, which bounds its rounding.
    signed
        True if some coefficient of G, or a weight through which the pixels are seen, is negative, so that they need
        not be monotone.
    sizes
        The parts with all signs dropped, where some are negative; rounding is a share of these.
    """

    form: Literal["power", "bernstein"]
    parts: tuple[tuple[sparse.csr_array, Gamma], ...]
    degrees: Int[np.ndarray, " pixel"]
    terms: int
    signed: bool
    sizes: tuple[tuple[sparse.csr_array, Gamma], ...] = ()

    @property
    def degree(self) -> int:
        """Degree of the polynomials."""
        return len(self.parts) - 1

    @property
    def touched(self) -> Bool[np.ndarray, " pixel"]:
        """Pixels that the parameter changes."""
        return self.degrees > 0

    def coefficients(self, rows: slice) -> Float[np.ndarray, "power pixel band"]:
        """The spectra q_k, or b_k, of some pixels."""
        taken = self._rows(rows)
        return np.stack([taken[id(G)] @ spectra for G, spectra in self.parts])

    def size(self, t: Number | Float[np.ndarray, " row"], rows: slice) -> Sizes:
        """The largest sum of magnitudes in each of some pixels, at any value up to t; one 0 where nothing cancels."""
        if not self.signed:
            return np.zeros((1, 1))
        sizes = np.stack([G[rows] @ spectra for G, spectra in self.sizes])
        if self.form == "bernstein":
            return sizes.max(axis=(0, 2), initial=0)[:, None]
        powers = np.reshape(t, (1, -1, 1)).astype(float) ** np.arange(len(sizes))[:, None, None]
        return (powers * sizes).sum(axis=0).max(axis=1, initial=0)[:, None]

    def at(self, t: Number, rows: slice = slice(None)) -> Float[np.ndarray, "pixel band"]:
        """The pixels at one value of the parameter."""
        k, degree = np.arange(self.degree + 1), self.degree
        weights = (
            t**k if self.form == "power" else np.array([comb(degree, j) for j in k]) * (1 - t) ** (degree - k) * t**k
        )
        # Parts that share a matrix are weighted before the product with it.
        mixed: dict[int, Gamma] = {}
        for weight, (part, spectra) in zip(weights.tolist(), self.parts, strict=True):
            mixed[id(part)] = mixed[id(part)] + weight * spectra if id(part) in mixed else weight * spectra
        taken = self._rows(rows)
        products = [taken[key] @ spectra for key, spectra in mixed.items()]
        return np.sum(products, axis=0) if len(products) > 1 else products[0]

    def seen(self, matrix: Float[np.ndarray, "band slab"], rows: Int[np.ndarray, " row"]) -> "Along":
        """Some of the pixels, each spectrum times a matrix."""
        taken = self._rows(rows)
        added = int((matrix != 0).sum(axis=0).max(initial=0))
        signed = self.signed or bool((matrix < 0).any())
        whole = {key: abs(G) for key, G in taken.items()} if signed else {}
        return replace(
            self,
            parts=tuple((taken[id(G)], spectra @ matrix) for G, spectra in self.parts),
            degrees=self.degrees[rows],
            terms=self.terms + added,
            signed=signed,
            sizes=tuple((whole[id(G)], abs(spectra) @ abs(matrix)) for G, spectra in self.parts if signed),
        )

    def taken(self, rows: Int[np.ndarray, " row"]) -> "Along":
        """Some of the pixels."""
        taken = self._rows(rows)
        return replace(
            self,
            parts=tuple((taken[id(G)], spectra) for G, spectra in self.parts),
            degrees=self.degrees[rows],
            sizes=tuple((G[rows], spectra) for G, spectra in self.sizes),
        )

    def brightest(self, t: Number, bounds: Float[np.ndarray, " slab"]) -> Float[np.ndarray, " pixel"]:
        """The share of its bounds that each pixel never passes, at any value up to t; for coefficients >= 0 only."""
        shares = [(spectra / bounds).max(axis=1, initial=0) for _, spectra in self.parts]
        if self.form == "bernstein":
            return self.parts[0][0] @ np.max(shares, axis=0)
        # Beyond all floats nothing is told to be inside.
        with np.errstate(over="ignore", invalid="ignore"):
            return np.sum(
                [np.float64(t) ** k * (G @ s) for k, ((G, _), s) in enumerate(zip(self.parts, shares, strict=True))],
                axis=0,
            )

    def _rows(self, rows: slice | Int[np.ndarray, " row"]) -> dict[int, sparse.csr_array]:
        """Rows of each part of G; a blend's parts are all of G, which is cut once."""
        parts = {id(G): G for G, _ in self.parts}
        if isinstance(rows, np.ndarray) and np.array_equal(rows, np.arange(len(self.degrees))):
            return parts
        return {key: G[rows] for key, G in parts.items()}


def along(system: LinearSystem, palette: Palette, parameter: Parameter) -> Along:
    """Every pixel's radiance as a polynomial in a parameter.

    Raises
    ------
    ValueError
        If nothing of the system has that name, if a blend's materials do not fit together, if the palette lacks a
        symbol, or if the system keeps a parameter of a model free.

    Examples
    --------
    Light that comes back from a mirror of brass to brass counts twice:

    >>> from symrt.feedback.parameters import Scale
    >>> from symrt.spectra.bands import RGB
    >>> system = LinearSystem.of("0.5*key*brass.diffuse + 0.25*key*brass.diffuse*brass.mirror", white={"key": 0.5})
    >>> palette = Palette(RGB, {"key": 1, "brass.diffuse": 0.5, "brass.mirror": 0.4})
    >>> along(system, palette, Scale("brass")).coefficients(slice(None))[:, 0, 0].tolist()
    [0.0, 0.25, 0.05]
    """
    if mixing_of(parameter) != "linear":
        raise ValueError(f"the {parameter}, makes no polynomials of the pixels: only a 'linear' blend is taken here")
    return along_ends(system, palette, moved_ends(system, palette, parameter))


def along_ends(system: LinearSystem, palette: Palette, ends: Mapping[str, Ends]) -> Along:
    """Every pixel as a polynomial in t when each of the symbols goes from its first spectrum to its last."""
    check_settled(system)

    # Expand Γ of every interaction in t; those that do not move keep theirs.
    given = gamma(system.interactions, palette)
    blocks = system.blocks(ends)
    degrees = blocks.degrees[blocks.of, 0]
    columns = [
        _product(i, palette, ends) if degree else product[None]
        for i, product, degree in zip(system.interactions, given, degrees.tolist(), strict=True)
    ]
    degree = int(degrees.max(initial=0))

    # From nothing it is a power of t; any other line is raised to the common degree, in Bernstein's form.
    power = all(not first.any() for first, _ in ends.values())
    chosen: list[np.ndarray] = [degrees == k if power else degrees >= 0 for k in range(degree + 1)]
    values = [c[-1:].repeat(degree + 1, axis=0) if power else _bernstein(c, degree) for c in columns]
    spectra = np.array(values).reshape(-1, degree + 1, len(palette.bands))

    # A line between equal spectra changes nothing.
    changing = (degrees > 0) & (spectra.any(axis=(1, 2)) if power else (spectra != spectra[:, :1]).any(axis=(1, 2)))
    return Along(
        form="power" if power else "bernstein",
        parts=tuple(
            (system.G if c.all() else system.G[:, np.flatnonzero(c)], spectra[c, k]) for k, c in enumerate(chosen)
        ),
        degrees=_degrees(system, np.where(changing, degrees, 0)),
        terms=int(system.term_counts.max(initial=0))
        + max((len(i.met) + 2 * len(i.powers) for i in system.interactions), default=0)
        + 8,
        signed=bool(system.signed),
    )


def _product(interaction: Interaction, palette: Palette, ends: Mapping[str, Ends]) -> Float[np.ndarray, "power band"]:
    """Γ of one interaction as Σ e_k (1 − t)^(D−k) t^k, with D the number of its symbols that move."""
    nothing = np.zeros((1, len(palette.bands)))
    product = np.ones((1, len(palette.bands)))
    for name in interaction.symbols:
        if name not in ends:
            # An alternative that the palette does not name is no part of the picture.
            product = times(product, palette[name]) if name in palette else product * 0.0
            continue
        first, last = ends[name]
        product = np.vstack([times(product, first), nothing]) + np.vstack([nothing, times(product, last)])
    # Glass and windows are next to the eye.
    for power in interaction.powers:
        product = product * power_of(palette, power)
    return product * hats([interaction], palette.bands)


def _bernstein(product: Float[np.ndarray, "power band"], degree: int) -> Float[np.ndarray, "raised band"]:
    """The same polynomial, times (1 − t + t)^m to bring it to `degree`, by its Bernstein coefficients b_k."""
    more = degree - len(product) + 1
    raised = np.zeros((degree + 1, product.shape[1]))
    for j, k in np.ndindex(len(product), more + 1):
        raised[j + k] += comb(more, k) * product[j]
    return raised / np.array([comb(degree, k) for k in range(degree + 1)])[:, None]


def _degrees(system: LinearSystem, columns: Int[np.ndarray, " interaction"]) -> Int[np.ndarray, " pixel"]:
    """The highest degree of the columns that each pixel has."""
    highest = np.zeros(system.height * system.width, dtype=int)
    for degree in range(1, int(columns.max(initial=0)) + 1):
        highest[system.pixels_of(columns == degree)] = degree
    return highest


def check_settled(system: LinearSystem) -> None:
    """Refuse a system that keeps a parameter of its formulas free.

    Examples
    --------
    >>> from symrt.interactions import Interaction
    >>> column = Interaction("sun", ("brass.specular",), (("brass.exponent", 0),))
    >>> check_settled(LinearSystem(sparse.csr_array([[0.5]]), (column,), 1, 1, {"sun": 1.0}))
    Traceback (most recent call last):
    ValueError: the system keeps brass.exponent free: give values, collapse(tree, values={…}), or system.at({…}), first
    """
    if free := sorted({name for i in system.interactions for name, _ in i.nodes}):
        of = sorted({Symbol.of(name).material for name in free} & set(system.models))
        models = "".join(f"; the model of {name}: {system.models[name]}" for name in of)
        raise ValueError(
            f"the system keeps {', '.join(free)} free: give values, collapse(tree, values={{…}}), or system.at({{…}}), "
            f"first{models}"
        )
