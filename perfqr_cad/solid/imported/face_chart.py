"""The chart of a wall between two faces of an imported solid: outlines are laid on the exact faces by Newton.

Straight projected segments stand in planes, projected arcs in cylinders, all others in ruled faces. Curves on
curved faces are cubic splines through exact points of the face; what they stray in between is measured.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cache, cached_property
from typing import TYPE_CHECKING

import numpy as np
from OCP.Geom import Geom_Circle, Geom_CylindricalSurface, Geom_Line, Geom_OffsetSurface, Geom_Plane
from OCP.gp import gp_Ax2, gp_Vec

from perfqr_cad.errors import KernelError
from perfqr_cad.pattern.outline import Arc, Line, Segment
from perfqr_cad.solid.chart import Column, Level, Trace, Wall
from perfqr_cad.solid.imported.lay import Laid, Projected
from perfqr_cad.solid.imported.skin import Skin
from perfqr_cad.solid.mesh import sampled
from perfqr_cad.solid.occ import (
    TOLERANCE_MM,
    Array,
    axes,
    direction,
    line_2d,
    pnt,
    spline_curve,
    spline_curve_2d,
)
from perfqr_cad.solid.ruled import ruled_wall

if TYPE_CHECKING:
    from OCP.Geom import Geom_Surface

LEAST_POINTS = 5  # of a spline through one segment
TURN_PER_POINT_RAD = 0.08  # a cubic over this turn of a radius R strays by R·θ⁴/384 = 1e-7 R
STRAIGHT_MM = 1e-8
SQUARE_TO_AXIS = 1e-12  # 1 − cosine of the angle at which a plane counts as square to the axis
SLACK = 2.0  # the error is measured halfway between points; near the ends it is a little greater elsewhere


@dataclass(frozen=True)
class FaceChart:
    """A wall from one face of a solid to another, or to pocket floors `depth_mm` below the front."""

    laid: Laid
    front: Skin
    back: Skin | None
    thickness_mm: float
    whole_circles: bool = False
    _known: dict[tuple[float, float, float], Array] = field(default_factory=dict, repr=False)

    def points(self, uv: Array, depth_mm: float) -> Array:
        """Exact points of the level; those of laid segments' starts are at hand."""
        keys = [(depth_mm, u, v) for u, v in uv.tolist()]
        if any(key not in self._known for key in keys):
            points = self._meet(uv, depth_mm)[1]
            self._known.update(zip(keys, points, strict=True))
        return np.array([self._known[key] for key in keys])

    def surface(self, depth_mm: float) -> Geom_Surface:
        if depth_mm == 0.0:
            return self.front.surface
        if self.back is not None:
            return self.back.surface
        return self._floor_surface

    def towards_reader(self, depth_mm: float) -> bool:
        if depth_mm > 0.0 and self.back is not None:
            return self.back.outward_sign < 0
        return self.front.outward_sign > 0

    @cached_property
    def _floor_surface(self) -> Geom_Surface:
        """The front moved inwards: along the axis of a projection, along its own normals under a wrap."""
        if isinstance(self.laid, Projected):
            x, y, z = (-self.thickness_mm * self.laid.frame_at_centre.axes[2]).tolist()
            moved = self.front.surface.Translated(gp_Vec(x, y, z))
            return moved  # pyright: ignore[reportReturnType] - a Geom_Geometry by its stub
        return Geom_OffsetSurface(self.front.surface, -self.thickness_mm * self.front.outward_sign)

    def lay(self, stacks: Sequence[tuple[Segment, ...]], levels: tuple[Level, ...]) -> list[Column]:
        counts = [self._points_for(stack) for stack in stacks]
        rows: list[list[Trace]] = [[] for _ in stacks]
        heights: list[list[Array]] = [[] for _ in stacks]
        for k, level in enumerate(levels):
            uv = [sampled(s[k], np.linspace(0, 1, n)) for s, n in zip(stacks, counts, strict=True)]
            images, points = self._meet(np.vstack(uv), level.depth_mm, on_face=level.on_face)
            splits = np.cumsum(counts)[:-1]
            for i, (at, image, p) in enumerate(
                zip(uv, np.split(images, splits), np.split(points, splits), strict=True)
            ):
                self._known[(level.depth_mm, *at[0].tolist())] = p[0]
                ruled = not self._is_simple(stacks[i])
                rows[i].append(self._trace(stacks[i][k], p, image, level, ruled))
                heights[i].append(p)
        return [
            Column(tuple(row), tuple(self._wall(stack, row, laid, j) for j in range(len(levels) - 1)))
            for stack, row, laid in zip(stacks, rows, heights, strict=True)
        ]

    def _is_simple(self, stack: tuple[Segment, ...]) -> bool:
        """Whether the wall is a plane or cylinder along the axis: a projected line or arc, not flared."""
        return isinstance(self.laid, Projected) and isinstance(stack[0], Line | Arc) and len(set(stack)) == 1

    def _points_for(self, stack: tuple[Segment, ...]) -> int:
        flat = self.front.is_plane and (self.back is None or self.back.is_plane)
        if flat and isinstance(stack[0], Line) and isinstance(self.laid, Projected):
            return LEAST_POINTS if not self._is_simple(stack) else 2
        ends = self.laid.normal(np.array([stack[0].start, stack[0].end]))
        turn = math.acos(min(1.0, float(ends[0] @ ends[1])))
        if isinstance(stack[0], Arc):
            turn += abs(stack[0].sweep_rad)
        return LEAST_POINTS + math.ceil(turn / TURN_PER_POINT_RAD / 4)

    def _meet(self, uv: Array, depth_mm: float, *, on_face: bool = True) -> tuple[Array, Array]:
        """Parameters and points of a level at pattern points."""
        origins, frames = self.laid.line(uv)
        if depth_mm > 0 and on_face and self.back is not None:
            return self._on(self.back, origins, frames, self.laid.at_depth(uv, self.laid.thickness_mm))
        images, points = self._on(self.front, origins, frames, origins)
        if depth_mm == 0.0:
            return images, points
        inward = -frames[:, 2]
        if on_face and not isinstance(self.laid, Projected):
            inward = -np.array([self.front.normal(u, v) for u, v in images.tolist()])
        return images, points + depth_mm * inward

    def _on(self, skin: Skin, origins: Array, frames: Array, guesses: Array) -> tuple[Array, Array]:
        images, points = skin.meet(origins, frames, guesses, self.laid.thickness_mm)
        return skin.in_period(images), points

    def _trace(self, segment: Segment, points: Array, image: Array, level: Level, ruled: bool) -> Trace:
        plane = level.on_face and self._skin(level).is_plane
        if not ruled:
            if _is_straight(points):
                length = float(np.linalg.norm(points[-1] - points[0]))
                curve = Geom_Line(pnt(points[0]), direction(points[-1] - points[0]))
                drawn = None if plane or not level.on_face else _image(image, length)
                return Trace(curve, 0.0, length, drawn, self._stray(points, image, level, plane))
            if isinstance(segment, Arc) and self._square(level):
                return Trace(self._circle(segment, points[0]), 0.0, abs(segment.sweep_rad))
        knots = _knots(len(points), 1.0)
        curve = spline_curve(_to_poles(len(points)) @ points, knots, 3)
        drawn = None if plane or not level.on_face else _image(image, 1.0)
        return Trace(curve, 0.0, 1.0, drawn, self._stray(points, image, level, plane))

    def _skin(self, level: Level) -> Skin:
        return self.back if level.depth_mm > 0 and self.back is not None else self.front

    def _square(self, level: Level) -> bool:
        """Whether a level is a plane square to the axis, on which projected arcs stay circles."""
        skin = self._skin(level)
        if not (level.on_face and skin.is_plane and isinstance(self.laid, Projected)):
            return False
        u0, u1, v0, v1 = skin.bounds
        normal = skin.normal((u0 + u1) / 2, (v0 + v1) / 2)
        return 1 - abs(float(normal @ self.laid.frame_at_centre.axes[2])) < SQUARE_TO_AXIS

    def _circle(self, arc: Arc, start: Array) -> Geom_Circle:
        assert isinstance(self.laid, Projected)
        e1, e2, n = self.laid.frame_at_centre.axes
        ray = (arc.start[0] - arc.centre[0]) * e1 + (arc.start[1] - arc.centre[1]) * e2
        return Geom_Circle(gp_Ax2(pnt(start - ray), direction(n if arc.ccw else -n), direction(ray)), arc.radius)

    def _stray(self, points: Array, image: Array, level: Level, plane: bool) -> float:
        """How far the curve leaves the face between its points, with some slack."""
        if plane or not level.on_face or len(points) < LEAST_POINTS:
            return TOLERANCE_MM
        surface = self.surface(level.depth_mm)
        between = _halfway(len(points))
        on_curve, uv = between @ points, between @ image
        on_face = np.array([surface.Value(u, v).Coord() for u, v in uv.tolist()])
        return max(TOLERANCE_MM, SLACK * float(np.linalg.norm(on_curve - on_face, axis=1).max()))

    def _wall(self, stack: tuple[Segment, ...], row: list[Trace], laid: list[Array], upper: int) -> Wall:
        top, bottom = row[upper], row[upper + 1]
        if not self._is_simple(stack):
            return ruled_wall(top, bottom)
        segment, p, q = stack[upper], laid[upper], laid[upper + 1]
        if isinstance(segment, Arc):
            return self._round_wall(segment, top, bottom, p, q)
        assert isinstance(self.laid, Projected)
        e1, e2, n = self.laid.frame_at_centre.axes
        along = (segment.end[0] - segment.start[0]) * e1 + (segment.end[1] - segment.start[1]) * e2
        return Wall(Geom_Plane(axes(p[0], np.cross(along, n), along)), outward=True)

    def _round_wall(self, arc: Arc, top: Trace, bottom: Trace, p: Array, q: Array) -> Wall:
        """The cylinder along the axis through an arc; its angle grows in the direction of travel."""
        assert isinstance(self.laid, Projected)
        frame = self.laid.frame_at_centre
        e1, e2, n = frame.axes
        z = n if arc.ccw else -n
        ray = (arc.start[0] - arc.centre[0]) * e1 + (arc.start[1] - arc.centre[1]) * e2
        centre = frame.to_space([[*arc.centre, 0.0]])[0]
        sweep = abs(arc.sweep_rad)
        rims = [(points - centre) @ z for points in (p, q)]
        angle = np.linspace(0.0, sweep, len(p))
        images = [
            line_2d(0.0, float(rim[0]), 1.0, 0.0)
            if isinstance(trace.curve, Geom_Circle)
            else _image(np.column_stack([angle, rim]), trace.last)
            for trace, rim in zip((top, bottom), rims, strict=True)
        ]
        fall = -1.0 if arc.ccw else 1.0
        sides = [line_2d(at, float(rims[0][end]), 0.0, fall) for at, end in ((0.0, 0), (sweep, -1))]
        surface = Geom_CylindricalSurface(axes(centre, z, ray), arc.radius)
        return Wall(surface, outward=arc.ccw, images=(images[0], images[1], sides[0], sides[1]))


