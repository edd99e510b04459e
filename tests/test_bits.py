"""Changes of form alone: G, tail and formulas of the shipped scenes stay as they were, bit for bit.

The hashes stand for symrt as it was before the tracer was made to carry effects.  A commit that moves a bit on purpose
says so and renews them: ``python tests/test_bits.py`` writes the new ones.
"""

import hashlib
import json
import sys
from pathlib import Path

import numpy as np
import pytest

import symrt as rt

if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).parent))
from scenes_for_tests import small

KEPT = Path(__file__).parent / "bits.json"

CASES = {
    "first": {"name": "first", "size": 64},
    "spheres": {"name": "spheres", "size": 64},
    "globe": {"name": "globe", "size": 64},
    "metals": {"name": "metals", "size": 48},
    "glass": {"name": "glass", "size": 32},
    "soft shadow": {"name": "soft_shadow", "size": 32},
    "lens": {"name": "lens", "size": 32},
    "many lights": {"name": "many_lights", "size": 32},
    "first, 3 x 3 samples": {"name": "first", "size": 24, "samples": 3},
    "spheres, 2 x 2 samples": {"name": "spheres", "size": 32, "samples": 2},
    "globe, 2 x 2 samples": {"name": "globe", "size": 32, "samples": 2},
    "spheres, free exponent": {"name": "spheres", "size": 24, "free": ["red.exponent"]},
    "globe, mirroring alternative": {"name": "globe", "size": 32, "alternatives": {"upland": ["brass", "ice"]}},
}


def canary() -> str:
    """A hash of functions whose last bit hangs on the processor: where it differs, sums are compared instead."""
    x = np.linspace(0.001, 0.999, 4001)
    wide = np.exp(np.longdouble(40) * np.log1p(-x.astype(np.longdouble))).astype(np.float64)
    values = [np.exp(x), np.log1p(-x), np.power(x, 5.0), np.arctan2(x, 1 - x), np.arcsin(x), np.cos(x), wide]
    return hashlib.sha256(np.concatenate(values).tobytes()).hexdigest()


def matrix_hash(matrix, interactions) -> str:
    digest = hashlib.sha256("; ".join(map(str, interactions)).encode())
    for part in (matrix.indptr.astype(np.int64), matrix.indices.astype(np.int64), matrix.data):
        digest.update(np.ascontiguousarray(part).tobytes())
    return digest.hexdigest()


def rendered(case: dict) -> rt.LinearSystem:
    scene = small(case["name"], case["size"], case.get("samples", 1))
    return rt.render(scene, free=case.get("free", ()), alternatives=case.get("alternatives"), progress=False)


def formula_hash(case: dict) -> str:
    """Every pixel of a small picture with its geometry in letters, to the last digit."""
    tree = rt.trace(small(case["name"], 16, case.get("samples", 1)), alternatives=case.get("alternatives"))
    digest = hashlib.sha256()
    for formula in rt.expressions(tree):
        values = {name: float(value).hex() for name, value in sorted(formula.values.items())}
        digest.update(f"{formula.text(digits=17)}; {values}; ".encode())
    return digest.hexdigest()


def record(case: dict) -> dict:
    """What is kept of a case: hashes, and the sum of each column for other processors."""
    system = rendered(case)
    return {
        "G": matrix_hash(system.G, system.interactions),
        "tail": matrix_hash(system.tail.bound, system.tail.interactions),
        "formulas": formula_hash(case),
        "columns": [str(interaction) for interaction in system.interactions],
        "sums": [float(total) for total in system.G.sum(axis=0)],
        "tail sums": [float(total) for total in system.tail.bound.sum(axis=0)],
    }


@pytest.mark.parametrize("name", CASES)
def test_a_change_of_form_moves_no_bit(name):
    kept = json.loads(KEPT.read_text())
    before, now = kept["cases"][name], record(CASES[name])
    assert now["columns"] == before["columns"]
    np.testing.assert_allclose(now["sums"], before["sums"], rtol=1e-12)
    np.testing.assert_allclose(now["tail sums"], before["tail sums"], rtol=1e-12)
    if canary() == kept["canary"]:
        assert (now["G"], now["tail"], now["formulas"]) == (before["G"], before["tail"], before["formulas"])


if __name__ == "__main__":
    everything = {"canary": canary(), "cases": {name: record(case) for name, case in CASES.items()}}
    KEPT.write_text(json.dumps(everything, indent=1) + "\n")
