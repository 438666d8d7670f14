"""Contours become regions by the non-zero rule, as fonts mean them.

A point is inside when the contours go round it a number of times that is not zero. Contours that keep apart
stay as they are, curves and all. Where they cross, Skia's path operations unite them with their curves, and
a union of their polygons, which is exact, is the witness: where the two differ, or loops would touch, the
polygons are taken.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np
import pathops
import shapely
from shapely import LinearRing, Polygon
from shapely.geometry.base import BaseGeometry

from perfqr_cad.geometry.arrays import Indices
from perfqr_cad.geometry.outline import Bezier, Line, Loop, Point, Points, Region, Segment

CHORD_MM = 0.01  # as the chords of a part's triangles, which must not cross either
GAP_MM = 2 * CHORD_MM  # loops at least so far apart cannot cross as chords; no nozzle parts nearer ones
WELD_MM = 1.5 * GAP_MM  # what lies so near to two loops that are nearer than the gap is filled
FINE_MM = 0.001  # chords of letters that become polygons
SPECK_MM2 = GAP_MM**2  # a smaller area is a slip of the font's or of the path operations
SHORT_MM = 1e-5  # path operations leave segments like this where curves all but meet
QUADRATIC = 1e-5  # share of its length by which a cubic may differ from a quadratic curve and count as one
WELDS = 3  # rounds in which loops that touch are joined; a second one is needed where a weld meets a loop


def united(contours: Sequence[Loop]) -> tuple[Region, ...]:
    """What closed contours of lines and Béziers, mm, enclose by the non-zero rule.

    Loops of the regions are simple and at least `GAP_MM` apart, or were polygons to begin with: gaps and webs
    narrower than that are filled.

    >>> square = Loop.from_points([(0, 0), (2, 0), (2, 2), (0, 2)])
    >>> shifted = Loop.from_points([(1, 1), (3, 1), (3, 3), (1, 3)])
    >>> [region.area for region in united([square, shifted])]
    [7.0]
    """
    contours = [contour for contour in contours if _is_seen(contour)]
    if _are_apart(contours):
        return _nested(contours)
    covered = _covered(contours)
    loops = _simplified(contours)
    if loops and _are_apart(loops):
        regions = _nested(loops)
        drawn = shapely.MultiPolygon([region.polygon(FINE_MM) for region in regions])
        if drawn.symmetric_difference(covered).area <= 2 * FINE_MM * covered.length:
            return regions
    return tuple(Region.from_polygon(polygon) for polygon in _welded(covered))


def near(regions: Sequence[Region]) -> Indices:
    """Pairs (k, 2) of regions that overlap, touch or lie less than `GAP_MM` apart."""
    polygons = np.array([region.polygon(CHORD_MM) for region in regions])
    pairs = shapely.STRtree(polygons).query(polygons, predicate="dwithin", distance=GAP_MM).T
    return pairs[pairs[:, 0] < pairs[:, 1]]


def loops_of(path: pathops.Path, scale: float = 1.0) -> tuple[Loop, ...]:
    """The contours of a Skia path, quadratic curves as cubic ones."""
    loops: list[Loop] = []
    segments: list[Segment] = []
    here = start = (0.0, 0.0)
    for verb, points in path:
        drawn = [(scale * x, scale * y) for x, y in points]
        match verb:
            case pathops.PathVerb.MOVE:
                here = start = drawn[0]
            case pathops.PathVerb.CLOSE:
                segments += _joined(here, [start])
                if segments:
                    loops.append(_closed(segments))
                segments, here = [], start
            case _:
                added = _joined(here, drawn)
                segments += added
                here = added[-1].end if added else here
    return tuple(loops)


def _joined(here: Point, points: Sequence[Point]) -> list[Segment]:
    """The segment to the last point: none where it has no length; a curve that comes back to its start is cut
    into chords, since a segment must lead somewhere."""
    if max(math.dist(here, point) for point in points) <= SHORT_MM:
        return []
    if len(points) == 1:
        return [Line(here, points[0])]
    if len(points) == 2:
        points = _raised(here, points[0]), _raised(points[1], points[0]), points[1]
    curve = Bezier(here, *points)
    if math.dist(here, points[-1]) > SHORT_MM:
        return [curve]
    return [Line(a, b) for a, b in pairwise([*curve.flatten(FINE_MM), points[-1]])]


def _raised(end: Point, control: Point) -> Point:
    """The control point of the cubic that is a quadratic curve, at one of its ends."""
    return end[0] + 2 / 3 * (control[0] - end[0]), end[1] + 2 / 3 * (control[1] - end[1])


def _closed(segments: Sequence[Segment]) -> Loop:
    """The loop of segments whose last end was moved onto the first start by rounding."""
    start = segments[0].start
    match segments[-1]:
        case Bezier() as last:
            return Loop((*segments[:-1], Bezier(last.start, last.c1, last.c2, start)))
        case last:
            return Loop((*segments[:-1], Line(last.start, start)))


def _path_of(loops: Sequence[Loop]) -> pathops.Path:
    """Loops of lines and Béziers as a Skia path."""
    path = pathops.Path()
    for loop in loops:
        path.moveTo(*loop.segments[0].start)
        for segment in loop.segments:
            if not isinstance(segment, Bezier):
                path.lineTo(*segment.end)
            elif control := _quadratic(segment):
                path.quadTo(*control, *segment.end)
            else:
                path.cubicTo(*segment.c1, *segment.c2, *segment.end)
        path.close()
    return path


def _quadratic(curve: Bezier) -> Point | None:
    """The control point of a cubic that is a quadratic curve; path operations are surer about those."""
    start, c1, c2, end = (np.asarray(point) for point in curve.controls)
    by_start, by_end = (3 * c1 - start) / 2, (3 * c2 - end) / 2
    if np.abs(by_start - by_end).max() > QUADRATIC * curve.length:
        return None
    x, y = ((by_start + by_end) / 2).tolist()
    return x, y


def _simplified(contours: Sequence[Loop]) -> tuple[Loop, ...]:
    """Loops without crossings of what contours enclose, curves kept; none where that fails."""
    path = _path_of(contours)
    try:
        path.simplify(fix_winding=True, keep_starting_points=False)
    except pathops.PathOpsError:
        return ()
    return tuple(loop for loop in loops_of(path) if _is_seen(loop))


def _is_seen(loop: Loop) -> bool:
    """Whether a loop is more than a speck, and than its chords lying on each other."""
    return abs(loop.area) > SPECK_MM2 and len(loop.flatten(CHORD_MM)) > 2


def _are_apart(loops: Sequence[Loop]) -> bool:
    """Whether loops cross neither themselves nor each other, as chords, and keep their distance."""
    rings = np.array([LinearRing(loop.flatten(CHORD_MM)) for loop in loops])
    if not np.all(shapely.is_simple(rings)):
        return False
    one, other = shapely.STRtree(rings).query(rings, predicate="dwithin", distance=GAP_MM)
    return not np.any(one != other)


def _nested(loops: Sequence[Loop]) -> tuple[Region, ...]:
    """Regions from loops that lie apart: those with ink on one side only, each hole with its own outline."""
    polygons = [Polygon(loop.flatten(CHORD_MM)) for loop in loops]
    corners = np.array([shapely.Point(loop.segments[0].start) for loop in loops])
    within, around = shapely.STRtree(polygons).query(corners, predicate="intersects")
    turns = np.array([1 if loop.area > 0 else -1 for loop in loops])
    outside = np.zeros(len(loops), np.int64)
    np.add.at(outside, within[within != around], turns[around[within != around]])
    inside = outside + turns
    outlines = np.flatnonzero((inside != 0) & (outside == 0))
    sizes = [polygon.area for polygon in polygons]
    holes: dict[int, list[Loop]] = {i: [] for i in outlines.tolist()}
    for k in np.flatnonzero((inside == 0) & (outside != 0)).tolist():
        own = min(set(around[within == k].tolist()) & holes.keys(), key=sizes.__getitem__)
        holes[own].append(loops[k].oriented(ccw=False))
    return tuple(Region(loops[i].oriented(ccw=True), tuple(found)) for i, found in holes.items())


def _covered(contours: Sequence[Loop]) -> BaseGeometry:
    """The same as polygons, whatever crosses: the faces between the chords that are gone round."""
    rings = [contour.flatten(FINE_MM) for contour in contours]
    chords = shapely.union_all(np.array([LinearRing(ring) for ring in rings]))
    faces = shapely.get_parts(shapely.polygonize(shapely.get_parts(chords)))
    points = shapely.get_coordinates(shapely.point_on_surface(faces))
    turns = np.sum([_turns(ring, points) for ring in rings], axis=0)
    return shapely.union_all(faces[turns != 0])


def _turns(ring: Points, points: Points) -> Indices:
    """How many times (k,) a polygon goes counter-clockwise round each point: upward crossings of the ray to
    the right, less downward ones."""
    ends = np.roll(ring, -1, axis=0)
    turns = np.zeros(len(points), np.int64)
    for i, (x, y) in enumerate(points):
        left = (ends[:, 0] - ring[:, 0]) * (y - ring[:, 1]) - (x - ring[:, 0]) * (ends[:, 1] - ring[:, 1])
        up, down = (ring[:, 1] <= y) & (ends[:, 1] > y), (ring[:, 1] > y) & (ends[:, 1] <= y)
        turns[i] = np.count_nonzero(up & (left > 0)) - np.count_nonzero(down & (left < 0))
    return turns


def _welded(covered: BaseGeometry) -> list[Polygon]:
    """Polygons without specks whose rings keep their distance: what lies near two of them is filled."""
    polygons = _seen_parts(covered)
    for _ in range(WELDS):
        polygons = _seen_parts(shapely.union_all(np.array([*polygons, *_welds(polygons)])))
    return _polygons(shapely.MultiPolygon(polygons).simplify(SHORT_MM))


def _seen_parts(covered: BaseGeometry) -> list[Polygon]:
    """The parts of polygons, and of their holes those, that are more than specks."""
    return [
        Polygon(part.exterior, [ring for ring in part.interiors if Polygon(ring).area > SPECK_MM2])
        for part in _polygons(covered)
        if part.area > SPECK_MM2
    ]


def _polygons(covered: BaseGeometry) -> list[Polygon]:
    return [part for part in shapely.get_parts(covered).tolist() if isinstance(part, Polygon)]


def _welds(polygons: Sequence[Polygon]) -> Iterator[BaseGeometry]:
    """What lies near two rings at once."""
    rings = [ring for polygon in polygons for ring in (polygon.exterior, *polygon.interiors)]
    pairs = shapely.STRtree(rings).query(np.array(rings), predicate="dwithin", distance=GAP_MM).T
    for i, k in pairs[pairs[:, 0] < pairs[:, 1]].tolist():
        one, other = (ring.buffer(WELD_MM, quad_segs=4) for ring in (rings[i], rings[k]))
        yield one.intersection(other)
