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
from numpy.typing import NDArray
from OCP.Geom import (
    Geom_ConicalSurface,
    Geom_CylindricalSurface,
    Geom_SphericalSurface,
    Geom_SurfaceOfRevolution,
)
from OCP.gp import gp_Ax1, gp_Ax3, gp_Dir, gp_Pnt

from perfqr_cad.errors import KernelError
from perfqr_cad.pattern.outline import Line, Segment
from perfqr_cad.surface import Cone, Cylinder, HeightField, Placement, Revolution, Revolved, Sphere
from perfqr_cad.surface.spline import (
    DEGREE,
    Spline,
    TensorSpline,
    fitted,
    greville,
    refined_knots,
    tensor_fitted,
)

from .brep import TOLERANCE_MM, Batch, CurveTable
from .chart import Band, Chart, Columns, Level, Traces
from .fitted import Sight, lay_fitted
from .geometry import Arcs, Cones, Curves, Lines, Planes, Surfaces
from .modelled import ModelledSurfaces
from .occ import spline_curve, spline_surface
from .ruled import straight
from .sampling import Array

OFFSET_FIT_MM = 1e-6  # between the modelled back and the true offset of the front
PIECES = (1, 2, 4, 8, 16, 32, 64)  # of each span of the front's spline, in the spline of an offset of it
FLAT = 1e-9  # slope below which a wall is called flat
Y = np.array([0.0, 1.0, 0.0])
UP = gp_Dir(0, 1, 0)
BACK = gp_Dir(0, 0, -1)  # seams of closed surfaces lie behind the axis, away from the code


