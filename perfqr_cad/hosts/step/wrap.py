"""Geodesics on an exact face: the map that keeps lengths and directions from the code's centre.

On planes, cylinders and cones it unrolls the face without any distortion.
"""

from __future__ import annotations

import numpy as np

from perfqr_cad.errors import DesignError
from perfqr_cad.geometry.arrays import Array
from perfqr_cad.hosts.body import Body
from perfqr_cad.hosts.frame import Frame
from perfqr_cad.hosts.host_placement import Wrapped
from perfqr_cad.hosts.probe import probe
from perfqr_cad.hosts.step.exact_face import ExactFace
from perfqr_cad.hosts.survey import FINE, INSET, Survey
from perfqr_cad.solid.kernel.evaluate import FIRST, SECOND

# points a side; the bicubic between them strays by h⁴/384 R³, 1e-6 mm for a code as wide as the radius
GRID = 33
STEPS = 12  # Runge-Kutta steps along each geodesic


def wrapped(face: ExactFace, frame: Frame, span_mm: float, thickness_mm: float) -> Wrapped:
    """The geodesic wrap of a square of edge `span_mm` about the frame's origin."""
    line = np.linspace(-span_mm / 2, span_mm / 2, GRID)
    flat = np.stack(np.meshgrid(line, line), axis=-1).reshape(-1, 2)
    points = geodesics(face, face.parameters(frame.origin), flat @ frame.axes[:2])
    return Wrapped(frame, span_mm, points.reshape(GRID, GRID, 3), thickness_mm)


def geodesics(face: ExactFace, start: tuple[float, float], along: Array) -> Array:
    """The points (k, 3) reached from a surface point by going straight along tangents (k, 3) for their
    length, mm."""
    _, du, dv = face.evaluate(np.array([start]), FIRST)[:, 0]
    # The tangents in parameters: least squares in the tangent plane.
    speed = np.linalg.lstsq(np.column_stack([du, dv]), along.T)[0].T
    state = np.asarray(np.hstack([np.broadcast_to(start, speed.shape), speed]), np.float64)
    step = 1.0 / STEPS
    for _ in range(STEPS):
        k1 = _rate(face, state)
        k2 = _rate(face, state + step / 2 * k1)
        k3 = _rate(face, state + step / 2 * k2)
        k4 = _rate(face, state + step * k3)
        state = np.asarray(state + step / 6 * (k1 + 2 * k2 + 2 * k3 + k4), np.float64)
    return face.evaluate(state[:, :2], 1)[0]


def _rate(face: ExactFace, state: Array) -> Array:
    """The geodesic equation: the acceleration of the curve has no tangential part. States (k, 4)."""
    speed = state[:, 2:]
    _, du, dv, duu, duv, dvv = face.evaluate(state[:, :2], SECOND)
    su, sv = speed[:, :1], speed[:, 1:]
    bend = duu * su * su + 2 * duv * su * sv + dvv * sv * sv
    e, f, g, a, b = (
        np.einsum("ki,ki->k", x, y) for x, y in ((du, du), (du, dv), (dv, dv), (du, -bend), (dv, -bend))
    )
    det = e * g - f * f
    if not (det > 1e-18 * e * g).all():
        raise DesignError("the code cannot be wrapped over a pole of the surface: project it, or move it")
    return np.column_stack([speed, (a * g - b * f) / det, (b * e - a * f) / det])


def survey_wrapped(body: Body, placement: Wrapped, size_mm: float) -> Survey:
    """Sample the wall under a wrapped code, along the face's normals; heights count from the wrap itself."""
    half = size_mm * (0.5 - INSET)
    line = np.linspace(-half, half, FINE)
    uv = np.stack(np.meshgrid(line, line), axis=-1).reshape(-1, 2)
    points, frames = placement.line(uv)
    met = probe(body, points, frames[:, 2])
    square = (FINE, FINE)
    tilt = np.degrees(np.arccos(np.clip(met.normal @ placement.frame_at_centre.axes[2], -1, 1)))
    return Survey(
        placement.frame_at_centre,
        size_mm,
        met.offset_mm.reshape(square),
        met.wall_mm.reshape(square),
        np.where(np.isnan(met.offset_mm), np.nan, tilt).reshape(square),
        np.einsum("kij,kj->ki", frames, met.normal).reshape(*square, 3),
        met.front.reshape(square),
        met.back.reshape(square),
        met.hidden.reshape(square),
    )
