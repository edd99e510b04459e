"""The waist of the house: a linear system between geometry and spectra, equation (2) of the paper.

A pixel is ``p_n(λ) = Σ_i g_{n,i} Γ_{i,λ}``.  `LinearSystem` holds the sparse matrix G (pixel × interaction) and the
name of each column.  What made G knows no spectrum; what uses it knows no shape.
"""

import json
import zipfile
import zlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

import numpy as np
from jaxtyping import Bool, Float
from scipy import sparse

__all__ = ["Interaction", "LinearSystem", "Nodes", "Tail", "load_system", "save_system"]

FORMAT = "symrt-system"
VERSION = 1
LARGEST_MEMBER = 8 << 30
"""Bytes that one array of a file may unpack to; a file that claims more is refused before it is read."""
MOST_NODES = 256


@dataclass(frozen=True, order=True)
class Interaction:
    """One light and the reflectances it met on its way to the eye: the name of a column of G.

    Parameters
    ----------
    light
        Name of the light.
    met
        Names of the reflectance symbols, ``material.component``, sorted because they commute.
    nodes
        ``(parameter, index)`` for each free parameter whose node this column belongs to.

    Examples
    --------
    >>> str(Interaction("sun", ("sea.diffuse", "sea.mirror", "sea.mirror")))
    'sun*sea.diffuse*sea.mirror**2'
    """

    light: str
    met: tuple[str, ...] = ()
    nodes: tuple[tuple[str, int], ...] = ()

    def __str__(self) -> str:
        powers = [f"{name}**{k}" if (k := self.met.count(name)) > 1 else name for name in dict.fromkeys(self.met)]
        return "*".join([self.light, *powers, *(f"node({name},{j})" for name, j in self.nodes)])

    @property
    def degree(self) -> int:
        """Number of reflectances met, with repetition."""
        return len(self.met)

    def degree_in(self, symbols: frozenset[str] | set[str]) -> int:
        """Total degree in the given symbols, lights or reflectances."""
        return sum(name in symbols for name in (self.light, *self.met))


@dataclass(frozen=True)
class Nodes:
    """Chebyshev nodes that make a nonlinear parameter linear: f(θ) = Σ_j ℓ_j(θ) f(θ_j).

    References
    ----------
    J.-P. Berrut and L. N. Trefethen, "Barycentric Lagrange Interpolation", SIAM Review 46(3), 2004.
    """

    parameter: str
    low: float
    high: float
    count: int
    scale: Literal["linear", "log"] = "log"

    def __post_init__(self) -> None:
        given = f"nodes of {self.parameter}: {self.count} in [{self.low}, {self.high}], {self.scale}"
        if not (np.isfinite(self.low) and np.isfinite(self.high) and self.low < self.high):
            raise ValueError(f"{given}: give a finite range, low below high")
        if self.scale not in ("linear", "log") or (self.scale == "log" and self.low <= 0):
            raise ValueError(f"{given}: the scale is 'linear', or 'log' for a range above 0")
        if not 1 <= self.count <= MOST_NODES:
            raise ValueError(f"{given}: give 1 to {MOST_NODES} nodes")

    @property
    def values(self) -> tuple[float, ...]:
        """The nodes θ_j, from high to low."""
        low, high = self._transform(self.low), self._transform(self.high)
        x = np.cos((2 * np.arange(self.count) + 1) * np.pi / (2 * self.count))
        t = (low + high) / 2 + (high - low) / 2 * x
        return tuple(float(v) for v in (np.exp(t) if self.scale == "log" else t))

    def weights(self, value: float) -> Float[np.ndarray, " node"]:
        """The Lagrange weights ℓ_j at a value; they sum to 1 and may be negative.

        Examples
        --------
        >>> Nodes("brass.exponent", 5.0, 80.0, 3).weights(20.0).round(12).tolist()
        [0.0, 1.0, 0.0]
        """
        if not self.low <= value <= self.high:
            raise ValueError(f"{self.parameter} = {value}: the system was collapsed for [{self.low}, {self.high}]")
        nodes = np.array([self._transform(v) for v in self.values])
        difference = self._transform(value) - nodes
        if np.any(difference == 0):
            return (difference == 0).astype(float)
        k = np.arange(self.count)
        terms = (-1.0) ** k * np.sin((2 * k + 1) * np.pi / (2 * self.count)) / difference
        return terms / terms.sum()

    def _transform(self, value: float) -> float:
        return float(np.log(value)) if self.scale == "log" else float(value)


