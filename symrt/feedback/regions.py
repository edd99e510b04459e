"""Give a region of the picture symbols of its own, so that parameters can vary over the picture (step 5).

The paper wants gamut mapping that varies spatially; a region is a mask over pixels, and a material seen there becomes
another material with the same geometry.
"""

from dataclasses import replace

import numpy as np
from jaxtyping import Bool
from scipy import sparse

from symrt.errors import require
from symrt.feedback.weighing import Mask, check_mask
from symrt.interactions import Interaction, normal_order
from symrt.spectra.palette import Palette, did_you_mean
from symrt.symbols import NAME, Surface, Symbol
from symrt.system import LinearSystem
from symrt.tails import Tail

Named = tuple[Interaction, ...]


def split(system: LinearSystem, material: str, mask: Mask, name: str) -> LinearSystem:
    """The same image, in which `material` is called `name` wherever the mask is true.

    A reflection in a mirror belongs to the pixel that it is seen in.

    Raises
    ------
    ValueError
        If the material does not occur, the new name is taken or is no name, or the mask has another size.

    Examples
    --------
    >>> system = LinearSystem.of("0.5*sun*sea.diffuse", "0.25*sun*sea.diffuse", white={"sun": 1.0})
    >>> parted = split(system, "sea", np.array([[False, True]]), "bay")
    >>> [str(interaction) for interaction in parted.interactions], parted.G.toarray().tolist()
    (['sun*bay.diffuse', 'sun*sea.diffuse'], [[0.0, 0.5], [0.25, 0.0]])
    """
    # Refuse names that are not there, or not free, and masks of another size.
    require("system", system, LinearSystem, "render(scene)")
    require("material", material, str, "the name of a material")
    require("name", name, str, "a new name for the region")
    symbols = [Symbol.of(reflectance) for reflectance in system.reflectances]
    known = {symbol.place for symbol in symbols}
    if material not in known:
        raise ValueError(f"no material {did_you_mean([material], known)}; there are: {', '.join(sorted(known))}")
    taken = {*known, *(symbol.material for symbol in symbols), *system.lights}
    if NAME.fullmatch(name) is None or name in taken:
        raise ValueError(f"{name!r}: a region needs a name of its own: a letter, then letters, digits, underscores")
    check_mask(system, mask, "the mask")

    # Move the region's coefficients to columns of its own; the bound on what was cut off follows.
    matrix, interactions = _parted(system.G, system.interactions, material, mask.ravel(), name)
    tail = system.tail and _parted_tail(system.tail, material, mask.ravel(), name)
    models = dict(system.models)
    if material in models:
        models[name] = models[material]
    renamed = {_renamed(i, material, name): by for i, by in system.interpolated.items()}
    left = set(interactions)
    interpolated = {i: by for i, by in {**system.interpolated, **renamed}.items() if i in left}
    lengths = {_called(symbol, material, name): how for symbol, how in system.lengths.items()} | dict(system.lengths)
    subtracting = (*system.subtracting, *([name] if material in system.subtracting else []))
    return replace(
        system,
        G=matrix,
        interactions=interactions,
        tail=tail,
        models=models,
        interpolated=interpolated,
        subtracting=subtracting,
        lengths=lengths,
    )


def with_region(palette: Palette, material: str, name: str) -> Palette:
    """The palette in which the region starts with the spectra of the material that it was split from.

    Examples
    --------
    >>> from symrt.spectra.bands import RGB
    >>> with_region(Palette(RGB, {"sun": 1, "sea.diffuse": [0.1, 0.2, 0.3]}), "sea", "bay")["bay.diffuse"]
    array([0.1, 0.2, 0.3])
    """
    require("palette", palette, Palette, "one of load_palettes(path)")
    require("material", material, str, "the name of a material")
    require("name", name, str, "the region's name")
    own = [s for s in palette.reflectances if Symbol.of(s).place == material]
    if not own:
        known = sorted({Symbol.of(s).place for s in palette.reflectances})
        raise ValueError(f"the palette has no material {did_you_mean([material], known)}")
    return palette.add({_called(symbol, material, name): palette[symbol] for symbol in own})


def _parted(
    matrix: sparse.csr_array, interactions: Named, material: str, inside: Bool[np.ndarray, " pixel"], name: str
) -> tuple[sparse.csr_array, Named]:
    """Rows inside the mask move to renamed columns; columns stay sorted, and empty ones go."""
    renamed = [_renamed(interaction, material, name) for interaction in interactions]
    columns = sorted({*interactions, *renamed})
    place = {interaction: j for j, interaction in enumerate(columns)}
    outside_to = np.array([place[i] for i in interactions], dtype=np.int64)
    inside_to = np.array([place[i] for i in renamed], dtype=np.int64)
    row = np.repeat(np.arange(matrix.shape[0]), np.diff(matrix.indptr))
    column = np.where(inside[row], inside_to[matrix.indices], outside_to[matrix.indices])
    whole = sparse.coo_array((matrix.data, (row, column)), shape=(matrix.shape[0], len(columns))).tocsr()
    used = np.flatnonzero(np.bincount(column, minlength=len(columns)))
    return whole[:, used], tuple(columns[j] for j in used)


def _parted_tail(tail: Tail, material: str, inside: Bool[np.ndarray, " pixel"], name: str) -> Tail:
    # What the region sends on, under its own name; then the bound, and the paints.
    reflected, passed = (
        tuple(
            tuple((_renamed_met(met, material, name), c) for met, c in shares)
            for shares in of_scene
            if any(Symbol.of(s).place == material for met, _ in shares for s in met)
        )
        for of_scene in (tail.reflected, tail.passed)
    )
    parted = _parted(tail.bound, tail.interactions, material, inside, name)
    fluorescent = (_called(symbol, material, name) for symbol in tail.fluorescent)
    return Tail(
        *parted,
        tail.reflected + reflected,
        tail.passed + passed,
        tuple(sorted({*tail.fluorescent, *fluorescent})),
    )


def _renamed(interaction: Interaction, material: str, name: str) -> Interaction:
    powers = tuple(sorted((_called(symbol, material, name), length) for symbol, length in interaction.powers))
    return replace(interaction, met=_renamed_met(interaction.met, material, name), powers=powers)


def _renamed_met(met: tuple[str, ...], material: str, name: str) -> tuple[str, ...]:
    return normal_order(_called(symbol, material, name) for symbol in met)


def _called(text: str, material: str, name: str) -> str:
    """A symbol in the region: ``sea.diffuse`` and ``sea>ice.diffuse``, both of points of the sea, get its new name."""
    symbol = Symbol.of(text)
    if symbol.place != material:
        return text
    surface = Surface(symbol.material, instead_of=name) if symbol.alternative else Surface(name)
    return str(replace(symbol, surface=surface))
