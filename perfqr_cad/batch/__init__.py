"""Many parts from a table: one row, one part. Rows are made in other processes, or by a Dask cluster."""

from perfqr_cad.batch.order import Order, Plan, suffixes
from perfqr_cad.batch.rows import Label, read_lines, read_table
from perfqr_cad.batch.workers import Summary, run

__all__ = ["Label", "Order", "Plan", "Summary", "read_lines", "read_table", "run", "suffixes"]
