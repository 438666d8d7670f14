# pyright: reportAttributeAccessIssue=false
# The modeller's stubs are incomplete.
"""Charts of curved walls of even thickness: revolved, conical, free-form."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import numpy as np
from OCP.Geom import (
    Geom_BSplineSurface,
    Geom_Circle,
    Geom_ConicalSurface,
    Geom_Curve,
    Geom_CylindricalSurface,
    Geom_Line,
    Geom_Plane,
    Geom_SphericalSurface,
    Geom_Surface,
    Geom_SurfaceOfRevolution,
)
from OCP.gp import gp_Ax1, gp_Ax2, gp_Ax3, gp_Dir, gp_Pnt

from perfqr_cad.errors import KernelError
from perfqr_cad.pattern.outline import Line, Segment
from perfqr_cad.surface import Cone, Cylinder, HeightField, Revolution, Revolved, Sphere
from perfqr_cad.surface.spline import (
    DEGREE,
    Spline,
    TensorSpline,
    fitted,
    greville,
    refined_knots,
    tensor_fitted,
)

from .chart import Column, Level, Trace, Wall
from .fitted import Sight, lay_fitted
from .occ import TOLERANCE_MM, Array, direction, line_2d, pnt, spline_curve, spline_surface

OFFSET_FIT_MM = 1e-6  # between the modelled back and the true offset of the front
PIECES = (1, 2, 4, 8, 16, 32, 64)  # of each span of the front's spline, in the spline of an offset of it
FLAT = 1e-9  # slope below which a wall is called flat
Y = gp_Dir(0, 1, 0)
BACK = gp_Dir(0, 0, -1)  # seams of closed surfaces lie behind the axis, away from the code


@dataclass(frozen=True, eq=False)
class RevolvedChart:
    """Around the y axis: meridians stand in planes through the axis, parallels in planes, cylinders and
    cones.

    Surface parameters are the angle from the far side, θ + π, and v along the meridian.
    """

    wall: Revolved
    whole_circles: bool = False
    sight: Sight | None = None

    @property
    def thickness_mm(self) -> float:
        return self.wall.thickness_mm

    def points(self, uv: Array, depth_mm: float) -> Array:
        return self.wall.at_depth(uv, depth_mm)

    def parameters(self, uv: Array, depth_mm: float) -> Array:
        return np.column_stack([self.wall.angle(uv) + math.pi, uv[:, 1] * self._speed])

    def towards_reader(self, depth_mm: float) -> bool:
        return True

    @lru_cache(maxsize=16)  # noqa: B019 - a chart lives as long as one build
    def surface(self, depth_mm: float) -> Geom_Surface:
        frame = gp_Ax3(gp_Pnt(0, 0, 0), Y, BACK)
        match self.wall:
            case Cylinder(radius, _):
                return Geom_CylindricalSurface(frame, radius - depth_mm)
            case Sphere(radius, _):
                return Geom_SphericalSurface(frame, radius - depth_mm)
            case Revolution():
                meridian = fitted_meridian(self.wall, depth_mm)
                points = np.column_stack(
                    [np.zeros(len(meridian.poles)), meridian.poles[:, 1], -meridian.poles[:, 0]]
                )
                curve = spline_curve(points, meridian.knots, DEGREE)
                return Geom_SurfaceOfRevolution(curve, gp_Ax1(gp_Pnt(0, 0, 0), Y))
            case _:
                raise KernelError(f"no exact surface for {type(self.wall).__name__}: use Revolution")

    def lay(self, stacks: Sequence[tuple[Segment, ...]], levels: tuple[Level, ...]) -> list[Column]:
        columns = [self._exact(stack, levels) for stack in stacks]
        rest = iter(lay_fitted([s for s, c in zip(stacks, columns, strict=True) if c is None], levels, self))
        return [
            self._flattened(stack, next(rest)) if column is None else column
            for stack, column in zip(stacks, columns, strict=True)
        ]

    @property
    def _speed(self) -> float:
        """Surface parameter per mm of v: latitude on a sphere, length elsewhere."""
        return 1 / self.wall.radius_mm if isinstance(self.wall, Sphere) else 1.0

    def _exact(self, stack: tuple[Segment, ...], levels: tuple[Level, ...]) -> Column | None:
        """Straight walls on a line of the grid, where edges and walls are lines, circles, planes and
        cones."""
        line = stack[0]
        if not isinstance(line, Line) or any(s != line for s in stack):
            return None
        depths = [level.depth_mm for level in levels]
        if line.start[1] == line.end[1]:
            walls = [self._parallel_wall(line, a, b) for a, b in pairwise(depths)]
            traces = tuple(self._parallel(line, depth) for depth in depths)
            return Column(traces, tuple(w for w in walls if w is not None)) if all(walls) else None
        if line.start[0] == line.end[0] and isinstance(self.wall, Cylinder | Sphere):
            wall = self._meridian_wall(line)
            return Column(tuple(self._meridian(line, depth) for depth in depths), (wall,) * (len(depths) - 1))
        return None

    def _flattened(self, stack: tuple[Segment, ...], column: Column) -> Column:
        """Walls on a fitted meridian stand in its plane."""
        line = stack[0]
        if isinstance(line, Line) and line.start[0] == line.end[0] and all(s == line for s in stack):
            return Column(column.traces, (self._meridian_wall(line),) * len(column.walls))
        return column

    def _parallel(self, line: Line, depth_mm: float) -> Trace:
        (u, v), (u1, _) = line.start, line.end
        ((radius, height),) = self.wall.meridian_at(np.array([v]), depth_mm).tolist()
        ahead = math.copysign(1.0, u1 - u)
        frame = gp_Ax2(gp_Pnt(0, height, 0), gp_Dir(0, ahead, 0), self._ray(u))
        image = line_2d(u / self.wall.centre_radius_mm + math.pi, v * self._speed, ahead, 0)
        exact = isinstance(self.wall, Cylinder | Sphere)
        tolerance = TOLERANCE_MM if exact else TOLERANCE_MM + 2 * OFFSET_FIT_MM  # other backs are fitted
        sweep = abs(u1 - u) / self.wall.centre_radius_mm
        return Trace(Geom_Circle(frame, radius), 0.0, sweep, image, tolerance)

    def _parallel_wall(self, line: Line, depth_a: float, depth_b: float) -> Wall | None:
        """Between two coaxial circles; None where it would be a cylinder about the axis (an axial normal)."""
        (u, v), (u1, _) = line.start, line.end
        (ra, ya), (rb, yb) = self.wall.meridian_at(np.array([v, v]), np.array([depth_a, depth_b])).tolist()
        ahead = math.copysign(1.0, u1 - u)
        if abs(ya - yb) <= FLAT * abs(ra - rb):
            return Wall(
                Geom_Plane(gp_Ax3(gp_Pnt(0, ya, 0), gp_Dir(0, -ahead, 0), self._ray(u))), outward=True
            )
        if abs(ra - rb) <= FLAT * abs(ya - yb):
            return None
        slant = math.hypot(ra - rb, ya - yb)
        fall, rise = (-slant, ya - yb) if ra > rb else (slant, yb - ya)  # the axis points to the wider end
        axis = math.copysign(1.0, rise)
        frame = gp_Ax3(gp_Pnt(0, ya, 0), gp_Dir(0, axis, 0), self._ray(u))
        surface = Geom_ConicalSurface(frame, math.atan2(abs(ra - rb), abs(ya - yb)), ra)
        turn = 1.0 if axis == ahead else -1.0
        sweep = turn * abs(u1 - u) / self.wall.centre_radius_mm
        images = (
            line_2d(0, 0, turn, 0),
            line_2d(0, fall, turn, 0),
            line_2d(0, 0, 0, fall),
            line_2d(sweep, 0, 0, fall),
        )
        return Wall(surface, outward=(ya > yb) == (ahead > 0), images=images)

    def _meridian(self, line: Line, depth_mm: float) -> Trace:
        """A straight line on a cylinder, a great circle on a sphere."""
        (u, v), (_, v1) = line.start, line.end
        up = math.copysign(1.0, v1 - v)
        image = line_2d(u / self.wall.centre_radius_mm + math.pi, v * self._speed, 0, up)
        start = self.points(np.array([line.start]), depth_mm)[0]
        curve: Geom_Curve
        if isinstance(self.wall, Sphere):
            angle = u / self.wall.centre_radius_mm
            across = np.cross([math.sin(angle), 0.0, math.cos(angle)], [0.0, up, 0.0])
            frame = gp_Ax2(gp_Pnt(0, 0, 0), direction(across), direction(start))
            curve = Geom_Circle(frame, self.wall.radius_mm - depth_mm)
        else:
            curve = Geom_Line(pnt(start), gp_Dir(0, up, 0))
        return Trace(curve, 0.0, abs(v1 - v) * self._speed, image)

    def _meridian_wall(self, line: Line) -> Wall:
        """The plane through the axis; its normal points to the right of travel."""
        up = math.copysign(1.0, line.end[1] - line.start[1])
        angle = line.start[0] / self.wall.centre_radius_mm
        right = gp_Dir(up * math.cos(angle), 0, -up * math.sin(angle))
        return Wall(Geom_Plane(gp_Ax3(gp_Pnt(0, 0, 0), right, Y)), outward=True)

    def _ray(self, u: float) -> gp_Dir:
        """From the axis to the pattern's u."""
        angle = u / self.wall.centre_radius_mm
        return gp_Dir(math.sin(angle), 0, math.cos(angle))


