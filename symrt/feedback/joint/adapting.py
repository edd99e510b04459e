"""Change an image as little as it takes to be reproducible: the loop of step 5 of the paper, with its criteria stated.

Means are tried from the simplest on: nothing; one factor on all lights; the scales of least change, with no pixel left
out; the lexicographic and the brightest ones; the same with a part of the pixels left out, as few as will do; and, if
the caller allows it, pixels moved one by one.  The first that meets every criterion is accepted.  If none does, the
answer says what each one lacked, what bound it, and what could have been reached.
"""

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from jaxtyping import Float, Int
from tqdm.auto import tqdm

from symrt.feedback.joint.acceptance import Goal
from symrt.feedback.joint.adapted import Adapted, Criteria, Step
from symrt.feedback.joint.appearance import Appearance, appearance
from symrt.feedback.joint.fits import fit, symbols_of
from symrt.feedback.joint.fitted import Fit
from symrt.feedback.limits import check_kinds, described
from symrt.feedback.parameters import Exposure, Scale, moved
from symrt.feedback.pixelwise import Target, map_pixels
from symrt.feedback.ranges import Range, check_share, checked_range, feasible
from symrt.feedback.reasons import Feasible
from symrt.gamut.gamuts import device_gamut
from symrt.gamut.interface import ConvexGamut
from symrt.gamut.intersections import UnevenGamut
from symrt.gamut.slabs import Gamut
from symrt.spectra.bands import Number
from symrt.spectra.palette import Palette
from symrt.spectra.reference import Reference, as_asked
from symrt.system import LinearSystem

COMPARED = 2000
"""Object pixels, drawn evenly, on which colours are compared and gamuts without bounds in each band are asked."""
SHARE_HALVINGS = 5
"""Of the share left out: it is known to a 32nd of what is allowed."""
GOALS: tuple[Goal, ...] = ("closest", "lexicographic", "brightest")

Pixels = Int[np.ndarray, " pixel"]
Reflectances = Float[np.ndarray, "pixel band"]


def adapt(  # noqa: PLR0913  # a public verb names its options
    system: LinearSystem,
    palette: Palette,
    gamut: ConvexGamut | UnevenGamut,
    scales: Sequence[Scale],
    *,
    least_inside: Number = 1.0,
    most_difference: Number | None = None,
    least_lightness: Number | None = None,
    least_luminance: Number = 0.5,
    map_rest: bool = False,
    within: Range = (0.01, 3.0),
    reference: Reference | None = None,
    cap: bool = True,
    most: int = COMPARED,
    progress: bool = True,
) -> Adapted:
    """The simplest change of an image that meets stated criteria, or why none does.

    Parameters
    ----------
    gamut
        Of any model.  Scales are fitted to the bounds that it has in each band, or else to those of its device's
        envelope, and all lights are then dimmed as far as the gamut itself asks for: see `feasible`.
    scales
        Of materials, components or lights, as for `fit`.
    least_inside
        Least share of the object pixels that must be inside the gamut; those moved one by one, to rounding.
    most_difference
        Largest mean CIEDE2000 from the image given, both seen as prints under D50 beside a perfect diffuser.
    least_lightness
        Least mean CIE L*, as a share of that of the image given; whatever is lighter than white counts as white.
    least_luminance
        Share of the mean of min(Y, 1) of the image given that an acceptable answer keeps, as for `fit`: black is in
        every gamut; 0 accepts any.
    map_rest
        True to let pixels be moved one by one at last, as `map_pixels` does: the image is then no palette's any more.
    within, reference, cap
        As for `fit`.
    most
        Object pixels on which colours are compared, and on which gamuts without bounds in each band are asked.
    progress
        True to show a bar on standard error, after a second.

    Raises
    ------
    ValueError
        If a criterion is no share, or the scales, the palette, the gamut and the system do not fit together.

    Examples
    --------
    A sea twice as bright as paper can be: dimming does, and keeps half of its light.

    >>> from symrt.device import load_device
    >>> device = load_device("dye3-endura-premier")
    >>> system = LinearSystem.of("0.25*sun*sea.diffuse", "1*sun*sea.diffuse", white={"sun": 0.5})
    >>> palette = Palette(device.bands, {"sun": 2, "sea.diffuse": 0.9})
    >>> found = adapt(system, palette, device_gamut(device, "envelope"), [Scale("sea")], progress=False)
    >>> found.accepted.means, round(found.exposure, 6)
    ('exposure', 0.5)
    >>> strict = adapt(system, palette, device_gamut(device, "envelope"), [Scale("sea")], most_difference=1)
    >>> strict.verdict, strict.accepted
    ('not reached', None)
    """
    # Refuse criteria that are no shares, and parts that do not fit together.
    start = time.perf_counter()
    check_kinds(system, palette, gamut)
    check_share(least_inside, "least_inside")
    check_share(least_lightness or 0.0, "least_lightness")
    check_share(least_luminance, "least_luminance")
    if most_difference is not None and not most_difference >= 0:
        raise ValueError(f"most_difference = {most_difference}: it is a mean CIEDE2000, 0 or more; or None")
    symbols_of(system, palette, scales)
    criteria = Criteria(float(least_inside), most_difference, least_lightness, least_luminance)
    checked = checked_range(scales[0] if scales else Scale("-"), within)

    # Every step is seen against the white of the image given, and its palette carries it.
    seen = as_asked(reference).kept(system, palette)
    image = appearance(system, replace(palette, white=seen.radiance), gamut, seen, most=most)
    work = _Work(image, tuple(scales), checked, seen, cap, criteria)

    # Try one means after another, until one meets all criteria.
    steps: list[Step] = []
    with tqdm(desc="adapt", unit="step", delay=1, leave=False, disable=not progress) as bar:
        for step in _steps(work, map_rest):
            steps.append(step)
            bar.set_postfix_str(step.means)
            bar.update()
            if criteria.met(step):
                break

    accepted = steps[-1] if criteria.met(steps[-1]) else None
    return Adapted(
        criteria=criteria,
        steps=tuple(steps),
        accepted=accepted,
        asked=len(image.pixels),
        objects=int(system.object_pixels.sum()),
        note=described(gamut),
        seconds=time.perf_counter() - start,
    )


