"""DXF R2000 of the outline in millimetres: lines and arcs as polylines with bulges, circles, splines."""

from __future__ import annotations

import math
from collections.abc import Generator, Iterator, Sequence
from contextlib import contextmanager
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING, Any

from perfqr_cad.export.design_view import DesignView
from perfqr_cad.geometry import Arc, Bezier, Circle, Line, Loop
from perfqr_cad.geometry.outline import Segment
from perfqr_cad.pattern import Bridge

if TYPE_CHECKING:
    from ezdxf.document import Drawing
    from ezdxf.layouts.layout import Modelspace

OUTLINE, HOLES, BRIDGES = "OUTLINE", "HOLES", "BRIDGES"
# AutoCAD colour indices: white/black, red, green. The bridges are for the eye: their layer does not plot.
LAYERS = {OUTLINE: 7, HOLES: 1, BRIDGES: 3}
MILLIMETRES = 4  # $INSUNITS
METRIC = 1  # $MEASUREMENT


def write(design: DesignView, path: Path) -> None:
    """Write the reading face: what to cut on `OUTLINE` and `HOLES`, where material was added on `BRIDGES`."""
    with _without_clock():
        document = _document()
        space = document.modelspace()
        region = design.pattern.region
        for loop, layer in [(region.outer, OUTLINE), *((hole, HOLES) for hole in region.holes)]:
            _add_loop(space, loop, {"layer": layer})
        for bridge in design.pattern.bridges:
            space.add_lwpolyline(_corners(bridge), format="xy", close=True, dxfattribs={"layer": BRIDGES})
        document.saveas(path)


def _document() -> Drawing:
    from ezdxf.filemanagement import new

    document = new("R2000", units=MILLIMETRES)
    document.header["$MEASUREMENT"] = METRIC
    for name, colour in LAYERS.items():
        document.layers.add(name, color=colour)
    document.layers.get(BRIDGES).dxf.plot = 0
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


def _add_loop(space: Modelspace, loop: Loop, attributes: dict[str, Any]) -> None:
    first = loop.segments[0]
    if isinstance(first, Circle):
        space.add_circle(first.centre, first.radius, dxfattribs=attributes)
        return
    runs = list(_runs(loop.segments))
    for curved, run in runs:
        closed = len(runs) == 1
        if curved:
            _add_spline(space, run, closed, attributes)
        else:
            _add_polyline(space, run, closed, attributes)


def _runs(segments: Sequence[Segment]) -> Iterator[tuple[bool, list[Any]]]:
    """Maximal chains of Béziers (True) and of lines and arcs (False)."""
    for curved, run in groupby(segments, key=lambda s: isinstance(s, Bezier)):
        yield curved, list(run)


def _add_polyline(space: Modelspace, run: list[Line | Arc], closed: bool, attributes: dict[str, Any]) -> None:
    points = [(*segment.start, _bulge(segment)) for segment in run]
    if not closed:
        points.append((*run[-1].end, 0.0))
    space.add_lwpolyline(points, format="xyb", close=closed, dxfattribs=attributes)


def _bulge(segment: Line | Arc) -> float:
    """Tangent of a quarter of the angle swept; 0 for a line."""
    return math.tan(segment.sweep_rad / 4) if isinstance(segment, Arc) else 0.0


def _add_spline(space: Modelspace, run: list[Bezier], closed: bool, attributes: dict[str, Any]) -> None:
    """One cubic B-spline through the chain: a knot of multiplicity 3 between two Béziers keeps both exact."""
    controls = [run[0].start, *(p for b in run for p in (b.c1, b.c2, b.end))]
    inner = [float(k) for k in range(1, len(run)) for _ in range(3)]
    spline = space.add_spline(degree=3, dxfattribs=attributes)
    spline.control_points = [(x, y, 0.0) for x, y in controls]
    spline.knots = [0.0] * 4 + inner + [float(len(run))] * 4
    spline.dxf.flags = 8 + (1 if closed else 0)  # planar, closed


def _corners(bridge: Bridge) -> list[tuple[float, float]]:
    (x1, y1), (x2, y2) = bridge.start, bridge.end
    length = math.dist(bridge.start, bridge.end)
    nx, ny = (y1 - y2) / length * bridge.width_mm / 2, (x2 - x1) / length * bridge.width_mm / 2
    return [(x1 + nx, y1 + ny), (x2 + nx, y2 + ny), (x2 - nx, y2 - ny), (x1 - nx, y1 - ny)]
