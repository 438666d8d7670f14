"""Charts of walls between faces of an imported solid: exact on plane pairs, by Newton and fitted
elsewhere."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, cast

import numpy as np
from OCP.BRepOffset import BRepOffset, BRepOffset_Status
from OCP.Geom import Geom_ElementarySurface, Geom_OffsetSurface, Geom_RectangularTrimmedSurface
from OCP.gp import gp_Trsf, gp_Vec

from perfqr_cad.geometry.arrays import Array
from perfqr_cad.geometry.outline import Segment
from perfqr_cad.hosts.frame import Frame
from perfqr_cad.hosts.host_placement import HostPlacement, Projected
from perfqr_cad.hosts.step.exact_face import ExactFace
from perfqr_cad.profile.loft import Level
from perfqr_cad.solid.charts.chart import Chart, Columns
from perfqr_cad.solid.charts.fitted import Projection, fitted_columns
from perfqr_cad.solid.charts.plane_chart import PlaneChart
from perfqr_cad.solid.kernel.modelled import ModelledSurfaces
from perfqr_cad.solid.tables.batches import Move, Surfaces
from perfqr_cad.solid.tables.brep import Batch
from perfqr_cad.surface import Plane

if TYPE_CHECKING:
    from OCP.Geom import Geom_Surface

LEVEL_MM = 1e-9  # the front is the frame's own plane
SQUARE = 1e-12  # 1 − cosine of the angle at which a plane counts as square to the axis


def chart_between(
    placement: HostPlacement, front: ExactFace, back: ExactFace | None, reach_mm: float
) -> Chart:
    """The chart of holes from one face to another, or (no `back`) to floors `reach_mm` below the front."""
    if (
        isinstance(placement, Projected)
        and float(np.abs(placement.heights_mm).max()) < LEVEL_MM
        and all(_square(s, placement) for s in (front, back) if s is not None)
    ):
        return PlanePairChart(placement.frame_at_centre, front, back, reach_mm)
    return FaceChart(placement, front, back, reach_mm)


@dataclass(frozen=True)
class PlanePairChart:
    """Two planes square to the axis: the flat plate's own exact curves and walls, moved into place."""

    frame: Frame
    front: ExactFace
    back: ExactFace | None
    thickness_mm: float
    whole_circles: bool = False

    @cached_property
    def _plate(self) -> PlaneChart:
        return PlaneChart(Plane(self.thickness_mm))

    @property
    def _move(self) -> Move:
        """From the plate's coordinates (front at z = thickness) to the solid's."""
        return Move(self.frame.origin - self.thickness_mm * self.frame.axes[2], self.frame.axes)

    def points(self, uv: Array, depth_mm: float) -> Array:
        return self.frame.to_space(np.column_stack([uv, np.full(len(uv), -depth_mm)]))

    def surface(self, depth_mm: float) -> Surfaces:
        if depth_mm == 0.0:
            return ModelledSurfaces((self.front.surface,))
        if self.back is not None and depth_mm == self.thickness_mm:
            return ModelledSurfaces((self.back.surface,))
        return self._move.surfaces(self._plate.surface(depth_mm))

    def towards_reader(self, depth_mm: float) -> bool:
        if depth_mm == 0.0:
            return self.front.outward_sign > 0
        return self.back is None or depth_mm != self.thickness_mm or self.back.outward_sign < 0

    def columns(self, stacks: Sequence[tuple[Segment, ...]], levels: tuple[Level, ...]) -> Columns:
        plain, move = self._plate.columns(stacks, levels), self._move
        return Columns(
            tuple(
                replace(traces, curves=tuple(Batch(b.rows, move.curves(b.of)) for b in traces.curves))
                for traces in plain.traces
            ),
            tuple(
                replace(band, surfaces=tuple(Batch(b.rows, move.surfaces(b.of)) for b in band.surfaces))
                for band in plain.bands
            ),
        )


