"""The effects that symrt can simulate: one file each, and this list.

A scene pays only for the effects that something in it calls for.  To add one, write its file and put its record into
`EFFECTS`; the plan, the tracer, the tail and the formulas ask the list.
"""

from symrt.tracing.effects.absorption import ABSORPTION
from symrt.tracing.effects.ambient import AMBIENT
from symrt.tracing.effects.caustics import CAUSTICS
from symrt.tracing.effects.dispersion import DISPERSION
from symrt.tracing.effects.effect import Call, Effect, Passed, Segment, Sent
from symrt.tracing.effects.emission import EMISSION
from symrt.tracing.effects.environment import ENVIRONMENT
from symrt.tracing.effects.film import SUPERSAMPLING
from symrt.tracing.effects.fluorescence import FLUORESCENCE
from symrt.tracing.effects.footprints import FOOTPRINTS
from symrt.tracing.effects.interreflection import INTERREFLECTION
from symrt.tracing.effects.lens import LENS
from symrt.tracing.effects.mirrors import MIRRORS
from symrt.tracing.effects.penumbrae import PENUMBRAE
from symrt.tracing.effects.refraction import REFRACTION
from symrt.tracing.effects.shadows import SHADOWS
from symrt.tracing.effects.textures import TEXTURES

EFFECTS: tuple[Effect, ...] = (
    SHADOWS,
    PENUMBRAE,
    MIRRORS,
    REFRACTION,
    DISPERSION,
    ABSORPTION,
    CAUSTICS,
    INTERREFLECTION,
    AMBIENT,
    EMISSION,
    ENVIRONMENT,
    FLUORESCENCE,
    TEXTURES,
    FOOTPRINTS,
    LENS,
    SUPERSAMPLING,
)

__all__ = ["EFFECTS", "Call", "Effect", "Passed", "Segment", "Sent"]
