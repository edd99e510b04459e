"""The command line: it assembles the commands of `symrt.commands` and ends bad input in one line.

Nothing slow is imported before a command needs it, so that ``symrt --help`` answers at once.  Bad input ends in one
line a fault on standard error and exit code 2; results go to standard output, progress to standard error.
"""

import sys
import warnings
from collections.abc import Sequence
from functools import partial
from typing import Annotated, Any

import typer

import symrt as rt
from symrt.commands.feedback import adapt, feasible, fit, map_pixels
from symrt.commands.gamuts import gamut, report
from symrt.commands.rendering import merge, render, settle
from symrt.commands.saying import say
from symrt.commands.scenes import demo, formula, gallery, plan, probe, shade

app = typer.Typer(add_completion=False, pretty_exceptions_enable=False, rich_markup_mode=None)

# Whatever class the installed typer derives its usage errors from: click's own, or a copy of it.
USAGE_ERROR: Any = next(kind for kind in reversed(typer.BadParameter.__mro__) if hasattr(kind, "format_message"))
BAD_INPUT, INTERRUPTED = 2, 130
LONGEST = 600
"""Letters of a fault's line; what was given may be longer."""
COMMANDS = (
    plan,
    probe,
    render,
    merge,
    settle,
    formula,
    shade,
    gamut,
    feasible,
    report,
    fit,
    adapt,
    map_pixels,
    gallery,
    demo,
)
"""In the order in which the help lists them."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; the exit code is 0, 2 for bad input, 130 when interrupted.

    Examples
    --------
    >>> main(["--version"])
    symrt 0.1.0
    0
    """
    # Run the command; each of its warnings is a line, said once.
    try:
        with warnings.catch_warnings():
            said: set[str] = set()
            warnings.showwarning = partial(_warned, said)
            words = sys.argv[1:] if arguments is None else list(arguments)
            return int(app(words or ["--help"], prog_name="symrt", standalone_mode=False) or 0)

    # Whatever stops it is an exit code, and a line that says why.
    except (KeyboardInterrupt, typer.Abort):
        return INTERRUPTED
    except USAGE_ERROR as error:
        return _refused(error.format_message())
    except OSError as error:
        return _refused(f"{error.filename}: {error.strerror}" if error.filename else str(error))
    except (ValueError, MemoryError) as error:
        return _refused(str(error))


def _show_version(asked: bool) -> bool:
    if asked:
        typer.echo(f"symrt {rt.__version__}")
        raise typer.Exit
    return asked


@app.callback()
def start(
    version: Annotated[  # its callback answers
        bool, typer.Option("--version", help="Show the version and exit.", is_eager=True, callback=_show_version)
    ] = False,
) -> None:
    """Render a scene once, with every light and material left free; then ask.

    Example: symrt demo --out out
    """


for command in COMMANDS:
    app.command(command.__name__.replace("_", "-"))(command)


def _warned(said: set[str], message: Warning | str, *_: Any, **__: Any) -> None:
    """One line for each warning, however often the library has reason to give it."""
    if str(message) in said:
        return
    said.add(str(message))
    say(f"symrt: warning: {message}", err=True)


def _refused(message: str) -> int:
    for line in message.splitlines():
        say(f"symrt: {line if len(line) <= LONGEST else line[:LONGEST] + '…'}", err=True)
    return BAD_INPUT