@dataclass(frozen=True)
class FaceChart:
    """Any two faces: outlines are met with the exact surfaces by Newton's iteration, then fitted."""

    placement: HostPlacement
    front: ExactFace
    back: ExactFace | None
    thickness_mm: float
    whole_circles: bool = False
    _between: dict[float, Geom_Surface] = field(default_factory=dict, repr=False)
    _met: dict[tuple[float, bytes], tuple[Array, Array]] = field(default_factory=dict, repr=False)

    @property
    def projection(self) -> Projection | None:
        """The projection's direction; a wrap has none."""
        if not isinstance(self.placement, Projected):
            return None
        return Projection(self.placement.frame_at_centre.origin, self.placement.frame_at_centre.axes)

    def points(self, uv: Array, depth_mm: float) -> Array:
        return self._meet(uv, depth_mm)[1]

    def parameters(self, uv: Array, depth_mm: float) -> Array:
        return self._meet(uv, depth_mm)[0]

    def surface(self, depth_mm: float) -> Surfaces:
        return ModelledSurfaces((self._surface(depth_mm),))

    def _surface(self, depth_mm: float) -> Geom_Surface:
        if depth_mm == 0.0:
            return self.front.surface
        if self._on_back(depth_mm) and self.back is not None:
            return self.back.surface
        if depth_mm not in self._between:
            self._between[depth_mm] = self._sunk(depth_mm)
        return self._between[depth_mm]

    def towards_reader(self, depth_mm: float) -> bool:
        if self._on_back(depth_mm) and self.back is not None:
            return self.back.outward_sign < 0
        return self.front.outward_sign > 0

    def columns(self, stacks: Sequence[tuple[Segment, ...]], levels: tuple[Level, ...]) -> Columns:
        return fitted_columns(stacks, levels, self)

    def _on_back(self, depth_mm: float) -> bool:
        return self.back is not None and depth_mm >= self.thickness_mm

    def _sunk(self, depth_mm: float) -> Geom_Surface:
        """The front moved inwards: along the axis of a projection, along its own normals under a wrap; its
        parameters stay. Cylinders, cones, spheres and tori become such of another radius."""
        if isinstance(self.placement, Projected):
            x, y, z = (-depth_mm * self.placement.frame_at_centre.axes[2]).tolist()
            shift = gp_Trsf()
            shift.SetTranslation(gp_Vec(x, y, z))
            return cast("Geom_Surface", self.front.surface.Transformed(shift))
        offset = -depth_mm * self.front.outward_sign
        if isinstance(self.front.surface, Geom_ElementarySurface):
            return BRepOffset.Surface_s(self.front.surface, offset, BRepOffset_Status.BRepOffset_Good)
        finite = Geom_RectangularTrimmedSurface(self.front.surface, *self.front.bounds)  # writers ask for it
        return Geom_OffsetSurface(finite, offset)

    def _meet(self, uv: Array, depth_mm: float) -> tuple[Array, Array]:
        """Parameters and points of a level at pattern points; asked for twice, hence kept."""
        key = (depth_mm, np.ascontiguousarray(uv).tobytes())
        if key not in self._met:
            self._met[key] = self._found(uv, depth_mm)
        return self._met[key]

    def _found(self, uv: Array, depth_mm: float) -> tuple[Array, Array]:
        lines, frames = self.placement.line(uv)
        reach = self.placement.thickness_mm
        if self._on_back(depth_mm) and self.back is not None:
            return self.back.meet(lines, frames, self.placement.at_depth(uv, reach), reach)
        images, points = self.front.meet(lines, frames, lines, reach)
        if depth_mm == 0.0:
            return images, points
        inward = -frames[:, 2]
        if not isinstance(self.placement, Projected):
            inward = -self.front.normals(images)
        return images, points + depth_mm * inward


def _square(face: ExactFace, placement: Projected) -> bool:
    """Whether a face is a plane square to the projection's axis."""
    if not face.is_plane:
        return False
    u0, u1, v0, v1 = face.bounds
    (normal,) = face.normals(np.array([[(u0 + u1) / 2, (v0 + v1) / 2]]))
    return 1 - abs(float(normal @ placement.frame_at_centre.axes[2])) < SQUARE
