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
from perfqr_cad.pattern.choice import easiest
from perfqr_cad.profile import Walls
from perfqr_cad.solid import Solid
from perfqr_cad.surface import Cylinder, HeightField, Placement, Plane, Sphere
from perfqr_cad.symbol import encode
from perfqr_cad.table import Table

TEXT = "https://example.com/p/1234567"
SIZE_MM, THICKNESS_MM = 140.0, 2.0
KB_PER_GB = 1e6  # of Linux's account of memory
NAIVE_S = 60.0  # processor time after which the loop of box cuts is given up
FLARED = Walls(draft_deg=15.0, lip_mm=0.2)


def run() -> Table:
    """Processor times of one run on this machine; the ratios are what carries over."""
    eight = _pattern(8)
    plate = Plane(THICKNESS_MM)
    curved: dict[str, Placement] = {
        "version 8, cylinder": Cylinder(100.0, THICKNESS_MM),
        "version 8, sphere": Sphere(110.0, THICKNESS_MM),
        "version 8, B-spline": HeightField.of(_bump, 75.0, THICKNESS_MM),
    }
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "part.step"
        for placement in (plate, *curved.values()):
            _parts(_pattern(3), placement, path)  # loads the libraries
        times, solid = _parts(eight, plate, path)
        total = sum(times.values())
        rows: list[tuple[Any, ...]] = [_row("version 8, plate, filleted", times, total, 1.0)]
        for version, target in ((5, 2.0), (8, None)):
            pattern = eight if version == 8 else _pattern(version)
            drafted, _ = _parts(pattern, plate, path, FLARED)
            rows.append(_row(f"version {version}, plate, drafted 15°", drafted, total, target))
        for name, placement in curved.items():
            rows.append(_row(name, _parts(eight, placement, path)[0], total, 4.0))
        for version, target in ((20, 4.0), (40, 20.0)):
            parts, _ = _parts(_pattern(version), plate, path)
            rows.append(_row(f"version {version}, plate", parts, total, target))
        memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / KB_PER_GB
        kernel = _kernel_writer(solid.shape, path)
    naive, cuts, all_cuts = _naive()
    rows.append(("version 8, box cuts one by one (CadQuery)", naive, None, None, naive, naive / total, None))
    rows.append(("version 8, the kernel's own STEP writer", None, kernel, None, kernel, kernel / total, None))
    bound = "" if cuts == all_cuts else f": given up after {NAIVE_S:g} s, its time and ratio are lower bounds"
    return Table(
        title="Solids (processor seconds)",
        columns=("case", "solid + proof + mesh", "STEP", "STL", "total", "ratio to first", "target"),
        rows=tuple(rows),
        notes=(
            f"{SIZE_MM:g} mm code, {THICKNESS_MM:g} mm thick (version 40: doubled); up to {memory:.2g} GB",
            f"the loop made {cuts} of {all_cuts} box cuts, without STEP, STL or a check{bound}",
        ),
    )


def _pattern(version: int) -> Pattern:
    spec = PatternSpec(size_mm=SIZE_MM if version <= 20 else 2 * SIZE_MM)
    return build_pattern(easiest(encode(TEXT, version=version), spec, pads=False)[0], spec)


def _parts(
    pattern: Pattern, placement: Placement, path: Path, walls: Walls | None = None
) -> tuple[dict[str, float], Solid]:
    from perfqr_cad.solid import build, write_step

    times: dict[str, float] = {}
    solid = _timed(times, "solid", lambda: build(pattern, placement, walls))
    _timed(times, "step", lambda: write_step(solid, path))
    _timed(
        times, "stl", lambda: _stl(solid.triangles.vertices[solid.triangles.faces], path.with_suffix(".stl"))
    )
    return times, solid


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


def _naive() -> tuple[float, int, int]:
    """A box cut for every dark module, as a first script would do it: its time, cuts made, cuts to make."""
    import cadquery

    matrix = encode(TEXT, version=8).matrix
    module = SIZE_MM / (matrix.size + 8)
    dark = [(c, r) for r in range(matrix.size) for c in range(matrix.size) if matrix.dark[r, c]]
    start = time.process_time()
    plate = cadquery.Workplane().box(SIZE_MM, SIZE_MM, THICKNESS_MM)
    cuts = 0
    while cuts < len(dark) and time.process_time() - start < NAIVE_S:
        column, row = dark[cuts]
        at = ((column + 0.5 - matrix.size / 2) * module, (matrix.size / 2 - row - 0.5) * module)
        plate = plate.cut(cadquery.Workplane().center(*at).box(module, module, 2 * THICKNESS_MM))
        cuts += 1
    return time.process_time() - start, cuts, len(dark)


def _kernel_writer(shape: Any, path: Path) -> float:
    """The kernel's STEP writer on the same solid: it heals every perforated face again, wire against wire."""
    from OCP.STEPControl import STEPControl_StepModelType, STEPControl_Writer

    from perfqr_cad.solid.kernel import occ

    occ.silence()
    start = time.process_time()
    writer = STEPControl_Writer()
    writer.Transfer(shape, STEPControl_StepModelType.STEPControl_AsIs)
    writer.Write(str(path))
    return time.process_time() - start


def _bump(x: np.ndarray[Any, Any], y: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    return -(x * x + y * y) / 300 + np.sin(x / 15)
