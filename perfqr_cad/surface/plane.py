"""A flat plate: back face z = 0, front (reader's) face z = thickness."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from perfqr_cad.geometry.arrays import Array
from perfqr_cad.surface.placement import Placement, pairs, positive


@dataclass(frozen=True)
class Plane(Placement):
    """The plate of the pattern plane itself; the reader looks along −z.

    >>> Plane(2.0).at_depth([(3, 4)], 0.5).tolist()
    [[3.0, 4.0, 1.5]]
    """

    thickness_mm: float

    def __post_init__(self) -> None:
        positive("thickness_mm", self.thickness_mm)

    @property
    def is_flat(self) -> bool:
        return True

    def at_depth(self, uv: ArrayLike, depth_mm: ArrayLike) -> Array:
        at = pairs(uv)
        height = np.broadcast_to(self.thickness_mm - np.asarray(depth_mm, dtype=np.float64), len(at))
        return np.column_stack([at, height])

    def normal(self, uv: ArrayLike) -> Array:
        return np.tile([0.0, 0.0, 1.0], (len(pairs(uv)), 1))

    def tangents(self, at: Array, depth_mm: ArrayLike = 0.0) -> tuple[Array, Array]:
        return np.tile([1.0, 0.0, 0.0], (len(at), 1)), np.tile([0.0, 1.0, 0.0], (len(at), 1))

    def reach_mm(self) -> float:
        return math.inf


@dataclass(frozen=True)
class TurnedPlane(Plane):
    """The same plate turned over about the y axis: the reader looks along +z at the face z = 0, and the face
    z = thickness shows the code mirrored."""

    @property
    def is_turned(self) -> bool:
        return True

    def at_depth(self, uv: ArrayLike, depth_mm: ArrayLike) -> Array:
        return super().at_depth(uv, depth_mm) * (-1.0, 1.0, -1.0) + (0.0, 0.0, self.thickness_mm)

    def normal(self, uv: ArrayLike) -> Array:
        return -super().normal(uv)

    def tangents(self, at: Array, depth_mm: ArrayLike = 0.0) -> tuple[Array, Array]:
        along_u, along_v = super().tangents(at, depth_mm)
        return -along_u, along_v
