# pyright: reportAttributeAccessIssue=false
# The modeller's stubs are incomplete.
"""Exact solids: building, proof, STEP and STL, and what the same work costs the naive way."""

from __future__ import annotations

import resource
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from perfqr_cad.pattern import Pattern, PatternSpec
from perfqr_cad.pattern import build as build_pattern
from perfqr_cad.solid import Walls
from perfqr_cad.surface import Cylinder, HeightField, Placement, Plane, Sphere
from perfqr_cad.symbol import encode
from perfqr_cad.table import Table

TEXT = "https://example.com/p/1234567"
SIZE_MM, THICKNESS_MM = 140.0, 2.0
KB_PER_GB = 1e6  # of Linux's account of memory
NAIVE_CUTS = 24  # box cuts that are timed; the rest are extrapolated, which favours the loop: cuts get slower


def run() -> Table:
    """Processor times of one run on this machine; the ratios are what carries over."""
    eight = _pattern(8)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "part.step"
        _parts(_pattern(3), Plane(THICKNESS_MM), path)  # loads the modeller
        plate, shape = _parts(eight, Plane(THICKNESS_MM), path)
        total = sum(plate.values())
        rows: list[tuple[Any, ...]] = [_row("version 8, plate, filleted", plate, total, 1.0)]
        drafted, _ = _parts(eight, Plane(THICKNESS_MM), path, Walls(draft_deg=5.0, lip_mm=0.4))
        rows.append(_row("version 8, plate, drafted 5°", drafted, total, None))
        curved: dict[str, Placement] = {
            "version 8, cylinder": Cylinder(100.0, THICKNESS_MM),
            "version 8, sphere": Sphere(110.0, THICKNESS_MM),
            "version 8, B-spline": HeightField.of(_bump, 75.0, THICKNESS_MM),
        }
        for name, placement in curved.items():
            rows.append(_row(name, _parts(eight, placement, path)[0], total, 4.0))
        for version, target in ((20, 4.0), (40, 20.0)):
            parts, _ = _parts(_pattern(version), Plane(THICKNESS_MM), path)
            rows.append(_row(f"version {version}, plate", parts, total, target))
        kernel = _kernel_writer(shape, path)
    naive = _naive()
    rows.append(("version 8, box cuts one by one (CadQuery)", None, None, None, naive, naive / total, None))
    rows.append(("version 8, the kernel's own STEP writer", None, kernel, None, kernel, kernel / total, None))
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / KB_PER_GB
    return Table(
        title="Solids (processor seconds)",
        columns=("case", "solid + proof + mesh", "STEP", "STL", "total", "ratio to first", "target"),
        rows=tuple(rows),
        notes=(
            f"{SIZE_MM:g} mm code, {THICKNESS_MM:g} mm thick (version 40: doubled); up to {memory:.2g} GB",
            f"the naive loop is timed over {NAIVE_CUTS} cuts and extrapolated to one for each dark module, "
            "without STEP, STL or a check; later cuts are slower, so that favours the loop",
        ),
    )


def _pattern(version: int) -> Pattern:
    spec = PatternSpec(size_mm=SIZE_MM if version <= 20 else 2 * SIZE_MM, time_limit_s=5.0)
    return build_pattern(encode(TEXT, version=version), spec)


def _parts(
    pattern: Pattern, placement: Placement, path: Path, walls: Walls | None = None
) -> tuple[dict[str, float], Any]:
    from perfqr_cad.solid import build, write_step

    times: dict[str, float] = {}
    solid = _timed(times, "solid", lambda: build(pattern, placement, walls))
    _timed(times, "step", lambda: write_step(solid, path))
    _timed(
        times, "stl", lambda: _stl(solid.triangles.vertices[solid.triangles.faces], path.with_suffix(".stl"))
    )
    return times, solid.shape


def _timed(times: dict[str, float], name: str, work: Callable[[], Any]) -> Any:
    start = time.process_time()
    result = work()
    times[name] = time.process_time() - start
    return result


def _row(name: str, times: dict[str, float], first: float, target: float | None) -> tuple[Any, ...]:
    total = sum(times.values())
    return name, times["solid"], times["step"], times["stl"], total, total / first, target


def _stl(corners: np.ndarray[Any, Any], path: Path) -> None:
    """Binary STL, as the exporter lays it out."""
    record = np.zeros(
        len(corners), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")]
    )
    record["corners"] = corners
    path.write_bytes(bytes(80) + np.uint32(len(corners)).tobytes() + record.tobytes())


def _naive() -> float:
    """A box cut for every dark module, as a first script would do it."""
    import cadquery

    matrix = encode(TEXT, version=8).matrix
    module = SIZE_MM / (matrix.size + 8)
    dark = [(c, r) for r in range(matrix.size) for c in range(matrix.size) if matrix.dark[r, c]]
    start = time.process_time()
    plate = cadquery.Workplane().box(SIZE_MM, SIZE_MM, THICKNESS_MM)
    for column, row in dark[:NAIVE_CUTS]:
        at = ((column + 0.5 - matrix.size / 2) * module, (matrix.size / 2 - row - 0.5) * module)
        plate = plate.cut(cadquery.Workplane().center(*at).box(module, module, 2 * THICKNESS_MM))
    return (time.process_time() - start) * len(dark) / NAIVE_CUTS


def _kernel_writer(shape: Any, path: Path) -> float:
    """The kernel's STEP writer on the same solid: it heals every perforated face again, wire against wire."""
    from OCP.STEPControl import STEPControl_StepModelType, STEPControl_Writer

    start = time.process_time()
    writer = STEPControl_Writer()
    writer.Transfer(shape, STEPControl_StepModelType.STEPControl_AsIs)
    writer.Write(str(path))
    return time.process_time() - start


def _bump(x: np.ndarray[Any, Any], y: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    return -(x * x + y * y) / 300 + np.sin(x / 15)
