"""Benchmarks, one module a layer: `run()` measures and returns tables, ratios beside their targets.

Nothing here is imported by the program, and no test depends on a time measured here.
"""

from perfqr_cad.table import Table

__all__ = ["Table"]
