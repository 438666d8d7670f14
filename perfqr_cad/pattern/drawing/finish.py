"""From a canvas to the finished pattern: its outline, the proof of its webs, what a reader makes of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from perfqr_cad.errors import DesignError
from perfqr_cad.geometry.outline import Region
from perfqr_cad.pattern.bridge import Bridge
from perfqr_cad.pattern.cells.brightness import solid_part
from perfqr_cad.pattern.cells.canvas import Canvas, strip
from perfqr_cad.pattern.cells.lattice import Cells, Labels, Lattice
from perfqr_cad.pattern.cells.tracing import Boundaries, sharpened, trace
from perfqr_cad.pattern.drawing.front import joined, regions
from perfqr_cad.pattern.drawing.rounding import filleted, smoothed
from perfqr_cad.pattern.drawing.style import ROUNDED_RADIUS
from perfqr_cad.pattern.joining.rings import as_webs, flush_where_joined, front_cells
from perfqr_cad.pattern.pattern import Optimality, Pattern
from perfqr_cad.pattern.spec import PatternSpec
from perfqr_cad.pattern.surround import surrounded
from perfqr_cad.symbol import Matrix, Symbol, readability

if TYPE_CHECKING:
    from shapely.geometry import Polygon

LEAST_SMOOTHING_MM = 0.01  # below this a contour may as well be exact
MOST_MENDS = 4  # rounds; a mend can only join
WEB_TOL = 0.01  # of the least web: rounding of coordinates and of the arcs of the eroding disc


@dataclass(frozen=True)
class Job:
    """What stays the same while bridges are added."""

    symbol: Symbol
    spec: PatternSpec
    islands_before: int
    size_reason: str
    optimality: Optimality | None = None
    losses: tuple[float, ...] = ()


def finish(canvas: Canvas, job: Job | Pattern, sound: bool = False) -> Pattern:
    """The pattern of a canvas. DesignError when it is not one piece with the least web throughout.

    sound  the web has been checked already
    """
    canvas = flush_where_joined(canvas, job.spec)
    if not sound and len(pieces := web_pieces(_borne(canvas, job.spec), job.spec.web_mm)) != 1:
        raise DesignError(
            f"webs under {job.spec.web_mm:g} mm hold the pattern: without them {len(pieces)} pieces are left,"
            " 1 is needed; use a larger --size or a finer nozzle"
        )
    front = styled(front_regions(canvas), canvas, job.spec)
    size_mm = canvas.lattice.cells * canvas.lattice.cell_mm
    return _pattern(canvas, surrounded(front, size_mm, job.spec.surround, job.spec.web_mm), job)


def styled(front: Sequence[Region], canvas: Canvas, spec: PatternSpec) -> tuple[Region, ...]:
    """The outline with smooth contours, rounded corners and the holes of its style."""
    front = _smooth(front, canvas, spec)
    radius_mm = spec.fillet_radius_mm
    if spec.style == "rounded":
        radius_mm = max(radius_mm, ROUNDED_RADIUS * canvas.lattice.module_mm)
    return tuple(filleted(region, radius_mm) for region in front)


def _smooth(front: Sequence[Region], canvas: Canvas, spec: PatternSpec) -> Sequence[Region]:
    """Smooth within the tolerance, or within less where that would cost a web."""
    tolerance_mm = canvas.smooth_mm
    bars = as_webs(canvas, spec)
    while tolerance_mm > LEAST_SMOOTHING_MM:
        smooth = [smoothed(region, tolerance_mm, canvas.recessed) for region in front]
        polygon = joined(smooth, bars).polygon()
        if polygon.is_valid and len(web_pieces(polygon, spec.web_mm)) == 1:
            return smooth
        tolerance_mm /= 2
    return front


def mended(canvas: Canvas, spec: PatternSpec) -> tuple[Canvas, bool]:
    """The canvas with a bridge wherever less than the least web holds a piece; and whether all hold now."""
    import shapely
    from shapely.ops import nearest_points

    for _ in range(MOST_MENDS):
        parts = shapely.get_parts(_borne(canvas, spec))
        pieces = [piece for part in parts for piece in web_pieces(part, spec.web_mm) or [part]]
        pieces.sort(key=lambda piece: piece.area)
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

    parts = shapely.get_parts(_borne(canvas, spec))
    pieces = [piece for part in parts for piece in web_pieces(part, spec.web_mm) or [part]]
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


def _pattern(canvas: Canvas, front: tuple[Region, ...], job: Job | Pattern) -> Pattern:
    lattice, spec = canvas.lattice, job.spec
    observed = Matrix((solid_part(lattice) >= 0.5) == (spec.tone == "inverted"))
    changed = int(np.count_nonzero(lattice.solid ^ canvas.asked)) * lattice.cell_mm**2
    return Pattern(
        symbol=job.symbol,
        spec=spec,
        module_mm=lattice.module_mm,
        quiet_modules=lattice.quiet,
        region=joined(front, canvas.recessed),
        front=front,
        bridges=canvas.bridges,
        islands_before=job.islands_before,
        observed=observed,
        readability=readability(observed, job.symbol),
        changed_area_mm2=changed,
        edits=canvas.edits,
        optimality=job.optimality,
        losses=job.losses,
        size_reason=job.size_reason,
        canvas=canvas,
    )


def front_regions(canvas: Canvas) -> tuple[Region, ...]:
    """The material at the front face in mm, without recessed bars, the slanted bridges exact."""
    import shapely

    cells = front_cells(canvas)
    if canvas.slanted:
        found = [Region.from_polygon(piece) for piece in shapely.get_parts(ground(canvas, cells))]
        return tuple(sorted(found, key=lambda region: -region.area))
    rings = drawn_rings(cells, canvas.lattice)
    loops = rings.loops()
    outers = [loop for loop, area in zip(loops, rings.areas, strict=True) if area > 0]
    holes = [loop for loop, area in zip(loops, rings.areas, strict=True) if area < 0]
    return regions(outers, [*holes, *canvas.shapes])


def _borne(canvas: Canvas, spec: PatternSpec) -> Any:
    """The material by which the least web is judged: recessed bars count as wide as that, see `as_webs`."""
    cells = canvas.upright.copy()
    for bar in as_webs(canvas, spec):
        canvas.rect(bar).of(cells)[:] = True
    return ground(canvas, cells)


def ground(canvas: Canvas, cells: Cells | None = None) -> Any:
    """The material as a shapely polygon or several; `cells` stand in for the canvas's upright ones."""
    import shapely
    from shapely.geometry import MultiLineString, Polygon

    upright = canvas.upright if cells is None else cells
    rings = drawn_rings(upright, canvas.lattice)
    shape: Any = rings.polygon()
    if shape is None:
        try:
            shape = shapely.build_area(MultiLineString(list(rings.lines)))
        except shapely.errors.GEOSException:  # sharpened corners of two pieces cross: keep their stairs
            rings = _in_mm(trace(upright), canvas.lattice)
            shape = shapely.build_area(MultiLineString(list(rings.lines)))
    if canvas.shapes:
        shape = shapely.difference(shape, shapely.union_all([Polygon(s.flatten()) for s in canvas.shapes]))
    if canvas.slanted:
        shape = shapely.union_all([shape, *(Polygon(strip(bridge)) for bridge in canvas.slanted)])
    return shape


def drawn_rings(cells: Cells, lattice: Lattice) -> Boundaries:
    """Boundary rings in mm, their stairs sharpened, but for those few that would cut themselves by it."""
    import shapely

    plain = trace(cells)
    sharp = sharpened(plain)
    drawn = _in_mm(sharp.where(shapely.is_valid(sharp.polygons()), plain), lattice)
    polygon = drawn.polygon()
    return drawn if polygon is None or polygon.is_valid else _in_mm(plain, lattice)


def _in_mm(rings: Boundaries, lattice: Lattice) -> Boundaries:
    return Boundaries(lattice.all_to_mm(rings.points), rings.bounds)
