"""Cameras: the rays that leave the eye, some for each pixel (step 1).

Pixel (x, y), x from the left and y from the top, looks along film position ((x+½)/width, (y+½)/height); with n × n
samples a pixel, along ((x+(i+½)/n)/width, (y+(j+½)/n)/height).  Rays leave a pinhole, or places on a thin lens of
diameter A that meet on a plane at the distance s.  A point at the distance z is then a disk in the picture, as wide as
A |z − s|/z is on that plane [1]_.

References
----------
.. [1] M. Potmesil and I. Chakravarty, "A Lens and Aperture Camera Model for Synthetic Image Generation", SIGGRAPH 1981.
"""

import math
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np
from jaxtyping import Float

from symrt.arrays import Vectors, normalise
from symrt.errors import hinting, refuse
from symrt.geometry import Triple
from symrt.geometry.directions import unit_vectors
from symrt.geometry.rays import Rays
from symrt.scene.camera_checks import camera_faults
from symrt.scene.checks import Number, check_triple, floats, settle


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
    aperture
        Diameter of the lens in scene units; 0 is a pinhole, to which everything is sharp.
    focus
        Distance in scene units, along the line of sight, of the plane that a lens shows sharply; the target's if not
        given.
    f_number, film_width
        In place of `aperture`, for a perspective camera: the lens's focal length over its diameter, and the width of
        the film in scene units, 0.036 for small-format film in metres.
    lens_samples
        Number of places on the lens that a pixel is seen from, at least; see `lens_rays`.

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
    aperture: Number = 0.0
    focus: Number | None = None
    f_number: Number | None = None
    film_width: Number | None = None
    lens_samples: int = 64
    type: Literal["perspective", "orthographic"] = field(default="perspective")

    def __post_init__(self) -> None:
        if self.type == "perspective" and self.field_of_view is None:
            settle(self, field_of_view=40.0)
        places = [*check_triple("position", self.position), *check_triple("target", self.target)]
        places += check_triple("up", self.up, direction=True)
        refuse([*places, *camera_faults(self, placed=not places)])
        settle(self, position=floats(self.position), target=floats(self.target), up=floats(self.up))
        for key in ("field_of_view", "view_width", "aperture", "focus", "f_number", "film_width"):
            if getattr(self, key) is not None:
                settle(self, **{key: float(getattr(self, key))})

    @property
    def rays_a_pixel(self) -> int:
        """Number of samples, and so of camera rays, in one pixel."""
        return self.samples**2 * (self.lens_places if self.lens_diameter > 0 else 1)

    @property
    def lens_places(self) -> int:
        """Number of places on the lens for each of a pixel's film positions: an even one, so that it has halves."""
        return 2 * math.ceil(self.lens_samples / self.samples**2 / 2)

    @property
    def lens_diameter(self) -> float:
        """Diameter of the lens in scene units; 0 for a pinhole.

        Examples
        --------
        Lens and film are v = w/(2 tan α/2) apart, for film of width w and a view of the angle α; 1/f = 1/v + 1/s.

        >>> eye = Camera(position=(0, 0, 2), target=(0, 0, 0), width=3, height=2, f_number=2, film_width=0.036)
        >>> round(eye.lens_diameter, 6)
        0.024131
        """
        if self.f_number is None:
            return float(self.aperture)
        between = _given(self.film_width) / (2 * _half_width(self))
        return between / (1 + between / self.focus_distance) / float(self.f_number)

    @property
    def focus_distance(self) -> float:
        """Distance of the plane that is sharp, along the line of sight: the target's unless another is given."""
        return math.dist(self.position, self.target) if self.focus is None else float(self.focus)


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
    across, upwards = _view(camera, window)
    forward, right, up = _frame(camera)

    # Perspective rays leave one point in many directions, orthographic rays many points in one direction.
    origin = np.broadcast_to(np.array(camera.position)[:, None], (3, across.size))
    if camera.type == "perspective":
        return Rays(origin=origin.copy(), direction=unit_vectors(forward + right * across + up * upwards))
    return Rays(origin=origin + right * across + up * upwards, direction=np.repeat(forward, across.size, axis=1))


def lens_rays(camera: Camera, window: Window, lens: Float[np.ndarray, "2 place"]) -> Rays:
    """The rays of a camera with a lens, through the pixels of a window.

    Parameters
    ----------
    lens
        Places in the unit disk, right and up, `lens_places` for each film position of the window, in the order of
        `camera_rays`.

    Examples
    --------
    From the rightmost place of a lens, through the point that is sharp in the middle of the picture:

    >>> eye = Camera(position=(0, 0, 4), target=(0, 0, 0), width=1, height=1, aperture=6, lens_samples=2)
    >>> rays = lens_rays(eye, Window(0, 0, 1, 1), np.array([[1.0, -1.0], [0.0, 0.0]]))
    >>> rays.origin[:, 0].tolist(), rays.direction[:, 0].round(15).tolist()
    ([3.0, 0.0, 4.0], [-0.6, 0.0, -0.8])
    """
    across, upwards = (np.repeat(film, camera.lens_places) for film in _view(camera, window))
    forward, right, up = _frame(camera)
    aside, above = camera.lens_diameter / 2 * lens

    # From a place on the lens to the point, on the plane that is sharp, which the pinhole's ray would meet.
    origin = np.array(camera.position)[:, None] + right * aside + up * above
    aside, above = aside / camera.focus_distance, above / camera.focus_distance
    if camera.type == "perspective":
        return Rays(origin, unit_vectors(forward + right * (across - aside) + up * (upwards - above)))
    return Rays(origin + right * across + up * upwards, unit_vectors(forward - right * aside - up * above))


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


def _view(camera: Camera, window: Window) -> tuple[np.ndarray, np.ndarray]:
    """The samples of a window, right and up from the middle of the view: at distance 1 from the eye, or parallel."""
    # Film coordinates from -1 at the left and the bottom to 1; pixels are square.
    x, y = _film(camera, window)
    half = _half_width(camera)
    return (2 * x - 1) * half, (1 - 2 * y) * half * (camera.height / camera.width)


def _half_width(camera: Camera) -> float:
    """Half the width of the view: at distance 1 from the eye, or of the parallel view itself."""
    if camera.type == "perspective":
        return math.tan(math.radians(_given(camera.field_of_view)) / 2)
    return _given(camera.view_width) / 2


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
