"""Table 1: the five codes on a cuboid, with our times beside the paper's.

The paper ran C++ on a desktop processor of 4 GHz with Abaqus for the stress; the ratio column is its sum of
connectivity and structural time over ours. Its modules of thin halftones could be printed below two nozzle
lines; a size that our web rule refuses is raised to the least that works, and said so.
"""

from __future__ import annotations

import time
from pathlib import Path

from perfqr_cad.reproduce.exhibits import pattern_of
from perfqr_cad.reproduce.stand_ins import TABLE_1, THICKNESS_MM, Row, picture
from perfqr_cad.table import Table

COLUMNS = (
    "model", "version", "size mm", "islands", "connectivity s", "paper s", "bridges",
    "structure s", "paper s ", "added", "status", "times faster",
)  # fmt: skip
PRESSURE_MPA = 5e-6  # §5.2: 5 Pa
YIELD_MPA = 10.0  # §5.2: χ for PLA


def run(out: Path) -> Table:
    """Rows of Table 1."""
    return Table(
        "Table 1: connectivity and structure, ours beside the paper's",
        COLUMNS,
        tuple(_row(row, out) for row in TABLE_1),
        (f"cuboid of {THICKNESS_MM:g} mm, {PRESSURE_MPA:g} MPa, χ = {YIELD_MPA:g} MPa, clamped",),
    )


def _row(row: Row, out: Path) -> tuple[object, ...]:
    from perfqr_cad.capture import read
    from perfqr_cad.structure import Case, Pressure, reinforce
    from perfqr_cad.surface import Plane

    captured = read(picture(row, out))
    begin = time.perf_counter()
    pattern = pattern_of(captured, row)
    connected = time.perf_counter()
    strong = reinforce(pattern, Plane(THICKNESS_MM), Case.of(Pressure(PRESSURE_MPA), yield_mpa=YIELD_MPA))
    reinforced = time.perf_counter()
    ours = reinforced - begin
    return (
        row.name, captured.matrix.version, pattern.size_mm, pattern.islands_before, connected - begin,
        row.connectivity_s, len(pattern.bridges), reinforced - connected, row.structural_s,
        len(strong.bridges), strong.status,
        (row.connectivity_s + row.structural_s) / ours,
    )  # fmt: skip
