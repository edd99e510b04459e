"""The cost of effects that nothing calls for in the scenes named, as JSON.

Run by `test_branches` where nothing else watches calls.
"""

import gc
import json
import sys
import tracemalloc

import numpy as np
from scenes_for_tests import small

from symrt import fast
from symrt.linear.collapse import run
from symrt.linear.program import make_program
from symrt.tracing import effects
from symrt.tracing.planner import first_plan
from symrt.tracing.stage import make_stage
from symrt.tracing.tracer import trace_window

WHOLE = effects.EFFECTS


SIZES = {"cornell": (16, 40), "lens": (16, 48), "many_lights": (8, 24), "prism": (16, 48)}
"""Pixels across the small and the large picture, of scenes that cost more than others."""


def traced(scene, listed):
    """A scene traced and collapsed with a list of effects: the tree, the system, calls, and peak bytes."""
    effects.EFFECTS = listed
    stage, chosen = make_stage(scene), first_plan(scene)
    program = make_program(stage.materials)
    run(program, trace_window(stage, chosen))  # what is made once is made

    calls = 0

    def count(_frame, event, _argument):
        nonlocal calls
        calls += event in ("call", "c_call")

    gc.collect()
    gc.disable()
    sys.setprofile(count)
    tree = trace_window(stage, chosen)
    system = run(program, tree)
    sys.setprofile(None)
    peaks = []
    for _ in range(3):
        gc.collect()
        tracemalloc.start()
        run(program, trace_window(stage, chosen))
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    gc.enable()
    return tree, system, calls, min(peaks)


def compared(scene):
    """The whole list against those effects that the plan simulates."""
    effects.EFFECTS = WHOLE
    kept = tuple(effect for effect in WHOLE if effect.name in first_plan(scene))
    cut, whole = traced(scene, kept), traced(scene, WHOLE)
    matrices = [(whole[1].G, cut[1].G), (whole[1].tail.bound, cut[1].tail.bound)]
    parts = ("data", "indices", "indptr")
    return {
        "same bits": all(np.array_equal(getattr(a, part), getattr(b, part)) for a, b in matrices for part in parts),
        "same rays": dict(whole[0].rays) == dict(cut[0].rays)
        and set(whole[0].rays) <= {"camera", *(effect.name for effect in kept)}
        and list(whole[0].counts.effects) == ["camera", *(effect.name for effect in kept)],
        "more calls": whole[2] - cut[2],
        "more bytes": whole[3] - cut[3],
        "bytes": cut[3],
        "left aside": len(WHOLE) - len(kept),
    }


if __name__ == "__main__":
    with fast.use(False):  # kernels are loaded at some point, which would count
        measured = {name: [compared(small(name, size)) for size in SIZES.get(name, (32, 96))] for name in sys.argv[1:]}
    print(json.dumps(measured))  # noqa: T201  # it is a script
