"""The extra `fast`: the few inner loops that stay dear, compiled by Numba, to the bit what NumPy computes.

NumPy is the reference and always complete.  Kernels take its place once enough has been asked for that loading them
pays, unless `use` says otherwise; as no bit depends on it, neither does any answer.  Numba compiles them once for each
processor and keeps the machine code where it keeps all its own: beside the module, or in the user's cache.
"""

import warnings
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from importlib import import_module
from importlib.util import find_spec
from threading import Lock
from types import ModuleType

WORTH = 2_000_000
"""Pairs of a ray and a shape after which kernels are loaded: NumPy takes as long for them as loading does."""

ROOMS = (
    "symrt.geometry.fast.boxes",
    "symrt.geometry.fast.flats",
    "symrt.geometry.fast.quadrics",
    "symrt.geometry.fast.surfaces",
    "symrt.geometry.fast.triangles",
    "symrt.tracing.fast.lighting",
    "symrt.linear.fast.gathering",
    "symrt.gamut.fast.slabs",
)
"""The modules of kernels."""

_WANTED: ContextVar[bool | None] = ContextVar("wanted", default=None)
_LOADING = Lock()
_ROOMS: dict[str, ModuleType | None] = {}
_ASKED: Counter[str] = Counter()


@contextmanager
def use(kernels: bool | None) -> Iterator[None]:
    """Within a block, in this thread and in the workers of its renders, use compiled kernels or do not.

    Parameters
    ----------
    kernels
        False: NumPy alone.  True: kernels from the first ray on.  None: kernels once they pay, as outside of any block.

    Raises
    ------
    ModuleNotFoundError
        If kernels are asked for and Numba is not installed, or unfit.

    Examples
    --------
    >>> import numpy as np
    >>> from symrt.geometry import Rays, Sphere, nearest
    >>> ray = Rays(origin=np.array([[0.0], [0.0], [3.0]]), direction=np.array([[0.0], [0.0], [-1.0]]))
    >>> with use(False):
    ...     nearest([Sphere((0, 0, 0), 1, "red")], ray).distance
    array([2.])
    """
    if kernels and not available():
        raise ModuleNotFoundError("the kernels of symrt need Numba: pip install 'symrt[fast]', or use(None)")
    before = _WANTED.set(kernels)
    try:
        yield
    finally:
        _WANTED.reset(before)


def wanted() -> bool | None:
    """The last word of `use` in this thread, for a thread that is to do as the one that started it."""
    return _WANTED.get()


def adopt(kernels: bool | None) -> None:
    """Do in this thread as another one does: for the `initializer` of a pool of threads.

    Examples
    --------
    >>> from concurrent.futures import ThreadPoolExecutor
    >>> with use(False), ThreadPoolExecutor(1, initializer=adopt, initargs=(wanted(),)) as threads:
    ...     threads.submit(wanted).result()
    False
    """
    _WANTED.set(kernels)


def expected() -> bool:
    """Whether kernels are to be used in this thread once they pay, as far as can be told without loading any.

    Examples
    --------
    >>> with use(False):
    ...     expected()
    False
    """
    return (
        wanted() is not False and _ROOMS.get("symrt.fast.canary", True) is not None and find_spec("numba") is not None
    )


def available() -> bool:
    """Whether Numba is installed and computes what NumPy does."""
    with _LOADING:
        return _load("symrt.fast.canary") is not None


def kernels(room: str, pairs: int) -> ModuleType | None:
    """The module `room` of kernels for `pairs` more pairs of a ray and a shape, or None: NumPy is to do it.

    Examples
    --------
    >>> with use(False):
    ...     kernels("symrt.geometry.fast.quadrics", 10**9) is None
    True
    """
    asked = _WANTED.get()
    if asked is False:
        return None
    if room in _ROOMS:
        return _ROOMS[room]
    if asked is None:
        _ASKED[room] += pairs  # a count that two threads lose costs a moment, and no bit
        if _ASKED[room] < WORTH:
            return None
    # While one thread loads kernels, the others go on with NumPy, unless they were told not to.
    if not _LOADING.acquire(blocking=bool(asked)):
        return None
    try:
        return _load(room)
    finally:
        _LOADING.release()


def load() -> bool:
    """Load every kernel now, compiled if need be, and say whether they are used: for a machine that is made ready.

    Examples
    --------
    >>> load() == available()
    True
    """
    with _LOADING:
        return all(_load(room) is not None for room in ROOMS)


def _load(room: str) -> ModuleType | None:
    """Load a module of kernels, after a canary; say once why that cannot be done."""
    if room not in _ROOMS:
        _ROOMS[room], fault = _tried(room)
        if fault:
            warnings.warn(f"the extra `fast` is left unused, NumPy does it all: {fault}", RuntimeWarning, stacklevel=2)
    return _ROOMS[room]


def _tried(room: str) -> tuple[ModuleType | None, str]:
    """A module of kernels, or None and what keeps it from being used: nothing, where Numba is not installed."""
    # Numba may be missing, or unfit.
    try:
        from numba.core import errors, event  # noqa: PLC0415  # slow to import, and optional
    except ModuleNotFoundError as error:
        if not (error.name or "").startswith("numba"):
            raise
        return None, ""
    except ImportError as error:  # an unfit NumPy
        return None, _line(error)

    # The canary first, then the kernels; a fault of either is told.
    try:
        with event.install_listener("numba:compile", import_module("symrt.fast.notice").Notice()):
            canary = import_module("symrt.fast.canary")
            if fault := canary.fault():
                return None, str(fault)
            return import_module(room), ""
    except (RuntimeError, OSError, errors.NumbaError) as error:  # no place for machine code, a full disk, another Numba
        return None, _line(error)


def _line(error: Exception) -> str:
    return " ".join(str(error).split())
