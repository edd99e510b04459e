"""``python -m symrt`` is the command line."""

import sys

from symrt.cli import main

sys.exit(main())
