"""Where lines meet planes, cylinders, cones and spheres: closed forms, poles and seams included."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from OCP.Geom import (
    Geom_ConicalSurface,
    Geom_CylindricalSurface,
    Geom_Plane,
    Geom_RectangularTrimmedSurface,
    Geom_SphericalSurface,
    Geom_Surface,
)

from perfqr_cad.geometry.arrays import Array
from perfqr_cad.solid.kernel.evaluate import frame_of

LEVEL = 1e-14  # of the squared direction: a quadratic coefficient below is none


@dataclass(frozen=True)
class Quadric:
    """In the surface's own axes (rows x, y, z of `axes`): x² + y² + bend z² = (radius + slope z)².

    bend  1 for a sphere, 0 for a cylinder or cone; a plane has no radius, and z = 0
    """

    origin: Array
    axes: Array
    radius: float | None
    bend: float = 0.0
    slope: float = 0.0

    def meet(self, guesses: Array, directions: Array) -> tuple[Array, Array]:
        """Parameters (k, 2) and points (k, 3) where lines meet the surface, nearest to points on them; NaN
        where they do not."""
        p, d = (guesses - self.origin) @ self.axes.T, directions @ self.axes.T
        with np.errstate(divide="ignore", invalid="ignore"):
            along = -p[:, 2] / d[:, 2] if self.radius is None else self._nearest_root(p, d)
        local = p + along[:, None] * d
        return self._parameters(local), self.origin + local @ self.axes

    def _nearest_root(self, p: Array, d: Array) -> Array:
        """Of a t² + 2 b t + c = 0, on the side of a cone's axis where its radius is above 0."""
        radius = self.radius or 0.0
        metric = np.array([1.0, 1.0, self.bend - self.slope**2])
        a, b, c = (d * d) @ metric, (p * d) @ metric, (p * p) @ metric
        b, c = b - radius * self.slope * d[:, 2], c - 2 * radius * self.slope * p[:, 2] - radius**2
        # The root without cancellation first, the other from the product of both.
        far = -(b + np.where(b < 0, -1.0, 1.0) * np.sqrt(b * b - a * c))
        roots = np.stack([np.where(np.abs(a) > LEVEL, far / a, np.nan), c / far])
        if self.slope:
            roots[radius + self.slope * (p[:, 2] + roots * d[:, 2]) < 0] = np.nan
        size = np.where(np.isnan(roots), np.inf, np.abs(roots))
        return np.take_along_axis(roots, size.argmin(axis=0)[None], axis=0)[0]

    def _parameters(self, local: Array) -> Array:
        """As the modeller counts them; angles in 0 to 2π."""
        if self.radius is None:
            return local[:, :2]
        u = np.mod(np.arctan2(local[:, 1], local[:, 0]), 2 * np.pi)
        if self.bend:
            return np.column_stack([u, np.arctan2(local[:, 2], np.hypot(local[:, 0], local[:, 1]))])
        return np.column_stack([u, local[:, 2] * np.hypot(1.0, self.slope)])


def quadric(surface: Geom_Surface) -> Quadric | None:
    """The closed form of a surface, where it has one."""
    known: Any = surface
    match known:
        case Geom_RectangularTrimmedSurface():
            return quadric(known.BasisSurface())
        case Geom_Plane():
            return _in_frame(known, None)
        case Geom_CylindricalSurface():
            return _in_frame(known, known.Radius())
        case Geom_ConicalSurface():
            return _in_frame(known, known.RefRadius(), slope=float(np.tan(known.SemiAngle())))
        case Geom_SphericalSurface():
            return _in_frame(known, known.Radius(), bend=1.0)
        case _:
            return None


def _in_frame(surface: Any, radius: float | None, bend: float = 0.0, slope: float = 0.0) -> Quadric:
    origin, *axes = frame_of(surface)
    return Quadric(origin, np.stack(axes), radius, bend, slope)
