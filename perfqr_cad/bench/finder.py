"""How the rings are held, and who reads the code then: the front behind `finder` and `bars`.

Plates of several versions and module sizes are filmed tilted, held in every way from bars that read from
furthest aside to bars that bear most; every decoder of the core panel is asked for each view.
"""

from __future__ import annotations

from dataclasses import dataclass

from perfqr_cad.bench.pattern import plain_code
from perfqr_cad.pattern import PatternSpec, build
from perfqr_cad.pattern.spec import FinderStrategy
from perfqr_cad.pipeline.holding import ALLOWABLE_MPA, RingHold, front
from perfqr_cad.progress import tell
from perfqr_cad.scan import Look, View
from perfqr_cad.scan.camera.preview import plate_scene
from perfqr_cad.scan.decoding.decoders import CORE, accepted
from perfqr_cad.scan.decoding.panel import shared
from perfqr_cad.scan.filming import reads
from perfqr_cad.scan.schedule import PATIENCE
from perfqr_cad.symbol import payload_of
from perfqr_cad.table import Table

CODES = ((1, 2.0), (3, 1.6), (5, 1.3), (7, 1.2), (3, 2.4))  # version, module in mm
THICKNESS_MM, LIP_MM, DRAFT_DEG = 1.6, 0.2, 15.0  # a plate that is meant to be read from the side
NOZZLE_MM = 0.4
HOLDS = 4  # of the front: thicker plates are out of reach of zbar
TILTS_DEG = (10.0, 20.0, 30.0, 40.0)
AZIMUTHS_DEG = (25.0, 115.0, 205.0, 295.0)  # off the code's axes, as the certificate films it
VIEW_MODULE_PX = 6.0  # frontal
LEAST_VIEW_PX = 400
TYPICAL_MODULE_MM = 1.6  # for which the force is given


@dataclass(frozen=True)
class _Way:
    """A way to hold rings, and how thick its plates are."""

    finder: FinderStrategy
    hold: RingHold | None = None

    @property
    def thickness_mm(self) -> float:
        return THICKNESS_MM if self.hold is None else self.hold.thickness_mm

    def spec(self, size_mm: float) -> PatternSpec:
        if self.hold is None:
            return PatternSpec(size_mm=size_mm, finder=self.finder)
        bars, height, width = self.hold.bars, self.hold.height_mm, self.hold.width_mm
        return PatternSpec(size_mm=size_mm, bars=bars, bar_height_mm=height, bar_width_mm=width)

    def row(self) -> tuple[object, ...]:
        """What the way is, and the force that it should bear, N."""
        if self.hold is None:
            return self.finder, "-", "flush", f"{THICKNESS_MM:g}", "-"
        width = "wide" if self.hold.width_mm is None else f"{self.hold.width_mm:g}"
        bears = f"{self.hold.bears_n(TYPICAL_MODULE_MM):.2g}"
        return self.finder, self.hold.bars, f"{width} x {self.hold.height_mm:.2g}", self.thickness_mm, bears


def run() -> Table:
    """Views read of all filmed, in %, by the way the rings are held, by decoder and tilt."""
    ways = [_Way("panel"), _Way("diagonal")]
    ways += [_Way("recessed", hold) for hold in front(THICKNESS_MM, NOZZLE_MM)[:HOLDS]]
    return Table(
        "finder: views read, by how the rings are held",
        ("finder", "bars", "mm", "plate mm", "bears N", *CORE),
        tuple((*way.row(), *_shares(way)) for way in ways),
        (
            "version and module: "
            + ", ".join(f"{version} of {module_mm:g} mm" for version, module_mm in CODES)
            + f"; lip {LIP_MM:g} mm, draft {DRAFT_DEG:g}°; {PATIENCE} frames a view; tilts "
            + ", ".join(f"{tilt:g}°" for tilt in TILTS_DEG),
            f"bears: a fingertip on a ring, estimate for {TYPICAL_MODULE_MM:g} mm and {ALLOWABLE_MPA:g} MPa",
        ),
    )


def _shares(way: _Way) -> list[str]:
    """For each decoder of the core panel, the views read at each tilt, %."""
    read = {(decoder, tilt): 0 for decoder in CORE for tilt in TILTS_DEG}
    for version, module_mm in CODES:
        tell(f"finder: {way.row()}, version {version}, modules of {module_mm:g} mm")
        for tilt, names in _film(way, version, module_mm):
            for decoder in names:
                read[decoder, tilt] += 1
    views = len(CODES) * len(AZIMUTHS_DEG)
    return ["/".join(f"{100 * read[decoder, tilt] / views:.0f}" for tilt in TILTS_DEG) for decoder in CORE]


def _film(way: _Way, version: int, module_mm: float) -> list[tuple[float, frozenset[str]]]:
    """Tilt and decoders that read, view by view."""
    symbol = plain_code(version)
    pattern = build(symbol, way.spec(module_mm * (symbol.size + 8)))
    scene = plate_scene(pattern, way.thickness_mm, draft_deg=DRAFT_DEG, lip_mm=LIP_MM)
    size_px = max(LEAST_VIEW_PX, round(VIEW_MODULE_PX * (symbol.size + 8) / 0.7))
    views = [View(tilt, azimuth, size_px=size_px) for tilt in TILTS_DEG for azimuth in AZIMUTHS_DEG]
    right = accepted(payload_of(symbol).data)
    found = reads(scene, views, Look(), right, shared(CORE), frames=[PATIENCE] * len(views))
    return [(view.tilt_deg, names) for view, names in zip(views, found, strict=True)]
