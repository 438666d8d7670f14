"""The basis functions of B-splines."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np

from perfqr_cad.geometry.segments import Array

MANY = 64  # parameters; fewer are fractions of an edge or nodes of a rule, asked for again and again


def basis(knots: tuple[float, ...], degree: int, x: Array) -> tuple[Array, Array]:
    """All basis functions and their slopes at k parameters, (k, n) each (Piegl and Tiller, §2.2)."""
    if x.size <= MANY:
        return _known_basis(knots, degree, tuple(x.tolist()))
    return _basis(np.array(knots), degree, x)


@lru_cache(maxsize=256)
def _known_basis(knots: tuple[float, ...], degree: int, x: tuple[float, ...]) -> tuple[Array, Array]:
    return _basis(np.array(knots), degree, np.array(x))


def _basis(t: Array, degree: int, x: Array) -> tuple[Array, Array]:
    count = len(t) - degree - 1
    x = np.clip(x, t[degree], t[count])[:, None]
    span = np.clip(np.searchsorted(t, x[:, 0], side="right") - 1, degree, count - 1)
    values = np.zeros((len(x), len(t) - 1))
    values[np.arange(len(x)), span] = 1.0
    slopes = values
    for p in range(1, degree + 1):
        rise, fall = _inverse(t[p:-1] - t[: -p - 1]), _inverse(t[p + 1 :] - t[1:-p])
        slopes = p * (rise * values[:, :-1] - fall * values[:, 1:])
        values = (x - t[: -p - 1]) * rise * values[:, :-1] + (t[p + 1 :] - x) * fall * values[:, 1:]
    return values, slopes


def _inverse(steps: Array) -> Any:
    """1 / steps, 0 where a step is 0."""
    return np.divide(1.0, steps, out=np.zeros_like(steps), where=steps > 0)
