"""Step 1: trace a scene once and record the tree of rays."""

from symrt.tracing.plan import Plan, Planned
from symrt.tracing.planner import plan
from symrt.tracing.probe import Meeting, Probe, probe
from symrt.tracing.raytree import RayTree
from symrt.tracing.tracer import trace

__all__ = ["Meeting", "Plan", "Planned", "Probe", "RayTree", "plan", "probe", "trace"]
