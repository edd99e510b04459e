"""Step 1: trace a scene once and record the tree of rays."""

from symrt.tracing.plan import Effect, Plan, plan
from symrt.tracing.raytree import RayTree
from symrt.tracing.tracer import trace

__all__ = ["Effect", "Plan", "RayTree", "plan", "trace"]
