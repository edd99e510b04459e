"""The records of the effects that a plan names: what the tracer calls (step 1)."""

from dataclasses import dataclass

from symrt.tracing import effects
from symrt.tracing.effects.effect import Effect
from symrt.tracing.plan import Plan


@dataclass(frozen=True, eq=False)
class AtWork:
    """The records of the effects in a plan that are simulated, and of those that are left out and bounded.

    Parameters
    ----------
    simulated, bounded
        Effects in the order of the plan; the tracer calls no others.
    left_out
        Names of the bounded effects.
    """

    simulated: tuple[Effect, ...]
    bounded: tuple[Effect, ...]
    left_out: frozenset[str]

    @property
    def gathered(self) -> frozenset[str]:
        """The formulas that lights meet by which rays are sent on, too."""
        return frozenset(via for effect in (*self.simulated, *self.bounded) for via in effect.gathers)


def at_work(chosen: Plan) -> AtWork:
    """Look up the records of a plan's effects; the plan itself holds words only, so that it can be sent and kept."""
    by_name = {effect.name: effect for effect in effects.EFFECTS}
    simulated, bounded, left_out = [], [], []
    for planned in chosen.effects:
        if planned.state == "simulated":
            simulated.append(by_name[planned.name])
        elif planned.state == "left out, bounded":
            bounded.append(by_name[planned.name])
            left_out.append(planned.name)
    return AtWork(tuple(simulated), tuple(bounded), frozenset(left_out))
