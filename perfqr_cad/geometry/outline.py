"""Outlines in the plane, mm: segments, closed loops and regions with holes.

Lines, arcs, circles and cubic Béziers are kept as what they are down to STEP, SVG and DXF; areas are
exact (Green's theorem), and only `flatten` approximates, within a stated tolerance.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from shapely.geometry import Polygon

Point: TypeAlias = tuple[float, float]
Points: TypeAlias = NDArray[np.float64]

LEAST_MM = 1e-6  # shorter segments are rounding, and no modeller can give them a direction
FLATTEN_TOL_MM = 0.005  # greatest distance between a curve and its chords; a tenth of a printer's step
GAUSS_3 = ((-math.sqrt(0.6), 5 / 9), (0.0, 8 / 9), (math.sqrt(0.6), 5 / 9))  # exact to degree 5


@dataclass(frozen=True, slots=True)
class Line:
    """A straight segment from `start` to `end`."""

    start: Point
    end: Point

    def reversed(self) -> Line:
        return Line(self.end, self.start)

    def moment(self) -> float:
        """Its share of the enclosed area: ½∮(x dy − y dx), mm²."""
        return (self.start[0] * self.end[1] - self.end[0] * self.start[1]) / 2

    def flatten(self, tol_mm: float) -> list[Point]:
        """The points of the segment, without its end."""
        return [self.start]

    @property
    def length(self) -> float:
        return math.dist(self.start, self.end)


@dataclass(frozen=True, slots=True)
class Arc:
    """A circular arc from `start` to `end` about `centre`, counter-clockwise when `ccw`; less than a turn.

    >>> quarter = Arc((2.0, 0.0), (0.0, 2.0), (0.0, 0.0), ccw=True)
    >>> quarter.radius, quarter.length == math.pi
    (2.0, True)
    """

    start: Point
    end: Point
    centre: Point
    ccw: bool

    @property
    def radius(self) -> float:
        return math.dist(self.start, self.centre)

    @property
    def start_rad(self) -> float:
        return math.atan2(self.start[1] - self.centre[1], self.start[0] - self.centre[0])

    @property
    def sweep_rad(self) -> float:
        """Signed angle swept, positive counter-clockwise."""
        end = math.atan2(self.end[1] - self.centre[1], self.end[0] - self.centre[0])
        turn = (end - self.start_rad) % math.tau
        return turn if self.ccw else turn - math.tau

    @property
    def length(self) -> float:
        return self.radius * abs(self.sweep_rad)

    def at(self, fraction: float) -> Point:
        """The point a fraction of the way along."""
        angle = self.start_rad + fraction * self.sweep_rad
        return self.centre[0] + self.radius * math.cos(angle), self.centre[1] + self.radius * math.sin(angle)

    def reversed(self) -> Arc:
        return Arc(self.end, self.start, self.centre, not self.ccw)

    def moment(self) -> float:
        """Its share of the enclosed area: ½∮(x dy − y dx), mm²."""
        (cx, cy), (dx, dy) = self.centre, (self.end[0] - self.start[0], self.end[1] - self.start[1])
        return (self.radius**2 * self.sweep_rad + cx * dy - cy * dx) / 2

    def flatten(self, tol_mm: float) -> list[Point]:
        """Points on the arc, without its end; no chord is farther than `tol_mm` from it."""
        pieces = _chords(self.radius, abs(self.sweep_rad), tol_mm)
        return [self.start] + [self.at(i / pieces) for i in range(1, pieces)]


@dataclass(frozen=True, slots=True)
class Circle:
    """A whole circle: a loop by itself."""

    centre: Point
    radius: float
    ccw: bool

    @property
    def start(self) -> Point:
        return self.centre[0] + self.radius, self.centre[1]

    @property
    def end(self) -> Point:
        return self.start

    @property
    def length(self) -> float:
        return math.tau * self.radius

    def reversed(self) -> Circle:
        return Circle(self.centre, self.radius, not self.ccw)

    def moment(self) -> float:
        """Its signed area, mm²."""
        return math.pi * self.radius**2 * (1 if self.ccw else -1)

    def flatten(self, tol_mm: float) -> list[Point]:
        """Points around the circle; no chord is farther than `tol_mm` from it."""
        pieces = max(8, _chords(self.radius, math.tau, tol_mm))
        step = math.tau / pieces * (1 if self.ccw else -1)
        (cx, cy), r = self.centre, self.radius
        return [(cx + r * math.cos(i * step), cy + r * math.sin(i * step)) for i in range(pieces)]


@dataclass(frozen=True, slots=True)
class Bezier:
    """A cubic Bézier segment with control points `c1` and `c2`."""

    start: Point
    c1: Point
    c2: Point
    end: Point

    @property
    def controls(self) -> tuple[Point, Point, Point, Point]:
        return self.start, self.c1, self.c2, self.end

    @property
    def length(self) -> float:
        points = [*self.flatten(FLATTEN_TOL_MM), self.end]
        return sum(math.dist(a, b) for a, b in pairwise(points))

    def at(self, t: float) -> Point:
        """The point at parameter t in [0, 1]."""
        s = 1 - t
        weights = (s**3, 3 * s * s * t, 3 * s * t * t, t**3)
        return (
            sum(w * p[0] for w, p in zip(weights, self.controls, strict=True)),
            sum(w * p[1] for w, p in zip(weights, self.controls, strict=True)),
        )

    def derivative(self, t: float) -> Point:
        """d/dt of the point at parameter t."""
        s = 1 - t
        p = self.controls
        weights = (3 * s * s, 6 * s * t, 3 * t * t)
        return (
            sum(w * (b[0] - a[0]) for w, a, b in zip(weights, p, p[1:], strict=False)),
            sum(w * (b[1] - a[1]) for w, a, b in zip(weights, p, p[1:], strict=False)),
        )

    def reversed(self) -> Bezier:
        return Bezier(self.end, self.c2, self.c1, self.start)

    def moment(self) -> float:
        """Its share of the enclosed area: ½∮(x dy − y dx), mm²; the integrand has degree 5."""
        total = 0.0
        for node, weight in GAUSS_3:
            t = (1 + node) / 2
            (x, y), (dx, dy) = self.at(t), self.derivative(t)
            total += weight / 2 * (x * dy - y * dx)
        return total / 2

    def flatten(self, tol_mm: float) -> list[Point]:
        """Points on the curve, without its end; chord error at most `tol_mm` (second-difference bound)."""
        p = self.controls
        bend = max(
            math.hypot(a[0] - 2 * b[0] + c[0], a[1] - 2 * b[1] + c[1])
            for a, b, c in zip(p, p[1:], p[2:], strict=False)
        )
        pieces = max(1, math.ceil(math.sqrt(0.75 * bend / tol_mm)))
        return [self.start] + [self.at(i / pieces) for i in range(1, pieces)]


Segment: TypeAlias = Line | Arc | Circle | Bezier


@dataclass(frozen=True)
class Loop:
    """A closed chain of segments, each starting where the one before ends; a circle stands alone.

    >>> square = Loop.from_points([(0, 0), (2, 0), (2, 2), (0, 2)])
    >>> square.area, square.length, square.reversed().area
    (4.0, 8.0, -4.0)
    """

    segments: tuple[Segment, ...]

    @staticmethod
    def from_points(points: Sequence[Point] | Points) -> Loop:
        """The closed polygon through (k, 2) points, in mm; of points closer than `LEAST_MM` one is kept."""
        corners = np.asarray(points, np.float64)
        steps = np.abs(corners - np.roll(corners, 1, axis=0)).max(axis=1)
        corners = [(x, y) for x, y in corners[steps > LEAST_MM].tolist()]
        return Loop(tuple(Line(a, b) for a, b in zip(corners, corners[1:] + corners[:1], strict=True)))

    @cached_property
    def area(self) -> float:
        """Exact signed area, mm²; positive when counter-clockwise."""
        return sum(s.moment() for s in self.segments)

    @property
    def length(self) -> float:
        return sum(s.length for s in self.segments)

    def flatten(self, tol_mm: float = FLATTEN_TOL_MM) -> Points:
        """(k, 2) corners in mm, the first not repeated; curves within `tol_mm` of their chords."""
        return np.array([p for s in self.segments for p in s.flatten(tol_mm)], dtype=np.float64)

    def reversed(self) -> Loop:
        """The same loop the other way round."""
        return Loop(tuple(s.reversed() for s in reversed(self.segments)))

    def oriented(self, ccw: bool) -> Loop:
        """The loop in the given sense."""
        return self if (self.area > 0) == ccw else self.reversed()


@dataclass(frozen=True)
class Region:
    """One piece of material: a counter-clockwise outer loop and clockwise holes, mm.

    >>> square = Loop.from_points([(0, 0), (4, 0), (4, 4), (0, 4)])
    >>> hole = Loop((Circle((2.0, 2.0), 1.0, ccw=False),))
    >>> round(Region(square, (hole,)).area + math.pi, 9)
    16.0
    """

    outer: Loop
    holes: tuple[Loop, ...] = ()

    @property
    def loops(self) -> tuple[Loop, ...]:
        return (self.outer, *self.holes)

    @cached_property
    def area(self) -> float:
        """Exact area, mm²."""
        return self.outer.area + sum(hole.area for hole in self.holes)

    def segments(self) -> Iterator[Segment]:
        """Every segment of every loop, outer first."""
        for loop in self.loops:
            yield from loop.segments

    def polygon(self, tol_mm: float = FLATTEN_TOL_MM) -> Polygon:
        """The region as a shapely polygon; curves within `tol_mm` of their chords."""
        from shapely.geometry import Polygon

        return Polygon(self.outer.flatten(tol_mm), [hole.flatten(tol_mm) for hole in self.holes])

    @staticmethod
    def from_polygon(polygon: Polygon) -> Region:
        """The straight-edged region of a shapely polygon."""
        return Region(
            Loop.from_points(np.asarray(polygon.exterior.coords)[:-1, :2]).oriented(ccw=True),
            tuple(
                Loop.from_points(np.asarray(ring.coords)[:-1, :2]).oriented(ccw=False)
                for ring in polygon.interiors
            ),
        )


def _chords(radius: float, angle_rad: float, tol_mm: float) -> int:
    """Chords that keep an arc's sagitta r(1 − cos(θ/2)) within the tolerance."""
    if radius <= tol_mm:
        return max(1, math.ceil(angle_rad / (math.pi / 2)))
    return max(1, math.ceil(angle_rad / (2 * math.acos(1 - tol_mm / radius))))
