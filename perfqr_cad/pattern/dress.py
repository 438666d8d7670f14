"""Corners and edges of the finished outline: exact fillets, smooth contours of free-form art."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from perfqr_cad.pattern.bridge import Bridge
from perfqr_cad.pattern.front import edge_under
from perfqr_cad.pattern.lattice import after, before
from perfqr_cad.pattern.outline import LEAST_MM, Arc, Bezier, Line, Loop, Point, Points, Region, Segment

LEAST_EDGE_MM = 0.1  # a quarter of a nozzle: what no slicer resolves and every mesher stumbles over
STRAIGHT_TURN_RAD = 1e-6  # a turn below this is rounding
SMOOTH_TURN_RAD = math.radians(60)  # a sharper turn is a corner that the art meant
Flags: TypeAlias = NDArray[np.bool_]
SIMPLIFY_PART = 0.7  # of the tolerance goes into straightening stairs, the rest into rounding


def filleted(region: Region, radius_mm: float) -> Region:
    """Every re-entrant corner of the material between two lines rounded by an arc of at most the radius.

    Fillets only add material, so what was one piece stays one. An edge too short for its two fillets gets
    smaller ones.
    """
    if radius_mm <= 0:
        return region
    return Region(_filleted(region.outer, radius_mm), tuple(_filleted(h, radius_mm) for h in region.holes))


def _filleted(loop: Loop, radius_mm: float) -> Loop:
    if not all(isinstance(segment, Line) for segment in loop.segments):
        return loop
    corners = np.array([segment.start for segment in loop.segments])
    edges = after(corners) - corners
    lengths = np.hypot(edges[:, 0], edges[:, 1])
    arriving = before(edges)
    turn = np.arctan2(
        arriving[:, 0] * edges[:, 1] - arriving[:, 1] * edges[:, 0], (arriving * edges).sum(axis=1)
    )
    # The material lies on the left: a turn to the right is re-entrant.
    rounded = turn < -STRAIGHT_TURN_RAD
    tangent = np.tan(np.abs(turn) / 2)
    behind = np.where(after(rounded), lengths / 2, lengths)  # half where the next corner takes the rest
    ahead = np.where(before(rounded), before(lengths) / 2, before(lengths))
    room = np.minimum(behind, ahead)
    cut = np.where(rounded, np.minimum(radius_mm * tangent, room), 0.0)
    cut = _without_remnants(cut, lengths)
    cut[cut < LEAST_EDGE_MM / 2] = 0.0
    return Loop(tuple(_segments(corners, edges / lengths[:, None], cut, tangent)))


def _without_remnants(cut: np.ndarray, lengths: np.ndarray) -> np.ndarray:
    """Cuts reduced where they would leave a straight remnant too short to be meshed or offset."""
    for _ in range(2):  # the two ends of an edge may both give way
        taken = cut + after(cut)
        rest = lengths - taken
        short = (rest > LEAST_MM) & (rest < LEAST_EDGE_MM) & (taken > 0)
        factor = np.where(short, np.maximum(lengths - LEAST_EDGE_MM, 0) / np.maximum(taken, LEAST_MM), 1.0)
        cut = cut * np.minimum(factor, before(factor))
    return cut


def _segments(corners: Points, along: Points, cut: np.ndarray, tangent: np.ndarray) -> list[Segment]:
    segments: list[Segment] = []
    count = len(corners)
    starts = corners + along * cut[:, None]
    ends = corners - before(along) * cut[:, None]
    for k in range(count):
        start, end = _point(starts[k]), _point(ends[(k + 1) % count])
        if cut[k] > 0:
            radius = cut[k] / tangent[k]
            into = along[k - 1]
            normal = np.array([into[1], -into[0]])  # to the right, where the void lies
            segments.append(Arc(_point(ends[k]), start, _point(ends[k] + normal * radius), ccw=False))
        if math.dist(start, end) > LEAST_MM:
            segments.append(Line(start, end))
    return _closed(segments)


def smoothed(region: Region, tolerance_mm: float, bars: Sequence[Bridge] = ()) -> Region:
    """Stairs of pixels drawn as smooth edges that stay within the tolerance of them.

    Stairs are straightened first (Douglas and Peucker), then gentle corners become Bézier arcs that leave and
    meet the edges along their direction. Corners sharper than 60° and the edges on which bars end stay.
    """
    tips = [tip for bar in bars for tip in (bar.start, bar.end)]

    def smooth(loop: Loop) -> Loop:
        corners, kept = _straightened(loop.flatten(), tips, SIMPLIFY_PART * tolerance_mm)
        return _bent(corners, kept, tolerance_mm)

    return Region(smooth(region.outer), tuple(smooth(hole) for hole in region.holes))


def _straightened(corners: Points, tips: Sequence[Point], tolerance_mm: float) -> tuple[Points, Flags]:
    """Corners of a loop with its stairs straightened, and which of them end an edge that a tip lies on."""
    import shapely

    low, high = corners.min(axis=0) - LEAST_MM, corners.max(axis=0) + LEAST_MM
    near = [tip for tip in tips if (low <= tip).all() and (tip <= high).all()]
    under = sorted({k for tip in near if (k := edge_under(tip, corners, after(corners))) is not None})
    if not under:
        ring = shapely.simplify(shapely.Polygon(corners), tolerance_mm)
        found = shapely.get_coordinates(ring)[:-1]
        return found, np.zeros(len(found), np.bool_)
    turned = np.roll(corners, -(under[0] + 1), axis=0)
    ends = [k - under[0] for k in (*under[1:], under[0] + len(corners))]  # of the chains between those edges
    chains: list[Points] = []
    first = 0
    for end in ends:
        chain = turned[first:end]
        if len(chain) > 1:
            chain = shapely.get_coordinates(shapely.simplify(shapely.LineString(chain), tolerance_mm))
        chains.append(chain)
        first = end
    kept = [np.isin(np.arange(len(chain)), (0, len(chain) - 1)) for chain in chains]
    return np.concatenate(chains), np.concatenate(kept)


def _bent(corners: Points, kept: Flags, tolerance_mm: float) -> Loop:
    edges = after(corners) - corners
    lengths = np.hypot(edges[:, 0], edges[:, 1])
    along = edges / lengths[:, None]
    arriving = before(along)
    turn = np.abs(
        np.arctan2(arriving[:, 0] * along[:, 1] - arriving[:, 1] * along[:, 0], (arriving * along).sum(1))
    )
    # A quadratic arc over cuts c passes its corner at c·sin(φ/2)/2.
    bow = np.maximum(np.sin(turn / 2), 1e-9)
    room = np.minimum(lengths, before(lengths)) / 2
    cut = np.minimum(2 * (1 - SIMPLIFY_PART) * tolerance_mm / bow, room)
    cut[kept | (turn > SMOOTH_TURN_RAD) | (turn < STRAIGHT_TURN_RAD)] = 0.0
    cut = _without_remnants(cut, lengths)
    cut[cut < LEAST_EDGE_MM / 10] = 0.0
    segments: list[Segment] = []
    for k in range(len(corners)):
        corner = corners[k]
        start, end = corner - arriving[k] * cut[k], corner + along[k] * cut[k]
        if cut[k] > 0:
            c1, c2 = start + (corner - start) * 2 / 3, end + (corner - end) * 2 / 3
            segments.append(Bezier(_point(start), _point(c1), _point(c2), _point(end)))
        following = (k + 1) % len(corners)
        to = corners[following] - along[k] * cut[following]
        if math.dist(end, to) > LEAST_MM:
            segments.append(Line(_point(end), _point(to)))
    return Loop(tuple(_closed(segments)))


def _closed(segments: list[Segment]) -> list[Segment]:
    """Each segment made to start exactly where the one before ends."""
    closed: list[Segment] = []
    for k, segment in enumerate(segments):
        end = segments[(k + 1) % len(segments)].start
        match segment:
            case Line(start, _):
                closed.append(Line(start, end))
            case Arc(start, _, centre, ccw):
                closed.append(Arc(start, end, centre, ccw))
            case Bezier(start, c1, c2, _):
                closed.append(Bezier(start, c1, c2, end))
            case _:
                closed.append(segment)
    return closed


def _point(p: np.ndarray) -> Point:
    return float(p[0]), float(p[1])
