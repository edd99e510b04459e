"""Fluorescence: paints that give light back at other wavelengths, ``material = diag(r) + Σ_q v_q u_qᵀ``.

It costs no ray: such a component is a matrix in place of a spectrum, and its rays go where all others do.  But matrices
do not commute, so that columns keep the order in which light met them; Γ multiplies them so, when a palette is given.
"""

from symrt.scene.records import Scene
from symrt.symbols import Surface
from symrt.tracing.effects.effect import Call, Effect
from symrt.tracing.stage import Alternatives


def _call(scene: Scene, alternatives: Alternatives) -> Call:
    used = [m.name for m in scene.materials if m.name in scene.used_materials]
    others = [str(Surface(other, instead_of=name)) for name in used for other in alternatives.get(name, ())]
    named = [name for name in (*used, *others) if scene.material(Surface.of(name).material).reflection.fluorescent]
    return Call(tuple(named), without="no material fluoresces")


FLUORESCENCE = Effect(
    "fluorescence", _call, needed="its light is in columns of its own; give an excitation of 0 in the palette"
)
