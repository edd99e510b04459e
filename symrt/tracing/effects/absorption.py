"""Absorption: light that goes a length d through glass is left T^d, a power of its transmittance (an effect of step 1).

The law is Beer's and Lambert's.  A ray remembers the glass that it has entered and not left, one within the other, so
that an opaque thing, a bubble or other glass may stand inside; rays that are mirrored inside stay there.  The glass
that a ray enters is the one whose formula lets it in; it leaves that again, or else the innermost.

Light from lamps is not followed through glass, whose shadows are full: on what stands inside of glass only lamps
inside, ambient light and lamps without shadows shine, and what they bring is absorbed on its way to the viewer only.
"""

from collections.abc import Iterator

import numpy as np
from jaxtyping import Int

from symrt.arrays import dot
from symrt.geometry.rays import Hits, clearance, encloses
from symrt.scene.records import Scene
from symrt.symbols import Surface, named
from symrt.tracing.effects.effect import Call, Effect, Segment
from symrt.tracing.stage import Alternatives, Stage, senders
from symrt.tracing.view import Batch, View

MEDIA = "media"
"""The state that keeps the glasses that a ray is inside of: their numbers as digits, the innermost last."""
OUTSIDE = "outside"
"""The state that keeps whether a ray left from the outer side of a surface."""
BITS = 62
"""Binary digits of a ray's glasses; of more than fit, the outermost are forgotten."""

Media = Int[np.ndarray, " ray"]


def _call(scene: Scene, alternatives: Alternatives) -> Call:
    clear = senders(scene, alternatives, "transmitted")
    absorbing = (name for name in clear if scene.material(Surface.of(name).material).reflection.inside != 0)
    return Call(tuple(absorbing), without="no glass absorbs")


def _segment(stage: Stage, batch: Batch, view: View, hits: Hits) -> Segment:
    """The lengths that rays went in each absorbing glass, from where they left to their hits."""
    # Glasses by their numbers, from 1; the last digit of a ray's is the innermost that it is in.
    glasses = tuple(name for name, record in stage.materials.items() if record.model.refracts)
    base = len(glasses) + 1
    media = _entered(batch, glasses, base) if batch.branches else _around_the_eye(stage, batch, glasses, base)

    inside = {}
    for number, name in enumerate(glasses, start=1):
        formula = stage.materials[name].model.inside
        through = media % base == number
        if formula != 0 and through.any():
            inside[named(name, formula.name)] = np.where(through & np.isfinite(hits.distance), hits.distance, 0.0)
    outside = dot(view.surface.normal, view.viewer) > 0
    return Segment(inside, {MEDIA: media, OUTSIDE: outside})


def _around_the_eye(stage: Stage, batch: Batch, glasses: tuple[str, ...], base: int) -> Media:
    """The glasses that the camera, at the origin, is inside of; the one whose surface is nearest is the innermost."""
    eye = np.zeros(3)
    around = sorted(
        (-clearance(shape, eye), number)
        for first, shape in zip(stage.first_slot, stage.seen, strict=False)  # after them comes the sky
        for number in [_glass_of(stage, stage.slots[first], glasses)]
        if number and encloses(shape, eye)
    )
    media = 0
    for _, number in around:
        media = media * base + number
    return np.full(batch.sample.size, media)


def _glass_of(stage: Stage, name: str, glasses: tuple[str, ...]) -> int:
    """The number of the glass that a slot, of a material or of a texture, is made of; 0 if it is of none."""
    materials = getattr(stage.textures.get(name), "materials", (name,))
    return next((glasses.index(material) + 1 for material in materials if material in glasses), 0)


def _entered(batch: Batch, glasses: tuple[str, ...], base: int) -> Media:
    """The glasses that rays are inside of, after those that went through a surface have entered or left one."""
    media, outside = batch.state[MEDIA].copy(), batch.state[OUTSIDE]
    for own, number in _through(batch, glasses):
        before = media[own]
        media[own] = np.where(outside[own], _put(before, number, base), _taken(before, number, base))
    return media


def _through(batch: Batch, glasses: tuple[str, ...]) -> Iterator[tuple[slice, int]]:
    """The rays of each branch that went through a surface, and the number of the glass that let them."""
    first = 0
    for branch in batch.branches:
        if branch.via == "transmitted":
            sending = [k for k, name in enumerate(glasses, start=1) if branch.materials and name in branch.materials]
            yield slice(first, first + branch.size), sending[0]
        first += branch.size


def _put(media: Media, number: int, base: int) -> Media:
    """The glasses with another one innermost.

    Examples
    --------
    >>> _put(np.array([0, 2]), 1, 3).tolist()
    [1, 7]
    """
    return media % base ** (int(BITS / np.log2(base)) - 1) * base + number


def _taken(media: Media, number: int, base: int) -> Media:
    """The glasses without the innermost of a number; where it is not there, without the innermost of all.

    Examples
    --------
    >>> [_taken(np.array([7]), number, 3).tolist() for number in (1, 2)]
    [[2], [1]]
    """
    left = np.where(media > 0, media // base, 0)
    found = np.zeros(media.shape, dtype=bool)
    place = 1
    while (rest := media // place).any():
        here = ~found & (rest % base == number)
        left = np.where(here, rest // base * place + media % place, left)
        found |= here
        place *= base
    return left


ABSORPTION = Effect("absorption", _call, segment=_segment)
