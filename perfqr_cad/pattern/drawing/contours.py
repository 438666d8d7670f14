"""From the cells of a canvas to its outline in mm, and the proof that the least web holds throughout."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from perfqr_cad.errors import DesignError
from perfqr_cad.geometry.outline import Region
from perfqr_cad.pattern.bridge import Bridge
from perfqr_cad.pattern.cells.canvas import Canvas
from perfqr_cad.pattern.cells.lattice import Cells, Labels, Lattice
from perfqr_cad.pattern.cells.tracing import Boundaries, sharpened, trace
from perfqr_cad.pattern.drawing.front import front_with_bars, regions
from perfqr_cad.pattern.drawing.rounding import filleted, smoothed
from perfqr_cad.pattern.drawing.style import ROUNDED_RADIUS
from perfqr_cad.pattern.joining.rings import as_webs, front_cells
from perfqr_cad.pattern.spec import PatternSpec

if TYPE_CHECKING:
    from shapely.geometry import Polygon

LEAST_SMOOTHING_MM = 0.01  # below this a contour may as well be exact
MOST_MENDS = 4  # rounds; a mend can only join
WEB_TOL = 0.01  # of the least web: rounding of coordinates and of the arcs of the eroding disc


def styled_front(canvas: Canvas, spec: PatternSpec) -> tuple[Region, ...]:
    """The front face with smooth contours, rounded corners and the holes of its style; the greatest first."""
    radius_mm = spec.fillet_radius_mm
    if spec.style == "rounded":
        radius_mm = max(radius_mm, ROUNDED_RADIUS * canvas.lattice.module_mm)
    return tuple(filleted(region, radius_mm) for region in _smooth(_front(canvas), canvas, spec))


def check_webs(canvas: Canvas, spec: PatternSpec) -> None:
    """DesignError when the canvas is not one piece with the least web throughout."""
    if (pieces := len(web_pieces(_web_material(canvas, spec), spec.web_mm))) != 1:
        raise DesignError(
            f"webs under {spec.web_mm:g} mm hold the pattern: without them {pieces} pieces are left,"
            " 1 is needed",
            "a larger code",
            "a finer nozzle",
        )


def mended(canvas: Canvas, spec: PatternSpec) -> tuple[Canvas, bool]:
    """The canvas with a bridge wherever less than the least web holds a piece; and whether all hold now."""
    from shapely.ops import nearest_points

    for _ in range(MOST_MENDS):
        pieces = sorted(_held_pieces(canvas, spec), key=lambda piece: piece.area)
        for k, piece in enumerate(pieces[:-1]):
            other = min(pieces[k + 1 :], key=piece.distance)
            start, end = ((p.x, p.y) for p in nearest_points(piece, other))
            canvas = canvas.with_slanted(Bridge(start, end, spec.web_mm, "connectivity", 0.0))
        if len(pieces) <= 1:
            return canvas, True
    return canvas, False


def numbered_pieces(canvas: Canvas, spec: PatternSpec) -> Labels | None:
    """(cells, cells) piece of each cell when webs thinner than the least are cut; None when it is one."""
    import cv2
    import shapely

    pieces = _held_pieces(canvas, spec)
    if len(pieces) <= 1:
        return None
    lattice = canvas.lattice
    labels = np.zeros(canvas.solid.shape, np.int32)
    for number, piece in enumerate(pieces, start=1):
        rings = [shapely.get_coordinates(ring) for ring in (piece.exterior, *piece.interiors)]
        corners = [np.rint(lattice.all_from_mm(ring) - 0.5).astype(np.int32) for ring in rings]
        cv2.fillPoly(labels, corners, (number,))
        middle = piece.representative_point()
        x, y = lattice.from_mm((middle.x, middle.y))
        labels[int(y), int(x)] = number
    labels[~canvas.solid] = 0
    return labels


def web_pieces(polygon: Polygon, web_mm: float) -> list[Polygon]:
    """What is left of a polygon after erosion by half the least web."""
    import shapely

    eroded = polygon.buffer(-web_mm / 2 * (1 - WEB_TOL), quad_segs=4)
    return [piece for piece in shapely.get_parts(eroded) if not piece.is_empty]


def _held_pieces(canvas: Canvas, spec: PatternSpec) -> list[Any]:
    """The material cut at webs thinner than the least; a part that nowhere reaches it counts as one piece."""
    import shapely

    parts = shapely.get_parts(_web_material(canvas, spec))
    return [piece for part in parts for piece in web_pieces(part, spec.web_mm) or [part]]


def _smooth(front: Sequence[Region], canvas: Canvas, spec: PatternSpec) -> Sequence[Region]:
    """Smooth within the tolerance, or within less where that would cost a web."""
    tolerance_mm = canvas.smooth_mm
    bars = as_webs(canvas, spec)
    while tolerance_mm > LEAST_SMOOTHING_MM:
        smooth = [smoothed(region, tolerance_mm, canvas.recessed) for region in front]
        polygon = front_with_bars(smooth, bars).polygon()
        if polygon.is_valid and len(web_pieces(polygon, spec.web_mm)) == 1:
            return smooth
        tolerance_mm /= 2
    return front


def _front(canvas: Canvas) -> tuple[Region, ...]:
    """The material at the front face in mm, without recessed bars, the slanted bridges exact."""
    import shapely

    cells = front_cells(canvas)
    if canvas.slanted:
        found = [Region.from_polygon(piece) for piece in shapely.get_parts(_material(canvas, cells))]
        return tuple(sorted(found, key=lambda region: -region.area))
    boundaries = _traced(cells, canvas.lattice)
    loops = boundaries.loops()
    outers = [loop for loop, area in zip(loops, boundaries.areas, strict=True) if area > 0]
    holes = [loop for loop, area in zip(loops, boundaries.areas, strict=True) if area < 0]
    return regions(outers, [*holes, *canvas.shapes])


def _web_material(canvas: Canvas, spec: PatternSpec) -> Any:
    """The material by which the least web is judged: recessed bars count as wide as that, see `as_webs`."""
    cells = canvas.upright.copy()
    for bar in as_webs(canvas, spec):
        canvas.rect(bar).of(cells)[:] = True
    return _material(canvas, cells)


def _material(canvas: Canvas, cells: Cells) -> Any:
    """A shapely polygon, or several, of cells that stand for the canvas's upright ones."""
    import shapely
    from shapely.geometry import MultiLineString, Polygon

    boundaries = _traced(cells, canvas.lattice)
    shape: Any = boundaries.polygon()
    if shape is None:
        try:
            shape = shapely.build_area(MultiLineString(list(boundaries.lines)))
        except shapely.errors.GEOSException:  # sharpened corners of two pieces cross: keep their stairs
            boundaries = _in_mm(trace(cells), canvas.lattice)
            shape = shapely.build_area(MultiLineString(list(boundaries.lines)))
    if canvas.shapes:
        shape = shapely.difference(shape, shapely.union_all([Polygon(s.flatten()) for s in canvas.shapes]))
    if canvas.slanted:
        strips = (Polygon(bridge.overlapping().corners()) for bridge in canvas.slanted)
        shape = shapely.union_all([shape, *strips])
    return shape


def _traced(cells: Cells, lattice: Lattice) -> Boundaries:
    """Boundaries in mm, their stairs sharpened, but for those few that would cut themselves by it."""
    import shapely

    plain = trace(cells)
    sharp = sharpened(plain)
    found = _in_mm(sharp.where(shapely.is_valid(sharp.polygons()), plain), lattice)
    polygon = found.polygon()
    return found if polygon is None or polygon.is_valid else _in_mm(plain, lattice)


def _in_mm(boundaries: Boundaries, lattice: Lattice) -> Boundaries:
    return Boundaries(lattice.all_to_mm(boundaries.points), boundaries.bounds)
