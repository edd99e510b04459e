"""The waist of the house: a linear system between geometry and spectra, equation (2) of the paper.

A pixel is ``p_n(λ) = Σ_i g_{n,i} Γ_{i,λ}``.  `LinearSystem` holds the sparse matrix G (pixel × interaction) and the
name of each column.  What made G knows no spectrum; what uses it knows no shape.
"""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float, Int
from scipy import sparse

from symrt.counts import Counts
from symrt.estimates import Estimate
from symrt.interactions import Blocks, Interaction, blocks_of, settled, written
from symrt.lengths import Lengths
from symrt.nodes import FIRST_ORDER, Nodes
from symrt.symbols import Symbol
from symrt.table import html_table
from symrt.tails import Tail

OWN = "a negative term"
"""Why a column is signed that was written so."""


@dataclass(frozen=True, eq=False)
class LinearSystem:
    """A rendered image in which every light and reflectance is still free.

    Parameters
    ----------
    G
        Coefficients g_{n,i}, (pixel × interaction), float64; pixel n = y · width + x, y from the top.
    interactions
        The columns of G, in canonical (sorted) order.
    height, width
        Of the image, in pixels.
    white
        For each light of the scene, the coefficient of a perfect diffuser that stands at the camera's target, faces
        the light and is not shadowed.
    models
        For each material, its model and its parameters' values as text: with the same text, only spectra differ.
    parameters
        Nodes of each parameter that is still free.
    tail
        Bound on what the depth limit cut off.
    seconds
        Time spent in each step.
    interpolated
        For columns that `at` summed with negative weights, and that were not negative before: those parameters.
    subtracting
        Materials whose models may subtract, as one with an F82 does.
    errors
        For each light whose share that is seen was estimated, the error of that share over all lit points.
    counts
        The rays, the pixels and the time of each effect that was simulated.
    noise
        By light, if pixels are means of drawn samples: their error under reflectances of 1, as a share of its white.
    glowing
        Lights that are seen themselves: a pixel of nothing but their columns without a reflectance is no object.
    lengths
        By transmittance, the nodes of lengths in glass; `error` is at most the share of clear light that they err by.
    """

    G: sparse.csr_array
    interactions: tuple[Interaction, ...]
    height: int
    width: int
    white: Mapping[str, float]
    models: Mapping[str, str] = field(default_factory=dict)
    parameters: Mapping[str, Nodes] = field(default_factory=dict)
    tail: Tail | None = None
    seconds: Mapping[str, float] = field(default_factory=dict)
    interpolated: Mapping[Interaction, tuple[str, ...]] = field(default_factory=dict)
    subtracting: tuple[str, ...] = ()
    errors: Mapping[str, Estimate] = field(default_factory=dict)
    counts: Counts = field(default_factory=Counts)
    noise: Mapping[str, Estimate] = field(default_factory=dict)
    glowing: tuple[str, ...] = ()
    lengths: Mapping[str, Lengths] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if self.G.shape != (self.height * self.width, len(self.interactions)):
            raise ValueError(
                f"G is {self.G.shape}, but {self.height} × {self.width} pixels and {len(self.interactions)} "
                "interactions were named"
            )

    @classmethod
    def of(cls, *pixels: str, white: Mapping[str, float] | None = None, width: int | None = None) -> "LinearSystem":
        """A system that one writes down, a text for each pixel, row by row from the top; ``"0"`` is a black one.

        Parameters
        ----------
        white
            The lights in their order, each with the coefficient of its white; if not given, the lights in the order in
            which they are written, each 1.
        width
            Of the image; all pixels stand in one row if it is not given.

        Raises
        ------
        ValueError
            If a term is not the product of a number, one light and reflectances.

        Examples
        --------
        >>> system = LinearSystem.of("0.5*sun*sea.diffuse", "0.25*sun*sea.diffuse + 0.1*sky*ice.diffuse")
        >>> [str(interaction) for interaction in system.interactions]
        ['sky*ice.diffuse', 'sun*sea.diffuse']
        >>> system.G.toarray().tolist()
        [[0.0, 0.5], [0.1, 0.25]]
        """
        rows = [written(text) for text in pixels]
        interactions = sorted({interaction for row in rows for interaction, _ in row})
        place = {interaction: k for k, interaction in enumerate(interactions)}
        entries = [(n, place[i], g) for n, row in enumerate(rows) for i, g in row]
        shape = (len(pixels), len(interactions))
        n, k, g = zip(*entries, strict=True) if entries else ((), (), ())
        matrix = sparse.coo_array((np.array(g, dtype=float), (n, k)), shape=shape).tocsr()
        width = len(pixels) if width is None else width
        lights = dict.fromkeys((i.light for row in rows for i, _ in row), 1.0)
        height = len(pixels) // width if width else 0
        return cls(matrix, tuple(interactions), height, width, lights if white is None else white)

    def rows(self, pixels: Int[np.ndarray, " chosen"]) -> "LinearSystem":
        """Some of the pixels, by their numbers, as a system of one row of pixels; what was cut off comes with them.

        Examples
        --------
        >>> LinearSystem.of("0.5*sun*sea.diffuse", "0.25*sun*sea.diffuse").rows(np.array([1])).G.toarray()
        array([[0.25]])
        """
        tail = None if self.tail is None else replace(self.tail, bound=self.tail.bound[pixels])
        return replace(self, G=self.G[pixels], height=1, width=len(pixels), tail=tail)

    def at(self, parameters: Mapping[str, float | int]) -> "LinearSystem":
        """The system with some of its free parameters at values: their nodes are summed, by their weights.

        Interpolation weights may be negative, and so may sums of them be, by no more than the nodes' error.  Where that
        error is known, and the model only adds, they are 0: nearer to what is true, and all questions have answers.
        Other columns stay as they are, and `signed` tells of which.

        Raises
        ------
        ValueError
            If no parameter of that name is free, or the value is outside its range.

        Examples
        --------
        >>> nodes = Nodes("brass.exponent", 5.0, 80.0, 3)
        >>> columns = tuple(Interaction("sun", ("brass.specular",), (("brass.exponent", j),)) for j in range(3))
        >>> system = LinearSystem(
        ...     sparse.csr_array([[0.1, 0.2, 0.4]]), columns, 1, 1, {"sun": 1.0}, {}, {"brass.exponent": nodes}
        ... )
        >>> settled = system.at({"brass.exponent": 20.0})
        >>> [str(interaction) for interaction in settled.interactions], settled.G.toarray().round(12).tolist()
        (['sun*brass.specular'], [[0.2]])
        """
        if unknown := [name for name in parameters if name not in self.parameters]:
            free = ", ".join(self.parameters) or "none"
            raise ValueError(f"not a free parameter: {', '.join(unknown)}; free are: {free}")
        weights = {name: self.parameters[name].weights(float(value)) for name, value in parameters.items()}
        left, interactions, to = settled(self.interactions, weights)

        # The parameters whose weights may have made a column negative, where nothing else had.
        turning = {name for name, values in weights.items() if (values < 0).any()}
        by: dict[Interaction, set[str]] = {interaction: set() for interaction in interactions}
        for before, after in zip(self.interactions, left, strict=True):
            by[after] |= {*self.interpolated.get(before, ()), *(name for name, _ in before.nodes if name in turning)}
        own = {after for before, after in zip(self.interactions, left, strict=True) if before in self._own_signs}
        by = {i: set() if self._adding(names) and i not in own else names for i, names in by.items()}
        matrix = (self.G @ to).tocsr()
        settling = np.array([not by[i] and i not in own for i in interactions], dtype=bool)
        matrix.data[settling[matrix.indices] & (matrix.data < 0)] = 0.0
        return replace(
            self,
            G=matrix,
            interactions=tuple(interactions),
            parameters={name: nodes for name, nodes in self.parameters.items() if name not in weights},
            interpolated={i: tuple(sorted(names)) for i, names in by.items() if names and i not in own},
        )

    def times(
        self, spectra: Float[np.ndarray, "interaction *band"], pixels: Int[np.ndarray, " chosen"] | slice = slice(None)
    ) -> Float[np.ndarray, "_ *band"]:
        """Equation (2): the sum, over the columns, of a pixel's coefficient times what is given for the column.

        Parameters
        ----------
        spectra
            For each interaction a number, or one in each band: Γ, or what is made of it.  Sums are of its precision.
        pixels
            Their numbers, or a slice of all.

        Examples
        --------
        >>> system = LinearSystem.of("0.5*sun*sea.diffuse", "0.25*sun*sea.diffuse + 0.1*sky*ice.diffuse")
        >>> system.times(np.array([10.0, 4.0]))
        array([2., 2.])
        """
        coefficients = self.G if isinstance(pixels, slice) and pixels == slice(None) else self.G[pixels]
        return coefficients.astype(spectra.dtype, copy=False) @ spectra

    def terms(self, pixel: int) -> tuple[tuple[Interaction, float], ...]:
        """The terms whose sum a pixel is: interactions, each with its coefficient, without those of coefficient 0.

        Examples
        --------
        >>> [(str(i), g) for i, g in LinearSystem.of("0.5*sun*sea.diffuse + 0.1*sky*sea.diffuse").terms(0)]
        [('sky*sea.diffuse', 0.1), ('sun*sea.diffuse', 0.5)]
        """
        entries = slice(self.G.indptr[pixel], self.G.indptr[pixel + 1])
        found = zip(self.G.indices[entries].tolist(), self.G.data[entries].tolist(), strict=True)
        return tuple((self.interactions[column], g) for column, g in found if g != 0)

    def blocks(self, *groups: Collection[str]) -> Blocks:
        """The columns by their degrees in groups of symbols, such as those that each of some scales multiplies.

        Examples
        --------
        >>> system = LinearSystem.of("0.5*key*brass.diffuse + 0.25*key*brass.diffuse*brass.mirror + key*sea.diffuse")
        >>> blocks = system.blocks({"brass.diffuse", "brass.mirror"}, {"key"})
        >>> blocks.degrees.tolist(), blocks.of.tolist()
        ([[0, 0], [0, 1], [1, 1], [2, 1]], [2, 3, 1])
        """
        return blocks_of(self.interactions, groups)

    def pixels_of(self, columns: Bool[np.ndarray, " interaction"] | None = None) -> Bool[np.ndarray, " pixel"]:
        """The pixels in which some of the columns, or of all, have a coefficient, and not a stored 0.

        Examples
        --------
        >>> system = LinearSystem.of("0.5*sun*sea.diffuse", "0.25*sun*sea.diffuse + 0.1*sky*ice.diffuse")
        >>> system.pixels_of(np.array([i.light == "sky" for i in system.interactions]))
        array([False,  True])
        """
        columns = np.ones(len(self.interactions), dtype=bool) if columns is None else columns
        if columns.all() and self.G.data.all():
            return self.term_counts > 0
        counted = columns[self.G.indices] & (self.G.data != 0)
        return np.diff(np.append(0, np.cumsum(counted))[self.G.indptr]) > 0

    @property
    def term_counts(self) -> Int[np.ndarray, " pixel"]:
        """The number of coefficients of each pixel."""
        return np.diff(self.G.indptr)

    @cached_property
    def signed(self) -> Mapping[Interaction, str]:
        """The columns that may take from a pixel although no spectrum is negative, and why.

        A coefficient is negative, by a formula or by the weights of `at`; or a free parameter's weights may be.

        Examples
        --------
        >>> {str(i): why for i, why in LinearSystem.of("0.5*sun*sea.diffuse - 0.1*sky*sea.diffuse").signed.items()}
        {'sky*sea.diffuse': 'a negative term'}
        """
        found = {}
        for interaction in self.interactions:
            # The weight of a single node is always 1.
            free = [n for n, _ in interaction.nodes if n not in self.parameters or self.parameters[n].count > 1]
            by = dict.fromkeys([*self.interpolated.get(interaction, ()), *free, *self._curved(interaction)])
            way = FIRST_ORDER if any(self._first_order(name) for name in by) else "interpolation"
            if interaction in self._own_signs:
                found[interaction] = self._subtracted_by(interaction)
            elif interaction in self._negative or free:
                found[interaction] = f"{way} in {', '.join(by)}"
        return found

    def _adding(self, parameters: Collection[str]) -> bool:
        """True if the errors of parameters are known, and the models whose they are only add."""
        return all(
            name in self.parameters
            and self.parameters[name].error < np.inf
            and Symbol.of(name).material not in self.subtracting
            for name in parameters
        )

    @cached_property
    def _negative(self) -> frozenset[Interaction]:
        """The columns with a negative coefficient."""
        return frozenset(self.interactions[column] for column in np.unique(self.G.indices[self.G.data < 0]))

    @cached_property
    def _own_signs(self) -> frozenset[Interaction]:
        """The columns with a negative coefficient that no interpolation gave them."""
        return frozenset(i for i in self._negative if not (self.interpolated.get(i) or self._curved(i)))

    def _curved(self, interaction: Interaction) -> list[str]:
        """Names of a column whose numbers are of both signs: of lengths by Chebyshev's weights, and of slopes."""
        through = [n for n, _ in interaction.powers if n in self.lengths and self.lengths[n].scheme == "chebyshev"]
        return through + [name for name, _ in interaction.nodes if self._first_order(name)]

    def _first_order(self, parameter: str) -> bool:
        return parameter in self.parameters and self.parameters[parameter].around is not None

    def _subtracted_by(self, interaction: Interaction) -> str:
        """The reason that a column has a negative coefficient: the models of some materials, or that it was written."""
        met = {Symbol.of(name).material for name in interaction.met}
        # A term of a model may name none of its own reflectances: then it is one of all that may subtract.
        materials = [name for name in self.subtracting if name in met] or list(self.subtracting)
        return f"the model of {' or '.join(materials)} subtracts" if materials else OWN

    @property
    def lights(self) -> tuple[str, ...]:
        """Names of the scene's lights, whether or not any pixel sees them."""
        return tuple(self.white)

    @property
    def reflectances(self) -> tuple[str, ...]:
        """Names of the reflectance symbols that occur in some pixel, transmittances among them, sorted."""
        return tuple(sorted({name for interaction in self.interactions for name in interaction.names[1:]}))

    @property
    def symbols(self) -> tuple[str, ...]:
        """Every free spectrum that some pixel depends on: lights, then reflectances."""
        seen = {interaction.light for interaction in self.interactions}
        return (*(light for light in self.lights if light in seen), *self.reflectances)

    @property
    def object_pixels(self) -> Bool[np.ndarray, " pixel"]:
        """Pixels in which light reaches something: rows of G that are not empty, or all zeros.

        Lights that are seen themselves do not count; where a reflectance is on the way, as in a mirror, they do.
        """
        objects = [len(i.names) > 1 or i.light not in self.glowing for i in self.interactions]
        return self.pixels_of(np.array(objects, bool))

    def __repr__(self) -> str:
        interactions = f"{len(self.interactions)} interactions"
        kept = f"{self.G.nnz} coefficients, {self.G.nnz / max(1, self.height * self.width):.1f} a pixel"
        return f"LinearSystem({self.width} × {self.height} pixels, {interactions}, {kept}{self._erring()})"

    def _erring(self) -> str:
        errors = (f"; the share of {name} that is seen errs by {error}" for name, error in self.errors.items())
        noise = (f"; the noise of {name} is {error} of its white" for name, error in self.noise.items())
        way = (f"; lengths in {Symbol.of(n).material} err by at most {w.error:.2g}" for n, w in self.lengths.items())
        free = (f"; {n.parameter} errs by at most {n.error:.2g}" for n in self.parameters.values() if n.error < np.inf)
        return "".join((*errors, *noise, *way, *free))

    def _repr_html_(self) -> str:
        pixels = np.bincount(self.G.indices, minlength=len(self.interactions))
        rows = [(str(i), str(i.degree), str(count)) for i, count in zip(self.interactions, pixels, strict=True)]
        counts = self.counts._repr_html_() if self.counts.effects else ""
        head = f"<p>{self.width} × {self.height} pixels{self._erring()}</p>"
        return head + html_table(("interaction", "degree", "pixels"), rows) + counts
