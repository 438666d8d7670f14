"""DXF in millimetres for cutters: every loop one closed entity of lines and arcs, or a circle.

Béziers are drawn as arcs within `ARC_TOL_MM`: of the programs that were tried FreeCAD gives closed splines
another area and OpenSCAD leaves them out, each without a word (docs/files.md).
"""

from __future__ import annotations

import math
from collections.abc import Generator, Iterable
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from perfqr_cad.export.cutting import cut
from perfqr_cad.export.design_view import DesignView, face
from perfqr_cad.geometry import Arc, Circle, Loop
from perfqr_cad.geometry.biarc import with_arcs
from perfqr_cad.geometry.outline import Segment
from perfqr_cad.pattern import Bridge

if TYPE_CHECKING:
    from ezdxf.document import Drawing
    from ezdxf.layouts.layout import Modelspace

DxfVersion = Literal["r2000", "r12"]
RELEASES: dict[DxfVersion, str] = {"r2000": "AC1015", "r12": "AC1009"}  # $ACADVER

OUTLINE, HOLES, ENGRAVE, BRIDGES = "OUTLINE", "HOLES", "ENGRAVE", "BRIDGES"
# AutoCAD colour indices: white/black, red, blue, green.
COLOURS = {OUTLINE: 7, HOLES: 1, ENGRAVE: 5, BRIDGES: 3}
MILLIMETRES = 4  # $INSUNITS
METRIC = 1  # $MEASUREMENT
MARGIN = 1.1  # height of the first view over that of the part
ARC_TOL_MM = 0.002  # a fiftieth of a narrow laser's kerf
# Greatest rise of an arc over its chord: readers that drop bulges, as OpenSCAD does, are no farther off.
RISE_MM = 0.05


def write(
    design: DesignView,
    path: Path,
    *,
    version: DxfVersion = "r2000",
    bridges: bool = False,
    kerf_mm: float = 0.0,
) -> None:
    """Write what to engrave, the holes and, last, the outline, each on a layer of its own.

    `bridges` adds where material was laid, for the eye: lines on a layer that is frozen and not plotted.
    R12 has no unit; its numbers are millimetres all the same. Paths keep half of a kerf off the part.
    """
    work = cut(design, kerf_mm)
    with _without_clock():
        document = _document(version, work.outline)
        for name, loops in ((ENGRAVE, work.engrave), (HOLES, work.holes), (OUTLINE, (work.outline,))):
            if loops:
                document.layers.add(name, color=COLOURS[name])
            for loop in loops:
                _add_loop(document.modelspace(), version, loop, {"layer": name})
        if bridges:
            _add_bridges(document, version, face(design).bridges)
        document.saveas(path)


def _document(version: DxfVersion, outline: Loop) -> Drawing:
    """An empty drawing that opens with the outline in view."""
    from ezdxf.document import Drawing

    document = Drawing.new(RELEASES[version])  # ezdxf.new() logs a warning that R12 has no unit
    if version != "r12":
        document.units = MILLIMETRES
    document.header["$MEASUREMENT"] = METRIC
    corners = outline.flatten()
    (left, low), (right, high) = corners.min(axis=0).tolist(), corners.max(axis=0).tolist()
    document.modelspace().reset_extents((left, low, 0.0), (right, high, 0.0))
    document.set_modelspace_vport(MARGIN * (high - low), ((left + right) / 2, (low + high) / 2))
    return document


@contextmanager
def _without_clock() -> Generator[None]:
    """Make and save documents without the times and random identifiers that ezdxf puts into the header."""
    from ezdxf import options  # pyright: ignore[reportPrivateImportUsage]

    before = options.write_fixed_meta_data_for_testing
    options.write_fixed_meta_data_for_testing = True
    try:
        yield
    finally:
        options.write_fixed_meta_data_for_testing = before


def _add_loop(space: Modelspace, version: DxfVersion, loop: Loop, attributes: dict[str, Any]) -> None:
    """One closed entity."""
    first = loop.segments[0]
    if isinstance(first, Circle):
        space.add_circle(first.centre, first.radius, dxfattribs=attributes)
        return
    points = [point for segment in with_arcs(loop, ARC_TOL_MM).segments for point in _vertices(segment)]
    add = space.add_polyline2d if version == "r12" else space.add_lwpolyline
    add(points, format="xyb", close=True, dxfattribs=attributes)


def _vertices(segment: Segment) -> list[tuple[float, float, float]]:
    """x, y and bulge, the tangent of a quarter of the angle swept, along a line or an arc without its end."""
    if not isinstance(segment, Arc):
        return [(*segment.start, 0.0)]
    pieces = segment.flatten(RISE_MM)
    bulge = math.tan(segment.sweep_rad / len(pieces) / 4)
    return [(x, y, bulge) for x, y in pieces]


def _add_bridges(document: Drawing, version: DxfVersion, bridges: Iterable[Bridge]) -> None:
    """Centre lines as wide as the bars, which no reader can take for an outline, on a frozen layer."""
    layer = document.layers.add(BRIDGES, color=COLOURS[BRIDGES])
    layer.freeze()
    layer.dxf.plot = 0
    space = document.modelspace()
    add = space.add_polyline2d if version == "r12" else space.add_lwpolyline
    for bridge in bridges:
        ends = [(*end, bridge.width_mm, bridge.width_mm) for end in (bridge.start, bridge.end)]
        add(ends, format="xyse", dxfattribs={"layer": BRIDGES})
