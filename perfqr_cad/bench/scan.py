"""The camera and the panel: views a second, a whole panel, and what is read before which ground."""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial

from perfqr_cad.geometry import Triangles
from perfqr_cad.pattern import Pattern, PatternSpec, build
from perfqr_cad.scan import FULL, Look, ScanReport, Scene, View, certify, place
from perfqr_cad.scan.camera.camera import Camera
from perfqr_cad.solid import build as build_solid
from perfqr_cad.surface import Plane
from perfqr_cad.symbol import encode
from perfqr_cad.table import Table

TEXT = "https://example.com/p/1234567"
TILTS_DEG = (0.0, 20.0, 45.0, 60.0)
REPEATS = 3
LONG_S = 5.0  # a run as long as this needs no repeat


def run() -> Table:
    """Seconds of wall time and of this process's CPU, the targets for two idle cores; and, as remarks, what
    each engine reads before each ground, and the grade."""
    pattern = build(encode(TEXT, version=5), PatternSpec(size_mm=60.0))
    placement = Plane(2.0)
    triangles = build_solid(pattern, placement).triangles
    scene = Scene(place(triangles, placement, edge_mm=pattern.size_mm))

    def prepare() -> None:
        Scene(place(triangles, placement, edge_mm=pattern.size_mm)).prepare(Look())

    rows: list[tuple[object, ...]] = [("sections and light, once a part", *_timed(prepare), None)]
    for tilt in TILTS_DEG:
        view = View(tilt, 25.0)
        camera = Camera(view, scene.part.code)
        rows.append(
            (f"plate, 1000 x 1000, {tilt:g}°", *_timed(partial(scene.layered, camera, Look(), 0.85)), 0.05)
        )
        rows.append(
            (f"rays, 1000 x 1000, {tilt:g}°", *_timed(partial(scene.cast, camera, Look(), 0.85)), 0.3)
        )
    rows.append(
        ("quick certificate, 4 engines", *_timed(lambda: _certify(triangles, pattern, full=False)), 2.0)
    )
    whole: list[ScanReport] = []
    rows.append((f"whole panel, {len(FULL.views())} views, all engines",
                 *_timed(lambda: whole.append(_certify(triangles, pattern, full=True))), 15.0))  # fmt: skip
    return Table(
        "Scan",
        ("what", "wall s", "cpu s", "target s"),
        tuple(rows),
        (
            "part and flat print both filmed",
            "cpu: pictures only, decoders run in processes of their own",
            *_before_grounds(whole[-1]),
        ),
    )


def _before_grounds(report: ScanReport) -> list[str]:
    """What each engine reads before each ground, by tilt, and the grade."""
    lines: list[str] = []
    for result in report.grounds:
        tilts = "/".join(f"{tilt:g}" for tilt in result.tilts_deg)
        read = (f"{name} {'/'.join(f'{rate:.0%}' for rate in rates)}" for name, rates in result.rates.items())
        lines.append(f"{result.ground.name}, {tilts}°: {', '.join(read)}")
    return [*lines, *([] if report.grade is None else [f"grade {report.grade.words}"])]


def _certify(triangles: Triangles, pattern: Pattern, *, full: bool) -> ScanReport:
    placement = Plane(2.0)
    if full:
        return certify(triangles, placement, pattern, TEXT, schedule=FULL, decoders=None)
    return certify(triangles, placement, pattern, TEXT)


def _timed(action: Callable[[], object]) -> tuple[float, float]:
    """Wall and CPU seconds: the first call warms up what is kept, the best of the next is reported."""
    best = (float("inf"), float("inf"))
    begin, busy = time.perf_counter(), time.process_time()
    action()
    first = time.perf_counter() - begin
    if first > LONG_S:
        return first, time.process_time() - busy
    for _ in range(REPEATS):
        wall, cpu = time.perf_counter(), time.process_time()
        action()
        best = min(best, (time.perf_counter() - wall, time.process_time() - cpu))
    return best
