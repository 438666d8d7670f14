"""Cubic Béziers as chains of circular arcs, for files that hold lines and arcs alone.

A biarc joins two points with given directions by two arcs that share a tangent (Bolton, "Biarc curves",
Computer-Aided Design 7(2), 1975). Of the many the one whose outer tangents are equally long is taken; where
it does not follow the curve closely enough the curve is halved.
"""

from __future__ import annotations

import math

import numpy as np

from perfqr_cad.geometry.outline import LEAST_MM, Arc, Bezier, Line, Loop, Point, Points, Segment

MOST_TURN_RAD = 1.1 * math.pi / 2  # what turns more may leave the curve where that has no points
LEAST_PROBES = 16  # points of a curve that are compared with its arcs
PROBE_SHARE = 1 / 8  # of the tolerance: between points the curve is no farther from its chords
LEAST_TURN_RAD = 1e-6  # what turns less is straight: over 100 mm an arc of it bows by 13 nm


def with_arcs(loop: Loop, tol_mm: float) -> Loop:
    """The loop with every Bézier as arcs and lines within `tol_mm` of it, its tangents kept."""
    segments: list[Segment] = []
    for segment in loop.segments:
        segments += arcs_of(segment, tol_mm) if isinstance(segment, Bezier) else [segment]
    return Loop(tuple(segments))


def arcs_of(curve: Bezier, tol_mm: float) -> list[Line | Arc]:
    """Arcs and lines from the start of a curve to its end, within `tol_mm` of it.

    >>> quarter = Bezier((1, 0), (1, 0.5523), (0.5523, 1), (0, 1))
    >>> [round(arc.radius, 3) for arc in arcs_of(quarter, 0.001)]
    [1.0, 1.0]
    """
    controls = np.asarray(curve.controls)
    if np.ptp(controls, axis=0).max() < LEAST_MM:
        return [Line(curve.start, curve.end)]
    pieces = _biarc(controls)
    probes = _points(controls, max(LEAST_PROBES, len(curve.flatten(PROBE_SHARE * tol_mm))))
    if np.min([_distance_mm(probes, piece) for piece in pieces], axis=0).max() <= tol_mm:
        return pieces
    return [piece for half in _halves(controls) for piece in arcs_of(half, tol_mm)]


def _points(controls: Points, count: int) -> Points:
    """(count, 2) points of the curve at equal steps of its parameter, without its ends."""
    t = np.linspace(0.0, 1.0, count + 2)[1:-1, None]
    s = 1 - t
    return np.hstack([s**3, 3 * s * s * t, 3 * s * t * t, t**3]) @ controls


def _halves(controls: Points) -> tuple[Bezier, Bezier]:
    """The curve of (4, 2) control points in two at its middle parameter (de Casteljau)."""
    a, b, c, d = controls
    ab, bc, cd = (a + b) / 2, (b + c) / 2, (c + d) / 2
    abc, bcd = (ab + bc) / 2, (bc + cd) / 2
    middle = (abc + bcd) / 2
    first, second = ([_point(p) for p in half] for half in ((a, ab, abc, middle), (middle, bcd, cd, d)))
    return Bezier(*first), Bezier(*second)


def _biarc(controls: Points) -> list[Line | Arc]:
    """Two arcs with the ends and the end tangents of a curve of (4, 2) control points."""
    start, end = controls[0], controls[-1]
    leaving, arriving = _direction(controls), -_direction(controls[::-1])
    chord = end - start
    # Tangent lengths d with |chord − d (leaving + arriving)| = 2 d: the positive root of a quadratic.
    along = chord @ (leaving + arriving)
    reach = along + math.sqrt(along**2 + 2 * (1 - leaving @ arriving) * (chord @ chord))
    if reach < LEAST_MM**2:  # the curve turns back on itself: no biarc, and halves will have one
        return [Line(_point(start), _point(end))]
    d = chord @ chord / reach
    joint = (start + end + d * (leaving - arriving)) / 2
    first, second = _arc(start, joint, leaving), _arc(end, joint, -arriving).reversed()
    if isinstance(first, Line) and isinstance(second, Line):
        return [Line(first.start, second.end)]
    return [first, second]


def _direction(controls: Points) -> Points:
    """Unit tangent where a curve begins: towards the first control point that is another point."""
    steps = controls[1:] - controls[0]
    lengths = np.hypot(*steps.T)
    k = int(np.argmax(lengths > LEAST_MM / 2))
    return steps[k] / lengths[k]


def _arc(start: Points, end: Points, leaving: Points) -> Line | Arc:
    """The arc between two points that leaves the first in a direction.

    A line where it hardly turns, and where it would turn by more than `MOST_TURN_RAD`: there the curve
    doubles back, and its halves will do better.
    """
    dx, dy = end - start
    half_turn = math.atan2(leaving[0] * dy - leaving[1] * dx, leaving[0] * dx + leaving[1] * dy)
    turns = LEAST_TURN_RAD <= 2 * abs(half_turn) <= MOST_TURN_RAD
    if not turns or math.hypot(dx, dy) < LEAST_MM:
        return Line(_point(start), _point(end))
    centre = (start + end + np.array([-dy, dx]) / math.tan(half_turn)) / 2
    return Arc(_point(start), _point(end), _point(centre), half_turn > 0)


def _distance_mm(points: Points, piece: Line | Arc) -> Points:
    """Distances (k,) of (k, 2) points from a line or an arc."""
    start, end = np.array(piece.start), np.array(piece.end)
    if isinstance(piece, Line):
        step = end - start
        share = np.clip((points - start) @ step / max(step @ step, LEAST_MM**2), 0.0, 1.0)
        return np.hypot(*(points - start - share[:, None] * step).T)
    x, y = (points - piece.centre).T
    turned = (np.arctan2(y, x) - piece.start_rad) * (1 if piece.ccw else -1) % math.tau
    to_ends = np.minimum(np.hypot(*(points - start).T), np.hypot(*(points - end).T))
    return np.where(turned <= abs(piece.sweep_rad), np.abs(np.hypot(x, y) - piece.radius), to_ends)


def _point(p: Points) -> Point:
    return float(p[0]), float(p[1])
