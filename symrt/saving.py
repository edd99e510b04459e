"""Systems in files: what was rendered once is kept, bit for bit (between steps 2 and 3)."""

from pathlib import Path
from typing import Any

import numpy as np
from scipy import sparse

from symrt.archives import Kind, read_archive, whole, write_archive
from symrt.system import Interaction, LinearSystem, Nodes, Shares, Tail

__all__ = ["load_system", "save_system"]

KIND = Kind("system", 1, "save a system with save_system first", "render the scene and save it again")
LARGEST = 8 << 30
"""Bytes that the arrays of a file may unpack to; a file that claims more is refused before it is read."""


def save_system(path: str | Path, system: LinearSystem) -> None:
    """Write a system to one ``.npz`` file: arrays, and names as JSON; nothing in it is executable.

    The file appears whole or not at all.

    Examples
    --------
    >>> import tempfile
    >>> grey = LinearSystem(sparse.csr_array([[0.5]]), (Interaction("sun", ("red.diffuse",)),), 1, 1, {"sun": 1.0})
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     save_system(Path(folder) / "grey.npz", grey)
    ...     load_system(Path(folder) / "grey.npz").interactions
    (Interaction(light='sun', met=('red.diffuse',), nodes=()),)
    """
    tail = system.tail or Tail(sparse.csr_array((system.height * system.width, 0)))
    header = {
        "height": int(system.height),
        "width": int(system.width),
        "interactions": [[i.light, list(i.met), [list(n) for n in i.nodes]] for i in system.interactions],
        "tail": None if system.tail is None else [[i.light, list(i.met), []] for i in tail.interactions],
        "reflected": [[[list(met), float(c).hex()] for met, c in shares] for shares in tail.reflected],
        "white": {name: float(value).hex() for name, value in system.white.items()},
        "models": dict(system.models),
        "parameters": [[n.parameter, n.low.hex(), n.high.hex(), n.count, n.scale] for n in system.parameters.values()],
        "seconds": dict(system.seconds),
    }
    arrays: dict[str, np.ndarray] = {}
    for name, matrix in (("G", system.G), ("tail", tail.bound)):
        arrays |= {
            f"{name}_data": matrix.data,
            f"{name}_indices": matrix.indices.astype(np.int32),
            f"{name}_indptr": matrix.indptr.astype(np.int64),
        }
    write_archive(path, KIND, header, arrays)


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
        arrays, header = read_archive(path, KIND, LARGEST)
        interactions = _interactions(header["interactions"])
        tail = None if header["tail"] is None else _interactions(header["tail"])
        reflected = _shares(header["reflected"])
        pixels = int(header["height"]) * int(header["width"])
        system = LinearSystem(
            G=_matrix(arrays, "G", pixels, len(interactions)),
            interactions=interactions,
            height=int(header["height"]),
            width=int(header["width"]),
            white={str(k): _finite(float.fromhex(v)) for k, v in header["white"].items()},
            models={str(k): str(v) for k, v in header["models"].items()},
            parameters={
                name: Nodes(name, float.fromhex(low), float.fromhex(high), int(count), scale)
                for name, low, high, count, scale in header["parameters"]
            },
            tail=None if tail is None else Tail(_matrix(arrays, "tail", pixels, len(tail)), tail, reflected),
            seconds={str(k): float(v) for k, v in header["seconds"].items()},
        )
        _check_nodes(system)
        return system


def _check_nodes(system: LinearSystem) -> None:
    for interaction in system.interactions:
        for name, j in interaction.nodes:
            if name not in system.parameters or not 0 <= j < system.parameters[name].count:
                raise ValueError(f"{interaction} names a node that is not there")


def _finite(value: float) -> float:
    if not np.isfinite(value):
        raise ValueError(f"a white of {value}")
    return value


def _interactions(rows: list[Any]) -> tuple[Interaction, ...]:
    return tuple(
        Interaction(str(light), tuple(map(str, met)), tuple((str(name), int(j)) for name, j in nodes))
        for light, met, nodes in rows
    )


def _shares(rows: list[Any]) -> tuple[Shares, ...]:
    return tuple(tuple((tuple(map(str, met)), float.fromhex(c)) for met, c in shares) for shares in rows)


def _matrix(arrays: dict[str, np.ndarray], name: str, rows: int, columns: int) -> sparse.csr_array:
    data, indices, indptr = (arrays[f"{name}_{part}"] for part in ("data", "indices", "indptr"))
    if indices.dtype.kind != "i" or indptr.dtype.kind != "i":
        raise ValueError(f"the places of {name} are not whole numbers")
    # A bound on what was cut off may be infinite: nothing is known then.
    if data.dtype != np.float64 or not np.all(np.isfinite(data) | (np.isposinf(data) & (name == "tail"))):
        raise ValueError(f"the coefficients of {name} are not finite float64 numbers")
    matrix = sparse.csr_array((data, indices, indptr), shape=(rows, columns))
    matrix.check_format(full_check=True)
    return matrix
