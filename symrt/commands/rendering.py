"""Commands that render a scene, in one go or in parts, and put parts together (steps 1 and 2)."""

import re
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

import symrt as rt
from symrt.commands import options as option
from symrt.commands.arguments import pairs_of, scene_of
from symrt.commands.freeing import free_of, values_of
from symrt.commands.outputs import apart, writable
from symrt.commands.saying import say
from symrt.errors import shown
from symrt.show.writing import json_text

if TYPE_CHECKING:
    from symrt.linear.workers import Workers
    from symrt.system import LinearSystem


def render(  # noqa: PLR0913, PLR0917  # a command names its options
    scene: option.SceneFile,
    out: Annotated[
        Path | None,
        typer.Option("--out", "-o", help="Where the system goes; SCENE.npz if not given. Of parts, a folder."),
    ] = None,
    size: option.Size = None,
    samples: Annotated[int | None, typer.Option(help="n for n × n samples a pixel.")] = None,
    alternative: Annotated[
        list[str] | None,
        typer.Option(metavar="FROM:TO", help="Trace also what a blend of two unlike materials needs; repeatable."),
    ] = None,
    without: option.Without = None,
    tolerance: option.Thrift = None,
    free: option.Freed = None,
    error: option.InterpolationError = None,
    lengths: option.LengthScheme = "hats",
    workers: Annotated[
        str | None, typer.Option(help="Threads, or the word processes; the result does not depend on it.")
    ] = None,
    part: Annotated[
        str | None,
        typer.Option(metavar="K/N", help="Render only the K-th of N parts, into the folder --out; see merge."),
    ] = None,
    memory: Annotated[
        float | None, typer.Option(metavar="GIB", help="GiB there are; this machine's if not given.")
    ] = None,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="Say what memory and time it would take.")] = False,
    as_json: option.Json = False,
) -> None:
    """Trace and collapse a scene into a linear system.

    The file that it writes is what every other command reads.

    Example: symrt render globe --size 512 --out globe.npz
    """
    # Words that cannot be obeyed are refused before any work.
    how: dict[str, Any] = {"alternatives": pairs_of(alternative or ()), "force": dict.fromkeys(without or (), False)}
    how |= {
        "free": free_of(free or ()),
        "tolerance": tolerance,
        "error": error,
        "lengths": lengths,
        "workers": _workers(workers),
    }
    numbers = None if part is None else _part(part)
    if numbers is not None and out is None and not dry_run:
        raise ValueError(f"--part {part}: name the folder that the parts go to, such as --out parts")
    if numbers is None and not dry_run:
        out = writable(out or Path(f"{Path(scene).stem}.npz"), ".npz", form="symrt-system")
        apart({"--out": out}, [scene])

    # An estimate, a part, or all of it.
    loaded = scene_of(scene, size, samples)
    if dry_run:
        found = rt.estimate(loaded, part=numbers, **how)
        say(json_text(asdict(found)) if as_json else str(found))
    elif numbers is not None and out is not None:
        path = rt.render_part(loaded, numbers, out, memory=memory, **how)
        say(json_text({"part": str(path)}) if as_json else f"{path}: part {numbers[0]} of {numbers[1]}")
    elif out is not None:
        _save(out, rt.render(loaded, memory=memory, **how), as_json)


def merge(
    folder: Annotated[Path, typer.Argument(metavar="FOLDER", help="The folder of the parts.")],
    out: Annotated[Path, typer.Option("--out", "-o", help="Where the system goes (.npz).")],
    as_json: option.Json = False,
) -> None:
    """Put the parts of a picture together; those that are missing are named as a job array takes them.

    Example: symrt merge parts --out globe.npz
    """
    out = writable(out, ".npz", form="symrt-system")
    _save(out, rt.merge_parts(folder), as_json)


def settle(
    system: Annotated[str, typer.Argument(metavar="SYSTEM", help="A system with free parameters (.npz).")],
    values: Annotated[list[str], typer.Argument(metavar="NAME=VALUE...", help="Such as brass.exponent=40.")],
    out: Annotated[Path, typer.Option("--out", "-o", help="Where the system goes (.npz).")],
    as_json: option.Json = False,
) -> None:
    """Give free parameters of a system their values, without rendering: every other command takes what it writes.

    Example: symrt settle free.npz brass.exponent=40 --out globe.npz
    """
    out = writable(out, ".npz", form="symrt-system")
    apart({"--out": out}, [system])
    _save(out, rt.load_system(system).at(values_of(values)), as_json)


def _save(out: Path, system: "LinearSystem", as_json: bool) -> None:
    rt.save_system(out, system)
    record = {"system": str(out), "width": system.width, "height": system.height}
    record |= {"interactions": [str(i) for i in system.interactions], "coefficients": int(system.G.nnz)}
    record |= {"errors": {light: asdict(error) for light, error in system.errors.items()}}
    record |= {"counts": {name: asdict(count) for name, count in system.counts.effects.items()}}
    record |= {"parameters": {name: asdict(nodes) for name, nodes in system.parameters.items()}}
    record |= {"lengths": {name: asdict(how) | {"error": how.error} for name, how in system.lengths.items()}}
    seconds = ", ".join(f"{name} {spent:.2f} s" for name, spent in system.seconds.items())
    if as_json:
        say(json_text(record | {"seconds": dict(system.seconds)}))
    else:
        say(f"{out}: {system!r}; {seconds}")
        say(str(system.counts), err=True)


def _workers(word: str | None) -> "Workers":
    """The workers of ``--workers``: a number of threads, or processes."""
    if word is None or word == "processes":
        return word  # type: ignore[return-value]  # one of the two
    if not re.fullmatch(r"[1-9][0-9]{0,3}", word):
        raise ValueError(f"--workers {shown(word)}: at least one thread works: give a number from 1, or processes")
    return int(word)


def _part(word: str) -> tuple[int, int]:
    """The number of a part and of all parts, from a word such as ``3/64``."""
    found = re.fullmatch(r"([0-9]{1,6})/([0-9]{1,6})", word)
    if not found:
        raise ValueError(f"--part {shown(word)}: write K/N, such as 3/64 for the third of 64 parts")
    return int(found[1]), int(found[2])
