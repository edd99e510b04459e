"""The tracer: radiance along a ray, by recursion; spectra are multiplied as the light travels.

A hit sends on ``Σ weight · (emitted + Σ light · direct + Σ light · ambient + Σ formula · next hit)``, the last sum over
all the rays that the scene's rules send on from it, each by one formula of the hit's materials.
"""

from collections.abc import Mapping
from functools import partial

from reference.models import Seen, formulas, shares
from reference.records import Hit, Illumination, Ray, Scene, Spectrum
from reference.shapes import group
from reference.vectors import Vector, dot, mirrored, scale


def radiance(
    scene: Scene,
    spectra: Mapping[str, Spectrum],
    origin: Vector,
    direction: Vector,
    bounces: int,
    carried: float = 1.0,
    via: str = "",
    within: tuple[str, ...] = (),
) -> Spectrum:
    """Radiance against `direction`, in every band; rays are followed for so many more bounces.

    The ray carries a share of what its sample of the film sees, and was sent on by a formula, or by the camera; it runs
    within glasses, the innermost last.
    """
    black = [0.0] * len(next(iter(spectra.values())))
    hit = nearest(scene, origin, direction, seeing=True)
    if hit is None or hit.material in scene.lamps:
        seen = light_itself(scene, spectra, hit, direction, via)
        return dimmed(spectra, within, hit, seen) if hit else seen

    # Both normals turn to the eye, and the materials there share the point.
    to_eye = scale(-1, direction)
    normal = turned(hit.normal, to_eye)
    inside = dot(hit.normal, to_eye) < 0
    hit = hit._replace(normal=normal, shading=turned(hit.shading, normal), from_inside=inside)
    weights = scene.textures[hit.material](hit) if hit.material in scene.textures else {hit.material: 1.0}

    # The light that the hit sends by itself, and of that of the lamps what its materials send on.
    total = list(black)
    for rule in scene.emitting:
        for light, amount in rule(hit, to_eye).items():
            gather(total, amount, spectra[light])
    for name, weight in weights.items():
        from_lights(total, scene, spectra, hit, to_eye, name, weight)

    # What further rays bring; beyond the depth they are cut off.
    for ray in (ray for rule in scene.sending for ray in rule(hit, to_eye)):
        senders = {name: weight for name, weight in weights.items() if ray.of is None or name in ray.of}
        meeting = {name: weight for name, weight in senders.items() if formulas(scene.materials[name], ray.via)}
        # The largest share that the ray may carry on: reflectances are at most 1.
        onwards = carried * ray.weight * sum(meeting.values())
        if not meeting or onwards < scene.least:
            continue
        if bounces > 0:
            how = (bounces - 1, onwards, ray.via, after(within, hit, ray))
            arriving = radiance(scene, spectra, hit.point, ray.direction, *how)
        else:
            arriving = black if scene.beyond is None else spectra[scene.beyond]
        for name, weight in meeting.items():
            for component, share in shares(scene.materials[name], ray.via, Seen(hit.shading, to_eye, ray.direction)):
                gather(total, weight * ray.weight * share, arriving, reflectance(spectra, name, component))

    return dimmed(spectra, within, hit, total)


def dimmed(spectra: Mapping[str, Spectrum], within: tuple[str, ...], hit: Hit, light: Spectrum) -> Spectrum:
    """Light from a hit as the innermost glass on its way leaves it."""
    left = spectra.get(f"{within[-1]}.transmittance") if within else None
    return list(light) if left is None else [x * share**hit.distance for x, share in zip(light, left, strict=True)]


def after(within: tuple[str, ...], hit: Hit, ray: Ray) -> tuple[str, ...]:
    """The glasses that a ray runs within once it has left a hit."""
    if ray.via != "transmitted" or not ray.of:
        return within
    if not hit.from_inside:
        return (*within, *ray.of)
    last = max((k for k, name in enumerate(within) if name in ray.of), default=len(within) - 1)
    return within[:last] + within[last + 1 :]


