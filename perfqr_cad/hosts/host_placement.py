"""How a code lies on a given face: projected along one axis, or wrapped along the face's own normals."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from perfqr_cad.geometry.arrays import Array
from perfqr_cad.geometry.spline import TensorSpline, tensor
from perfqr_cad.hosts.frame import Frame
from perfqr_cad.surface import Distortion, Placement
from perfqr_cad.surface.placement import pairs

GRID = 65  # samples a side of a projection's height field
MARGIN = 1.02  # the field reaches a little beyond the code, for derivatives on its rim
INVERSE_SEEDS = 33  # a side
INVERSE_STEPS = 20  # fixed-point steps towards the foot of a point on the front


@dataclass(frozen=True)
class HostPlacement(Placement):
    """A code on a face that is not ours: every pattern point is a straight line through the wall.

    `line` gives the lines the holes follow; the exact faces are met along them.
    """

    frame_at_centre: Frame

    @abstractmethod
    def line(self, uv: ArrayLike) -> tuple[Array, Array]:
        """Points (k, 3) on or near the front, and frames (k, 3, 3) whose third rows are the hole's axis."""

    def pattern_points(self, points: Array) -> Array:
        """Pattern points (k, 2) of points (k, 3) near the wall; NaN for those far outside the code."""
        from scipy.spatial import cKDTree

        line = np.linspace(-self.reach_mm(), self.reach_mm(), INVERSE_SEEDS)
        grid = np.stack(np.meshgrid(line, line), axis=-1).reshape(-1, 2)
        distance, nearest = cKDTree(self.point(grid)).query(points)
        uv = grid[nearest]
        for _ in range(INVERSE_STEPS):
            on_front, frames = self.line(uv)
            uv = np.clip(uv + np.einsum("kij,kj->ki", frames[:, :2], points - on_front), line[0], line[-1])
        far = distance > self.thickness_mm + 4 * (line[1] - line[0])
        return np.where(far[:, None], np.nan, uv)


@dataclass(frozen=True)
class Projected(HostPlacement):
    """The paper's way (§5.2): the code is projected onto the face along the normal at its centre.

    `heights_mm` (k, k) of the front above the tangent plane, on a square grid of edge `span_mm` (rows up,
    columns right). The holes run along the axis, so the reader before the centre sees the code undistorted.
    """

    span_mm: float
    heights_mm: Array = field(repr=False)
    thickness_mm: float

    @cached_property
    def _height(self) -> TensorSpline:
        return _spline(self.heights_mm[..., None], self.span_mm)

    @property
    def is_flat(self) -> bool:
        return bool(np.ptp(self.heights_mm) < 1e-9 * self.span_mm)

    def at_depth(self, uv: ArrayLike, depth_mm: ArrayLike) -> Array:
        at = pairs(uv)
        height = self._height(at)[:, 0] - np.asarray(depth_mm, float)
        return self.frame_at_centre.to_space(np.column_stack([at, height]))

    def normal(self, uv: ArrayLike) -> Array:
        at = pairs(uv)
        slopes = [self._height(at, order)[:, 0] for order in ((1, 0), (0, 1))]
        normal = np.column_stack([-slopes[0], -slopes[1], np.ones(len(at))])
        return normal / np.linalg.norm(normal, axis=1)[:, None] @ self.frame_at_centre.axes

    def reader_axes(self) -> Array:
        return self.frame_at_centre.axes

    def reach_mm(self) -> float:
        return self.span_mm / 2

    def line(self, uv: ArrayLike) -> tuple[Array, Array]:
        points = self.point(uv)
        return points, np.broadcast_to(self.frame_at_centre.axes, (len(points), 3, 3))

    def distortion(self, size_mm: float) -> Distortion:
        """As the reader before the centre sees it: a projection keeps area and angle, only the tilt
        counts."""
        on_the_face = super().distortion(size_mm)
        return Distortion(0.0, 0.0, on_the_face.tilt_worst_deg)


@dataclass(frozen=True)
class Wrapped(HostPlacement):
    """Geodesic wrap: lengths and directions from the centre are kept; isometric where the face unrolls.

    `points_mm` (k, k, 3) of the front on a square grid of edge `span_mm` (rows up, columns right). The holes
    run along the face's normals.
    """

    span_mm: float
    points_mm: Array = field(repr=False)
    thickness_mm: float

    @cached_property
    def _front(self) -> TensorSpline:
        return _spline(self.points_mm, self.span_mm)

    def at_depth(self, uv: ArrayLike, depth_mm: ArrayLike) -> Array:
        at = pairs(uv)
        depth = np.broadcast_to(np.asarray(depth_mm, float), len(at))
        if not depth.any():
            return self._front(at)
        return self._front(at) - depth[:, None] * self.normal(at)

    def normal(self, uv: ArrayLike) -> Array:
        return self.frame(uv)[:, 2]

    def frame(self, uv: ArrayLike) -> Array:
        along_u, along_v = self.tangents(pairs(uv))
        normal = _unit(np.cross(along_u, along_v))
        e1 = _unit(along_u)
        return np.stack([e1, np.cross(normal, e1), normal], axis=1)

    def tangents(self, at: Array, depth_mm: ArrayLike = 0.0) -> tuple[Array, Array]:
        if np.any(depth_mm):
            return super().tangents(at, depth_mm)
        return self._front(at, (1, 0)), self._front(at, (0, 1))

    def reach_mm(self) -> float:
        return self.span_mm / 2

    def line(self, uv: ArrayLike) -> tuple[Array, Array]:
        at = pairs(uv)
        return self._front(at), self.frame(at)


def _spline(values: Array, span_mm: float) -> TensorSpline:
    """The bicubic through values (k, k, d) on a square grid, rows up, columns right; x comes first in it."""
    line = np.linspace(-span_mm / 2, span_mm / 2, len(values))
    return tensor(line, line, np.swapaxes(values, 0, 1))


def _unit(vectors: Array) -> Array:
    return vectors / np.linalg.norm(vectors, axis=1)[:, None]
