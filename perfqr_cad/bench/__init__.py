"""Benchmarks, one module a layer."""

from perfqr_cad.table import Table

__all__ = ["Table"]
