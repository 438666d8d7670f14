"""Outlines at −x: what is seen from behind."""

from __future__ import annotations

from perfqr_cad.geometry.outline import Arc, Bezier, Circle, Line, Loop, Point, Region, Segment


def mirrored(region: Region) -> Region:
    """The region at −x. Its loops run the other way there, so that material stays to their left."""
    return Region(_loop(region.outer), tuple(_loop(hole) for hole in region.holes))


def _loop(loop: Loop) -> Loop:
    return Loop(tuple(_backward(segment) for segment in reversed(loop.segments)))


def _backward(segment: Segment) -> Segment:
    """A segment at −x from its end to its start; the sense of an arc changes twice."""
    match segment:
        case Line(start, end):
            return Line(_at(end), _at(start))
        case Arc(start, end, centre, ccw):
            return Arc(_at(end), _at(start), _at(centre), ccw)
        case Circle(centre, radius, ccw):
            return Circle(_at(centre), radius, ccw)
        case Bezier(start, c1, c2, end):
            return Bezier(_at(end), _at(c2), _at(c1), _at(start))


def _at(point: Point) -> Point:
    return -point[0], point[1]
