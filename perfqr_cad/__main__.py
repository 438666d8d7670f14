"""`python -m perfqr_cad` is the command `perfqr`."""

import sys
from pathlib import Path

# Python puts the current folder first on its path: a random.py that lies there is none of this program's.
if sys.path and Path(sys.path[0]).resolve() == Path.cwd() != Path(__file__).resolve().parents[1]:
    del sys.path[0]

from perfqr_cad.cli import entry

entry()