@dataclass(frozen=True, eq=False)
class _Work:
    """The question put to `adapt`, with the image given."""

    image: Appearance
    scales: tuple[Scale, ...]
    within: tuple[float, float]
    reference: Reference
    cap: bool
    criteria: Criteria

    @property
    def bounds(self) -> Gamut | None:
        """The gamut that scales are fitted to, with bounds in each band; a monitor has none."""
        gamut = self.image.gamut
        if isinstance(gamut, Gamut):
            return gamut
        return device_gamut(gamut.devices[0], "envelope") if gamut.devices else None

    def exposed(self, palette: Palette, gamut: ConvexGamut | UnevenGamut, share: float) -> Feasible:
        """The exposures of a palette that leave no more than a share of the pixels outside a gamut."""
        return feasible(
            self.image.system,
            palette,
            gamut,
            Exposure(),
            within=(min(1.0, self.within[0]), 1.0),
            allowed_out=share,
            reference=self.reference,
            progress=False,
        )

    def fitted(self, bounds: Gamut, goal: Goal, share: float) -> Fit:
        """Scales of an objective that leave no more than a share outside the bounds."""
        return fit(
            self.image.system,
            self.image.palette,
            bounds,
            self.scales,
            objective=goal,
            within=self.within,
            allowed_out=share,
            reference=self.reference,
            cap=self.cap,
            least_luminance=0.0,
            progress=False,
        )


def _steps(work: _Work, map_rest: bool) -> Iterator[Step]:
    """The means one after another, each with what it reaches."""
    # List the means: dimming, and scales of each objective, without pixels left out and then with them.
    tried: list[Step] = []
    bounds, spare = work.bounds, 1.0 - work.criteria.least_inside
    asked = [partial(_as_given, work)]
    for share in (0.0, spare) if spare else (0.0,):
        asked.append(partial(_fewest, work, partial(_dimmed, work), share))
        if bounds is not None and work.scales:
            asked += [partial(_fewest, work, partial(_scaled, work, bounds, goal), share) for goal in GOALS]

    # Try them, and at last move the pixels that the best of them leave outside.
    for ask in asked:
        tried.append(ask())
        yield tried[-1]
    if map_rest:
        for step in _worth_mapping(work.criteria, tried):
            yield from (_mapped(work, step, towards) for towards in _targets(work.image.gamut))


def _targets(gamut: ConvexGamut | UnevenGamut) -> tuple[Target, ...]:
    """The targets of single pixels: no straight line leads to a grey in a gamut that is not convex."""
    if isinstance(gamut, UnevenGamut):
        return ("nearest",)
    return ("neutral",) if isinstance(gamut, Gamut) else ("nearest", "neutral")


