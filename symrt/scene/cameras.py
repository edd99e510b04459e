"""Cameras: the rays that leave the eye, some for each pixel (step 1).

Pixel (x, y), x from the left and y from the top, looks along film position ((x+½)/width, (y+½)/height); with n × n
samples a pixel, along ((x+(i+½)/n)/width, (y+(j+½)/n)/height).
"""

import math
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from symrt.arrays import Vectors, normalise
from symrt.errors import hinting, refuse, shown
from symrt.geometry import Triple
from symrt.geometry.rays import Rays
from symrt.scene.checks import Number, check_number, check_triple, check_whole, floats, settle

LARGEST = 32768
"""Largest number of pixels on a side: a pixel's number then fits 32 bits."""


@hinting
@dataclass(frozen=True, kw_only=True)
class Camera:
    """A viewpoint, the point it looks at, and a film of square pixels.

    Parameters
    ----------
    position, target
        The viewpoint, and the point in the middle of the picture.
    up
        A direction that points up in the picture.
    field_of_view
        Horizontal angle in degrees that a perspective camera sees, 40 if not given.
    view_width
        Width in scene units that an orthographic camera sees.
    width, height
        Size of the film in pixels.
    samples
        Number n of samples across a pixel and down it: n × n regular ones, for 1 the pixel's centre.

    Examples
    --------
    >>> Camera(position=(0, 3, 8), target=(0, 1, 0), width=320, height=240).field_of_view
    40.0
    """

    position: Triple
    target: Triple
    up: Triple = (0, 1, 0)
    field_of_view: Number | None = None
    view_width: Number | None = None
    width: int
    height: int
    samples: int = 1
    type: Literal["perspective", "orthographic"] = field(default="perspective")

    def __post_init__(self) -> None:
        if self.type == "perspective" and self.field_of_view is None:
            settle(self, field_of_view=40.0)
        places = [*check_triple("position", self.position), *check_triple("target", self.target)]
        places += check_triple("up", self.up, direction=True)
        refuse([*places, *([] if places else _view_faults(self)), *_film_faults(self), *_angle_faults(self)])
        settle(self, position=floats(self.position), target=floats(self.target), up=floats(self.up))
        for key in ("field_of_view", "view_width"):
            if getattr(self, key) is not None:
                settle(self, **{key: float(getattr(self, key))})

    @property
    def rays_a_pixel(self) -> int:
        """Number of samples, and so of camera rays, in one pixel."""
        return self.samples**2


@dataclass(frozen=True)
class Window:
    """A part of the film: the columns from `left` and the rows from `top`, both from 0."""

    left: int
    top: int
    width: int
    height: int


def camera_rays(camera: Camera, window: Window | None = None) -> Rays:
    """The camera's rays through the pixels of a window, or of the whole film.

    Pixels run along rows from the top left; the n × n samples of a pixel follow each other, along rows too: ray r
    belongs to the window's pixel r // n².

    Examples
    --------
    >>> eye = Camera(position=(0, 0, 5), target=(0, 0, 0), width=3, height=3, field_of_view=90)
    >>> camera_rays(eye, Window(1, 1, 1, 1)).direction.T.tolist()
    [[0.0, 0.0, -1.0]]
    """
    window = window or Window(0, 0, camera.width, camera.height)
    x, y = _film(camera, window)
    forward, right, up = _frame(camera)

    # Half the width of the view: at distance 1 from the eye, or of the parallel view itself.
    if camera.type == "perspective":
        half = math.tan(math.radians(_given(camera.field_of_view)) / 2)
    else:
        half = _given(camera.view_width) / 2

    # Film coordinates from -1 at the left and the bottom to 1; pixels are square.
    across = (2 * x - 1) * half
    upwards = (1 - 2 * y) * half * (camera.height / camera.width)

    # Perspective rays leave one point in many directions, orthographic rays many points in one direction.
    origin = np.broadcast_to(np.array(camera.position)[:, None], (3, x.size))
    if camera.type == "perspective":
        return Rays(origin=origin.copy(), direction=normalise(forward + right * across + up * upwards))
    return Rays(origin=origin + right * across + up * upwards, direction=np.repeat(forward, x.size, axis=1))


def moved_camera(camera: Camera, by: Triple) -> Camera:
    """The camera after the whole scene has moved by the vector `by`.

    Examples
    --------
    >>> eye = Camera(position=(0, 3, 8), target=(0, 1, 0), width=320, height=240)
    >>> moved_camera(eye, (0, -3, -8)).target
    (0.0, -2.0, -8.0)
    """
    shift = np.array(by, dtype=float)
    position, target = ((np.array(place) + shift).tolist() for place in (camera.position, camera.target))
    return replace(camera, position=tuple(position), target=tuple(target))


def _film(camera: Camera, window: Window) -> tuple[np.ndarray, np.ndarray]:
    """Film positions x and y of all samples in a window, pixel by pixel."""
    n = camera.samples
    within = (np.arange(n) + 0.5) / n
    x = (window.left + np.arange(window.width)[:, None] + within) / camera.width
    y = (window.top + np.arange(window.height)[:, None] + within) / camera.height
    shape = (window.height, window.width, n, n)
    film_x = np.broadcast_to(x[None, :, None, :], shape)
    film_y = np.broadcast_to(y[:, None, :, None], shape)
    return film_x.ravel(), film_y.ravel()


def _frame(camera: Camera) -> tuple[Vectors, Vectors, Vectors]:
    """Unit vectors forward, right and up, as the camera sees them."""
    position, target, up = (np.array(v, dtype=float) for v in (camera.position, camera.target, camera.up))
    forward = normalise((target - position)[:, None])
    right = normalise(np.cross(forward, normalise(up[:, None]), axis=0))
    return forward, right, np.cross(right, forward, axis=0)


def _given(value: Number | None) -> float:
    if value is None:
        raise ValueError("the camera's field of view was removed after it was made; make it anew with rt.Camera")
    return float(value)


def _view_faults(camera: Camera) -> list[str]:
    position, target, up = (np.array(floats(v)) for v in (camera.position, camera.target, camera.up))
    if not np.any(target - position):
        return ["target: the camera stands at the point it looks at; move its position or its target"]
    forward = normalise((target - position)[:, None])
    if np.linalg.norm(np.cross(forward, normalise(up[:, None]), axis=0)) < 1e-9:
        return ["up: it points along the line of sight; give another direction, such as [0, 0, -1] for a view down"]
    return []


def _film_faults(camera: Camera) -> list[str]:
    sides = [("width", camera.width, LARGEST), ("height", camera.height, LARGEST), ("samples", camera.samples, 64)]
    return [fault for key, value, most in sides for fault in check_whole(key, value, most)]


def _angle_faults(camera: Camera) -> list[str]:
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
    faults = list(check_number("field_of_view", camera.field_of_view))
    if not faults and not 0 < _given(camera.field_of_view) < 180:
        faults = [
            f"field_of_view = {camera.field_of_view}: it must be more than 0 and less than 180 degrees; 40 is usual"
        ]
    return faults
