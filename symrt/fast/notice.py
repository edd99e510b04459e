"""One line on standard error when something is compiled for the first time: what was kept is only loaded."""

import sys
from typing import Any

from numba.core import event
from tqdm import tqdm

NOTICE = "symrt compiles its inner loops for this processor, once: this takes some seconds"


class Notice(event.Listener):
    """Listens to Numba's compiler."""

    said = False

    def on_start(self, event: Any) -> None:  # noqa: ARG002  # Numba's names
        """Say it, once a process."""
        if not Notice.said:
            tqdm.write(NOTICE, file=sys.stderr)
            Notice.said = True

    def on_end(self, event: Any) -> None:
        """Nothing."""