def curved_chart(placement: Placement) -> Chart:
    """The chart of a curved wall. Raises `KernelError` for one that is not of `perfqr_cad.surface`."""
    match placement:
        case Revolved():
            return RevolvedChart(placement)
        case Cone():
            return ConeChart(placement)
        case HeightField():
            return HeightFieldChart(placement)
        case _:
            raise KernelError(
                f"no exact chart for {type(placement).__name__}: use a surface of perfqr_cad.surface"
            )


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
    def surface(self, depth_mm: float) -> Surfaces:
        frame = gp_Ax3(gp_Pnt(0, 0, 0), UP, BACK)
        match self.wall:
            case Cylinder(radius, _):
                return ModelledSurfaces((Geom_CylindricalSurface(frame, radius - depth_mm),))
            case Sphere(radius, _):
                return ModelledSurfaces((Geom_SphericalSurface(frame, radius - depth_mm),))
            case Revolution():
                meridian = fitted_meridian(self.wall, depth_mm)
                points = np.column_stack(
                    [np.zeros(len(meridian.poles)), meridian.poles[:, 1], -meridian.poles[:, 0]]
                )
                curve = spline_curve(points, meridian.knots, DEGREE)
                return ModelledSurfaces((Geom_SurfaceOfRevolution(curve, gp_Ax1(gp_Pnt(0, 0, 0), UP)),))
            case _:
                raise KernelError(f"no exact surface for {type(self.wall).__name__}: use Revolution")

    def lay(self, stacks: Sequence[tuple[Segment, ...]], levels: tuple[Level, ...]) -> Columns:
        """Straight walls on lines of the grid keep lines, circles, planes and cones; all others are fitted,
        but for planes through the axis."""
        depths = [level.depth_mm for level in levels]
        upright = [isinstance(stack[0], Line) and all(s == stack[0] for s in stack) for stack in stacks]
        ends = np.array([(stack[0].start, stack[0].end) for stack in stacks])
        across, along = (np.array(upright) & (ends[:, 0, k] == ends[:, 1, k]) for k in (1, 0))
        across[across] = self._has_cones(ends[across, 0, 1], depths)
        exact = across | (along & isinstance(self.wall, Cylinder | Sphere))
        rows = [np.flatnonzero(part) for part in (across, exact & along, ~exact)]
        fitted = lay_fitted([stacks[i] for i in rows[2].tolist()], levels, self)
        flat = np.flatnonzero(along[rows[2]])
        parts = [
            (rows[0], self._parallels(ends[rows[0]], depths)),
            (rows[1], self._meridians(ends[rows[1]], depths)),
            (rows[2], fitted.walled(flat, self._meridian_planes(ends[rows[2]][flat]))),
        ]
        return Columns.joined(len(stacks), len(levels), parts)

    @property
    def _speed(self) -> float:
        """Surface parameter per mm of v: latitude on a sphere, length elsewhere."""
        return 1 / self.wall.radius_mm if isinstance(self.wall, Sphere) else 1.0

    def _images(self, ends: Array) -> CurveTable:
        """Lines of the grid in the parameters of the level."""
        at = ends * np.array([1 / self.wall.centre_radius_mm, self._speed]) + np.array([math.pi, 0.0])
        return straight(np.arange(len(ends)), at[:, 0], at[:, 1])

    def _has_cones(self, v: Array, depths: Sequence[float]) -> NDArray[np.bool_]:
        """Whether walls on parallels are planes or cones: not cylinders about the axis (an axial normal)."""
        drops = np.diff([self.wall.meridian_at(v, depth) for depth in depths], axis=0)
        radial, axial = np.abs(drops[..., 0]), np.abs(drops[..., 1])
        return np.all((axial <= FLAT * radial) | (radial > FLAT * axial), axis=0)

    def _parallels(self, ends: Array, depths: Sequence[float]) -> Columns:
        """Circles about the axis, planes and cones between."""
        exact = isinstance(self.wall, Cylinder | Sphere)
        tolerance = TOLERANCE_MM if exact else TOLERANCE_MM + 2 * OFFSET_FIT_MM  # other backs are fitted
        rows, still = np.arange(len(ends)), np.zeros(len(ends))
        u, v = ends[:, 0].T
        turn = (ends[:, 1, 0] - u) / self.wall.centre_radius_mm
        ahead = np.sign(turn)
        ray = self._rays(u)
        rings = [self.wall.meridian_at(v, depth) for depth in depths]
        traces = tuple(
            Traces(
                (
                    Batch[Curves](
                        rows, Arcs(at[:, 1:] * Y, ray, _upright(ahead, ray), at[:, 0], np.abs(turn))
                    ),
                ),
                np.full(len(ends), tolerance),
                self._images(ends),
            )
            for at in rings
        )
        bands: list[Band] = []
        for (ra, ya), (rb, yb) in pairwise(ring.T for ring in rings):
            flat = np.abs(ya - yb) <= FLAT * np.abs(ra - rb)
            # The axis of a cone points to its wider end.
            rise = np.where(flat, 1.0, np.sign(np.where(ra > rb, ya - yb, yb - ya)))
            fall = np.hypot(ra - rb, ya - yb) * np.where(ra > rb, -1.0, 1.0)
            sweep = np.abs(turn) * np.where(rise == ahead, 1.0, -1.0)
            planes = Planes(ya[:, None] * Y, -ahead[:, None] * Y, ray)
            angle = np.arctan2(np.abs(ra - rb), np.abs(ya - yb))
            cones = Cones(ya[:, None] * Y, rise[:, None] * Y, ray, ra, angle)
            begin, foot, end, far_foot = (
                np.column_stack(p) for p in ((still, still), (still, fall), (sweep, still), (sweep, fall))
            )
            images = tuple(
                straight(rows, *line)
                for line in ((begin, end), (foot, far_foot), (begin, foot), (end, far_foot))
            )
            plane, cone = np.flatnonzero(flat), np.where(flat, -1, rows)
            outward = flat | ((ya > yb) == (ahead > 0))
            surfaces = Batch[Surfaces](plane, planes[plane]), Batch[Surfaces](rows, cones).renumbered(cone)
            drawn = tuple(tuple(b.renumbered(cone) for b in table) for table in images)
            bands.append(Band(surfaces, outward, drawn))
        return Columns(traces, tuple(bands))

    def _meridians(self, ends: Array, depths: Sequence[float]) -> Columns:
        """Straight lines on a cylinder, great circles on a sphere, in planes through the axis."""
        rows = np.arange(len(ends))
        traces: list[Traces] = []
        for depth in depths:
            start, end = (self.points(ends[:, k], depth) for k in (0, 1))
            curves: Curves = Lines(start, end)
            if isinstance(self.wall, Sphere):
                turn = (ends[:, 1, 1] - ends[:, 0, 1]) / self.wall.radius_mm
                radius = self.wall.radius_mm - depth
                ray = start / radius
                across = np.cross(self._rays(ends[:, 0, 0]), Y) * np.sign(turn)[:, None]
                curves = Arcs(0 * ray, ray, np.cross(across, ray), np.full(len(ends), radius), np.abs(turn))
            tolerance = np.full(len(ends), TOLERANCE_MM)
            traces.append(Traces((Batch(rows, curves),), tolerance, self._images(ends)))
        walls = (Batch[Surfaces](rows, self._meridian_planes(ends)),)
        band = Band(walls, np.ones(len(ends), np.bool_), ((), (), (), ()))
        return Columns(tuple(traces), (band,) * (len(depths) - 1))

    def _meridian_planes(self, ends: Array) -> Planes:
        """Planes through the axis; their normals point to the right of travel."""
        up = np.sign(ends[:, 1, 1] - ends[:, 0, 1])[:, None]
        right = np.cross(Y, self._rays(ends[:, 0, 0])) * up
        return Planes(np.zeros((len(ends), 3)), right, np.broadcast_to(Y, right.shape))

    def _rays(self, u: Array) -> Array:
        """From the axis to the pattern's u, (k, 3)."""
        angle = u / self.wall.centre_radius_mm
        return np.column_stack([np.sin(angle), np.zeros(len(u)), np.cos(angle)])


def _upright(ahead: Array, ray: Array) -> Array:
    """Tangents (k, 3) of circles about the axis that start at some rays."""
    return ahead[:, None] * np.cross(Y, ray)


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
    def surface(self, depth_mm: float) -> Surfaces:
        frame = gp_Ax3(gp_Pnt(0, 0, 0), gp_Dir(0, -self.wall.upward, 0), BACK)
        angle = self.wall.half_angle_rad
        return ModelledSurfaces(
            (Geom_ConicalSurface(frame, angle, self.wall.radius_mm - depth_mm / math.cos(angle)),)
        )

    def lay(self, stacks: Sequence[tuple[Segment, ...]], levels: tuple[Level, ...]) -> Columns:
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
    def surface(self, depth_mm: float) -> Surfaces:
        heights = self.wall.heights if depth_mm == 0 else fitted_heights(self.wall, depth_mm)
        x, y = greville(heights.u_knots), greville(heights.v_knots)
        grid = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1)
        poles = np.concatenate([grid, heights.poles], axis=-1)
        return ModelledSurfaces((spline_surface(poles, heights.u_knots, heights.v_knots, (DEGREE, DEGREE)),))

    def lay(self, stacks: Sequence[tuple[Segment, ...]], levels: tuple[Level, ...]) -> Columns:
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
