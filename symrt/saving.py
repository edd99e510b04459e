"""Systems in files: what was rendered once is kept, bit for bit (between steps 2 and 3).

A file is believed no more than a scene file is: every name, index, shape and number in it is checked, each by its own
rule and against the others, before a system is made of them.
"""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from scipy import sparse

from symrt.archives import Kind, read_archive, whole, write_archive
from symrt.columns import columns_of, nodes_of, nodes_row, row_of
from symrt.counts import Count, Counts
from symrt.errors import shown
from symrt.estimates import Estimate
from symrt.faults import faults
from symrt.headers import count_of, list_of, number_of, size_of, table_of, text_of
from symrt.interactions import Interaction
from symrt.lengths import Lengths
from symrt.nodes import Nodes
from symrt.symbols import OF_MATERIAL
from symrt.system import LinearSystem
from symrt.tails import Shares, Tail

KIND = Kind("system", 2, "save a system with save_system first", "render the scene and save it again")
LARGEST = 8 << 30
"""Bytes that the arrays of a file may unpack to; a file that claims more is refused before it is read."""
KEYS = ("height", "width", "interactions", "tail", "reflected", "passed", "white", "models", "parameters", "seconds")
"""Of the header, beside those that every file of ours has."""
TOLD = ("errors", "noise", "counts", "lengths", "fluorescent", "gathered")
"""Of the header, where there is any of it."""
ARRAYS = frozenset(f"{name}_{part}" for name in ("G", "tail") for part in ("data", "indices", "indptr"))


def save_system(path: str | Path, system: LinearSystem) -> None:
    """Write a system to one ``.npz`` file: arrays, and names as JSON; nothing in it is executable.

    The file appears whole or not at all.

    Raises
    ------
    ValueError
        If `load_system` would refuse it: names or numbers that no scene gives; or if a file of another kind is there.

    Examples
    --------
    >>> import tempfile
    >>> grey = LinearSystem.of("0.5*sun*red.diffuse", white={"sun": 1.0})
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     save_system(Path(folder) / "grey.npz", grey)
    ...     load_system(Path(folder) / "grey.npz").interactions
    (Interaction(light='sun', met=('red.diffuse',), nodes=(), window=(), powers=()),)
    """
    try:
        header, arrays = packed(system)
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None
    write_archive(path, KIND, header, arrays)


def packed(system: LinearSystem) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """The header and the arrays of a file that holds a system, unless `unpacked` would refuse them."""
    if fault := next(faults(system), None):
        raise ValueError(f"not saved: {fault}: correct the system")
    tail = system.tail or Tail(sparse.csr_array((system.height * system.width, 0)))
    header = {
        "height": int(system.height),
        "width": int(system.width),
        "interactions": [row_of(i) for i in system.interactions],
        "tail": None if system.tail is None else [row_of(i) for i in tail.interactions],
        "reflected": [[[list(met), float(c).hex()] for met, c in shares] for shares in tail.reflected],
        "passed": [[[list(met), float(c).hex()] for met, c in shares] for shares in tail.passed],
        "white": {name: float(value).hex() for name, value in system.white.items()},
        "models": dict(system.models),
        "parameters": [nodes_row(nodes) for nodes in system.parameters.values()],
        "seconds": dict(system.seconds),
    }
    if system.interpolated:
        # Files of all other systems stay as they were before there was such a record.
        place = {interaction: k for k, interaction in enumerate(system.interactions)}
        header["interpolated"] = [[place[i], list(names)] for i, names in system.interpolated.items()]
    some = {"subtracting": system.subtracting, "glowing": system.glowing, "fluorescent": tail.fluorescent}
    header |= {name: list(names) for name, names in some.items() if names}
    header |= dict(_told(system, tail))
    arrays: dict[str, np.ndarray] = {}
    for name, matrix in (("G", system.G), ("tail", tail.bound)):
        arrays |= {
            f"{name}_data": matrix.data,
            f"{name}_indices": matrix.indices.astype(np.int32),
            f"{name}_indptr": matrix.indptr.astype(np.int64),
        }
    return header, arrays


