"""Laws of cameras: a pixel's ray goes where the film says, whatever window, frame or number of samples."""

import numpy as np
import pytest

from symrt.scene.cameras import Camera, Window, camera_rays, moved_camera


def film_position(camera, direction):
    """Where a ray direction meets the film, from the left and the top in [0, 1], by a linear solve of our own."""
    forward = np.subtract(camera.target, camera.position)
    forward = forward / np.linalg.norm(forward)
    right = np.cross(forward, camera.up) / np.linalg.norm(np.cross(forward, camera.up))
    upward = np.cross(right, forward)
    half = np.tan(np.radians(camera.field_of_view) / 2)
    across, up, ahead = np.linalg.solve(np.stack([right, upward, forward], axis=1), direction)
    aspect = camera.height / camera.width
    return (across / ahead / half + 1) / 2, (1 - up / ahead / half / aspect) / 2


SKEWED = Camera(position=(3, 4, 5), target=(-1, 0.5, 0.2), up=(0.1, 1, 0.2), field_of_view=53, width=7, height=5)


def test_a_pixel_looks_along_its_centre_on_the_film():
    rays = camera_rays(SKEWED)
    x, y = film_position(SKEWED, rays.direction)
    rows, columns = np.mgrid[0:5, 0:7]
    np.testing.assert_allclose(x, (columns.ravel() + 0.5) / 7, rtol=1e-12)
    np.testing.assert_allclose(y, (rows.ravel() + 0.5) / 5, rtol=1e-12)


def test_directions_are_unit_vectors_from_the_eye():
    rays = camera_rays(SKEWED)
    np.testing.assert_allclose(np.linalg.norm(rays.direction, axis=0), 1, rtol=4e-16)
    np.testing.assert_array_equal(rays.origin, np.repeat([[3.0], [4.0], [5.0]], 35, axis=1))


def test_samples_divide_each_pixel_regularly_and_follow_each_other():
    camera = Camera(position=(0, 0, 5), target=(0, 0, 0), width=4, height=3, samples=2)
    x, y = film_position(camera, camera_rays(camera).direction)
    pixel = 1 * 4 + 2
    mine = slice(4 * pixel, 4 * pixel + 4)
    np.testing.assert_allclose(x[mine] * 4 - 2, [0.25, 0.75, 0.25, 0.75], rtol=1e-12)
    np.testing.assert_allclose(y[mine] * 3 - 1, [0.25, 0.25, 0.75, 0.75], rtol=1e-12)


@pytest.mark.parametrize("samples", [1, 3])
def test_a_window_is_that_part_of_the_whole_film_bit_for_bit(samples):
    camera = Camera(position=(1, 2, 3), target=(0, 0, 0), width=6, height=5, samples=samples)
    whole = camera_rays(camera).direction.reshape(3, 5, 6, samples**2)
    part = camera_rays(camera, Window(2, 1, 3, 4)).direction.reshape(3, 4, 3, samples**2)
    np.testing.assert_array_equal(part, whole[:, 1:5, 2:5])


def test_the_leftmost_and_rightmost_edges_span_the_field_of_view():
    camera = Camera(position=(0, 0, 0), target=(0, 0, -1), field_of_view=90, width=1000, height=10)
    ends = camera_rays(camera, Window(0, 5, 1, 1)).direction, camera_rays(camera, Window(999, 5, 1, 1)).direction
    # The centres of the outermost pixels stand half a pixel inside tan 45° = 1.
    expected = 1 - 1 / 1000
    assert -ends[0][0] / ends[0][2] == pytest.approx(-expected, rel=1e-12)
    assert -ends[1][0] / ends[1][2] == pytest.approx(expected, rel=1e-12)


def test_right_in_the_picture_is_right_in_right_handed_axes():
    camera = Camera(position=(0, 0, 8), target=(0, 0, 0), width=2, height=2)
    top_left, top_right, low_left, _ = camera_rays(camera).direction.T
    assert top_left[0] < 0 < top_right[0]
    assert low_left[1] < 0 < top_left[1]


def test_orthographic_rays_are_parallel_and_span_the_view_width():
    camera = Camera(type="orthographic", view_width=6, position=(0, 0, 9), target=(0, 0, 0), width=3, height=2)
    rays = camera_rays(camera)
    np.testing.assert_array_equal(rays.direction, np.repeat([[0.0], [0.0], [-1.0]], 6, axis=1))
    np.testing.assert_allclose(rays.origin[0], [-2, 0, 2, -2, 0, 2], atol=1e-15)
    np.testing.assert_allclose(rays.origin[1], [1, 1, 1, -1, -1, -1], rtol=1e-15)
    np.testing.assert_array_equal(rays.origin[2], 9.0)


