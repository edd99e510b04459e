"""Random systems with the sparsity of a rendered image, for tests of the feedback that need no renderer."""

import numpy as np
from scipy import sparse

from symrt.interactions import Interaction
from symrt.spectra.bands import wavelengths
from symrt.spectra.palette import Palette
from symrt.system import LinearSystem

BANDS = wavelengths(380, 730, 10)
MATTE = ("deep", "shelf", "lowland", "upland", "mountain", "ice")


def system(height=24, width=24, seed=0, mirrors=True, background=0.2):
    """Matte materials and a glossy brass under a key and a fill light; some brass mirrors matte things, or itself."""
    random = np.random.default_rng(seed)
    names = [(light, (f"{m}.diffuse",)) for light in ("fill", "key") for m in (*MATTE, "brass")]
    names += [(light, ("brass.specular",)) for light in ("fill", "key")]
    if mirrors:
        names += [(light, ("brass.mirror", f"{m}.diffuse")) for light in ("fill", "key") for m in MATTE[:3]]
        names += [
            ("key", ("brass.diffuse", "brass.mirror")),
            ("key", ("brass.diffuse", "brass.mirror", "brass.mirror")),
        ]
    columns = sorted(Interaction(light, tuple(sorted(met))) for light, met in names)
    number = {column: k for k, column in enumerate(columns)}
    coefficients = np.zeros((height * width, len(columns)))
    seen = random.integers(0, len(MATTE) + 1, height * width)
    for column, k in number.items():
        lit = random.uniform(0, 1, height * width) ** 2 * (0.3 if column.light == "key" else 0.05)
        if column.met == ("brass.specular",):
            lit *= random.uniform(0, 1, height * width) ** 8 * 8
        material = column.met[0].partition(".")[0]
        index = MATTE.index(material) if material in MATTE else len(MATTE)
        coefficients[:, k] = np.where(seen == index, lit, 0)
    coefficients[random.uniform(size=height * width) < background] = 0
    return LinearSystem(
        sparse.csr_array(coefficients), tuple(columns), height, width, white={"key": 1 / np.pi, "fill": 1 / np.pi}
    )


def palette(seed=0, mirrors=True):
    """Smooth spectra, moderately bright."""
    random = np.random.default_rng(seed)
    nm = np.array(BANDS.centres)

    def smooth(low, high):
        centre, width = random.uniform(400, 700), random.uniform(40, 150)
        return low + (high - low) * np.exp(-(((nm - centre) / width) ** 2))

    spectra = {"key": 3 + smooth(-0.5, 0.5), "fill": 1 + smooth(-0.2, 0.2)}
    spectra |= {f"{m}.diffuse": smooth(0.1, random.uniform(0.3, 0.9)) for m in (*MATTE, "brass")}
    spectra |= {"brass.specular": smooth(0.1, 0.2)} | ({"brass.mirror": smooth(0.1, 0.3)} if mirrors else {})
    return Palette(BANDS, spectra)


def awkward(seed):
    """A small system and palette with ties, zeros, empty rows, spectra of 0 and 1, and products of any degree to 3."""
    random = np.random.default_rng(seed)
    materials = [f"m{k}" for k in range(random.integers(2, 6))]
    symbols = [f"{m}.{c}" for m in materials for c in ("diffuse", "mirror", "specular")]
    columns = set()
    for _ in range(random.integers(2, 14)):
        met = sorted(map(str, random.choice(symbols, random.integers(0, 4))))
        columns.add(Interaction(str(random.choice(["key", "fill"])), tuple(met)))
    pixels = int(random.integers(1, 60))
    shape = (pixels, len(columns))
    coefficients = random.uniform(0, 1, shape) * (random.uniform(size=shape) < random.uniform(0.1, 0.9))
    if random.uniform() < 0.3:
        coefficients = np.round(coefficients * 4) / 4
    spectra = {}
    for name in symbols:
        flat = random.uniform() < 0.3
        spectra[name] = random.choice([0, 0.5, 1], 36) if flat else random.uniform(0, 1, 36) * random.choice([1, 1e-3])
    spectra["key"] = np.full(36, 2.0) if random.uniform() < 0.5 else random.uniform(0.5, 4, 36)
    spectra["fill"] = random.uniform(0, 1, 36)
    image = LinearSystem(sparse.csr_array(coefficients), tuple(sorted(columns)), 1, pixels, {"key": 0.5, "fill": 0.5})
    return image, Palette(BANDS, spectra), materials


def few_pixels(seed, pixels=10, scales=4):
    """Random textures of some materials, one light, degree 1: small enough to try all choices."""
    random = np.random.default_rng(seed)
    columns = tuple(Interaction("key", (f"{m}.diffuse",)) for m in sorted(MATTE)[:scales])
    weights = random.uniform(0, 1, (pixels, scales)) * (random.uniform(size=(pixels, scales)) < 0.6) + 1e-3
    return LinearSystem(sparse.csr_array(weights), columns, 1, pixels, {"key": 1.0})