def _told(system: LinearSystem, tail: Tail) -> Iterator[tuple[str, Any]]:
    """The parts of the header that are there where there is any of them."""
    for key, estimates in (("errors", system.errors), ("noise", system.noise)):
        if estimates:
            yield key, {name: [e.count, e.rms.hex(), e.largest.hex()] for name, e in estimates.items()}
    if system.counts.effects:
        effects = [[n, c.rays, c.seconds, c.pixels, dict(c.ways)] for n, c in system.counts.effects.items()]
        yield "counts", {"pixels": system.counts.pixels, "effects": effects}
    if tail.gathered:
        yield "gathered", [[row_of(i), [float(c).hex() for c in sums]] for i, sums in tail.gathered.items()]
    if system.lengths:
        yield "lengths", {name: [lengths.a_decade, lengths.scheme] for name, lengths in system.lengths.items()}


def load_system(path: str | Path) -> LinearSystem:
    """Read a system that `save_system` wrote, bit for bit.

    Raises
    ------
    ValueError
        If the file is not such a system, is truncated, or its parts contradict each other.

    Examples
    --------
    >>> load_system("missing.npz")
    Traceback (most recent call last):
    ValueError: missing.npz: no such file; save a system with save_system first
    """
    with whole(path, KIND):
        return unpacked(*read_archive(path, KIND, LARGEST))


def unpacked(arrays: dict[str, np.ndarray], header: Mapping[str, Any]) -> LinearSystem:
    """The system that the arrays and the header of a file make; each part of them is checked."""
    # Columns of what is there, and of what was cut off.
    _check_keys(arrays, header)
    interactions = columns_of(header["interactions"])
    tail = None if header["tail"] is None else columns_of(header["tail"])
    reflected, passed = (_shares(header[name]) for name in ("reflected", "passed"))
    height, width = count_of(header["height"]), count_of(header["width"])

    # Both matrices, and all that is said of them.
    bound = _matrix(arrays, "tail", height * width, 0 if tail is None else len(tail))
    fluorescent = tuple(map(text_of, list_of(header.get("fluorescent", []))))
    if tail is None and (reflected or passed or fluorescent):
        raise ValueError("nothing was cut off, but there are shares of it")
    gathered = _gathered(header.get("gathered", []))
    system = LinearSystem(
        G=_matrix(arrays, "G", height * width, len(interactions)),
        interactions=interactions,
        height=height,
        width=width,
        white={name: float.fromhex(text_of(v)) for name, v in table_of(header["white"])},
        models={name: text_of(v) for name, v in table_of(header["models"])},
        parameters=_parameters(header["parameters"]),
        tail=None if tail is None else Tail(bound, tail, reflected, passed, fluorescent, gathered),
        seconds={name: number_of(v) for name, v in table_of(header["seconds"])},
        interpolated=_interpolated(header.get("interpolated", []), interactions),
        subtracting=tuple(map(text_of, list_of(header.get("subtracting", [])))),
        glowing=tuple(map(text_of, list_of(header.get("glowing", [])))),
        errors={name: _estimate(*list_of(row)) for name, row in table_of(header.get("errors", {}))},
        counts=_counts(header["counts"]) if "counts" in header else Counts(),
        noise={name: _estimate(*list_of(row)) for name, row in table_of(header.get("noise", {}))},
        lengths={name: _nodes_of_lengths(*list_of(row)) for name, row in table_of(header.get("lengths", {}))},
    )

    # Parts that fit each other.
    if fault := next(faults(system), None):
        raise ValueError(fault)
    return system


def _check_keys(arrays: Mapping[str, np.ndarray], header: Mapping[str, Any]) -> None:
    """Refuse what belongs to nothing: a file of ours has just these parts."""
    known = {"format", "version", "digest", "interpolated", "subtracting", "glowing", *TOLD, *KEYS}
    if unknown := (set(header) - known) | (set(arrays) - ARRAYS):
        raise ValueError(f"{shown(min(unknown))} belongs to nothing")