def _worth_mapping(criteria: Criteria, tried: Sequence[Step]) -> list[Step]:
    """The steps that lack nothing but pixels inside; if there are none, the one that changed least."""
    different = {(step.inside, step.difference, step.lightness): step for step in reversed(tried)}
    ranked = sorted(different.values(), key=lambda step: step.difference)
    return [step for step in ranked if criteria.lacking(step) <= {"inside"}] or ranked[:1]


def _as_given(work: _Work) -> Step:
    start = time.perf_counter()
    figures = work.image.figures(work.image.palette)
    return Step("as given", *figures, "", work.image.palette, 1.0, 0.0, time.perf_counter() - start)


def _dimmed(work: _Work, share: float) -> Step:
    """One factor on all lights."""
    start = time.perf_counter()
    palette, gamut = work.image.palette, work.image.gamut
    if not isinstance(gamut, Gamut):
        return _judged(work, "exposure", palette, 1.0, share, "", start)
    level, why = _largest(work.exposed(palette, gamut, share))
    return _judged(
        work, "exposure", palette, level, share, f"all lights × {level:.4g}: {why or 'nothing binds'}", start
    )


def _scaled(work: _Work, bounds: Gamut, goal: Goal, share: float) -> Step:
    """Scales of an objective."""
    start = time.perf_counter()
    found = work.fitted(bounds, goal, share)
    named = [f"{name} × {found.values[name]:.4g}: {why}" for name, why in found.reasons.items() if why.x is not None]
    why = "; ".join(named) or "no pixel binds"
    left = found.untouched_outside.size + found.unfixable.size
    why += f"; {left} pixels are outside whatever the scales" if left else ""
    return _judged(work, goal, found.palette, 1.0, share, why, start)


def _judged(work: _Work, means: str, palette: Palette, exposure: float, share: float, binds: str, start: float) -> Step:
    """A palette's figures; all lights are dimmed further where the gamut itself asks for it."""
    image = work.image
    if not isinstance(image.gamut, Gamut):
        found = work.exposed(palette, image.gamut, share)
        exposure, why = _largest(found)
        own = f"all lights × {exposure:.4g}: {why}, for {image.gamut.name}" if exposure < 1 or why else ""
        binds = "; ".join(part for part in (binds, own) if part)
    final = moved(image.system, palette, Exposure(), exposure) if exposure != 1 else palette
    return Step(means, *image.figures(final), binds, final, exposure, share, time.perf_counter() - start)


def _largest(found: Feasible) -> tuple[float, str]:
    """The largest exposure found, at most 1, and what stops it; what is too much to ask leaves it as it is."""
    left = found.untouched_outside.size + found.unfixable.size
    outside = f"{left} pixels are outside at any exposure" if left else ""
    if found.high is None:
        return 1.0, outside or "no exposure suits all pixels"
    why = str(found.reasons[-1][1]) if found.high < 1 else ""
    return found.high, "; ".join(part for part in (why, outside) if part)


def _fewest(work: _Work, ask: Callable[[float], Step], share: float) -> Step:
    """The step with the least share left out that meets all criteria; that of the whole share if none does."""
    step = ask(share)
    if not share or not work.criteria.met(step):
        return step
    few, many = 0.0, share
    for _ in range(SHARE_HALVINGS):
        other = ask((few + many) / 2)
        if work.criteria.met(other):
            step, many = other, other.left_out
        else:
            few = other.left_out
    return step


def _mapped(work: _Work, step: Step, towards: Target) -> Step:
    """A step whose image still has pixels outside, which are moved one by one."""
    # Move the pixels.
    start = time.perf_counter()
    image = work.image
    found = map_pixels(
        image.system, step.palette, image.gamut, towards=towards, reference=work.reference, progress=False
    )

    # Judge the image that results as the others were: what was moved lies on the boundary, to rounding.
    values = found.image.values.reshape(-1, len(image.white)) / image.white
    looks = image.looks(values[image.pixels])
    inside = image.inside_to_rounding(values[image.judged])
    binds = f"{found.share:.1%} of the object pixels moved, by at most {found.moved.max():.3g} RMS"
    return Step(
        f"{step.means}, then pixel by pixel to the {'nearest' if towards == 'nearest' else 'grey'}",
        inside,
        *looks,
        binds,
        step.palette,
        step.exposure,
        step.left_out,
        time.perf_counter() - start,
        mapped=found.image,
    )
