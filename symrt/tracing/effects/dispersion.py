"""Dispersion: glass whose index changes with the wavelength bends parts of the spectrum apart (an effect of step 1).

A view that meets such glass is split into one ray for each window of wavelengths, by the index at the window's centre,
and its columns are those of that window from there on; nowhere else does a window cost a ray.  Windows are hats that
sum to 1: at their centres a picture is what it would be with that wavelength traced by itself, and between two centres
a mixture of theirs.  Total reflection is decided, and rays that carry too little are ended, window by window.

Behind a ball of N-SF11 on a floor of hard tiles (64 × 64 pixels, 36 bands, against each band traced by itself) the
radiance of the ball's pixels is wrong by these shares of its mean; on a display, where bands are summed, by less:

=======  =============  ====  =========
windows  mean, by band  rms   rms, sRGB
=======  =============  ====  =========
3        10 %           38 %  22 %
6        4 %            23 %  8 %
12       1.6 %          15 %  5 %
24       0.8 %          11 %  2.6 %
=======  =============  ====  =========

Left out, all wavelengths are bent by the index in the middle of the windows.  What is seen by way of such glass is
then not where it should be: all of it is bounded in the tail, so that certificates hold but are coarse.
"""

import numpy as np

from symrt.geometry.rays import Rays
from symrt.scene.records import Scene
from symrt.symbols import Surface
from symrt.tracing.effects.effect import Call, Effect, Sent
from symrt.tracing.effects.refraction import Meeting, interface_of
from symrt.tracing.raytree import Points
from symrt.tracing.stage import Alternatives, Stage, refracting
from symrt.tracing.view import WINDOW, View


def _call(scene: Scene, alternatives: Alternatives) -> Call:
    dispersing = {material.name for material in scene.materials if material.dispersion is not None}
    return Call(
        tuple(name for name in refracting(scene, alternatives) if Surface.of(name).material in dispersing),
        without="no index changes with the wavelength",
        rays=f"{len(scene.nodes)} where a view meets it first",
        left_out="" if scene.depth else "the depth is 0",
        onwards=len(scene.nodes),
    )


def _onwards(stage: Stage, view: View, points: tuple[Points, ...]) -> tuple[Sent, ...]:
    """Nothing where refraction splits the rays; else rays that stand for those of all windows, to be bounded."""
    if WINDOW in view.state:
        return ()
    found = []
    for part in points:
        record = stage.materials[part.material]
        if record.indices:
            # The largest share that any window has of either way; the rays themselves are not followed.
            met = [interface_of(view, Meeting(part.material, part.hit, part.weight, index)) for index in record.indices]
            factors = {
                "fresnel": np.max([one.mirrored for one in met], axis=0),
                "transmission": np.max([one.through for one in met], axis=0),
            }
            nowhere = Rays(view.surface.point[:, part.hit], -view.viewer[:, part.hit])
            whole, materials = np.ones(part.hit.size), frozenset({part.material})
            sending = sorted(record.model.sending)
            found += [Sent(via, part.hit, nowhere, whole, factors, materials=materials) for via in sending]
    return tuple(found)


DISPERSION = Effect("dispersion", _call, onwards=_onwards, state={WINDOW: -1})
