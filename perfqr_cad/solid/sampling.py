"""Many segments at once, as arrays: positions and derivatives at common fractions of their parameters."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from perfqr_cad.pattern.outline import Arc, Bezier, Circle, Line, Segment

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


def by_kind(segments: Sequence[Segment]) -> dict[type, Indices]:
    """Indices of the lines, the Béziers and the round segments (under `Arc`)."""
    kinds: dict[type, list[int]] = {Line: [], Bezier: [], Arc: []}
    for i, segment in enumerate(segments):
        kinds[Arc if isinstance(segment, Circle) else type(segment)].append(i)
    return {kind: np.array(indices, dtype=np.int64) for kind, indices in kinds.items()}


def positions(segments: Sequence[Segment], fractions: Array) -> Array:
    """Points (k, q, 2) at q fractions of each segment's parameter (the angle, on arcs); the ends to the
    bit."""
    return _evaluated(segments, fractions)[0]


def derivatives(segments: Sequence[Segment], fractions: Array) -> tuple[Array, Array]:
    """Points and their derivatives by the fraction, each (k, q, 2)."""
    return _evaluated(segments, fractions)


def _evaluated(segments: Sequence[Segment], fractions: Array) -> tuple[Array, Array]:
    points = np.empty((len(segments), len(fractions), 2))
    slopes = np.empty_like(points)
    t = fractions[None, :, None]
    for kind, rows in by_kind(segments).items():
        if not len(rows):
            continue
        chosen = [segments[i] for i in rows]
        if kind is Line:
            start, end = _ends(chosen)
            points[rows] = start + t * (end - start)
            slopes[rows] = end - start
        elif kind is Bezier:
            p = np.array([s.controls for s in chosen if isinstance(s, Bezier)])[:, :, None, :]
            s = 1 - t
            points[rows] = s**3 * p[:, 0] + 3 * s * s * t * p[:, 1] + 3 * s * t * t * p[:, 2] + t**3 * p[:, 3]
            legs = p[:, 1:] - p[:, :-1]
            slopes[rows] = 3 * (s * s * legs[:, 0] + 2 * s * t * legs[:, 1] + t * t * legs[:, 2])
        else:
            points[rows], slopes[rows] = _round([s for s in chosen if isinstance(s, Arc | Circle)], t)
    start, end = _ends(segments)
    points[:, fractions == 0.0] = start
    points[:, fractions == 1.0] = end
    return points, slopes


def _round(segments: Sequence[Arc | Circle], t: Array) -> tuple[Array, Array]:
    centre = np.array([s.centre for s in segments])[:, None]
    radius = np.array([s.radius for s in segments])[:, None, None]
    start = np.array([s.start_rad if isinstance(s, Arc) else 0.0 for s in segments])[:, None, None]
    turn = np.array([sweep(s) for s in segments])[:, None, None]
    angle = start + t * turn
    cos, sin = np.cos(angle), np.sin(angle)
    points = centre + radius * np.concatenate([cos, sin], axis=-1)
    slopes = radius * turn * np.concatenate([-sin, cos], axis=-1)
    return points, slopes


def sweep(segment: Arc | Circle) -> float:
    """Signed angle swept, rad; positive counter-clockwise."""
    if isinstance(segment, Arc):
        return segment.sweep_rad
    return math.tau if segment.ccw else -math.tau


def quarters(angle_rad: float) -> int:
    """How many quarter turns, or parts of one, an angle takes: the spans of an arc as rational quadratics."""
    return max(1, math.ceil(angle_rad / (math.pi / 2) - 1e-9))


def _ends(segments: Sequence[Segment]) -> tuple[Array, Array]:
    """First and last points, (k, 1, 2) each."""
    ends = np.array([(s.start, s.end) for s in segments]).reshape(-1, 2, 1, 2)
    return ends[:, 0], ends[:, 1]
