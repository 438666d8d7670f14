"""Cubic splines through points, in one and two parameters, as B-splines that a solid modeller takes over
as they are."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

if TYPE_CHECKING:
    from scipy.interpolate import NdBSpline

Array = NDArray[np.float64]

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
        at = np.asarray(x, dtype=np.float64)
        first, weights = _basis(self.knots, at, derivative)
        return np.einsum("ki,kid->kd", weights, self.poles[first[:, None] + np.arange(DEGREE + 1)])


@dataclass(frozen=True)
class TensorSpline:
    """A bicubic B-spline: flat knots in both parameters and poles (n, m, d)."""

    u_knots: Array
    v_knots: Array
    poles: Array

    @cached_property
    def _compiled(self) -> NdBSpline:
        from scipy.interpolate import NdBSpline

        return NdBSpline((self.u_knots, self.v_knots), self.poles, DEGREE)

    def __call__(self, uv: Array, derivative: tuple[int, int] = (0, 0)) -> Array:
        """Values or partial derivatives (k, d) at (k, 2) parameters; the end pieces extend beyond the
        domain."""
        return np.asarray(self._compiled(uv, nu=derivative), np.float64)


def interpolated(x: Array, values: Array) -> Spline:
    """The not-a-knot cubic through (k, d) values at k ≥ 4 rising parameters."""
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
    derivative is
    less smooth there, and `pieces` equal pieces in each span."""
    breaks = np.unique(knots)
    steps = [np.linspace(a, b, pieces + 1)[1:] for a, b in pairwise(breaks)]
    inner = np.concatenate([np.append(step, step[-1]) for step in steps])[:-2]
    return np.concatenate([np.repeat(breaks[0], DEGREE + 1), inner, np.repeat(breaks[-1], DEGREE + 1)])


def not_a_knot(x: Array) -> Array:
    """Flat knots whose first and last two pieces are one cubic each."""
    return np.concatenate([np.repeat(x[0], DEGREE + 1), x[2:-2], np.repeat(x[-1], DEGREE + 1)])


def collocation(knots: Array, x: Array) -> Array:
    """Basis values (k, n) at k parameters."""
    first, weights = _basis(knots, x, 0)
    matrix = np.zeros((len(x), len(knots) - DEGREE - 1))
    np.put_along_axis(matrix, first[:, None] + np.arange(DEGREE + 1), weights, axis=1)
    return matrix


def greville(knots: Array) -> Array:
    """Abscissae (n,) whose values as poles make the spline the identity."""
    return np.array([knots[i + 1 : i + DEGREE + 1].mean() for i in range(len(knots) - DEGREE - 1)])


def _both_ways(along_u: Array, along_v: Array, values: Array) -> Array:
    """Poles (n, m, d) of values (n, m, d): the collocation systems solved along one parameter, then the
    other."""
    half = np.linalg.solve(along_u, values.reshape(len(values), -1)).reshape(values.shape)
    turned = np.swapaxes(half, 0, 1)
    whole = np.linalg.solve(along_v, turned.reshape(len(turned), -1)).reshape(turned.shape)
    return np.asarray(np.swapaxes(whole, 0, 1), np.float64)


def _basis(knots: Array, x: Array, derivative: int) -> tuple[NDArray[np.int64], Array]:
    """Index of the first non-zero basis function and the four values (k, 4): Cox-de Boor, vectorised."""
    last = len(knots) - DEGREE - 2
    span = np.clip(np.searchsorted(knots, x, side="right") - 1, DEGREE, last)
    values = _values(knots, span, x, DEGREE - derivative)
    for degree in range(DEGREE - derivative + 1, DEGREE + 1):
        values = _differentiated(knots, span, values, degree)
    return span - DEGREE, values


def _values(knots: Array, span: NDArray[np.int64], x: Array, degree: int) -> Array:
    values = np.ones((len(x), 1))
    for p in range(1, degree + 1):
        index = span[:, None] + np.arange(1 - p, 1)
        left, right = knots[index], knots[index + p]
        share = values / (right - left)
        grown = np.zeros((len(x), p + 1))
        grown[:, :-1] += share * (right - x[:, None])
        grown[:, 1:] += share * (x[:, None] - left)
        values = grown
    return values


def _differentiated(knots: Array, span: NDArray[np.int64], values: Array, degree: int) -> Array:
    """Derivative weights of one degree from the (derivative) values of the degree below."""
    index = span[:, None] + np.arange(1 - degree, 1)
    share = values * degree / (knots[index + degree] - knots[index])
    grown = np.zeros((len(values), degree + 1))
    grown[:, :-1] -= share
    grown[:, 1:] += share
    return grown
