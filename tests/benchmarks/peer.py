"""A scene that other renderers can have, too, and what is known of it: a ground, three spheres and two point lights."""

import numpy as np
from numba import njit

import symrt as rt

SIZE = 256
EYE, TARGET, VIEW = (0.0, 2.0, 8.0), (0.0, 0.8, 0.0), 40.0
BALLS = {"red": (-2.1, 1.0, 0.0), "green": (0.0, 1.0, -0.5), "blue": (2.1, 1.0, 0.0)}
LAMPS = {"cold": (-5.0, 4.0, 6.0), "warm": (4.0, 6.0, 5.0)}
BANDS = np.arange(380.0, 731.0, 10.0)


def scene() -> rt.Scene:
    return rt.Scene(
        camera=rt.Camera(position=EYE, target=TARGET, field_of_view=VIEW, width=SIZE, height=SIZE),
        shapes=[
            rt.Plane(point=(0, 0, 0), normal=(0, 1, 0), material="ground"),
            *(rt.Sphere(centre=at, radius=1, material=name) for name, at in BALLS.items()),
        ],
        materials=[rt.Material(name) for name in ("ground", *BALLS)],
        lights=[rt.PointLight(name, position=at) for name, at in LAMPS.items()],
    )


def spectra() -> dict[str, np.ndarray]:
    """Smooth ones: bumps for the balls, slopes for the lamps."""
    x = np.linspace(0, 1, BANDS.size)
    bumps = {
        name: 0.05 + 0.7 * np.exp(-((x - at) ** 2) / 0.03) for name, at in zip(BALLS, (0.9, 0.5, 0.15), strict=True)
    }
    materials = {f"{name}.diffuse": bump for name, bump in bumps.items()} | {"ground.diffuse": np.full(x.size, 0.4)}
    return materials | {"cold": 40 - 15 * x, "warm": 30 + 40 * x}


def palette() -> rt.Palette:
    return rt.Palette(bands=rt.wavelengths(380, 730, 10), spectra=spectra())


def products() -> np.ndarray:
    """What the exact kernel multiplies by: (material, lamp, band), the ground first."""
    known = spectra()
    return np.array([[known[f"{m}.diffuse"] * known[lamp] / np.pi for lamp in LAMPS] for m in ("ground", *BALLS)])


@njit(nogil=True, error_model="numpy")
def _met(o, d, balls, low, high):
    """The nearest shape between two distances, and how far it is: 0 for the ground, −1 for none."""
    shape, t = -1, high
    to_ground = -o[1] / d[1]
    if low < to_ground < t:
        shape, t = 0, to_ground
    for k in range(balls.shape[0]):
        x, y, z = o[0] - balls[k, 0], o[1] - balls[k, 1], o[2] - balls[k, 2]
        b, c = x * d[0] + y * d[1] + z * d[2], x * x + y * y + z * z - 1
        square = b * b - c
        if square >= 0:
            root = np.sqrt(square)
            enter, leave = -b - root, -b + root
            first = enter if enter > low else leave
            if low < first < t:
                shape, t = k + 1, first
    return shape, t


@njit(nogil=True, error_model="numpy")
def exact(eye, forward, right, up, balls, lamps, products, image):
    """One ray a pixel, one shadow ray a lamp, all bands at once: no name is free, and nothing is asked again."""
    height, width, bands = image.shape
    for row in range(height):
        for column in range(width):
            across, upwards = 2 * (column + 0.5) / width - 1, 1 - 2 * (row + 0.5) / height
            x = forward[0] + across * right[0] + upwards * up[0]
            y = forward[1] + across * right[1] + upwards * up[1]
            z = forward[2] + across * right[2] + upwards * up[2]
            size = np.sqrt(x * x + y * y + z * z)
            d = x / size, y / size, z / size
            shape, t = _met(eye, d, balls, 0.0, np.inf)
            for band in range(bands):
                image[row, column, band] = 0.0
            if shape < 0:
                continue
            p = eye[0] + t * d[0], eye[1] + t * d[1], eye[2] + t * d[2]
            n = (0.0, 1.0, 0.0)
            if shape > 0:
                n = p[0] - balls[shape - 1, 0], p[1] - balls[shape - 1, 1], p[2] - balls[shape - 1, 2]
            for lamp in range(lamps.shape[0]):
                x, y, z = lamps[lamp, 0] - p[0], lamps[lamp, 1] - p[1], lamps[lamp, 2] - p[2]
                size = np.sqrt(x * x + y * y + z * z)
                way = x / size, y / size, z / size
                cosine = n[0] * way[0] + n[1] * way[1] + n[2] * way[2]
                if cosine > 0 and _met(p, way, balls, 1e-9, size)[0] < 0:
                    share = cosine / (size * size)
                    for band in range(bands):
                        image[row, column, band] += share * products[shape, lamp, band]


