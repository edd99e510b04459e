"""How the time of a render grows, over two decades of pixels, of shapes and of lights, and a picture of it.

``python tests/benchmarks/growth.py growth.png`` measures and draws, in some minutes; processor seconds of one worker.
"""

import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import matplotlib as mpl
import numpy as np

if __name__ == "__main__":
    mpl.use("Agg")
    sys.path.insert(0, str(Path(__file__).parents[1]))

from benchmarks.pairs import machine
from matplotlib import pyplot as plt
from scenes_for_tests import SCENES, lamps

import symrt as rt
from symrt import fast


@dataclass(frozen=True)
class Growth:
    """Times of renders of scenes that differ in one number."""

    what: str
    counts: tuple[int, ...]
    times: tuple[float, ...]

    @property
    def slopes(self) -> tuple[float, float]:
        """Slopes of the time over the number, both as logarithms: through all, and through the last half.

        There what is fixed counts less; 1 is in proportion.
        """
        x, y = np.log(self.counts), np.log(self.times)
        half = len(self.counts) // 2
        return float(np.polyfit(x, y, 1)[0]), float(np.polyfit(x[half:], y[half:], 1)[0])

    @property
    def a_doubling(self) -> float:
        """Seconds that each doubling adds, where the time grows with the logarithm of the number."""
        return float(np.polyfit(np.log2(self.counts), self.times, 1)[0])

    def __str__(self) -> str:
        each = ", ".join(f"{n}: {t * 1e3:.0f} ms" for n, t in zip(self.counts, self.times, strict=True))
        whole, end = self.slopes
        return f"growth with {self.what}: slope {whole:.2f}, at the end {end:.2f} ({each})"


def spent(scene: rt.Scene) -> float:
    """Processor seconds of a render by one worker: the least of three, after one that pays for what is paid once."""
    found = []
    with fast.use(fast.available()):
        for _ in range(4):
            start = time.process_time()
            rt.render(scene, workers=1, progress=False)
            found.append(time.process_time() - start)
    return min(found[1:])


def grown(what: str, counts: Sequence[int], scene: Callable[[int], rt.Scene]) -> Growth:
    return Growth(what, tuple(counts), tuple(spent(scene(count)) for count in counts))


def spheres(count: int) -> rt.Scene:
    """As many spheres under two lamps, as large together as any other number of them."""
    random = np.random.default_rng(0)
    places, radius = random.uniform((-3, -3, -1), (3, 3, 1), (count, 3)), 0.55 * (20 / count) ** 0.5
    return rt.Scene(
        camera=rt.Camera(position=(0, 0, 9), target=(0, 0, 0), field_of_view=40, width=512, height=512),
        shapes=[rt.Sphere(tuple(place.tolist()), radius, "red") for place in places],
        materials=[rt.Material("red", model="phong", exponent=40)],
        lights=[rt.PointLight("warm", position=(4, 6, 8)), rt.PointLight("cold", position=(-4, 3, 8))],
    )


def with_pixels() -> Growth:
    globe = rt.load_scene(SCENES / "globe.toml")
    sides = {side * side: side for side in (160, 285, 506, 900, 1600)}
    return grown(
        "pixels", tuple(sides), lambda n: replace(globe, camera=replace(globe.camera, width=sides[n], height=sides[n]))
    )


def with_shapes() -> Growth:
    return grown("shapes", (20, 63, 200, 632, 2000), spheres)


def with_lights() -> Growth:
    return grown("lights", (1, 3, 10, 32, 100), lambda count: lamps(count, size=192))


def figure(found: Sequence[Growth]) -> plt.Figure:
    """A panel for each, both axes logarithmic, with its slope beside a line of slope 1."""
    drawn, panels = plt.subplots(1, len(found), figsize=(4 * len(found), 3.6), layout="constrained")
    for growth, panel in zip(found, panels, strict=True):
        counts, times = np.array(growth.counts), np.array(growth.times)
        panel.loglog(counts, times, "o-", color="#1f4e79", label="render, one worker")
        panel.loglog(counts, times[-1] * counts / counts[-1], ":", color="#888888", label="in proportion")
        whole, end = growth.slopes
        said = f"slope {whole:.2f}, at the end {end:.2f}"
        if growth.what == "shapes":
            said += f"\neach doubling adds {growth.a_doubling * 1e3:.0f} ms"
        panel.set(xlabel=f"number of {growth.what}", title=said)
        panel.title.set_fontsize(10)
        panel.grid(which="major", alpha=0.3)
    panels[0].set_ylabel("seconds of one processor")
    panels[0].legend(frameon=False, fontsize=9)
    drawn.supxlabel(machine(), fontsize=8, color="#666666")
    return drawn


if __name__ == "__main__":
    measured = [with_pixels(), with_shapes(), with_lights()]
    for one in measured:
        sys.stdout.write(f"{one}\n")
    figure(measured).savefig(sys.argv[1] if len(sys.argv) > 1 else "growth.png", dpi=100)
