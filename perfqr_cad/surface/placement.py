"""Where a pattern lies: a map from the pattern plane onto the reader's side of a wall of material.

Pattern coordinates (u, v) are mm, origin at the centre of the code, u right and v up as the reader sees it.
A placement never mirrors: ∂p/∂u × ∂p/∂v points towards the reader.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from perfqr_cad.errors import DesignError
from perfqr_cad.geometry.arrays import Array

# Central differences on lengths in mm: the truncation (h²) and rounding (1e-16 / h) errors meet near here.
STEP_MM = 1e-4
# The distortion is sampled on this many points a side, edges and corners of the code included.
SAMPLES = 33
UNBENT = 1e-6  # share of its length that a tangent loses through the wall: rounding of the differences


@dataclass(frozen=True)
class DistortionLimit:
    """How far a surface may bend a code.

    area       |true area of a module / nominal − 1|. Decoders fit one grid to the whole code (ISO/IEC 18004
               §12 takes the module size from the finders), so a module may not stray by half its pitch over
               the code.
    shear_deg  departure of a module's corners from a right angle.
    tilt_deg   angle between the surface and the reader's axis: a flat print is read at up to 50°, not beyond
               (measured on eight codes of version 8).
    """

    area: float = 0.25
    shear_deg: float = 15.0
    tilt_deg: float = 50.0


@dataclass(frozen=True)
class Distortion:
    """What a placement does to the modules of a code, at the worst places of its square; see
    `DistortionLimit`."""

    area_worst: float
    shear_worst_deg: float
    tilt_worst_deg: float

    def within(self, limit: DistortionLimit) -> bool:
        """Whether every figure keeps the limit."""
        return (
            self.area_worst <= limit.area
            and self.shear_worst_deg <= limit.shear_deg
            and self.tilt_worst_deg <= limit.tilt_deg
        )


class Placement(ABC):
    """A wall of material and the map of the pattern plane onto its front (reader's) side."""

    thickness_mm: float

    @property
    def is_flat(self) -> bool:
        """Whether the front is a plane and the map an isometry of it."""
        return False

    @property
    def is_turned(self) -> bool:
        """Whether the reader looks at the plate from below, so that its upper face is mirrored."""
        return False

    @abstractmethod
    def at_depth(self, uv: ArrayLike, depth_mm: ArrayLike) -> Array:
        """Points (k, 3) that lie `depth_mm` behind the front at (k, 2) pattern points; the depth may vary."""

    @abstractmethod
    def normal(self, uv: ArrayLike) -> Array:
        """Unit normals (k, 3) of the front surface, towards the reader."""

    @abstractmethod
    def reach_mm(self) -> float:
        """Half the edge of the largest square about the centre that the map covers; may be infinite."""

    def point(self, uv: ArrayLike) -> Array:
        """Points (k, 3) of the front surface."""
        return self.at_depth(uv, 0.0)

    def frame(self, uv: ArrayLike) -> Array:
        """Orthonormal frames (k, 3, 3) of the front surface, rows e1, e2, n; e1 follows ∂p/∂u."""
        at = pairs(uv)
        normal = self.normal(at)
        along_u, _ = self.tangents(at)
        along_u -= np.einsum("ki,ki->k", along_u, normal)[:, None] * normal
        along_u /= np.linalg.norm(along_u, axis=1)[:, None]
        return np.asarray(np.stack([along_u, np.cross(normal, along_u), normal], axis=1), np.float64)

    def reader_axes(self) -> Array:
        """Axes (3, 3) of the reader straight before the code: rows right, up, and towards the reader.

        The surface's own at the code's centre, unless the code is projected along another direction.
        """
        return self.frame((0.0, 0.0))[0]

    def volume_density(self, uv: ArrayLike, depth_mm: ArrayLike) -> Array:
        """Material volume per pattern area and depth, (k,): the Jacobian of `at_depth`."""
        at = pairs(uv)
        depth = np.broadcast_to(np.asarray(depth_mm, dtype=np.float64), len(at))
        down = (self.at_depth(at, depth + STEP_MM) - self.at_depth(at, depth - STEP_MM)) / (2 * STEP_MM)
        return -np.einsum("ki,ki->k", np.cross(*self.tangents(at, depth)), down)

    def bend_radius_mm(self, at: Array) -> float:
        """Least radius to which the front is bent towards its back at (k, 2) pattern points; may be infinite.

        The tangents shrink behind the front by 1 − depth / radius along the directions of curvature.
        """
        front, back = (np.stack(self.tangents(at, d), axis=1) for d in (0.0, self.thickness_mm))
        shrunk = np.linalg.solve(front @ front.swapaxes(1, 2), front @ back.swapaxes(1, 2))
        middle = (shrunk[:, 0, 0] + shrunk[:, 1, 1]) / 2
        spread = np.sqrt(np.maximum(middle**2 - np.linalg.det(shrunk), 0.0))
        lost = 1.0 - float((middle - spread).min())
        return self.thickness_mm / lost if lost > UNBENT else math.inf

    def require_unfolded(self, at: Array) -> None:
        """Raises `DesignError` where the wall is as thick as the radius it is bent to: its back folds."""
        if self.thickness_mm >= (radius := self.bend_radius_mm(at)):
            raise DesignError(
                f"a wall of {self.thickness_mm:g} mm folds over itself where the surface is bent to a radius "
                f"of {radius:.3g} mm: take a thickness below that, or a smoother surface"
            )

    def distortion(self, size_mm: float) -> Distortion:
        """What happens to the modules of a code of this edge. Raises `DesignError` when it does not fit at
        all."""
        half = size_mm / 2
        if half > self.reach_mm():
            raise DesignError(
                f"a code of {size_mm:.4g} mm does not fit this surface",
                f"at most {_floored(2 * self.reach_mm()):.10g} mm",
            )
        grid = square(half)
        along_u, along_v = self.tangents(grid)
        lengths = np.linalg.norm(along_u, axis=1) * np.linalg.norm(along_v, axis=1)
        area = np.abs(np.linalg.norm(np.cross(along_u, along_v), axis=1) - 1)
        sine = np.einsum("ki,ki->k", along_u, along_v) / lengths
        shear = np.degrees(np.abs(np.arcsin(np.clip(sine, -1, 1))))
        tilt = np.degrees(np.arccos(np.clip(self.normal(grid) @ self.reader_axes()[2], -1, 1)))
        return Distortion(float(area.max()), float(shear.max()), float(tilt.max()))

    def largest_size_mm(self, limit: DistortionLimit | None = None) -> float:
        """Edge of the largest code that keeps the limit, to 0.1 % and never above; may be infinite."""
        limit = limit or DistortionLimit()
        high = 2 * self.reach_mm()
        if math.isinf(high):
            if self.is_flat:
                return high
            raise ValueError("a curved surface has a finite reach")
        if self.distortion(high).within(limit):
            return high
        low = 0.0
        while high - low > 1e-3 * high:
            middle = (low + high) / 2
            low, high = (middle, high) if self.distortion(middle).within(limit) else (low, middle)
        return low

    def check(self, size_mm: float, limit: DistortionLimit | None = None) -> Distortion:
        """The distortion of a code of this edge. Raises `DesignError`, naming the largest size that works,
        or where the wall folds."""
        limit = limit or DistortionLimit()
        found = self.distortion(size_mm)
        self.require_unfolded(square(size_mm / 2))
        if not found.within(limit):
            raise DesignError(
                f"a code of {size_mm:.4g} mm is bent too much by this surface: module area off by "
                f"{found.area_worst:.0%} (limit {limit.area:.0%}), shear {found.shear_worst_deg:.0f}° "
                f"({limit.shear_deg:.0f}°), tilt {found.tilt_worst_deg:.0f}° ({limit.tilt_deg:.0f}°); "
                f"at most {_floored(self.largest_size_mm(limit)):.10g} mm stays within"
            )
        return found

    def tangents(self, at: Array, depth_mm: ArrayLike = 0.0) -> tuple[Array, Array]:
        """∂p/∂u and ∂p/∂v at (k, 2) pattern points and a depth, by central differences, each (k, 3)."""
        steps = (np.array([STEP_MM, 0.0]), np.array([0.0, STEP_MM]))
        along = [
            (self.at_depth(at + s, depth_mm) - self.at_depth(at - s, depth_mm)) / (2 * STEP_MM) for s in steps
        ]
        return along[0], along[1]


def square(half_mm: float) -> Array:
    """Points (k, 2) of a grid over a square about the centre."""
    line = np.linspace(-half_mm, half_mm, SAMPLES)
    return np.stack(np.meshgrid(line, line), axis=-1).reshape(-1, 2)


def pairs(uv: ArrayLike) -> Array:
    """Pattern points as (k, 2)."""
    return np.asarray(uv, dtype=np.float64).reshape(-1, 2)


def positive(name: str, value: float) -> float:
    """The value, when it is a finite length above zero; `DesignError` otherwise."""
    if not (math.isfinite(value) and value > 0):
        raise DesignError(f"{name}={value:g} is not a length above 0 mm")
    return value


def thinner(name: str, thickness_mm: float, radius_mm: float) -> None:
    """Raises `DesignError` when a wall reaches the axis or centre it is bent about."""
    if thickness_mm >= radius_mm:
        raise DesignError(
            f"a wall of {thickness_mm:g} mm does not fit in a {name} of radius {radius_mm:g} mm: "
            f"take a thickness below {radius_mm:g} mm or a larger radius"
        )


def _floored(size_mm: float) -> float:
    """Rounded down to 0.01 mm, so that the size named in a remedy works."""
    return math.floor(size_mm * 100) / 100