def _parameters(rows: list[Any]) -> dict[str, Nodes]:
    found: dict[str, Nodes] = {}
    for row in map(list_of, rows):
        nodes = nodes_of(*row)
        if nodes.parameter in found:
            raise ValueError(f"two parameters are called {shown(nodes.parameter)}")
        if not OF_MATERIAL.fullmatch(nodes.parameter):
            raise ValueError(f"a parameter is called {shown(nodes.parameter)}")
        found[nodes.parameter] = nodes
    return found


def _interpolated(rows: list[Any], interactions: tuple[Interaction, ...]) -> dict[Interaction, tuple[str, ...]]:
    found = {}
    for place, names in list_of(rows):
        if count_of(place) >= len(interactions) or interactions[place] in found:
            raise ValueError(f"column {place} was interpolated, and is not there, or is named twice")
        found[interactions[place]] = tuple(map(text_of, list_of(names)))
    return found


def _estimate(count: Any, rms: Any, largest: Any) -> Estimate:
    return Estimate(count_of(count), float.fromhex(text_of(rms)), float.fromhex(text_of(largest)))


def _counts(record: Any) -> Counts:
    found = dict(table_of(record))
    rows = [list_of(row) for row in list_of(found["effects"])]
    effects = {text_of(name): _effect_count(*row) for name, *row in rows}
    if set(found) != {"effects", "pixels"} or len(effects) < len(rows):
        raise ValueError("the counts of effects are of two effects of one name, or of something else")
    return Counts(effects, count_of(found["pixels"]))


def _effect_count(rays: Any, seconds: Any, pixels: Any, ways: Any) -> Count:
    by = {text_of(name): size_of(number) for name, number in table_of(ways)}
    return Count(size_of(rays), number_of(seconds), None if pixels is None else count_of(pixels), by)


def _nodes_of_lengths(a_decade: Any, scheme: Any) -> Lengths:
    return Lengths(count_of(a_decade), text_of(scheme))  # type: ignore[arg-type]  # Lengths checks it


def _shares(rows: list[Any]) -> tuple[Shares, ...]:
    return tuple(
        tuple((tuple(map(text_of, list_of(met))), float.fromhex(text_of(c))) for met, c in list_of(shares))
        for shares in list_of(rows)
    )


def _gathered(rows: list[Any]) -> dict[Interaction, tuple[float, ...]]:
    pairs = [list_of(row) for row in list_of(rows)]
    columns = columns_of([column for column, _ in pairs])
    if len(set(columns)) < len(columns):
        raise ValueError("a column of gathered light is told of twice")
    sums = (tuple(float.fromhex(text_of(c)) for c in list_of(numbers)) for _, numbers in pairs)
    return dict(zip(columns, sums, strict=True))


def _matrix(arrays: dict[str, np.ndarray], name: str, rows: int, columns: int) -> sparse.csr_array:
    """A matrix whose places were checked here: SciPy skips some of it where nothing is stored, and trusts the rest."""
    data, indices, indptr = (arrays[f"{name}_{part}"] for part in ("data", "indices", "indptr"))
    if indices.dtype.kind != "i" or indptr.dtype.kind != "i" or not data.ndim == indices.ndim == indptr.ndim == 1:
        raise ValueError(f"the places of {name} are not rows of whole numbers")
    if data.dtype != np.float64:
        raise ValueError(f"the coefficients of {name} are not finite float64 numbers")
    if len(indptr) != rows + 1 or len(indices) != len(data) or indptr[0] != 0 or indptr[-1] != len(data):
        raise ValueError(f"{name} has not {rows} rows, or not {len(data)} coefficients")
    if np.any(indptr[1:] < indptr[:-1]):
        raise ValueError(f"the rows of {name} are out of order")
    if len(indices) and not (indices.min() >= 0 and indices.max() < columns):
        raise ValueError(f"{name} has coefficients outside its {columns} columns")
    return sparse.csr_array((data, indices, indptr), shape=(rows, columns))
