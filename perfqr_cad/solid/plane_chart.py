# pyright: reportAttributeAccessIssue=false
# The modeller's stubs are incomplete.
"""The chart of a flat plate: every curve and every wall exact."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from OCP.Geom import Geom_Circle, Geom_ConicalSurface, Geom_CylindricalSurface, Geom_Line, Geom_Plane
from OCP.gp import gp_Ax2, gp_Ax3, gp_Dir, gp_Pnt

from perfqr_cad.errors import KernelError
from perfqr_cad.pattern.outline import Arc, Bezier, Circle, Line, Segment
from perfqr_cad.surface import Plane

from .chart import Column, Level, Trace, Wall
from .occ import Array, line_2d, spline_curve
from .ruled import oblique_wall, ruled_wall

UP, DOWN = gp_Dir(0, 0, 1), gp_Dir(0, 0, -1)
BEZIER_KNOTS = (0.0,) * 4 + (1.0,) * 4
# Arcs above one another are concentric, or meet their neighbours smoothly, to within this share of a radius.
SAME = 1e-9


@dataclass(frozen=True, eq=False)
class PlaneChart:
    """Levels are horizontal planes; lines stand in planes, arcs in cylinders and cones, Béziers in ruled
    faces."""

    plate: Plane
    whole_circles: bool = True

    @property
    def thickness_mm(self) -> float:
        return self.plate.thickness_mm

    def points(self, uv: Array, depth_mm: float) -> Array:
        return self.plate.at_depth(uv, depth_mm)

    @lru_cache(maxsize=8)  # noqa: B019 - a chart lives as long as one build
    def surface(self, depth_mm: float) -> Geom_Plane:
        return Geom_Plane(gp_Ax3(gp_Pnt(0, 0, self._z(depth_mm)), UP, gp_Dir(1, 0, 0)))

    def towards_reader(self, depth_mm: float) -> bool:
        return True

    def lay(self, stacks: Sequence[tuple[Segment, ...]], levels: tuple[Level, ...]) -> list[Column]:
        heights = [self._z(level.depth_mm) for level in levels]
        return [self._column(stack, heights) for stack in stacks]

    def _column(self, stack: tuple[Segment, ...], heights: list[float]) -> Column:
        traces = tuple(_trace(s, z) for s, z in zip(stack, heights, strict=True))
        bands = zip(stack, stack[1:], heights, heights[1:], traces, traces[1:], strict=False)
        return Column(traces, tuple(_wall(*band) for band in bands))

    def _z(self, depth_mm: float) -> float:
        return self.plate.thickness_mm - depth_mm


def _trace(segment: Segment, z: float) -> Trace:
    match segment:
        case Line((x, y), (x1, y1)):
            length = math.hypot(x1 - x, y1 - y)
            return Trace(Geom_Line(gp_Pnt(x, y, z), gp_Dir(x1 - x, y1 - y, 0)), 0.0, length)
        case Bezier():
            return Trace(spline_curve(_poles(segment, z), BEZIER_KNOTS, 3), 0.0, 1.0)
        case Arc() | Circle():
            frame = gp_Ax2(gp_Pnt(*segment.centre, z), UP if segment.ccw else DOWN, _start_ray(segment))
            return Trace(Geom_Circle(frame, segment.radius), 0.0, _sweep(segment))


def _wall(upper: Segment, lower: Segment, z0: float, z1: float, top: Trace, bottom: Trace) -> Wall:
    """The wall between two segments of one kind, from height z0 down to z1."""
    match upper, lower:
        case Line(), Line():
            return _flat_wall(upper, lower, z0, z1)
        case ((Arc() | Circle()), (Arc() | Circle())) if _concentric(upper, lower):
            return _round_wall(upper, lower, z0, z1)
        case ((Arc() | Circle()), (Arc() | Circle())):
            return oblique_wall(top, bottom)
        case Bezier(), Bezier():
            return ruled_wall(_poles(upper, z0), _poles(lower, z1), BEZIER_KNOTS, 3)
        case _:
            raise KernelError(f"a {type(upper).__name__} cannot stand above a {type(lower).__name__}")


def _flat_wall(upper: Line, lower: Line, z0: float, z1: float) -> Wall:
    """The plane through two parallel lines; its normal points to the right of travel."""
    (x, y), (x1, y1) = upper.start, upper.end
    length = math.hypot(x1 - x, y1 - y)
    dx, dy = (x1 - x) / length, (y1 - y) / length
    outset = (lower.start[0] - x) * dy - (lower.start[1] - y) * dx  # the lower line lies so far to the right
    normal = gp_Dir(dy * (z0 - z1), -dx * (z0 - z1), outset)
    return Wall(Geom_Plane(gp_Ax3(gp_Pnt(x, y, z0), normal, gp_Dir(dx, dy, 0))), outward=True)


def _round_wall(upper: Arc | Circle, lower: Arc | Circle, z0: float, z1: float) -> Wall:
    """The cylinder or cone through two concentric arcs of the same sweep.

    A cone's axis points to its wider end, as STEP asks (ISO 10303-42: 0 < semi-angle < 90°).
    """
    wider = lower.radius - upper.radius
    drop = z0 - z1
    cone = abs(wider) > SAME * upper.radius
    up = not (wider > 0) if cone else upper.ccw
    frame = gp_Ax3(gp_Pnt(*upper.centre, z0), UP if up else DOWN, _start_ray(upper))
    slant = math.hypot(wider, drop) if cone else drop
    fall = -slant if up else slant
    turn = 1.0 if up == upper.ccw else -1.0  # the surface's angle against the arc's
    sweep = turn * _sweep(upper)
    images = (
        line_2d(0, 0, turn, 0),
        line_2d(0, fall, turn, 0),
        line_2d(0, 0, 0, fall),
        line_2d(sweep, 0, 0, fall),
    )
    if cone:
        surface = Geom_ConicalSurface(frame, math.atan2(abs(wider), drop), upper.radius)
    else:
        surface = Geom_CylindricalSurface(frame, upper.radius)
    return Wall(surface, outward=upper.ccw, images=images)


def _concentric(a: Arc | Circle, b: Arc | Circle) -> bool:
    return math.dist(a.centre, b.centre) <= SAME * a.radius and abs(_sweep(a) - _sweep(b)) <= SAME


def _poles(segment: Bezier, z: float) -> Array:
    return np.array([(*p, z) for p in segment.controls])


def _start_ray(segment: Arc | Circle) -> gp_Dir:
    (x, y), (cx, cy) = segment.start, segment.centre
    return gp_Dir(x - cx, y - cy, 0)


def _sweep(segment: Arc | Circle) -> float:
    """Angle swept in the direction of travel, positive."""
    return math.tau if isinstance(segment, Circle) else abs(segment.sweep_rad)
