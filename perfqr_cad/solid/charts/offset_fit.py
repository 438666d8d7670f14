"""Splines of levels behind the front: the offset of a spline is none, so it is fitted, and refined until it
keeps the tolerance."""

from __future__ import annotations

import math

import numpy as np

from perfqr_cad.errors import KernelError
from perfqr_cad.geometry.arrays import Array
from perfqr_cad.geometry.spline import Spline, TensorSpline, fitted, greville, refined_knots, tensor_fitted
from perfqr_cad.surface import HeightField, Revolution

OFFSET_FIT_MM = 1e-6  # between the modelled back and the true offset of the front
PIECES = (1, 2, 4, 8, 16, 32, 64)  # of each span of the front's spline, in the spline of an offset of it


def fitted_meridian(wall: Revolution, depth_mm: float) -> Spline:
    """Radius and height over v of the meridian at a depth, within `OFFSET_FIT_MM`."""
    knots = wall.spline.knots - wall.centre_length_mm
    error = math.inf
    for pieces in PIECES:
        spline = fitted(lambda v: wall.meridian_at(v, depth_mm), refined_knots(knots, pieces))
        v = _midway(spline.knots)
        error = float(np.linalg.norm(spline(v) - wall.meridian_at(v, depth_mm), axis=1).max())
        if error <= OFFSET_FIT_MM:
            return spline
    raise KernelError(_misfit(error, depth_mm))


def fitted_heights(wall: HeightField, depth_mm: float) -> TensorSpline:
    """z(x, y) of the surface at a depth, within `OFFSET_FIT_MM`."""
    error = math.inf
    for pieces in PIECES:
        u_knots, v_knots = (refined_knots(k, pieces) for k in (wall.heights.u_knots, wall.heights.v_knots))
        spline = tensor_fitted(lambda at: wall.at_depth(at, depth_mm)[:, 2:], u_knots, v_knots)
        grid = np.stack(np.meshgrid(_midway(u_knots), _midway(v_knots)), axis=-1).reshape(-1, 2)
        error = float(np.abs(spline(grid)[:, 0] - wall.at_depth(grid, depth_mm)[:, 2]).max())
        if error <= OFFSET_FIT_MM:
            return spline
    raise KernelError(_misfit(error, depth_mm))


def _midway(knots: Array) -> Array:
    """Half-way between the sites of a fit, where it is checked."""
    sites = greville(knots)
    return (sites[1:] + sites[:-1]) / 2


def _misfit(error_mm: float, depth_mm: float) -> str:
    return (
        f"the surface {depth_mm:g} mm behind the front misses its spline by {error_mm:.1e} mm "
        f"(limit {OFFSET_FIT_MM:g} mm): take a smoother front or a thinner wall"
    )
