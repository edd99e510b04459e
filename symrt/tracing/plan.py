"""Which effects a scene calls for, by what; an effect that nothing calls for is never simulated (before step 1)."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from symrt.scene.lights import AmbientLight, Light
from symrt.scene.records import Scene

__all__ = ["Effect", "Plan", "direct_lights", "plan"]

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
        rows = [HEAD, *(effect.row for effect in self.effects)]
        widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
        return "\n".join("  ".join(map(str.ljust, row, widths)).rstrip() for row in rows)

    def _repr_html_(self) -> str:
        rows = [f"<tr>{''.join(f'<td>{cell}</td>' for cell in effect.row)}</tr>" for effect in self.effects]
        return f"<table><tr>{''.join(f'<th>{cell}</th>' for cell in HEAD)}</tr>{''.join(rows)}</table>"


def plan(scene: Scene) -> Plan:
    """The effects that `scene` calls for, and why the others are left out.

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
    materials, textures = used(scene)
    mirrors = tuple(m.name for m in scene.materials if m.name in materials and m.reflection.mirrors)
    casting = tuple(light.name for light in direct_lights(scene.lights) if light.shadows)
    ambient = tuple(light.name for light in scene.lights if isinstance(light, AmbientLight))
    n, pixels = scene.camera.samples, scene.camera.width * scene.camera.height
    supersampled = (f"camera.samples = {n}",) if n > 1 else ()
    return Plan(
        (
            Effect("shadows", casting if scene.shapes else (), "no light casts any", f"{len(casting)} a hit"),
            Effect("mirrors", mirrors if scene.depth else (), "no material mirrors", f"{scene.depth} a sample"),
            Effect("ambient", ambient, "no light is ambient", "none"),
            Effect("textures", tuple(sorted(textures)), "no surface has one", "none"),
            Effect("supersampling", supersampled, "the pixel's centre is asked for", f"{pixels * n * n}"),
        )
    )


def used(scene: Scene) -> tuple[frozenset[str], frozenset[str]]:
    """Names of the materials and of the textures that some shape is made of."""
    named = {name for shape in scene.shapes for name in _names(shape.material)}
    textures = {texture.name: texture for texture in scene.textures if texture.name in named}
    within = {name for texture in textures.values() for name in texture.materials}
    return frozenset((named | within) - set(textures)), frozenset(textures)


def direct_lights(lights: Iterable[Light | AmbientLight]) -> list[Light]:
    """The lights that come from somewhere; ambient light comes from everywhere, unshadowed."""
    return [light for light in lights if not isinstance(light, AmbientLight)]


def _names(material: str | Mapping[str, str]) -> tuple[str, ...]:
    return tuple(material.values()) if isinstance(material, Mapping) else (material,)
