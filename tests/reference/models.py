"""Models of reflection: each is a few formulas, and each formula the shares that its components send to the eye.

`direct` is a share of the irradiance on a surface that faces the light, `ambient` of light from everywhere, and
`reflected` of what a ray of that name brings.  A share that belongs to no component, "", is the same in all bands.
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


def mirror(_: Seen, __: Table) -> Shares:
    return [("mirror", 1.0)]


MODELS: dict[str, Model] = {
    "lambert": {"direct": lambert, "ambient": from_everywhere},
    "phong": {"direct": phong, "ambient": from_everywhere},
    "phong_plain": {"direct": phong_plain, "ambient": from_everywhere},
    "blinn_phong": {"direct": blinn_phong, "ambient": from_everywhere},
    "mirror": {"reflected": mirror},
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
