"""The extra `fast`: where it is used, where it is not, and how it says so."""

import hashlib
import os
import re
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
from scenes_for_tests import small

import symrt as rt
from symrt import fast
from symrt.geometry import Rays, Sphere, nearest

HOME = Path(__file__).parents[1]
KERNELS = [path for path in sorted((HOME / "symrt").rglob("fast/*.py")) if re.search("^TAKES", path.read_text(), re.M)]
TAKEN = ["fast/compiling.py", "fast/pairs.py", "geometry/fast/asking.py"]
needs_numba = pytest.mark.skipif(find_spec("numba") is None, reason="numba is not installed")


def digest():
    """Of all that kernels take from other files, as each of their own files keeps it."""
    return hashlib.sha256(b"".join((HOME / "symrt" / name).read_bytes() for name in TAKEN)).hexdigest()[:16]


@pytest.mark.parametrize("path", KERNELS, ids=lambda path: path.stem)
def test_machine_code_of_another_arithmetic_is_not_used(path):
    # Numba keeps machine code as long as the kernel's own file is the same: it must change with what it takes.
    # After a change, ``python tests/test_fast.py`` writes the new digest.
    assert f'TAKES = "{digest()}"' in path.read_text()


def test_all_kernels_are_known():
    modules = {".".join(path.relative_to(HOME).with_suffix("").parts) for path in KERNELS}
    assert modules == {*fast.ROOMS, "symrt.fast.canary"}


def python(script, **environment):
    """What a script says on standard output and on standard error, in a new process."""
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", script],
        capture_output=True,
        text=True,
        check=True,
        env={**os.environ, "PYTHONPATH": str(HOME), **environment},
        timeout=120,
    )
    return done.stdout, done.stderr


FIRST = """
import sys, hashlib, symrt as rt
from dataclasses import replace
from symrt import fast
scene = rt.load_scene("first")
small = replace(scene, camera=replace(scene.camera, width=24, height=24))
def bits(): return hashlib.sha256(rt.render(small, progress=False).G.toarray().tobytes()).hexdigest()
"""


def test_without_numba_everything_works_to_the_same_bits_and_says_nothing():
    asked = (
        "print(bits(), fast.available())\ntry:\n with fast.use(True): pass\nexcept ModuleNotFoundError as e: print(e)"
    )
    said, aside = python("import sys; sys.modules['numba'] = None" + FIRST + "fast.WORTH = 0\n" + asked)
    reference, _ = python(FIRST + "with fast.use(False): print(bits())")
    assert said.splitlines() == [
        f"{reference.strip()} False",
        "the kernels of symrt need Numba: pip install 'symrt[fast]', or use(None)",
    ]
    assert aside == ""


@needs_numba
def test_the_first_compilation_is_announced_and_the_next_process_loads_what_it_left(tmp_path):
    # An installation that cannot be written to: Numba keeps its code in the user's cache.
    closed = "import numba.core.caching as c\ndef no(self): raise OSError('read-only')\n"
    closed += "c.InTreeCacheLocator.ensure_cache_path = no\nfrom symrt import fast\nprint(fast.available())"
    environment = {"XDG_CACHE_HOME": str(tmp_path), "NUMBA_CACHE_DIR": ""}
    first, again = python(closed, **environment), python(closed, **environment)
    assert first == ("True\n", "symrt compiles its inner loops for this processor, once: this takes some seconds\n")
    assert again == ("True\n", "")
    assert list(tmp_path.rglob("*.nbi"))


@needs_numba
def test_where_machine_code_cannot_be_kept_numpy_does_it_all_and_says_why():
    nowhere = "import warnings; warnings.simplefilter('always')\nimport numba.core.caching as c\n"
    nowhere += "c.CacheImpl._locator_classes = []\nfrom symrt import fast\nprint(fast.available(), fast.available())"
    said, aside = python(nowhere)
    assert said == "False False\n"
    assert aside.count("the extra `fast` is left unused, NumPy does it all: cannot cache function") == 1


@needs_numba
@pytest.mark.parametrize(("row", "what"), [(0, "a d − b c"), (1, "the error of a product"), (2, "a quotient's root")])
def test_the_canary_falls_where_one_bit_differs(row, what, monkeypatch):
    from symrt.fast import canary  # noqa: PLC0415  # needs Numba

    def contracted(given, out, whole=canary.sing):
        whole(given, out)
        out[row, 0] = np.nextafter(out[row, 0], np.inf)

    monkeypatch.setattr(canary, "sing", contracted)
    monkeypatch.setattr(fast, "_ROOMS", {})
    ray = Rays(np.array([[0.0], [0.0], [3.0]]), np.array([[0.0], [0.0], [-1.0]]))
    with pytest.warns(RuntimeWarning, match=f"left unused, NumPy does it all: compiled here, {what} differs") as said:
        assert not fast.available()
    assert len(said) == 1
    assert nearest([Sphere((0, 0, 0), 1, "red")], ray).distance[0] == 2
    with pytest.raises(ModuleNotFoundError), fast.use(True):
        pass


@needs_numba
def test_kernels_are_loaded_once_they_pay_and_no_sooner(monkeypatch):
    loaded = []
    monkeypatch.setattr(fast, "_ROOMS", {})
    monkeypatch.setattr(fast, "_ASKED", {"a": 0})
    monkeypatch.setattr(fast, "_load", loaded.append)
    with fast.use(None):
        assert fast.kernels("a", fast.WORTH - 1) is None
        assert loaded == []
        fast.kernels("a", 1)
    assert loaded == ["a"]
    with fast.use(False):
        assert fast.kernels("a", 10**9) is None
    assert loaded == ["a"]


@needs_numba
def test_while_one_thread_loads_kernels_the_others_go_on_with_numpy(monkeypatch):
    monkeypatch.setattr(fast, "_ROOMS", {})
    with fast._LOADING, fast.use(None):
        assert fast.kernels("symrt.geometry.fast.quadrics", 10**9) is None


def test_the_threads_of_a_render_do_as_the_one_that_called_it(monkeypatch):
    seen = []
    monkeypatch.setattr(fast, "kernels", lambda *_: seen.append(fast.wanted()))
    with fast.use(False):
        rt.render(small("first", 16), workers=2, progress=False)
    assert set(seen) == {False}
    with ThreadPoolExecutor(1) as threads:
        assert threads.submit(fast.wanted).result() is None


@needs_numba
@pytest.mark.parametrize("name", ["first", "spheres", "globe"])
def test_a_scene_has_the_same_bits_with_and_without(name):
    found = []
    for kernels in (True, False):
        with fast.use(kernels):
            found.append(rt.render(small(name, 48), progress=False))
    one, other = found
    assert one.interactions == other.interactions
    for part in ("data", "indices", "indptr"):
        np.testing.assert_array_equal(getattr(one.G, part), getattr(other.G, part))


if __name__ == "__main__":
    for path in KERNELS:
        path.write_text(re.sub(r'^TAKES = ".*"', f'TAKES = "{digest()}"', path.read_text(), flags=re.M))