@dataclass(frozen=True, eq=False)
class ConeChart:
    """A code unrolled on a cone: its lines are geodesics, so edges are fitted and walls ruled.

    Surface parameters are the angle about an axis that points to the cone's wide end, and the slant length.
    """

    wall: Cone
    whole_circles: bool = False
    sight: Sight | None = None

    @property
    def thickness_mm(self) -> float:
        return self.wall.thickness_mm

    def points(self, uv: Array, depth_mm: float) -> Array:
        return self.wall.at_depth(uv, depth_mm)

    def parameters(self, uv: Array, depth_mm: float) -> Array:
        at = self.points(uv, depth_mm)
        angle = np.arctan2(at[:, 0], at[:, 2])
        slant = -self.wall.upward * at[:, 1] / math.cos(self.wall.half_angle_rad)
        return np.column_stack([math.pi - self.wall.upward * angle, slant])

    def towards_reader(self, depth_mm: float) -> bool:
        return True

    @lru_cache(maxsize=16)  # noqa: B019 - a chart lives as long as one build
    def surface(self, depth_mm: float) -> Geom_Surface:
        frame = gp_Ax3(gp_Pnt(0, 0, 0), gp_Dir(0, -self.wall.upward, 0), BACK)
        angle = self.wall.half_angle_rad
        return Geom_ConicalSurface(frame, angle, self.wall.radius_mm - depth_mm / math.cos(angle))

    def lay(self, stacks: Sequence[tuple[Segment, ...]], levels: tuple[Level, ...]) -> list[Column]:
        return lay_fitted(stacks, levels, self)


