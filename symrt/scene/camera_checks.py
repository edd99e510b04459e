"""Checks of a camera's view, film and lens, one line a fault (before step 1)."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from symrt.arrays import normalise
from symrt.errors import shown
from symrt.scene.checks import check_number, check_whole, floats

if TYPE_CHECKING:
    from symrt.scene.cameras import Camera

LARGEST = 32768
"""Largest number of pixels on a side: a pixel's number then fits 32 bits."""
MOST_PLACES = 4096
"""Largest number of places on a lens that a pixel may ask for."""
WIDEST = 10
"""Largest diameter of a lens over the distance that it focuses on."""


def camera_faults(camera: "Camera", *, placed: bool) -> Iterator[str]:
    """Faults of a camera; those of its direction only if its position, target and up are known to be `placed`."""
    faults = [*(_view_faults(camera) if placed else []), *_film_faults(camera), *_angle_faults(camera)]
    yield from faults
    lens = list(_lens_faults(camera))
    yield from lens
    if placed and not faults and not lens:
        yield from _width_faults(camera)


def _view_faults(camera: "Camera") -> list[str]:
    position, target, up = (np.array(floats(v)) for v in (camera.position, camera.target, camera.up))
    if not np.any(target - position):
        return ["target: the camera stands at the point it looks at; move its position or its target"]
    forward = normalise((target - position)[:, None])
    if np.linalg.norm(np.cross(forward, normalise(up[:, None]), axis=0)) < 1e-9:
        return ["up: it points along the line of sight; give another direction, such as [0, 0, -1] for a view down"]
    return []


def _film_faults(camera: "Camera") -> list[str]:
    sides = [("width", camera.width, LARGEST), ("height", camera.height, LARGEST), ("samples", camera.samples, 64)]
    return [fault for key, value, most in sides for fault in check_whole(key, value, most)]


def _angle_faults(camera: "Camera") -> list[str]:
    if camera.type not in ("perspective", "orthographic"):
        return [f"type = {shown(camera.type)}: it must be 'perspective' or 'orthographic'"]

    # An orthographic camera sees a width.
    if camera.type == "orthographic":
        if camera.field_of_view is not None:
            return ["field_of_view: an orthographic camera has none; give view_width, in scene units, instead"]
        if camera.view_width is None:
            return ["view_width: an orthographic camera needs it; give the width it sees, in scene units"]
        faults = list(check_number("view_width", camera.view_width))
        if not faults and not camera.view_width > 0:
            faults = [f"view_width = {camera.view_width}: it must be more than 0, in scene units"]
        return faults

    # A perspective camera sees an angle.
    if camera.view_width is not None:
        return ["view_width: a perspective camera has none; give field_of_view, or type = 'orthographic'"]
    angle = camera.field_of_view
    faults = list(check_number("field_of_view", angle))
    if angle is not None and not faults and not 0 < angle < 180:
        faults = [f"field_of_view = {angle}: it must be more than 0 and less than 180 degrees; 40 is usual"]
    return faults


def _lens_faults(camera: "Camera") -> Iterator[str]:
    # Numbers, and their signs.
    rules = {
        "focus": "it must be more than 0, the distance of what is sharp; leave it out to focus on the target",
        "f_number": "it must be more than 0; 2 is a bright lens, 16 a narrow one",
        "film_width": "it must be more than 0, in scene units; 0.036 is small-format film in metres",
    }
    faults = list(check_number("aperture", camera.aperture))
    yield from faults
    if not faults and camera.aperture < 0:
        yield f"aperture = {camera.aperture}: it must be 0, for a pinhole, or more: a diameter in scene units"
    for key, rule in rules.items():
        value = getattr(camera, key)
        if value is not None:
            faults = list(check_number(key, value))
            yield from faults
            if not faults and not value > 0:
                yield f"{key} = {value}: {rule}"
    yield from check_whole("lens_samples", camera.lens_samples, MOST_PLACES, least=2)

    # One way only of giving a width.
    if camera.f_number is None:
        if camera.film_width is not None:
            yield "film_width: it counts for a camera with an f_number only; add one, or leave it out"
    elif camera.type != "perspective":
        yield "f_number: an orthographic camera has no focal length; give aperture, in scene units, instead"
    elif camera.aperture:
        yield "f_number: the aperture is given, too; leave one of them out"
    elif camera.film_width is None:
        yield "f_number: it needs film_width, in scene units, such as 0.036 for small-format film in metres"


def _width_faults(camera: "Camera") -> Iterator[str]:
    diameter, focus = camera.lens_diameter, camera.focus_distance
    if not diameter <= WIDEST * focus:
        yield (
            f"aperture: a lens {diameter:g} wide is more than {WIDEST} times as wide as its focus is far, {focus:g}; "
            "make it narrower, or focus farther away"
        )