def light_itself(
    scene: Scene, spectra: Mapping[str, Spectrum], lamp: Hit | None, direction: Vector, via: str
) -> Spectrum:
    """The radiance of a lamp, from its front, or of the sky; a surface that gathers light is lit by them already."""
    total = [0.0] * len(next(iter(spectra.values())))
    if via == "direct":
        return total
    if lamp is not None:
        return list(spectra[lamp.material]) if dot(lamp.normal, direction) < 0 else total
    for sky in scene.skies:
        for light, amount in sky(direction).items():
            gather(total, amount, spectra[light])
    return total


def mirror_ray(hit: Hit, to_eye: Vector) -> list[Ray]:
    """The ray along the mirrored view; none where a smoothed normal sends it into the surface."""
    onward = mirrored(to_eye, hit.shading)
    return [Ray("reflected", onward)] if dot(onward, hit.normal) > 0 else []


def from_lights(
    total: Spectrum, scene: Scene, spectra: Mapping[str, Spectrum], hit: Hit, to_eye: Vector, name: str, weight: float
) -> None:
    """Add what one material sends to the eye of the light that reaches it from the lights themselves."""
    material = scene.materials[name]
    for light, ways in scene.lights.items():
        for way in ways(hit.point):
            if reaches(scene, light, way, hit):
                for component, share in shares(material, "direct", Seen(hit.shading, to_eye, way.direction)):
                    part = weight * way.irradiance * share
                    gather(total, part, spectra[light], reflectance(spectra, name, component))
    for light, lamp in scene.lamps.items():
        for way in lamp(hit, partial(free, scene, light, hit)):
            for component, share in shares(material, "direct", Seen(hit.shading, to_eye, way.direction)):
                part = weight * way.irradiance * share
                gather(total, part, spectra[light], reflectance(spectra, name, component))
    everywhere = [(light, "ambient") for light in scene.ambient]
    by_itself = [(light, "emitted") for light, glowing in scene.glowing.items() if glowing == name]
    for light, via in everywhere + by_itself:
        for component, share in shares(material, via, Seen(hit.shading, to_eye)):
            gather(total, weight * share, spectra[light], reflectance(spectra, name, component))


def reaches(scene: Scene, light: str, way: Illumination, hit: Hit) -> bool:
    """True unless a light is behind the surface, or hidden by another."""
    if dot(way.direction, hit.normal) <= 0 or dot(way.direction, hit.shading) <= 0:
        return False
    return free(scene, light, hit, way.direction, way.distance)


def free(scene: Scene, light: str, hit: Hit, direction: Vector, distance: float) -> bool:
    """True unless something stands before a distance, or the light shines through all."""
    blocker = None if light in scene.unshadowed else nearest(scene, hit.point, direction)
    return blocker is None or blocker.distance >= distance


def nearest(scene: Scene, origin: Vector, direction: Vector, *, seeing: bool = False) -> Hit | None:
    """The nearest surface that is not the one the ray starts on; for seeing, or a lamp."""
    shapes = [*scene.shapes, *scene.lanterns] if seeing else scene.shapes
    return group(shapes)(origin, direction, 1e-9 * (1 + max(map(abs, origin))))


def turned(normal: Vector, towards: Vector) -> Vector:
    return normal if dot(normal, towards) >= 0 else scale(-1, normal)


def reflectance(spectra: Mapping[str, Spectrum], material: str, component: str) -> Spectrum | None:
    return spectra[f"{material}.{component}"] if component else None


def gather(total: Spectrum, weight: float, light: Spectrum, reflectance: Spectrum | None = None) -> None:
    """Add a share of some light, as it is, or as a reflectance or a matrix with a row for each band leaves it."""
    if reflectance is not None and isinstance(reflectance[0], list):
        for amount, row in zip(light, reflectance, strict=True):
            for k, part in enumerate(row):
                total[k] += weight * amount * part
        return
    for k, amount in enumerate(light):
        total[k] += weight * amount * (1.0 if reflectance is None else reflectance[k])
