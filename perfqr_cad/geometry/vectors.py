"""Vectors of the plane, many at once: arrays (..., 2)."""

from __future__ import annotations

import numpy as np

from perfqr_cad.geometry.arrays import Array


def crossing(p: Array, d: Array, q: Array, e: Array) -> Array:
    """Where lines through p and q (k, 2) along d and e cross; not finite where they are parallel.

    >>> crossing(*(np.array([v]) for v in ((0, 0), (1, 0), (3, 2), (0, 1)))).tolist()
    [[3.0, 0.0]]
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        return p + d * (cross(q - p, e) / cross(d, e))[:, None]


def cross(a: Array, b: Array) -> Array:
    """a × b; positive where b points to the left of a."""
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def left(d: Array) -> Array:
    """d turned by a right angle, counter-clockwise."""
    return np.stack([-d[..., 1], d[..., 0]], axis=-1)


def unit(d: Array) -> Array:
    """d at length 1; no length stays none."""
    length = np.hypot(d[..., 0], d[..., 1])
    return d / np.where(length > 0, length, 1.0)[..., None]
