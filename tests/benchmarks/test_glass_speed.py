"""The cost of glass against an opaque ball in its place, in a processor's seconds."""

import time

import pytest
from benchmarks.pairs import ratio
from tracing.test_dispersion import ball

import symrt as rt

pytestmark = pytest.mark.benchmark

# What is aimed at is 3 times and 10 times; measured were 3.6 to 3.8 and, for N-SF11, 10 to 15 on a busy machine.
MOST = {"glass": 4.5, "6 windows": 19.0}


@pytest.mark.parametrize("what", MOST)
def test_a_ball_of_glass_costs_a_few_opaque_ones(what, report, benchmark):
    medium = {"index": 1.6} if what == "glass" else {"glass": "N-SF11"}
    clear, opaque = ball(6, depth=6, size=192, **medium), ball(6, depth=6, size=192)
    times, one, other = ratio(
        lambda: rt.collapse(rt.trace(clear)), lambda: rt.collapse(rt.trace(opaque)), pairs=5, clock=time.process_time
    )
    benchmark.pedantic(lambda: rt.trace(clear), rounds=1)
    report(f"a ball of {what}, depth 6: {times:.1f} opaque ones ({one * 1e3:.0f} against {other * 1e3:.0f} ms)")
    assert times <= MOST[what]
