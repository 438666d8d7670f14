"""How the rings are held, and who reads the code then: the measurement behind the default of `finder`.

Plates of several versions and module sizes are filmed frontally and tilted; every decoder of the core panel
is asked for each view.
"""

from __future__ import annotations

from itertools import product
from typing import get_args

from perfqr_cad.bench.pattern import plain_code
from perfqr_cad.pattern import PatternSpec, build
from perfqr_cad.pattern.spec import FinderStrategy
from perfqr_cad.progress import tell
from perfqr_cad.scan import Look, View
from perfqr_cad.scan.camera.preview import plate_scene
from perfqr_cad.scan.decoding.decoders import CORE, accepted
from perfqr_cad.scan.decoding.panel import Panel, shared
from perfqr_cad.scan.proof import PATIENCE, reads
from perfqr_cad.symbol import payload_of
from perfqr_cad.table import Table

VERSIONS = (1, 3, 5, 7, 20)
MODULES_MM = (1.2, 2.4)  # the least that a 0.4 mm nozzle can print, and twice that
THICKNESS_MM, LIP_MM, DRAFT_DEG = 1.6, 0.2, 15.0  # a plate that is meant to be read from the side
TILTS_DEG = (0.0, 20.0, 30.0)
AZIMUTHS_DEG = (65.0, 205.0)  # off the code's axes, as the certificate films it
VIEW_MODULE_PX = 6.0  # frontal
LEAST_VIEW_PX = 400
VIEW_MODULE_OF_LARGE_PX = 4.0  # of codes over LARGE modules a side, as a sensor of finite size sees them
LARGE = 100


def run() -> Table:
    """Views read of all filmed, by strategy and tilt, for zxing-cpp and for the whole core panel."""
    panel = shared(CORE)
    counts = {
        (strategy, version, module): _read(strategy, version, module, panel)
        for strategy, version, module in product(get_args(FinderStrategy), VERSIONS, MODULES_MM)
    }
    small = [version for version in VERSIONS if version <= 6]
    rows: list[tuple[object, ...]] = []
    for strategy in get_args(FinderStrategy):
        for name, versions in (("1 to 6", small), ("7 to 20", [v for v in VERSIONS if v not in small])):
            some = [counts[strategy, v, m] for v in versions for m in MODULES_MM]
            zxing = [_share([views[k][0] for views in some]) for k in range(len(TILTS_DEG))]
            every = [_share([views[k][1] for views in some]) for k in range(len(TILTS_DEG))]
            rows.append((strategy, name, *zxing, *every))
    return Table(
        "finder: views read, by how the rings are held",
        (
            "finder",
            "versions",
            *(f"zxing-cpp {tilt:g}°" for tilt in TILTS_DEG),
            *(f"core panel {tilt:g}°" for tilt in TILTS_DEG),
        ),
        tuple(rows),
        (
            f"versions {', '.join(map(str, VERSIONS))}; modules of 1.2 and 2.4 mm; plates of"
            f" {THICKNESS_MM:g} mm with a lip of {LIP_MM:g} mm and a draft of {DRAFT_DEG:g}°",
            f"core panel: {', '.join(CORE)}; {PATIENCE} frames a view",
        ),
    )


Counts = list[tuple[list[bool], list[bool]]]  # by tilt: for zxing-cpp and for every decoder, view by view


def _read(strategy: FinderStrategy, version: int, module_mm: float, panel: Panel) -> Counts:
    tell(f"finder: {strategy}, version {version}, modules of {module_mm:g} mm")
    symbol = plain_code(version)
    size_mm = module_mm * (symbol.size + 8)
    pattern = build(symbol, PatternSpec(size_mm=size_mm, finder=strategy))
    scene = plate_scene(pattern, THICKNESS_MM, draft_deg=DRAFT_DEG, lip_mm=LIP_MM)
    module_px = VIEW_MODULE_PX if symbol.size <= LARGE else VIEW_MODULE_OF_LARGE_PX
    size_px = max(LEAST_VIEW_PX, round(module_px * (symbol.size + 8) / 0.7))
    views = [
        View(tilt, azimuth, size_px=size_px)
        for tilt in TILTS_DEG
        for azimuth in (AZIMUTHS_DEG if tilt else AZIMUTHS_DEG[:1])
    ]
    right = accepted(payload_of(symbol).data)
    found = reads(scene, views, Look(), right, panel, frames=[PATIENCE] * len(views))
    return [
        (
            ["zxing-cpp" in names for view, names in zip(views, found, strict=True) if view.tilt_deg == tilt],
            [
                d in names
                for view, names in zip(views, found, strict=True)
                if view.tilt_deg == tilt
                for d in CORE
            ],
        )
        for tilt in TILTS_DEG
    ]


def _share(read: list[list[bool]]) -> str:
    every = [one for some in read for one in some]
    return f"{sum(every) / len(every):.0%}"
