"""Which effects a scene calls for, by what; an effect that nothing calls for is never simulated (before step 1)."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from symrt.scene.lights import AmbientLight, Light
from symrt.scene.records import Scene
from symrt.table import html_table, text_table

__all__ = ["Alternatives", "Effect", "Plan", "direct_lights", "mirroring", "plan"]

Alternatives = Mapping[str, Sequence[str]]
"""For a material, others that may take its place."""

HEAD = ("effect", "", "called for by", "rays at most")


@dataclass(frozen=True)
class Effect:
    """One effect, and what in the scene calls for it.

    Parameters
    ----------
    without
        Why it is left out where nothing calls for it.
    rays
        How many rays it may cost.
    """

    name: str
    called_by: tuple[str, ...]
    without: str
    rays: str

    @property
    def simulated(self) -> bool:
        """Whether the scene calls for it."""
        return bool(self.called_by)

    @property
    def row(self) -> tuple[str, str, str, str]:
        """The effect as a row of the plan's table."""
        if self.simulated:
            return self.name, "simulated", ", ".join(self.called_by), self.rays
        return self.name, "left out", self.without, "none"


@dataclass(frozen=True)
class Plan:
    """The effects that a trace will simulate, and those it leaves out because nothing calls for them."""

    effects: tuple[Effect, ...]

    def __contains__(self, name: str) -> bool:
        return any(effect.simulated for effect in self.effects if effect.name == name)

    def __str__(self) -> str:
        return text_table(HEAD, [effect.row for effect in self.effects])

    def _repr_html_(self) -> str:
        return html_table(HEAD, [effect.row for effect in self.effects])


def plan(scene: Scene, alternatives: Alternatives | None = None) -> Plan:
    """The effects that `scene`, traced with these `alternatives`, calls for, and why the others are left out.

    Examples
    --------
    >>> from symrt.scene import load_scene, shipped_scene
    >>> print(plan(load_scene(shipped_scene("first"))))
    effect                    called for by                    rays at most
    shadows        simulated  sun                              1 a hit
    mirrors        left out   no material mirrors              none
    ambient        left out   no light is ambient              none
    textures       left out   no surface has one               none
    supersampling  left out   the pixel's centre is asked for  none
    """
    mirrors = mirroring(scene, alternatives or {})
    casting = tuple(light.name for light in direct_lights(scene.lights) if light.shadows)
    ambient = tuple(light.name for light in scene.lights if isinstance(light, AmbientLight))
    n, pixels = scene.camera.samples, scene.camera.width * scene.camera.height
    supersampled = (f"camera.samples = {n}",) if n > 1 else ()
    unshadowed = "there is no shape" if casting else "no light casts any"
    unmirrored = "the depth is 0" if mirrors else "no material mirrors"
    return Plan(
        (
            Effect("shadows", casting if scene.shapes else (), unshadowed, f"{len(casting)} a hit"),
            Effect("mirrors", mirrors if scene.depth else (), unmirrored, f"{scene.depth} a sample"),
            Effect("ambient", ambient, "no light is ambient", "none"),
            Effect("textures", tuple(sorted(scene.used_textures)), "no surface has one", "none"),
            Effect("supersampling", supersampled, "the pixel's centre is asked for", f"{pixels * n * n}"),
        )
    )


def mirroring(scene: Scene, alternatives: Alternatives) -> tuple[str, ...]:
    """Names of the materials that mirror and that some shape is made of; ``sea>ice`` where only an alternative does."""
    mirrors = {m.name for m in scene.materials if m.reflection.mirrors}
    used = [m.name for m in scene.materials if m.name in scene.used_materials]
    others = (f"{name}>{other}" for name in used for other in alternatives.get(name, ()) if other in mirrors)
    return (*(name for name in used if name in mirrors), *others)


def direct_lights(lights: Iterable[Light | AmbientLight]) -> list[Light]:
    """The lights that come from somewhere; ambient light comes from everywhere, unshadowed."""
    return [light for light in lights if not isinstance(light, AmbientLight)]