@dataclass(frozen=True, eq=False)
class Tail:
    """What the depth limit cut off: an upper bound on the missing part of each pixel.

    Each column is a light times the mirrors a cut path had met.  The missing radiance is at most
    ``Σ bound · light · Π mirrors / (1 − ρ)`` with ρ the largest mirror reflectance in each band.
    """

    bound: sparse.csr_array
    interactions: tuple[Interaction, ...] = ()


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
        For each material, its model and the values of its parameters, as text: two materials with the same text
        differ in spectra only.
    parameters
        Nodes of each parameter that is still free.
    tail
        Bound on what the depth limit cut off.
    seconds
        Time spent in each step.
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

    def __post_init__(self) -> None:
        if self.G.shape != (self.height * self.width, len(self.interactions)):
            raise ValueError(
                f"G is {self.G.shape}, but {self.height} × {self.width} pixels and {len(self.interactions)} "
                "interactions were named"
            )

    @property
    def lights(self) -> tuple[str, ...]:
        """Names of the scene's lights, whether or not any pixel sees them."""
        return tuple(self.white)

    @property
    def reflectances(self) -> tuple[str, ...]:
        """Names of the reflectance symbols that occur in some pixel, sorted."""
        return tuple(sorted({name for interaction in self.interactions for name in interaction.met}))

    @property
    def symbols(self) -> tuple[str, ...]:
        """Every free spectrum that some pixel depends on: lights, then reflectances."""
        seen = {interaction.light for interaction in self.interactions}
        return (*(light for light in self.lights if light in seen), *self.reflectances)

    @property
    def object_pixels(self) -> Bool[np.ndarray, " pixel"]:
        """Pixels in which light reaches something: rows of G that are not empty."""
        return np.diff(self.G.indptr) > 0

    def __repr__(self) -> str:
        kept = f"{self.G.nnz} coefficients, {self.G.nnz / max(1, self.height * self.width):.1f} a pixel"
        return f"LinearSystem({self.width} × {self.height} pixels, {len(self.interactions)} interactions, {kept})"

    def _repr_html_(self) -> str:
        pixels = np.bincount(self.G.indices, minlength=len(self.interactions))
        rows = "".join(
            f"<tr><td><code>{interaction}</code></td><td>{interaction.degree}</td><td>{count}</td></tr>"
            for interaction, count in zip(self.interactions, pixels, strict=True)
        )
        head = "<tr><th>interaction</th><th>degree</th><th>pixels</th></tr>"
        return f"<p>{self.width} × {self.height} pixels</p><table>{head}{rows}</table>"


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
        "format": FORMAT,
        "version": VERSION,
        "height": system.height,
        "width": system.width,
        "interactions": [[i.light, list(i.met), [list(n) for n in i.nodes]] for i in system.interactions],
        "tail": None if system.tail is None else [[i.light, list(i.met), []] for i in tail.interactions],
        "white": {name: float(value).hex() for name, value in system.white.items()},
        "models": dict(system.models),
        "parameters": [[n.parameter, n.low.hex(), n.high.hex(), n.count, n.scale] for n in system.parameters.values()],
        "seconds": dict(system.seconds),
    }
    arrays = {"header": np.frombuffer(json.dumps(header).encode(), dtype=np.uint8)}
    for name, matrix in (("G", system.G), ("tail", tail.bound)):
        arrays |= {
            f"{name}_data": matrix.data,
            f"{name}_indices": matrix.indices.astype(np.int32),
            f"{name}_indptr": matrix.indptr.astype(np.int64),
        }
    path = Path(path)
    partial = path.with_name(path.name + ".partial")
    try:
        with partial.open("wb") as file:
            np.savez_compressed(file, allow_pickle=False, **arrays)
        partial.replace(path)
    finally:
        partial.unlink(missing_ok=True)


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
    arrays, header = _read(Path(path))
    try:
        interactions = _interactions(header["interactions"])
        tail = None if header["tail"] is None else _interactions(header["tail"])
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
            tail=None if tail is None else Tail(_matrix(arrays, "tail", pixels, len(tail)), tail),
            seconds={str(k): float(v) for k, v in header["seconds"].items()},
        )
        _check_nodes(system)
    except (KeyError, TypeError, AttributeError, ValueError, OverflowError) as error:
        raise _damaged(Path(path), error) from error
    return system


def _read(path: Path) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    try:
        _check_sizes(path)
        with np.load(path, allow_pickle=False) as file:
            arrays = {name: file[name] for name in file.files}
        header = json.loads(arrays.pop("header").tobytes())
    except FileNotFoundError:
        raise ValueError(f"{path}: no such file; save a system with save_system first") from None
    except (zipfile.BadZipFile, zlib.error, KeyError, EOFError, OSError, ValueError, RecursionError) as error:
        raise _damaged(path, error) from error
    if not isinstance(header, dict) or header.get("format") != FORMAT or header.get("version") != VERSION:
        raise ValueError(f"{path}: not a symrt system of version {VERSION}; render the scene and save it again")
    return arrays, header


def _check_sizes(path: Path) -> None:
    with zipfile.ZipFile(path) as archive:
        for info in archive.infolist():
            if info.file_size > LARGEST_MEMBER:
                raise ValueError(f"{info.filename} claims more than {LARGEST_MEMBER >> 30} GiB and is not read")


def _damaged(path: Path, error: Exception) -> ValueError:
    reason = " ".join(str(error).split())[:200]
    return ValueError(f"{path}: not a whole symrt system ({reason}); render the scene and save it again")


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


def _matrix(arrays: dict[str, np.ndarray], name: str, rows: int, columns: int) -> sparse.csr_array:
    data, indices, indptr = (arrays[f"{name}_{part}"] for part in ("data", "indices", "indptr"))
    if indices.dtype.kind != "i" or indptr.dtype.kind != "i":
        raise ValueError(f"the places of {name} are not whole numbers")
    if data.dtype != np.float64 or not np.all(np.isfinite(data)):
        raise ValueError(f"the coefficients of {name} are not finite float64 numbers")
    matrix = sparse.csr_array((data, indices, indptr), shape=(rows, columns))
    matrix.check_format(full_check=True)
    return matrix
