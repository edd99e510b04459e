"""Step 1: trace a scene once and record the tree of rays."""

from symrt.tracing.plan import Expectation, Expected, Plan, Planned
from symrt.tracing.planner import first_plan
from symrt.tracing.probe import Branching, Meeting, Probe, probe
from symrt.tracing.raytree import RayTree
from symrt.tracing.tracer import trace

__all__ = [
    "Branching",
    "Expectation",
    "Expected",
    "Meeting",
    "Plan",
    "Planned",
    "Probe",
    "RayTree",
    "first_plan",
    "probe",
    "trace",
]