def by_exact_kernel() -> np.ndarray:
    """The image in all bands."""
    eye, target = np.array(EYE), np.array(TARGET)
    forward = (target - eye) / np.linalg.norm(target - eye)
    right = np.cross(forward, (0, 1, 0))
    right /= np.linalg.norm(right)
    half, image = np.tan(np.radians(VIEW) / 2), np.empty((SIZE, SIZE, BANDS.size))
    frame = tuple(eye), forward, half * right, half * np.cross(right, forward)
    exact(*frame, np.array(list(BALLS.values())), np.array(list(LAMPS.values())), products(), image)
    return image


def by_mitsuba(mi, dr):
    """A function that renders the image by nine passes of four wavelengths each, without noise.

    Its own integrators draw wavelengths at random; here each pass traces the pixels' centres with four given ones.
    """
    known = spectra()

    def curve(values):
        return {
            "type": "regular",
            "wavelength_min": 380.0,
            "wavelength_max": 730.0,
            "values": ",".join(map(repr, values.tolist())),
        }

    def matte(name):
        return {"type": "diffuse", "reflectance": curve(known[f"{name}.diffuse"])}

    lamps = {
        name: {"type": "point", "position": list(at), "intensity": curve(known[name])} for name, at in LAMPS.items()
    }
    balls = {
        name: {"type": "sphere", "center": list(at), "radius": 1.0, "bsdf": matte(name)} for name, at in BALLS.items()
    }
    place = mi.ScalarTransform4f().rotate([1, 0, 0], -90).scale(1000)
    ground = {"type": "rectangle", "to_world": place, "bsdf": matte("ground")}
    loaded = mi.load_dict({"type": "scene", "ground": ground, **balls, **lamps})

    eye, target = np.array(EYE), np.array(TARGET)
    forward = (target - eye) / np.linalg.norm(target - eye)
    right = np.cross(forward, (0, 1, 0))
    right /= np.linalg.norm(right)
    half = np.tan(np.radians(VIEW) / 2)
    index = dr.arange(mi.UInt32, SIZE * SIZE)
    across = (2 * (mi.Float(index % SIZE) + 0.5) / SIZE - 1) * half
    upwards = (1 - 2 * (mi.Float(index // SIZE) + 0.5) / SIZE) * half
    up = np.cross(right, forward)
    direction = dr.normalize(
        mi.Vector3f(*forward.tolist()) + mi.Vector3f(*right.tolist()) * across + mi.Vector3f(*up.tolist()) * upwards
    )
    dr.eval(direction)

    def one_pass(wavelengths):
        ray = mi.Ray3f(o=mi.Point3f(*EYE), d=direction, time=0.0, wavelengths=wavelengths)
        si = loaded.ray_intersect(ray)
        context, radiance = mi.BSDFContext(), mi.Spectrum(0.0)
        for lamp in loaded.emitters():
            at, weight = lamp.sample_direction(si, mi.Point2f(0.5), si.is_valid())
            seen = si.is_valid() & ~loaded.ray_test(si.spawn_ray_to(at.p), si.is_valid())
            value = si.bsdf().eval(context, si, si.to_local(at.d), seen)
            radiance += dr.select(seen, value * weight, 0.0)
        dr.eval(radiance)
        return radiance

    def render():
        parts = []
        for first in range(0, BANDS.size, 4):
            four = type(mi.Ray3f().wavelengths)(*[dr.opaque(mi.Float, float(w)) for w in BANDS[first : first + 4]])
            parts.append(np.array(one_pass(four)).reshape(4, -1))
        return np.concatenate(parts).T.reshape(SIZE, SIZE, BANDS.size)

    return render
