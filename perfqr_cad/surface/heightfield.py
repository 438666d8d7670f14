"""A free-form wall z(x, y): the code is projected on it along −z, as the reader sees it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from perfqr_cad.errors import DesignError
from perfqr_cad.geometry.arrays import Array
from perfqr_cad.geometry.spline import TensorSpline, tensor
from perfqr_cad.surface.placement import Placement, pairs, positive


@dataclass(frozen=True)
class HeightField(Placement):
    """A bicubic B-spline front over a square, and a back `thickness_mm` behind it, measured along the normal.

    Holes run along z, so that a reader in front looks straight through them.

    heights  B-spline of z in mm over the square |x|, |y| ≤ half_mm; see `HeightField.of`

    >>> wave = HeightField.of(lambda x, y: 2.0 + x / 10, half_mm=20, thickness_mm=1.6)
    >>> wave.point([(5, 0)]).round(9).tolist()
    [[5.0, 0.0, 2.5]]
    """

    heights: TensorSpline
    half_mm: float
    thickness_mm: float

    def __post_init__(self) -> None:
        positive("half_mm", self.half_mm)
        positive("thickness_mm", self.thickness_mm)

    @staticmethod
    def of(
        height: Callable[[Array, Array], Array], half_mm: float, thickness_mm: float, samples: int = 33
    ) -> HeightField:
        """The spline through `height(x, y)` on a square grid of `samples` points a side. x and y are (k,
        m)."""
        if samples < 4:
            raise DesignError(f"a grid of {samples} points a side makes no smooth surface: give at least 4")
        line = np.linspace(-half_mm, half_mm, samples)
        x, y = np.meshgrid(line, line, indexing="ij")
        values = np.broadcast_to(np.asarray(height(x, y), dtype=np.float64), x.shape)
        if not np.isfinite(values).all():
            raise DesignError("the height field is not finite everywhere on its square: shrink the square")
        return HeightField(tensor(line, line, values[..., None]), half_mm, thickness_mm)

    def at_depth(self, uv: ArrayLike, depth_mm: ArrayLike) -> Array:
        at = pairs(uv)
        drop = np.asarray(depth_mm, dtype=np.float64) / self.normal(at)[:, 2]
        return np.column_stack([at, self.heights(at)[:, 0] - drop])

    def normal(self, uv: ArrayLike) -> Array:
        at = pairs(uv)
        slopes = [self.heights(at, d)[:, 0] for d in ((1, 0), (0, 1))]
        normal = np.column_stack([-slopes[0], -slopes[1], np.ones(len(at))])
        return normal / np.linalg.norm(normal, axis=1)[:, None]

    def tangents(self, at: Array, depth_mm: ArrayLike = 0.0) -> tuple[Array, Array]:
        zu, zv, zuu, zuv, zvv = (self.heights(at, d)[:, 0] for d in ((1, 0), (0, 1), (2, 0), (1, 1), (0, 2)))
        steeper = np.asarray(depth_mm, dtype=np.float64) / np.sqrt(1 + zu * zu + zv * zv)
        along_u = np.column_stack([np.ones(len(at)), np.zeros(len(at)), zu - steeper * (zu * zuu + zv * zuv)])
        along_v = np.column_stack([np.zeros(len(at)), np.ones(len(at)), zv - steeper * (zu * zuv + zv * zvv)])
        return along_u, along_v

    def bend_radius_mm(self, at: Array) -> float:
        """Infinite: the back is a height field as well, and cannot fold."""
        return math.inf

    def reach_mm(self) -> float:
        return self.half_mm
