"""Charts of curved walls of even thickness: revolved and conical ones, and which chart a wall takes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import numpy as np
from OCP.Geom import (
    Geom_ConicalSurface,
    Geom_CylindricalSurface,
    Geom_SphericalSurface,
    Geom_SurfaceOfRevolution,
)
from OCP.gp import gp_Ax1, gp_Ax3, gp_Dir, gp_Pnt

from perfqr_cad.errors import KernelError
from perfqr_cad.geometry.arrays import Array, Mask
from perfqr_cad.geometry.outline import Line, Segment
from perfqr_cad.geometry.spline import DEGREE
from perfqr_cad.profile.loft import Level
from perfqr_cad.solid.charts.chart import Band, Chart, Columns, Traces, WallChart
from perfqr_cad.solid.charts.fitted import Projection, fitted_columns
from perfqr_cad.solid.charts.height_field import HeightFieldChart
from perfqr_cad.solid.charts.offset_fit import OFFSET_FIT_MM, fitted_meridian
from perfqr_cad.solid.charts.ruled import grid_images, straight
from perfqr_cad.solid.kernel.modelled import ModelledSurfaces
from perfqr_cad.solid.kernel.occ import spline_curve
from perfqr_cad.solid.tables.batches import Arcs, Cones, Curves, Lines, Planes, Surfaces
from perfqr_cad.solid.tables.brep import TOLERANCE_MM, Batch, CurveTable
from perfqr_cad.surface import Cone, Cylinder, HeightField, Placement, Revolution, Revolved, Sphere

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
class RevolvedChart(WallChart[Revolved]):
    """Around the y axis: meridians stand in planes through the axis, parallels in planes, cylinders and
    cones.

    Surface parameters are the angle from the far side, θ + π, and v along the meridian.
    """

    whole_circles: bool = False
    projection: Projection | None = None

    def parameters(self, uv: Array, depth_mm: float) -> Array:
        return np.column_stack([self.wall.angle(uv) + math.pi, uv[:, 1] * self._speed])

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

    def columns(self, stacks: Sequence[tuple[Segment, ...]], levels: tuple[Level, ...]) -> Columns:
        """Straight walls on lines of the grid keep lines, circles, planes and cones; all others are fitted,
        but for planes through the axis."""
        depths = [level.depth_mm for level in levels]
        upright = [isinstance(stack[0], Line) and all(s == stack[0] for s in stack) for stack in stacks]
        ends = np.array([(stack[0].start, stack[0].end) for stack in stacks])
        across, along = (np.array(upright) & (ends[:, 0, k] == ends[:, 1, k]) for k in (1, 0))
        across[across] = self._has_cones(ends[across, 0, 1], depths)
        exact = across | (along & isinstance(self.wall, Cylinder | Sphere))
        rows = [np.flatnonzero(part) for part in (across, exact & along, ~exact)]
        fitted = fitted_columns([stacks[i] for i in rows[2].tolist()], levels, self)
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

    def _has_cones(self, v: Array, depths: Sequence[float]) -> Mask:
        """Whether walls on parallels are planes or cones: not cylinders about the axis (an axial normal)."""
        drops = np.diff([self.wall.meridian_at(v, depth) for depth in depths], axis=0)
        radial, axial = np.abs(drops[..., 0]), np.abs(drops[..., 1])
        return np.all((axial <= FLAT * radial) | (radial > FLAT * axial), axis=0)

    def _parallels(self, ends: Array, depths: Sequence[float]) -> Columns:
        """Circles about the axis, planes and cones between."""
        exact = isinstance(self.wall, Cylinder | Sphere)
        tolerance = TOLERANCE_MM if exact else TOLERANCE_MM + 2 * OFFSET_FIT_MM  # other backs are fitted
        rows = np.arange(len(ends))
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
            plane, cone = np.flatnonzero(flat), np.where(flat, -1, rows)
            outward = flat | ((ya > yb) == (ahead > 0))
            surfaces = Batch[Surfaces](plane, planes[plane]), Batch[Surfaces](rows, cones).renumbered(cone)
            images = grid_images(rows, sweep, fall)
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
class ConeChart(WallChart[Cone]):
    """A code unrolled on a cone: its lines are geodesics, so edges are fitted and walls ruled.

    Surface parameters are the angle about an axis that points to the cone's wide end, and the slant length.
    """

    whole_circles: bool = False
    projection: Projection | None = None

    def parameters(self, uv: Array, depth_mm: float) -> Array:
        at = self.points(uv, depth_mm)
        angle = np.arctan2(at[:, 0], at[:, 2])
        slant = -self.wall.upward * at[:, 1] / math.cos(self.wall.half_angle_rad)
        return np.column_stack([math.pi - self.wall.upward * angle, slant])

    @lru_cache(maxsize=16)  # noqa: B019 - a chart lives as long as one build
    def surface(self, depth_mm: float) -> Surfaces:
        frame = gp_Ax3(gp_Pnt(0, 0, 0), gp_Dir(0, -self.wall.upward, 0), BACK)
        angle = self.wall.half_angle_rad
        return ModelledSurfaces(
            (Geom_ConicalSurface(frame, angle, self.wall.radius_mm - depth_mm / math.cos(angle)),)
        )

    def columns(self, stacks: Sequence[tuple[Segment, ...]], levels: tuple[Level, ...]) -> Columns:
        return fitted_columns(stacks, levels, self)
