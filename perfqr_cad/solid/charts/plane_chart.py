"""The chart of a flat plate: every curve and every wall exact."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from perfqr_cad.errors import KernelError
from perfqr_cad.geometry.arrays import Array, Indices, Mask
from perfqr_cad.geometry.outline import Bezier, Line, Segment
from perfqr_cad.geometry.segments import by_kind, rounds
from perfqr_cad.profile.loft import Level
from perfqr_cad.solid.charts.chart import Band, Columns, Images, Traces, WallChart
from perfqr_cad.solid.charts.ruled import box_images, grid_images, oblique, spans_of
from perfqr_cad.solid.tables.batches import (
    Arcs,
    Cones,
    Curves,
    Lines,
    Planes,
    Splines,
    SplineSurfaces,
    Surfaces,
)
from perfqr_cad.solid.tables.brep import TOLERANCE_MM, Batch, CurveTable
from perfqr_cad.surface import Plane

UP, ALONG = np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0])
BEZIER_KNOTS = (0.0,) * 4 + (1.0,) * 4
# Arcs above one another are concentric, or meet their neighbours smoothly, to within this share of a radius.
SAME = 1e-9


@dataclass(frozen=True, eq=False)
class PlaneChart(WallChart[Plane]):
    """Levels are horizontal planes; lines stand in planes, arcs in cylinders and cones, Béziers in ruled
    faces."""

    whole_circles: bool = True

    def surface(self, depth_mm: float) -> Planes:
        return Planes(np.array([[0.0, 0.0, self._z(depth_mm)]]), UP[None], ALONG[None])

    def columns(self, stacks: Sequence[tuple[Segment, ...]], levels: tuple[Level, ...]) -> Columns:
        kinds = {kind: rows for kind, rows in by_kind([stack[0] for stack in stacks]).items() if len(rows)}
        drawn = [
            tuple(
                Batch(rows, _drawn([stacks[i][k] for i in rows], kind, self._z(level.depth_mm)))
                for kind, rows in kinds.items()
            )
            for k, level in enumerate(levels)
        ]
        tolerance = np.full(len(stacks), TOLERANCE_MM)
        traces = tuple(Traces(curves, tolerance) for curves in drawn)
        return Columns(traces, tuple(_band(upper, lower, len(stacks)) for upper, lower in pairwise(drawn)))

    def _z(self, depth_mm: float) -> float:
        return self.thickness_mm - depth_mm


def _drawn(segments: Sequence[Segment], kind: type, z: float) -> Curves:
    """Segments of one kind at a height."""
    if len(by_kind(segments)[kind]) < len(segments):
        raise KernelError(f"a {kind.__name__} can stand only above its own kind: part the outlines alike")
    if kind is Line:
        ends = np.array([(s.start, s.end) for s in segments])
        return Lines(_raised(ends[:, 0], z), _raised(ends[:, 1], z))
    if kind is Bezier:
        poles = np.array([s.controls for s in segments if isinstance(s, Bezier)])
        return Splines(_raised(poles, z), BEZIER_KNOTS, 3)
    centre, radius, start, sweep = rounds(segments)
    x = np.column_stack([np.cos(start), np.sin(start), np.zeros(len(start))])
    y = np.cross(UP, x) * np.sign(sweep)[:, None]
    return Arcs(_raised(centre, z), x, y, radius, np.abs(sweep))


def _raised(points: Array, z: float) -> Array:
    return np.concatenate([points, np.full((*points.shape[:-1], 1), z)], axis=-1)


def _band(upper: CurveTable, lower: CurveTable, count: int) -> Band:
    """The walls between segments of the same kinds on two levels."""
    walls = [
        wall
        for over, under in zip(upper, lower, strict=True)
        for wall in _walls(over.rows, over.of, under.of)
    ]
    outward = np.ones(count, np.bool_)
    for wall in walls:
        outward[wall.rows] = wall.outward
    images = tuple(
        tuple(batch for wall in walls if wall.images for batch in wall.images[i]) for i in range(4)
    )
    surfaces = tuple(Batch(wall.rows, wall.surfaces) for wall in walls)
    return Band(surfaces, outward, images)


@dataclass(frozen=True, eq=False)
class _WallBatch:
    """Walls of one kind: on which segments, and as in `Band`."""

    rows: Indices
    surfaces: Surfaces
    images: Images | None = None
    outward: Mask | bool = True


def _walls(rows: Indices, upper: Curves, lower: Curves) -> list[_WallBatch]:
    match upper, lower:
        case Lines(), Lines():
            return [_WallBatch(rows, _flat(upper, lower))]
        case Splines(), Splines():
            surfaces = SplineSurfaces.ruled(upper.poles, lower.poles, BEZIER_KNOTS, 3)
            return [_WallBatch(rows, surfaces, box_images(rows))]
        case Arcs(), Arcs():
            return _round(rows, upper, lower)
        case _:
            raise AssertionError("segments of a stack are of one kind")


def _flat(upper: Lines, lower: Lines) -> Planes:
    """The planes through parallel lines; their normals point to the right of travel."""
    along = (upper.end - upper.start) / upper.length[:, None]
    normal = np.cross(along, upper.start - lower.start)
    return Planes(upper.start, normal / np.linalg.norm(normal, axis=1)[:, None], along)


def _round(rows: Indices, upper: Arcs, lower: Arcs) -> list[_WallBatch]:
    """Cylinders and cones between arcs that are concentric and of the same sweep, oblique ones between
    others."""
    apart = np.hypot(*(upper.centre - lower.centre)[:, :2].T)
    same = (apart <= SAME * upper.radius) & (np.abs(upper.sweep - lower.sweep) <= SAME)
    spans = spans_of(upper, lower)
    on = np.flatnonzero(same)
    found = [_cones(rows[on], upper[on], lower[on])] if len(on) else []
    for count in np.unique(spans[~same]).tolist():
        on = np.flatnonzero(~same & (spans == count))
        found.append(_WallBatch(rows[on], *oblique(upper[on], lower[on], count, rows[on])))
    return found


def _cones(rows: Indices, upper: Arcs, lower: Arcs) -> _WallBatch:
    """A cone's axis points to its wider end, as STEP asks (ISO 10303-42: 0 < semi-angle < 90°)."""
    wider = lower.radius - upper.radius
    drop = (upper.centre - lower.centre)[:, 2]
    ccw = upper.axis[:, 2] > 0
    cone = np.abs(wider) > SAME * upper.radius
    up = np.where(cone, wider <= 0, ccw)
    slant = np.where(cone, np.hypot(wider, drop), drop)
    fall = np.where(up, -slant, slant)
    turn = np.where(up == ccw, upper.sweep, -upper.sweep)  # the surface's angle against the arc's
    axis = UP * np.where(up, 1.0, -1.0)[:, None]
    angle = np.where(cone, np.arctan2(np.abs(wider), drop), 0.0)
    cones = Cones(upper.centre, axis, upper.x, upper.radius, angle)
    return _WallBatch(rows, cones, grid_images(rows, turn, fall), ccw)