def _image(uv: Array, last: float) -> object:
    """A spline in the parameters of a surface through points (k, 2), its own parameter from 0 to `last`."""
    if len(uv) == 2:
        return spline_curve_2d(uv, (0.0, 0.0, last, last), 1)
    if len(uv) < LEAST_POINTS:
        raise KernelError(f"a curve on a face needs {LEAST_POINTS} points, got {len(uv)}")
    return spline_curve_2d(_to_poles(len(uv)) @ uv, _knots(len(uv), last), 3)


def _is_straight(points: Array) -> bool:
    if len(points) == 2:
        return True
    chord = (points[-1] - points[0]) / np.linalg.norm(points[-1] - points[0])
    return bool(np.linalg.norm(np.cross(points - points[0], chord), axis=1).max() < STRAIGHT_MM)


@cache
def _flat_knots(count: int) -> Array:
    """Not-a-knot cubic through `count` evenly spaced points of [0, 1]."""
    even = np.linspace(0, 1, count)
    return np.concatenate([[0.0] * 4, even[2:-2], [1.0] * 4])


def _knots(count: int, last: float) -> Array:
    return _flat_knots(count) * last


@cache
def _to_poles(count: int) -> Array:
    """Matrix (count, count) from evenly spaced points to the poles of the cubic through them."""
    from scipy.interpolate import BSpline

    return np.linalg.inv(BSpline.design_matrix(np.linspace(0, 1, count), _flat_knots(count), 3).toarray())


@cache
def _halfway(count: int) -> Array:
    """Matrix (count − 1, count) from evenly spaced points to the cubic's values halfway between them."""
    from scipy.interpolate import BSpline

    even = np.linspace(0, 1, count)
    middle = (even[:-1] + even[1:]) / 2
    return BSpline.design_matrix(middle, _flat_knots(count), 3).toarray() @ _to_poles(count)
