"""Walls of revolution about the y axis: cylinder, sphere, any meridian.

The centre of the code is on the +z side; the reader stands at +z. u runs around the axis at the angle u / r₀,
with r₀ the front's radius at the code's centre; v runs along the meridian by arc length. Lines of the
pattern's grid become circles and meridians, and the normals along them planes and cones: walls are exact.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from perfqr_cad.errors import DesignError
from perfqr_cad.geometry.arrays import Array
from perfqr_cad.geometry.spline import Spline, interpolated
from perfqr_cad.surface.placement import Placement, pairs, positive, thinner

FINE = 257  # points along a profile where its wall is looked at


class Revolved(Placement):
    """A meridian turned about the y axis."""

    @property
    @abstractmethod
    def centre_radius_mm(self) -> float:
        """Radius r₀ of the front at v = 0."""

    @abstractmethod
    def meridian(self, v: Array) -> Array:
        """(k, 2) radius and height of the front's meridian at v."""

    @abstractmethod
    def meridian_normal(self, v: Array) -> Array:
        """(k, 2) unit normals of the meridian, away from the axis."""

    def angle(self, uv: ArrayLike) -> Array:
        """Angle about the axis from the code's centre, rad, (k,)."""
        return pairs(uv)[:, 0] / self.centre_radius_mm

    def meridian_at(self, v: Array, depth_mm: ArrayLike) -> Array:
        """(k, 2) radius and height at a depth behind the front."""
        depth = np.broadcast_to(np.asarray(depth_mm, dtype=np.float64), len(v))
        return self.meridian(v) - depth[:, None] * self.meridian_normal(v)

    def at_depth(self, uv: ArrayLike, depth_mm: ArrayLike) -> Array:
        at = pairs(uv)
        angle, meridian = self.angle(at), self.meridian_at(at[:, 1], depth_mm)
        return np.column_stack(
            [meridian[:, 0] * np.sin(angle), meridian[:, 1], meridian[:, 0] * np.cos(angle)]
        )

    def normal(self, uv: ArrayLike) -> Array:
        at = pairs(uv)
        angle, normal = self.angle(at), self.meridian_normal(at[:, 1])
        return np.column_stack([normal[:, 0] * np.sin(angle), normal[:, 1], normal[:, 0] * np.cos(angle)])


@dataclass(frozen=True)
class Cylinder(Revolved):
    """Outer wall of a tube; the wrap is an isometry of the front surface.

    >>> Cylinder(30.0, 2.0).point([(0, 5)]).tolist(), round(Cylinder(30.0, 2.0).largest_size_mm(), 1)
    ([[0.0, 5.0, 30.0]], 52.3)
    """

    radius_mm: float
    thickness_mm: float

    def __post_init__(self) -> None:
        positive("radius_mm", self.radius_mm)
        positive("thickness_mm", self.thickness_mm)
        thinner("cylinder", self.thickness_mm, self.radius_mm)

    @property
    def centre_radius_mm(self) -> float:
        return self.radius_mm

    def meridian(self, v: Array) -> Array:
        return np.column_stack([np.full_like(v, self.radius_mm), v])

    def meridian_normal(self, v: Array) -> Array:
        return np.tile([1.0, 0.0], (len(v), 1))

    def reach_mm(self) -> float:
        return math.pi * self.radius_mm


@dataclass(frozen=True)
class Sphere(Revolved):
    """Outer wall of a spherical shell; u and v are longitude and latitude, as arc lengths at the centre."""

    radius_mm: float
    thickness_mm: float

    def __post_init__(self) -> None:
        positive("radius_mm", self.radius_mm)
        positive("thickness_mm", self.thickness_mm)
        thinner("sphere", self.thickness_mm, self.radius_mm)

    @property
    def centre_radius_mm(self) -> float:
        return self.radius_mm

    def meridian(self, v: Array) -> Array:
        return self.radius_mm * self.meridian_normal(v)

    def meridian_normal(self, v: Array) -> Array:
        return np.column_stack([np.cos(v / self.radius_mm), np.sin(v / self.radius_mm)])

    def reach_mm(self) -> float:
        """Short of the poles, where all longitudes meet."""
        return math.pi / 2 * self.radius_mm * (1 - 1e-6)


