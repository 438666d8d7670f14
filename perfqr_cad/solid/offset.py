"""Holes widened in the plane, segment by segment, so that the walls between stay planes, cones and ruled
faces.

`shapely.buffer` would flatten arcs and drop segments; here every segment of the widened loop lies above the
segment it came from. Loops run with the material on their left; a set-back moves a segment to the left.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from perfqr_cad.pattern.outline import Arc, Bezier, Circle, Line, Loop, Segment

from .sampling import Array

SMOOTH = 1e-6  # sine of the turn below which two segments join smoothly
EVEN = 0.35  # sine of the turn (20°) below which a mitre between unlike flares would be a long spike
HALVINGS = 8  # of a flare that closes an edge; after the last it is dropped
REACH = (-2, -1, 0, 1, 2)  # an edge and its neighbours, rounded corners between them included
SHORTEST = 0.05  # an edge that keeps less of its length than this counts as closed
MOST_TURN_RAD = 1.0  # an arc whose sweep changes more has closed and come out on the other side
SHARE = 0.5  # a rounded corner that would shrink below this share of its radius keeps the radius instead


def widened(loop: Loop, flares: Sequence[float] | Array, share: float = 1.0) -> Loop:
    """The loop with each segment set back to its left by its own flare, mm; half-way there by a `share`.

    Rounded corners between lines stay tangent; joints that hardly turn take the lesser flare of the two.
    Where a segment would vanish or turn over, it and its neighbours give way: their flares are halved, in the
    end dropped.
    """
    segments = loop.segments
    n = len(segments)
    back = list(flares)
    for attempt in range(HALVINGS):
        moved = _set_back(segments, back)
        bad = [i for i in range(n) if _turned_over(segments[i], moved[i])]
        if not bad:
            return Loop(tuple(moved if share == 1.0 else _set_back(segments, [share * b for b in back])))
        for i in {(k + step) % n for k in bad for step in REACH}:
            back[i] = back[i] / 2 if attempt < HALVINGS - 2 else 0.0
    return loop


def _set_back(segments: Sequence[Segment], flares: Sequence[float]) -> list[Segment]:
    """The segments set back, whether or not they still make a loop."""
    n = len(segments)
    if isinstance(segments[0], Circle):
        circle = segments[0]
        return [Circle(circle.centre, _radius(circle, flares[0]), circle.ccw)]
    back = _evened(segments, flares)
    fillets = {i: _fillet(segments, back, i) for i in range(n) if _is_fillet(segments, i)}
    corners: list[Array] = []
    for i in range(n):
        before = (i - 1) % n
        if i in fillets:
            corners.append(fillets[i][0])
        elif before in fillets:
            corners.append(fillets[before][1])
        else:
            corners.append(_corner(segments[before], back[before], segments[i], back[i]))
    moved: list[Segment] = []
    for i, segment in enumerate(segments):
        start, end = corners[i], corners[(i + 1) % n]
        centre = fillets[i][2] if i in fillets else None
        moved.append(_between(segment, back[i], start, end, centre))
    return moved


def _evened(segments: Sequence[Segment], flares: Sequence[float]) -> list[float]:
    """Flares made equal across smooth joints, save those of a fillet, which adapts."""
    back = list(flares)
    n = len(segments)
    changed = True
    while changed:
        changed = False
        for i in range(n):
            j = (i + 1) % n
            if (
                _is_fillet(segments, i)
                or _is_fillet(segments, j)
                or not _smooth(segments[i], segments[j], EVEN)
            ):
                continue
            least = min(back[i], back[j])
            changed |= back[i] != back[j]
            back[i] = back[j] = least
    return back


def _is_fillet(segments: Sequence[Segment], i: int) -> bool:
    """An arc tangent to a line on either side, which make a corner (a slot's end does not)."""
    before, arc, after = segments[i - 1], segments[i], segments[(i + 1) % len(segments)]
    if not (isinstance(arc, Arc) and isinstance(before, Line) and isinstance(after, Line)):
        return False
    if not (_smooth(before, arc) and _smooth(arc, after)):
        return False
    one, two = tangent(before, 1), tangent(after, 0)
    return abs(one[0] * two[1] - one[1] * two[0]) > EVEN and abs(arc.sweep_rad) < math.pi


def _fillet(segments: Sequence[Segment], back: Sequence[float], i: int) -> tuple[Array, Array, Array]:
    """Start, end and centre of the arc that rounds the corner of its two lines, set back by their own
    flares."""
    arc = segments[i]
    assert isinstance(arc, Arc)
    n = len(segments)
    before, after = (i - 1) % n, (i + 1) % n
    radius = _fillet_radius(arc, back[before], back[after])
    side = 1.0 if arc.ccw else -1.0  # the centre lies to the left of a counter-clockwise arc
    lines = [
        (_offset_point(segments[k], end, back[k] + side * radius), tangent(segments[k], end))
        for k, end in ((before, 1), (after, 0))
    ]
    centre = _crossing(*lines)
    feet = [centre - side * radius * _left(direction) for _, direction in lines]
    return feet[0], feet[1], centre


def _fillet_radius(arc: Arc, before: float, after: float) -> float:
    """Concentric where that leaves enough of the radius, else the radius itself: an oblique wall."""
    least = min(before, after)
    if not arc.ccw:
        return arc.radius + least
    return arc.radius - least if arc.radius - least > SHARE * arc.radius else arc.radius


def _corner(a: Segment, back_a: float, b: Segment, back_b: float) -> Array:
    """Where two set-back segments meet."""
    at = np.array(b.start)
    if _smooth(a, b):
        return at + back_a * _left(tangent(b, 0))
    line_a = (_offset_point(a, 1, back_a), tangent(a, 1))
    line_b = (_offset_point(b, 0, back_b), tangent(b, 0))
    meet = _crossing(line_a, line_b)
    # On arcs the tangents only give the first guess: Newton on both offset curves' equations.
    for _ in range(20):
        residual = np.array([_gap(a, back_a, line_a, meet), _gap(b, back_b, line_b, meet)])
        if np.abs(residual).max() < 1e-13:
            break
        if not np.isfinite(meet).all():
            break
        slopes = np.array([_gap_slope(a, line_a, meet), _gap_slope(b, line_b, meet)])
        meet = meet - np.linalg.lstsq(slopes, residual)[0]
    return meet


def _gap(segment: Segment, back: float, line: tuple[Array, Array], at: Array) -> float:
    """Signed distance of a point from a set-back segment's carrier: its circle, or the tangent line."""
    if isinstance(segment, Arc):
        return float(np.linalg.norm(at - segment.centre)) - _radius(segment, back)
    return float((at - line[0]) @ _left(line[1]))


def _gap_slope(segment: Segment, line: tuple[Array, Array], at: Array) -> Array:
    if isinstance(segment, Arc):
        ray = at - segment.centre
        return ray / np.linalg.norm(ray)
    return _left(line[1])


def _between(segment: Segment, back: float, start: Array, end: Array, centre: Array | None) -> Segment:
    a, b = (float(start[0]), float(start[1])), (float(end[0]), float(end[1]))
    match segment:
        case Line():
            return Line(a, b)
        case Arc():
            at = segment.centre if centre is None else (float(centre[0]), float(centre[1]))
            return Arc(a, b, at, segment.ccw)
        case Bezier():
            return _moved_bezier(segment, back, start, end)
        case Circle():
            raise ValueError("a circle is a loop by itself")


def _moved_bezier(curve: Bezier, back: float, start: Array, end: Array) -> Bezier:
    """The legs of the control polygon set back in parallel (Tiller and Hanson, 1984)."""
    p = [np.array(q) for q in curve.controls]
    legs = [(p[i] + back * _left(_unit(p[i + 1] - p[i])), _unit(p[i + 1] - p[i])) for i in range(3)]
    inner: list[Array] = []
    for one, two, control in ((legs[0], legs[1], p[1]), (legs[1], legs[2], p[2])):
        straight = abs(one[1][0] * two[1][1] - one[1][1] * two[1][0]) < SMOOTH
        inner.append(control + back * _left(one[1]) if straight else _crossing(one, two))
    points = [(float(q[0]), float(q[1])) for q in (start, *inner, end)]
    return Bezier(points[0], points[1], points[2], points[3])


def _radius(segment: Arc | Circle, back: float) -> float:
    """Of the concentric arc; not above 0 where the set-back closes it."""
    return segment.radius - back if segment.ccw else segment.radius + back


def _turned_over(old: Segment, new: Segment) -> bool:
    """Whether a segment has vanished, or runs the other way: the corners beside it have met."""
    if isinstance(new, Circle):
        return new.radius <= 0
    ahead = [np.subtract(s.end, s.start) for s in (old, new)]
    if not np.isfinite(ahead[1]).all() or new.start == new.end:
        return True
    if isinstance(old, Arc) and isinstance(new, Arc):
        astray = abs(math.dist(new.end, new.centre) - new.radius) > SMOOTH * new.radius
        return astray or abs(new.sweep_rad - old.sweep_rad) > MOST_TURN_RAD
    return float(ahead[0] @ ahead[1]) < SHORTEST * float(ahead[0] @ ahead[0])


@lru_cache(maxsize=1 << 17)  # each corner is asked for many times
def tangent(segment: Segment, end: int) -> Array:
    """Unit direction of travel at the start (0) or end (1)."""
    match segment:
        case Line(start, stop):
            return _unit(np.subtract(stop, start))
        case Bezier():
            return _unit(np.array(segment.derivative(float(end))))
        case Arc() | Circle():
            ray = np.subtract(segment.end if end else segment.start, segment.centre)
            return _unit(_left(ray) if segment.ccw else -_left(ray))


def _smooth(a: Segment, b: Segment, sine: float = SMOOTH) -> bool:
    one, two = tangent(a, 1), tangent(b, 0)
    return abs(one[0] * two[1] - one[1] * two[0]) < sine and float(one @ two) > 0


def _offset_point(segment: Segment, end: int, back: float) -> Array:
    return np.array(segment.end if end else segment.start) + back * _left(tangent(segment, end))


def _crossing(a: tuple[Array, Array], b: tuple[Array, Array]) -> Array:
    """Where two lines (point, direction) cross."""
    (p, d), (q, e) = a, b
    turn = d[0] * e[1] - d[1] * e[0]
    gap = q - p
    return p + d * (gap[0] * e[1] - gap[1] * e[0]) / turn


def _left(d: Array) -> Array:
    return np.array([-d[1], d[0]])


def _unit(d: Array) -> Array:
    return d / math.hypot(d[0], d[1])
