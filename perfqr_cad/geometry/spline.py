"""Cubic splines through points, in one and two parameters, as B-splines that a solid modeller takes over
as they are."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import BSpline, NdBSpline

from perfqr_cad.geometry.arrays import Array

DEGREE = 3


@dataclass(frozen=True)
class Spline:
    """A cubic B-spline curve: flat knots (n + 4,) and poles (n, d)."""

    knots: Array
    poles: Array

    @property
    def domain(self) -> tuple[float, float]:
        return float(self.knots[0]), float(self.knots[-1])

    def __call__(self, x: ArrayLike, derivative: int = 0) -> Array:
        """Values or derivatives (k, d) at k parameters; the end pieces extend beyond the domain."""
        return np.asarray(self._compiled(x, nu=derivative), np.float64)

    @cached_property
    def _compiled(self) -> BSpline:
        return BSpline(self.knots, self.poles, DEGREE)


@dataclass(frozen=True)
class TensorSpline:
    """A bicubic B-spline: flat knots in both parameters and poles (n, m, d)."""

    u_knots: Array
    v_knots: Array
    poles: Array

    @cached_property
    def _compiled(self) -> NdBSpline:
        return NdBSpline((self.u_knots, self.v_knots), self.poles, DEGREE)

    def __call__(self, uv: Array, derivative: tuple[int, int] = (0, 0)) -> Array:
        """Values or partial derivatives (k, d) at (k, 2) parameters; the end pieces extend beyond the
        domain."""
        return np.asarray(self._compiled(uv, nu=derivative), np.float64)


def interpolated(x: Array, values: Array) -> Spline:
    """The not-a-knot cubic through (k, d) values at k ≥ 4 rising parameters.

    >>> x = np.linspace(0.0, 4.0, 5)
    >>> cube = interpolated(x, x[:, None] ** 3)
    >>> round(float(cube([2.5])[0, 0]), 9), round(float(cube([2.5], 1)[0, 0]), 9)
    (15.625, 18.75)
    """
    knots = not_a_knot(x)
    return Spline(knots, np.asarray(np.linalg.solve(collocation(knots, x), values), np.float64))


def tensor(x: Array, y: Array, values: Array) -> TensorSpline:
    """The bicubic through values (k, m, d) on a grid of at least 4 × 4."""
    u_knots, v_knots = not_a_knot(x), not_a_knot(y)
    return TensorSpline(
        u_knots, v_knots, _both_ways(collocation(u_knots, x), collocation(v_knots, y), values)
    )


def fitted(function: Callable[[Array], Array], knots: Array) -> Spline:
    """The cubic with these flat knots through `function`, (k,) -> (k, d), at their Greville abscissae."""
    sites = greville(knots)
    return Spline(knots, np.asarray(np.linalg.solve(collocation(knots, sites), function(sites)), np.float64))


def tensor_fitted(function: Callable[[Array], Array], u_knots: Array, v_knots: Array) -> TensorSpline:
    """The bicubic with these flat knots through `function`, (k, 2) -> (k, d), at their Greville abscissae."""
    u, v = greville(u_knots), greville(v_knots)
    grid = np.stack(np.meshgrid(u, v, indexing="ij"), axis=-1)
    values = function(grid.reshape(-1, 2)).reshape(len(u), len(v), -1)
    return TensorSpline(
        u_knots, v_knots, _both_ways(collocation(u_knots, u), collocation(v_knots, v), values)
    )


def refined_knots(knots: Array, pieces: int) -> Array:
    """Knots for what is made of a spline's derivatives, an offset say: inner knots doubled, since a
    derivative is less smooth there, and `pieces` equal pieces in each span."""
    breaks = np.unique(knots)
    steps = [np.linspace(a, b, pieces + 1)[1:] for a, b in pairwise(breaks)]
    inner = np.concatenate([np.append(step, step[-1]) for step in steps])[:-2]
    return np.concatenate([np.repeat(breaks[0], DEGREE + 1), inner, np.repeat(breaks[-1], DEGREE + 1)])


def not_a_knot(x: Array) -> Array:
    """Flat knots whose first and last two pieces are one cubic each."""
    return np.concatenate([np.repeat(x[0], DEGREE + 1), x[2:-2], np.repeat(x[-1], DEGREE + 1)])


def collocation(knots: Array, x: Array) -> Array:
    """Values (k, n) of all cubic basis functions at k parameters."""
    # Rounding may put an abscissa of clamped knots beyond their end.
    return np.asarray(BSpline.design_matrix(x, knots, DEGREE, extrapolate=True).toarray(), np.float64)


def basis(knots: tuple[float, ...], degree: int, x: Array) -> tuple[Array, Array]:
    """Values and slopes of all basis functions of a degree at k parameters, (k, n) each.

    >>> values, slopes = basis((0.0, 0.0, 1.0, 1.0), 1, np.array([0.25]))
    >>> values.tolist(), slopes.tolist()
    ([[0.75, 0.25]], [[-1.0, 1.0]])
    """
    functions = _unit_splines(knots, degree)
    return functions(x), functions(x, nu=1)


@lru_cache(maxsize=64)
def _unit_splines(knots: tuple[float, ...], degree: int) -> BSpline:
    return BSpline(np.array(knots), np.eye(len(knots) - degree - 1), degree)


def greville(knots: Array) -> Array:
    """Abscissae (n,) whose values as poles make the spline the identity.

    >>> greville(np.array([0.0, 0, 0, 0, 3, 3, 3, 3])).tolist()
    [0.0, 1.0, 2.0, 3.0]
    """
    return np.array([knots[i + 1 : i + DEGREE + 1].mean() for i in range(len(knots) - DEGREE - 1)])


def _both_ways(along_u: Array, along_v: Array, values: Array) -> Array:
    """Poles (n, m, d) of values (n, m, d): the collocation systems solved along one parameter, then the
    other."""
    half = np.linalg.solve(along_u, values.reshape(len(values), -1)).reshape(values.shape)
    turned = np.swapaxes(half, 0, 1)
    whole = np.linalg.solve(along_v, turned.reshape(len(turned), -1)).reshape(turned.shape)
    return np.asarray(np.swapaxes(whole, 0, 1), np.float64)