@dataclass(frozen=True)
class Revolution(Revolved):
    """Outer wall of a turned body, such as a vase.

    profile    (radius, height) points in mm, upwards, at least 4; a cubic spline runs through them
    height_mm  where on the profile the centre of the code lies

    >>> vase = Revolution(((20, 0), (24, 20), (26, 40), (22, 60)), height_mm=30, thickness_mm=1.5)
    >>> 24 < vase.centre_radius_mm < 26
    True
    """

    profile: tuple[tuple[float, float], ...]
    height_mm: float
    thickness_mm: float

    def __post_init__(self) -> None:
        positive("thickness_mm", self.thickness_mm)
        points = np.array(self.profile, dtype=np.float64).reshape(-1, 2)
        if len(points) < 4:
            raise DesignError(f"a profile of {len(points)} points makes no smooth meridian: give at least 4")
        if not (np.isfinite(points).all() and (np.diff(points[:, 1]) > 0).all()):
            raise DesignError(
                "the heights of a profile must rise from point to point: sort them, drop equal ones"
            )
        low, high = points[0, 1], points[-1, 1]
        if not low < self.height_mm < high:
            raise DesignError(
                f"height {self.height_mm:g} mm is off the profile: choose one in {low:g} to {high:g} mm"
            )
        if (least := float(self._along(np.linspace(*self.span, FINE))[:, 0].min())) <= self.thickness_mm:
            thinner("surface of revolution", self.thickness_mm, max(least, 0.0))
        along = np.linspace(*self.span, FINE)
        self.require_unfolded(np.column_stack([np.zeros(FINE), along]))

    @cached_property
    def centre_radius_mm(self) -> float:  # type: ignore[override]  # a property, kept
        return float(self.meridian(np.zeros(1))[0, 0])

    @cached_property
    def spline(self) -> Spline:
        """Radius and height over arc length from the first point."""
        points = np.array(self.profile, dtype=np.float64)
        length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
        # The chords give a first parameter; lengths measured on that curve give one that is arc length
        # to about 1e-4, which is what the distortion report then shows.
        for _ in range(2):
            fine = np.linspace(length[0], length[-1], 64 * len(points) + 1)
            curve = interpolated(length, points)
            steps = np.linalg.norm(np.diff(curve(fine), axis=0), axis=1)
            length = np.interp(length, fine, np.concatenate([[0.0], np.cumsum(steps)]))
        return interpolated(length, points)

    @cached_property
    def centre_length_mm(self) -> float:
        """Arc length from the first profile point to the code's centre."""
        low, high = self.spline.domain
        while high - low > 1e-12 * (1 + abs(high)):
            middle = (low + high) / 2
            below = self.spline(np.array([middle]))[0, 1] < self.height_mm
            low, high = (middle, high) if below else (low, middle)
        return (low + high) / 2

    @property
    def span(self) -> tuple[float, float]:
        """Least and greatest v, mm."""
        low, high = self.spline.domain
        return low - self.centre_length_mm, high - self.centre_length_mm

    def _along(self, v: Array) -> Array:
        return self.spline(v + self.centre_length_mm)

    def meridian(self, v: Array) -> Array:
        return self._along(v) - (0.0, self.height_mm)

    def meridian_normal(self, v: Array) -> Array:
        slope = self.spline(v + self.centre_length_mm, 1)
        normal = np.column_stack([slope[:, 1], -slope[:, 0]])
        return normal / np.linalg.norm(normal, axis=1)[:, None]

    def reach_mm(self) -> float:
        low, high = self.span
        return min(-low, high, math.pi * self.centre_radius_mm)