@dataclass(frozen=True, eq=False)
class HeightFieldChart:
    """A code projected on z(x, y): lines stand in planes, arcs in cylinders. Surface parameters are x and
    y."""

    wall: HeightField
    whole_circles: bool = False

    @property
    def sight(self) -> Sight:
        return Sight(np.zeros(3), np.eye(3))

    @property
    def thickness_mm(self) -> float:
        return self.wall.thickness_mm

    def points(self, uv: Array, depth_mm: float) -> Array:
        return self.wall.at_depth(uv, depth_mm)

    def parameters(self, uv: Array, depth_mm: float) -> Array:
        return uv

    def towards_reader(self, depth_mm: float) -> bool:
        return True

    @lru_cache(maxsize=16)  # noqa: B019 - a chart lives as long as one build
    def surface(self, depth_mm: float) -> Geom_BSplineSurface:
        heights = self.wall.heights if depth_mm == 0 else fitted_heights(self.wall, depth_mm)
        x, y = greville(heights.u_knots), greville(heights.v_knots)
        grid = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1)
        poles = np.concatenate([grid, heights.poles], axis=-1)
        return spline_surface(poles, heights.u_knots, heights.v_knots, (DEGREE, DEGREE))

    def lay(self, stacks: Sequence[tuple[Segment, ...]], levels: tuple[Level, ...]) -> list[Column]:
        return lay_fitted(stacks, levels, self)


def fitted_meridian(wall: Revolution, depth_mm: float) -> Spline:
    """Radius and height over v of the meridian at a depth, within `OFFSET_FIT_MM`."""
    knots = wall.spline.knots - wall.centre_length_mm
    error = math.inf
    for pieces in PIECES:
        spline = fitted(lambda v: wall.meridian_at(v, depth_mm), refined_knots(knots, pieces))
        v = midway(spline.knots)
        error = float(np.linalg.norm(spline(v) - wall.meridian_at(v, depth_mm), axis=1).max())
        if error <= OFFSET_FIT_MM:
            return spline
    raise KernelError(_misfit(error, depth_mm))


def fitted_heights(wall: HeightField, depth_mm: float) -> TensorSpline:
    """z(x, y) of the surface at a depth, within `OFFSET_FIT_MM`."""
    error = math.inf
    for pieces in PIECES:
        u_knots, v_knots = (refined_knots(k, pieces) for k in (wall.heights.u_knots, wall.heights.v_knots))
        spline = tensor_fitted(lambda at: wall.at_depth(at, depth_mm)[:, 2:], u_knots, v_knots)
        grid = np.stack(np.meshgrid(midway(u_knots), midway(v_knots)), axis=-1).reshape(-1, 2)
        error = float(np.abs(spline(grid)[:, 0] - wall.at_depth(grid, depth_mm)[:, 2]).max())
        if error <= OFFSET_FIT_MM:
            return spline
    raise KernelError(_misfit(error, depth_mm))


def midway(knots: Array) -> Array:
    """Half-way between the sites of a fit, where it is checked."""
    sites = greville(knots)
    return (sites[1:] + sites[:-1]) / 2


def _misfit(error_mm: float, depth_mm: float) -> str:
    return (
        f"the surface {depth_mm:g} mm behind the front misses its spline by {error_mm:.1e} mm "
        f"(limit {OFFSET_FIT_MM:g} mm): take a smoother front or a thinner wall"
    )
