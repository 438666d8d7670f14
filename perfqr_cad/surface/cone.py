"""A band of a cone, such as a cup: the code is laid on the unrolled cone, arc lengths kept."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from perfqr_cad.errors import DesignError
from perfqr_cad.geometry.arrays import Array
from perfqr_cad.surface.placement import Placement, pairs, positive, thinner


@dataclass(frozen=True)
class Cone(Placement):
    """Outer wall of a cone about the y axis; the centre of the code is at (0, 0, radius), the reader at +z.

    half_angle_deg  between axis and wall; above 0 the cone narrows upwards, below 0 downwards
    The unrolled cone is flat, and the code is laid on it flat: the wrap is an isometry of the front surface.
    """

    radius_mm: float
    half_angle_deg: float
    thickness_mm: float

    def __post_init__(self) -> None:
        positive("radius_mm", self.radius_mm)
        positive("thickness_mm", self.thickness_mm)
        if not 0.1 <= abs(self.half_angle_deg) <= 80:
            raise DesignError(
                f"a cone of half-angle {self.half_angle_deg:g}° is outside 0.1° to 80°: "
                "take a cylinder or a plate"
            )
        thinner("cone", self.thickness_mm, self.radius_mm * math.cos(self.half_angle_rad))

    @property
    def half_angle_rad(self) -> float:
        """Always positive; `upward` says which way the cone narrows."""
        return math.radians(abs(self.half_angle_deg))

    @property
    def upward(self) -> float:
        """+1 where the cone narrows upwards, −1 downwards."""
        return math.copysign(1.0, self.half_angle_deg)

    @property
    def slant_mm(self) -> float:
        """Distance of the code's centre from the apex, along the wall."""
        return self.radius_mm / math.sin(self.half_angle_rad)

    def at_depth(self, uv: ArrayLike, depth_mm: ArrayLike) -> Array:
        slant, angle = self._unrolled(uv)
        depth = np.asarray(depth_mm, dtype=np.float64)
        sin, cos = math.sin(self.half_angle_rad), math.cos(self.half_angle_rad)
        radius = slant * sin - depth * cos
        height = self.upward * ((self.slant_mm - slant) * cos - depth * sin)
        return np.column_stack([radius * np.sin(angle), height, radius * np.cos(angle)])

    def normal(self, uv: ArrayLike) -> Array:
        _, angle = self._unrolled(uv)
        sin, cos = math.sin(self.half_angle_rad), math.cos(self.half_angle_rad)
        return np.column_stack(
            [cos * np.sin(angle), np.full_like(angle, self.upward * sin), cos * np.cos(angle)]
        )

    def reach_mm(self) -> float:
        """Short of the apex, of the inner wall's apex, and of a full turn."""
        to_apex = self.slant_mm - self.thickness_mm / math.tan(self.half_angle_rad)
        opening = math.pi * math.sin(self.half_angle_rad)
        if opening >= math.pi / 2:
            return to_apex
        side = math.tan(opening)  # the corners nearest the apex meet behind the cone
        return min(to_apex, self.slant_mm * side / (1 + side))

    def _unrolled(self, uv: ArrayLike) -> tuple[Array, Array]:
        """Distance from the apex along the wall and angle about the axis, (k,) each."""
        at = pairs(uv)
        down = self.slant_mm - self.upward * at[:, 1]
        return np.hypot(at[:, 0], down), np.arctan2(at[:, 0], down) / math.sin(self.half_angle_rad)
