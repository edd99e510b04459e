"""Models of reflection: each is a few formulas, and each formula the shares that its components send to the eye.

`direct` is a share of the irradiance on a surface that faces the light, `ambient` of light from everywhere, `reflected`
of what a ray of that name brings, and `emitted` of the light that the surface sends by itself.  A share that belongs to
no component, "", is the same in all bands.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

from reference.records import Table
from reference.vectors import Vector, add, dot, mirrored, unit


class Seen(NamedTuple):
    """The unit vectors at a point of a surface; `to_light` is where a ray goes, and None for ambient light."""

    normal: Vector
    to_eye: Vector
    to_light: Vector | None = None

    @property
    def n_l(self) -> float:
        return max(0.0, dot(self.normal, self.to_light))

    @property
    def n_v(self) -> float:
        return max(0.0, dot(self.normal, self.to_eye))

    @property
    def n_h(self) -> float:
        return max(0.0, dot(self.normal, unit(add(self.to_light, self.to_eye))))

    @property
    def h_v(self) -> float:
        return max(0.0, dot(unit(add(self.to_light, self.to_eye)), self.to_eye))

    @property
    def r_v(self) -> float:
        return max(0.0, dot(mirrored(self.to_light, self.normal), self.to_eye))


Shares = list[tuple[str, float]]
Formula = Callable[[Seen, Table], Shares]
Model = dict[str, Formula]


def lambert(at: Seen, _: Table) -> Shares:
    return [("diffuse", at.n_l / math.pi)]


def phong(at: Seen, material: Table) -> Shares:
    s = material["exponent"]
    return [*lambert(at, material), ("specular", (s + 2) / (2 * math.pi) * at.r_v**s * at.n_l)]


def phong_plain(at: Seen, material: Table) -> Shares:
    return [*lambert(at, material), ("specular", at.r_v ** material["exponent"] / math.pi)]


def blinn_phong(at: Seen, material: Table) -> Shares:
    s = material["exponent"]
    return [*lambert(at, material), ("specular", (s + 8) / (8 * math.pi) * at.n_h**s * at.n_l)]


def from_everywhere(_: Seen, __: Table) -> Shares:
    return [("diffuse", 1.0)]


def fluorescent(at: Seen, _: Table) -> Shares:
    """As a diffuser, by a matrix from the bands that light arrives in to those that it leaves in."""
    return [("fluorescence", at.n_l / math.pi)]


def mirror(_: Seen, __: Table) -> Shares:
    return [("mirror", 1.0)]


def metal(at: Seen, _: Table) -> Shares:
    """Schlick's formula, f0 + (1 - f0)(1 - cos)^5."""
    edge = (1 - at.n_v) ** 5
    return [("f0", 1 - edge), ("", edge)]


def metal_f82(at: Seen, material: Table) -> Shares:
    """Schlick's formula less a (its value where cos is 1/7 - f82), where a is cos (1 - cos)^6 over its value there."""
    bend = at.n_v * (1 - at.n_v) ** 6 / (1 / 7 * (6 / 7) ** 6)
    there = (6 / 7) ** 5
    return [*metal(at, material), ("f0", -bend * (1 - there)), ("", -bend * there), ("f82", bend)]


def rough_metal(at: Seen, material: Table) -> Shares:
    s, edge = material["exponent"], (1 - at.h_v) ** 5
    lobe = (s + 8) / (8 * math.pi) * at.n_h**s * at.n_l
    return [("f0", lobe * (1 - edge)), ("", lobe * edge)]


def all_of_it(_: Seen, __: Table) -> Shares:
    """What a ray of glass brings: the ray itself has Fresnel's share."""
    return [("", 1.0)]


def evenly(_: Seen, __: Table) -> Shares:
    """The same radiance in all directions."""
    return [("", 1.0)]


MODELS: dict[str, Model] = {
    "lambert": {"direct": lambert, "ambient": from_everywhere},
    "phong": {"direct": phong, "ambient": from_everywhere},
    "phong_plain": {"direct": phong_plain, "ambient": from_everywhere},
    "blinn_phong": {"direct": blinn_phong, "ambient": from_everywhere},
    "fluorescent": {"direct": fluorescent, "ambient": lambda *_: [("fluorescence", 1.0)]},
    "mirror": {"reflected": mirror},
    "emitter": {"emitted": evenly},
    "metal": {"reflected": metal},
    "metal_f82": {"reflected": metal_f82},
    "glass": {"reflected": all_of_it, "transmitted": all_of_it},
    "absorption": {},
    "rough_metal": {"direct": rough_metal},
}


def formulas(material: Table, via: str) -> list[Formula]:
    """The formulas of one name, of all models stacked in a material: names from the table above, or one's own."""
    named = material.get("model", "lambert")
    models = [
        MODELS[model] if isinstance(model, str) else model for model in (named if isinstance(named, list) else [named])
    ]
    return [model[via] for model in models if via in model]


def shares(material: Table, via: str, at: Seen) -> Shares:
    """The components of a material, each with the share that it sends to the eye by one formula."""
    return [share for formula in formulas(material, via) for share in formula(at, material)]
