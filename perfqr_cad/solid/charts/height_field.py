"""The chart of a free-form wall of even thickness."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from perfqr_cad.geometry.arrays import Array
from perfqr_cad.geometry.outline import Segment
from perfqr_cad.geometry.spline import DEGREE, greville
from perfqr_cad.profile.loft import Level
from perfqr_cad.solid.charts.chart import Columns, WallChart
from perfqr_cad.solid.charts.fitted import Projection, fitted_columns
from perfqr_cad.solid.charts.offset_fit import fitted_heights
from perfqr_cad.solid.kernel.modelled import ModelledSurfaces
from perfqr_cad.solid.kernel.occ import spline_surface
from perfqr_cad.solid.tables.batches import Surfaces
from perfqr_cad.surface import HeightField


@dataclass(frozen=True, eq=False)
class HeightFieldChart(WallChart[HeightField]):
    """A code projected on z(x, y): lines stand in planes, arcs in cylinders. Surface parameters are x and
    y."""

    whole_circles: bool = False

    @property
    def projection(self) -> Projection:
        return Projection(np.zeros(3), np.eye(3))

    def parameters(self, uv: Array, depth_mm: float) -> Array:
        return uv

    @lru_cache(maxsize=16)  # noqa: B019 - a chart lives as long as one build
    def surface(self, depth_mm: float) -> Surfaces:
        heights = self.wall.heights if depth_mm == 0 else fitted_heights(self.wall, depth_mm)
        x, y = greville(heights.u_knots), greville(heights.v_knots)
        grid = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1)
        poles = np.concatenate([grid, heights.poles], axis=-1)
        return ModelledSurfaces((spline_surface(poles, heights.u_knots, heights.v_knots, (DEGREE, DEGREE)),))

    def columns(self, stacks: Sequence[tuple[Segment, ...]], levels: tuple[Level, ...]) -> Columns:
        return fitted_columns(stacks, levels, self)
