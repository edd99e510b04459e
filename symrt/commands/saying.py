"""Output to the terminal, without characters that it would obey, in whatever encoding it has."""

import sys
from typing import Any

import typer

from symrt.errors import plain


def say(text: str, *, err: bool = False) -> None:
    r"""Write lines to standard output, or standard error; characters that a terminal would obey are shown as escapes.

    Letters that the stream's encoding lacks become escapes too: an answer never fails after the work is done.

    Examples
    --------
    >>> say("a\x1b[2Jprinter")
    a\x1b[2Jprinter
    """
    stream: Any = sys.stderr if err else sys.stdout
    encoding = getattr(stream, "encoding", None) or "utf-8"
    typer.echo(plain(text, keep="\n").encode(encoding, "backslashreplace").decode(encoding), err=err)
