"""`python -m perfqr_cad` is the command `perfqr`."""

from perfqr_cad.cli import entry

entry()
