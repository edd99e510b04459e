"""Which effects a scene calls for, by what; an effect that nothing calls for is never simulated (before step 1)."""

from dataclasses import dataclass

from symrt.scene.records import Scene

__all__ = ["Effect", "Plan", "plan"]


@dataclass(frozen=True)
class Effect:
    """One effect: what it does, and what in the scene calls for it; nothing does where `called_by` is empty."""

    name: str
    does: str
    called_by: tuple[str, ...]
    rays: str

    @property
    def simulated(self) -> bool:
        """Whether the scene calls for it."""
        return bool(self.called_by)


@dataclass(frozen=True)
class Plan:
    """The effects a trace will simulate, and those it leaves out because nothing calls for them."""

    effects: tuple[Effect, ...]

    def __contains__(self, name: str) -> bool:
        return any(effect.simulated for effect in self.effects if effect.name == name)

    def __str__(self) -> str:
        rows = [
            (e.name, "simulated" if e.simulated else "left out", ", ".join(e.called_by) or f"nothing {e.does}", e.rays)
            for e in self.effects
        ]
        head = ("effect", "", "called for by", "rays at most")
        widths = [max(len(row[column]) for row in (head, *rows)) for column in range(4)]
        return "\n".join(
            "  ".join(f"{cell:<{w}}" for cell, w in zip(row, widths, strict=True)).rstrip() for row in (head, *rows)
        )

    def _repr_html_(self) -> str:
        cells = "".join(
            f"<tr><td>{e.name}</td><td>{'simulated' if e.simulated else 'left out'}</td>"
            f"<td>{', '.join(e.called_by) or f'nothing {e.does}'}</td><td>{e.rays}</td></tr>"
            for e in self.effects
        )
        return f"<table><tr><th>effect</th><th></th><th>called for by</th><th>rays at most</th></tr>{cells}</table>"


def plan(scene: Scene) -> Plan:
    """The effects that `scene` calls for, and why the others are left out.

    Examples
    --------
    >>> from symrt.scene import load_scene, shipped_scene
    >>> chosen = plan(load_scene(shipped_scene("first")))
    >>> "mirrors" in chosen
    False
    """
    samples = scene.camera.samples
    pixels = scene.camera.width * scene.camera.height
    direct = [light for light in scene.lights if not is_ambient(light)]
    used = {material.name: material for material in scene.materials if material.name in scene.used_materials}
    mirrors = tuple(name for name, material in used.items() if material.reflection.mirrors)
    blockers = tuple(light.name for light in direct if light.shadows) if scene.shapes else ()
    return Plan(
        (
            Effect("shadows", "casts shadows", blockers, f"{len(blockers)} a hit"),
            Effect(
                "mirrors", "is a mirror", mirrors if scene.depth else (), f"{scene.depth if mirrors else 0} a sample"
            ),
            Effect("ambient", "is ambient", tuple(light.name for light in scene.lights if is_ambient(light)), "0"),
            Effect(
                "textures", "is textured", tuple(t.name for t in scene.textures if t.name in scene.used_textures), "0"
            ),
            Effect(
                "supersampling",
                "asks for more than one sample",
                (f"camera.samples = {samples}",) if samples > 1 else (),
                f"{pixels * samples**2}",
            ),
        )
    )


def is_ambient(light: object) -> bool:
    """Whether a light comes from everywhere, unshadowed."""
    return getattr(light, "type", None) == "ambient"
