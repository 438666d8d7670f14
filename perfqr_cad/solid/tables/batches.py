"""Curves and surfaces of one kind, many at a time, as arrays.

A curve of a table runs over fractions 0 to 1 of its own parameter. In space it is the curve of an edge, in
two dimensions the image of an edge in the parameters of a face's surface. Surfaces take the parameters of
ISO 10303-42: angles in radians and lengths in mm on planes, cylinders and cones, knots on splines.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Protocol, Self

import numpy as np

from perfqr_cad.geometry.arrays import Array, Indices
from perfqr_cad.geometry.spline import basis

RULING_KNOTS = (0.0, 0.0, 1.0, 1.0)


class Curves(Protocol):
    """k curves in two or three dimensions d."""

    def __len__(self) -> int: ...

    def __getitem__(self, rows: Indices) -> Self: ...

    def at(self, fractions: Array) -> tuple[Array, Array]:
        """Points and their derivatives by the fraction, (k, q, d) each."""
        ...


class Surfaces(Protocol):
    """k surfaces."""

    def __len__(self) -> int: ...

    def __getitem__(self, rows: Indices) -> Self: ...

    def at(self, which: Indices, uv: Array) -> Array:
        """Points (m, q, 3) at parameters (m, q, 2) of m of the surfaces."""
        ...

    @property
    def periods(self) -> Array:
        """After which the parameters come back to the same point, (k, 2); 0: never."""
        ...


@dataclass(frozen=True, eq=False)
class Lines:
    """From `start` (k, d) to `end` (k, d).

    >>> line = Lines(np.array([[0.0, 0.0]]), np.array([[3.0, 4.0]]))
    >>> line.length.tolist(), line.at(np.array([0.5]))[0].tolist()
    ([5.0], [[[1.5, 2.0]]])
    """

    start: Array
    end: Array

    def __len__(self) -> int:
        return len(self.start)

    def __getitem__(self, rows: Indices) -> Lines:
        return Lines(self.start[rows], self.end[rows])

    def at(self, fractions: Array) -> tuple[Array, Array]:
        s = fractions[:, None]
        points = (1 - s) * self.start[:, None] + s * self.end[:, None]
        return points, np.broadcast_to((self.end - self.start)[:, None], points.shape)

    @property
    def length(self) -> Array:
        """(k,)."""
        return np.sqrt(((self.end - self.start) ** 2).sum(axis=1))


@dataclass(frozen=True, eq=False)
class Arcs:
    """Circular arcs in space, by `sweep` (k,) rad > 0 from the unit ray `x` (k, 3) towards `y` (k, 3)."""

    centre: Array
    x: Array
    y: Array
    radius: Array
    sweep: Array

    def __len__(self) -> int:
        return len(self.radius)

    def __getitem__(self, rows: Indices) -> Arcs:
        return Arcs(*(a[rows] for a in (self.centre, self.x, self.y, self.radius, self.sweep)))

    @property
    def axis(self) -> Array:
        return np.cross(self.x, self.y)

    def at(self, fractions: Array) -> tuple[Array, Array]:
        angle = self.sweep[:, None] * fractions
        cos, sin = np.cos(angle)[..., None], np.sin(angle)[..., None]
        x, y = (self.radius[:, None] * a for a in (self.x, self.y))
        points = self.centre[:, None] + cos * x[:, None] + sin * y[:, None]
        slopes = self.sweep[:, None, None] * (cos * y[:, None] - sin * x[:, None])
        return points, slopes


@dataclass(frozen=True, eq=False)
class Splines:
    """B-splines of common flat knots from 0 to 1: poles (k, n, d)."""

    poles: Array
    knots: tuple[float, ...]
    degree: int

    def __len__(self) -> int:
        return len(self.poles)

    def __getitem__(self, rows: Indices) -> Splines:
        return Splines(self.poles[rows], self.knots, self.degree)

    def at(self, fractions: Array) -> tuple[Array, Array]:
        values, slopes = basis(self.knots, self.degree, fractions)
        return values @ self.poles, slopes @ self.poles


@dataclass(frozen=True, eq=False)
class Planes:
    """Through `origin` (k, 3), square to the unit `normal` (k, 3); u runs along the unit `x` (k, 3)."""

    origin: Array
    normal: Array
    x: Array

    def __len__(self) -> int:
        return len(self.origin)

    def __getitem__(self, rows: Indices) -> Planes:
        return Planes(self.origin[rows], self.normal[rows], self.x[rows])

    @property
    def y(self) -> Array:
        return np.cross(self.normal, self.x)

    def at(self, which: Indices, uv: Array) -> Array:
        x, y = self.x[which], self.y[which]
        return self.origin[which][:, None] + uv[..., :1] * x[:, None] + uv[..., 1:] * y[:, None]

    @property
    def periods(self) -> Array:
        return np.zeros((len(self), 2))

    def parameters(self, which: Indices, points: Array) -> Array:
        """Parameters (m, 2) of points (m, 3) on m of the planes."""
        off = points - self.origin[which]
        return np.column_stack([np.einsum("mi,mi->m", off, axis[which]) for axis in (self.x, self.y)])


@dataclass(frozen=True, eq=False)
class Cones:
    """Cylinders and cones of `radius` (k,) at `origin` (k, 3), wider by tan(`angle`) (k,) along the `axis`.

    u is the angle from `x` (k, 3) about the axis (k, 3), v the length along a ruling.
    """

    origin: Array
    axis: Array
    x: Array
    radius: Array
    angle: Array

    def __len__(self) -> int:
        return len(self.radius)

    def __getitem__(self, rows: Indices) -> Cones:
        return Cones(*(a[rows] for a in (self.origin, self.axis, self.x, self.radius, self.angle)))

    @property
    def y(self) -> Array:
        return np.cross(self.axis, self.x)

    def at(self, which: Indices, uv: Array) -> Array:
        u, v = uv[..., :1], uv[..., 1:]
        x, y, axis = (a[which][:, None] for a in (self.x, self.y, self.axis))
        sin, cos = (f(self.angle)[which][:, None, None] for f in (np.sin, np.cos))
        ray = np.cos(u) * x + np.sin(u) * y
        radius = self.radius[which][:, None, None] + v * sin
        return self.origin[which][:, None] + radius * ray + v * cos * axis

    @property
    def periods(self) -> Array:
        return np.tile([math.tau, 0.0], (len(self), 1))


@dataclass(frozen=True, eq=False)
class SplineSurfaces:
    """Tensor B-splines of common flat knots: poles (k, n, m, 3), weights (k, n, m), None where all are 1."""

    poles: Array
    u_knots: tuple[float, ...]
    v_knots: tuple[float, ...]
    degrees: tuple[int, int]
    weights: Array | None = None

    @staticmethod
    def ruled(upper: Array, lower: Array, knots: tuple[float, ...], degree: int) -> SplineSurfaces:
        """Straight lines between curves of poles (k, n, 3): v from the lower (0) to the upper (1), so that
        the normal points to the right of travel."""
        return SplineSurfaces(np.stack([lower, upper], axis=2), knots, RULING_KNOTS, (degree, 1))

    def __len__(self) -> int:
        return len(self.poles)

    def __getitem__(self, rows: Indices) -> SplineSurfaces:
        weights = None if self.weights is None else self.weights[rows]
        return SplineSurfaces(self.poles[rows], self.u_knots, self.v_knots, self.degrees, weights)

    @property
    def periods(self) -> Array:
        return np.zeros((len(self), 2))

    @property
    def domain(self) -> tuple[Array, Array]:
        """Least and greatest parameters, (2,) each."""
        low, high = ([self.u_knots[k], self.v_knots[k]] for k in (0, -1))
        return np.array(low), np.array(high)

    def at(self, which: Indices, uv: Array) -> Array:
        by_u, by_v = (
            basis(knots, degree, uv[..., i].ravel())[0].reshape(*uv.shape[:2], -1)
            for i, (knots, degree) in enumerate(zip((self.u_knots, self.v_knots), self.degrees, strict=True))
        )
        rows = np.einsum("mqi,mijd->mqjd", by_u, self._homogeneous[which])
        points = np.einsum("mqj,mqjd->mqd", by_v, rows)
        return points[..., :3] / points[..., 3:]

    def grid(self, u: Array, v: Array) -> tuple[Array, Array, Array]:
        """Points and first derivatives of all surfaces on a grid of parameters, (k, u, v, 3) each."""
        by_u, by_v = basis(self.u_knots, self.degrees[0], u), basis(self.v_knots, self.degrees[1], v)
        value, along_u, along_v = (
            np.einsum("ui,vj,kijd->kuvd", by_u[i], by_v[j], self._homogeneous, optimize=True)
            for i, j in ((0, 0), (1, 0), (0, 1))
        )
        weight = value[..., 3:]
        points = value[..., :3] / weight
        u_slopes, v_slopes = ((a[..., :3] - a[..., 3:] * points) / weight for a in (along_u, along_v))
        return points, u_slopes, v_slopes

    @property
    def _homogeneous(self) -> Array:
        weights = np.ones(self.poles.shape[:3]) if self.weights is None else self.weights
        return np.concatenate([self.poles * weights[..., None], weights[..., None]], axis=-1)


@dataclass(frozen=True, eq=False)
class Move:
    """A rigid motion: (x, y, z) goes to origin + x a₀ + y a₁ + z a₂, with aᵢ the rows of `axes` (3, 3)."""

    origin: Array
    axes: Array

    def curves(self, curves: Curves) -> Curves:
        """Curves in space, moved. Raises `TypeError` for a kind that is not of this module."""
        match curves:
            case Lines():
                return Lines(self._at(curves.start), self._at(curves.end))
            case Arcs(centre, x, y, radius, sweep):
                return Arcs(self._at(centre), x @ self.axes, y @ self.axes, radius, sweep)
            case Splines():
                return Splines(self._at(curves.poles), curves.knots, curves.degree)
            case _:
                raise TypeError(type(curves).__name__)

    def surfaces(self, surfaces: Surfaces) -> Surfaces:
        """Surfaces, moved. Raises `TypeError` for a kind that is not of this module."""
        match surfaces:
            case Planes(origin, normal, x):
                return Planes(self._at(origin), normal @ self.axes, x @ self.axes)
            case Cones(origin, axis, x, radius, angle):
                return Cones(self._at(origin), axis @ self.axes, x @ self.axes, radius, angle)
            case SplineSurfaces():
                return replace(surfaces, poles=self._at(surfaces.poles))
            case _:
                raise TypeError(type(surfaces).__name__)

    def _at(self, points: Array) -> Array:
        return self.origin + points @ self.axes