def test_moving_the_camera_to_the_origin_keeps_its_rays():
    moved = moved_camera(SKEWED, tuple(-v for v in SKEWED.position))
    assert moved.position == (0.0, 0.0, 0.0)
    np.testing.assert_allclose(camera_rays(moved).direction, camera_rays(SKEWED).direction, rtol=0, atol=4e-16)


GOOD = {"position": (0, 3, 8), "target": (0, 1, 0), "width": 4, "height": 4}


@pytest.mark.parametrize(
    ("change", "line"),
    [
        ({"field_of_view": 0}, r"^field_of_view = 0: it must be more than 0 and less than 180"),
        ({"field_of_view": 180}, r"^field_of_view = 180: it must be more"),
        ({"field_of_view": float("nan")}, r"^field_of_view = nan: numbers must be finite"),
        ({"width": 0}, r"^width = 0: it must be a whole number from 1 to 32768"),
        ({"height": -3}, r"^height = -3: it must be"),
        ({"height": 10**5000}, r"^height = an integer of more than 40 digits: it must be"),
        ({"samples": 0}, r"^samples = 0: it must be a whole number from 1 to 64"),
        ({"position": (0, 1, 0)}, r"^target: the camera stands at the point it looks at"),
        ({"target": (0, 3, float("inf"))}, r"^target\[2\] = inf: numbers must be finite"),
        ({"up": (0, 0, 0)}, r"^up = \[0, 0, 0\]: a direction must not be zero"),
        ({"up": (0, 2, 8)}, r"^up: it points along the line of sight"),
        ({"view_width": 3}, r"^view_width: a perspective camera has none"),
        ({"type": "orthographic"}, r"^view_width: an orthographic camera needs it"),
        ({"type": "orthographic", "view_width": 0}, r"^view_width = 0: it must be more than 0"),
        ({"type": "orthographic", "view_width": 2, "field_of_view": 40}, r"^field_of_view: an orthographic camera has"),
        ({"aperture": -0.5}, r"^aperture = -0.5: it must be 0, for a pinhole, or more: a diameter in scene units$"),
        ({"aperture": "wide"}, r"^aperture = 'wide': it must be a number"),
        ({"aperture": float("inf")}, r"^aperture = inf: numbers must be finite"),
        (
            {"aperture": 1, "focus": 0},
            r"^focus = 0: it must be more than 0, the distance of what is sharp; leave it out",
        ),
        ({"focus": -3}, r"^focus = -3: it must be more than 0"),
        ({"aperture": 3, "focus": 0.1}, r"^aperture: a lens 3 wide is more than 10 times as wide as its focus is far"),
        ({"f_number": 0, "film_width": 0.036}, r"^f_number = 0: it must be more than 0; 2 is a bright lens"),
        ({"f_number": 2}, r"^f_number: it needs film_width, in scene units, such as 0.036"),
        ({"f_number": 2, "film_width": 0}, r"^film_width = 0: it must be more than 0"),
        ({"film_width": 0.036}, r"^film_width: it counts for a camera with an f_number only"),
        ({"aperture": 0.1, "f_number": 2, "film_width": 1}, r"^f_number: the aperture is given, too"),
        (
            {"type": "orthographic", "view_width": 2, "f_number": 2, "film_width": 1},
            r"^f_number: an orthographic camera has no focal length; give aperture",
        ),
        ({"lens_samples": 1}, r"^lens_samples = 1: it must be a whole number from 2 to 4096"),
    ],
)
def test_a_camera_that_cannot_see_says_why(change, line):
    good = GOOD if change != {"up": (0, 2, 8)} else GOOD | {"target": (0, 1, 0)}
    with pytest.raises(ValueError, match=line):
        Camera(**(good | change))


def test_all_faults_of_a_camera_are_told_at_once():
    with pytest.raises(ValueError, match="width") as caught:
        Camera(position=(0, 3, float("nan")), target=(0, 1, 0), width=0, height=0, field_of_view=200)
    assert [line.split()[0] for line in str(caught.value).splitlines()] == [
        "position[2]",
        "width",
        "height",
        "field_of_view",
    ]
