"""A band of a cylinder: the code is wrapped around it, arc lengths kept."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from .placement import Array, Placement, pairs, positive, thinner


@dataclass(frozen=True)
class Cylinder(Placement):
    """Outer wall of a tube about the y axis; the centre of the code is at (0, 0, radius), the reader at +z.

    u runs around the tube (u = radius · angle), v along it: the wrap is an isometry of the front surface.
    """

    radius_mm: float
    thickness_mm: float

    def __post_init__(self) -> None:
        positive("radius_mm", self.radius_mm)
        positive("thickness_mm", self.thickness_mm)
        thinner("cylinder", self.thickness_mm, self.radius_mm)

    def angle(self, uv: ArrayLike) -> Array:
        """Angle about the axis from the code's centre, rad, (k,)."""
        return pairs(uv)[:, 0] / self.radius_mm

    def at_depth(self, uv: ArrayLike, depth_mm: ArrayLike) -> Array:
        at = pairs(uv)
        radius = self.radius_mm - np.asarray(depth_mm, dtype=np.float64)
        angle = self.angle(at)
        return np.column_stack([radius * np.sin(angle), at[:, 1], radius * np.cos(angle)])

    def normal(self, uv: ArrayLike) -> Array:
        angle = self.angle(uv)
        return np.column_stack([np.sin(angle), np.zeros_like(angle), np.cos(angle)])

    def reach_mm(self) -> float:
        return math.pi * self.radius_mm
