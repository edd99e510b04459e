"""The rays that effects send on from the hits of one level to the next (step 1)."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from symrt.geometry.rays import Rays
from symrt.tracing.effects.effect import CARRIED, Sent
from symrt.tracing.gathering import GATHERED
from symrt.tracing.raytree import Branch, Points
from symrt.tracing.stage import Stage
from symrt.tracing.view import WINDOW, Batch, State, View
from symrt.tracing.work import AtWork


@dataclass(frozen=True, eq=False)
class Onwards:
    """The rays that hits send on.

    Parameters
    ----------
    batch
        Those that are followed, together.
    followed
        The same, each part with the name of its effect.
    cut
        Those that are not followed, and bounded.
    """

    batch: Batch
    followed: Sequence[tuple[str, Sent]]
    cut: tuple[Branch, ...]


def rays_onwards(
    stage: Stage, effects: AtWork, view: View, here: tuple[Points, ...], tolerance: float, *, level: int
) -> Onwards:
    """The rays that all effects send on from a level, down to the stage's depth."""
    cut = [one for effect in effects.bounded if effect.onwards for one in effect.onwards(stage, view, here)]
    followed: list[tuple[str, Sent]] = []
    for effect in effects.simulated:
        for one in effect.onwards(stage, view, here) if effect.onwards else ():
            enough, rest = _parted(one, view.state, tolerance)
            within, beyond = _within(enough, stage.depth, level, view.state)
            followed += [(effect.name, sent) for sent in within]
            cut += beyond + rest
    return Onwards(_joined(view, [one for _, one in followed]), followed, tuple(map(_branch, cut)))


def _parted(sent: Sent, state: State, tolerance: float) -> tuple[list[Sent], list[Sent]]:
    """The rays that carry enough of their film samples' light to be followed, and the others."""
    if sent.share is None or CARRIED not in state:
        return [sent], []
    carried = state[CARRIED][sent.hit] * sent.share
    sent = replace(sent, state={**sent.state, CARRIED: carried})
    enough = carried >= tolerance
    if enough.all():
        return [sent], []
    return [sent.of(np.flatnonzero(enough))] if enough.any() else [], [sent.of(np.flatnonzero(~enough))]


def _within(sent: list[Sent], depth: int, level: int, state: State) -> tuple[list[Sent], list[Sent]]:
    """The rays that are followed, and those beyond the depth, in which the bounces of gathered light do not count."""
    followed, cut = [], []
    for one in sent:
        if one.rays is None or (GATHERED not in state and level >= depth):
            cut.append(one)
        elif GATHERED not in state or GATHERED in one.state:
            followed.append(one)
        else:
            within = level - state[GATHERED][one.hit] < depth
            followed.append(one.of(np.flatnonzero(within)))
            cut.append(one.of(np.flatnonzero(~within)))
    return followed, cut


def _branch(sent: Sent) -> Branch:
    return Branch(sent.via, sent.hit, sent.weight, sent.factors, sent.materials, sent.state.get(WINDOW))


def _joined(view: View, sent: Sequence[Sent]) -> Batch:
    """Join all rays that were sent on into one batch; effects' states are inherited where they did not change."""
    followed = [one.rays for one in sent if one.rays is not None]
    if not followed:
        none = np.empty((3, 0))
        return Batch(Rays(none, none), np.empty(0, dtype=np.int64), (), {})

    # The rays; −1 where no shape is known that a ray has left for good.
    rays = Rays(
        np.concatenate([one.origin for one in followed], axis=1),
        np.concatenate([one.direction for one in followed], axis=1),
        np.concatenate([np.full(len(one), -1, np.int32) if one.left is None else one.left for one in followed]),
    )

    # The film sample and the states of the hits that they left.
    sample = np.concatenate([view.sample[one.hit] for one in sent])
    state = {
        name: np.concatenate([one.state[name] if name in one.state else values[one.hit] for one in sent])
        for name, values in view.state.items()
    }
    return Batch(rays, sample, tuple(map(_branch, sent)), state)
