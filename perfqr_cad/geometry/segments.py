"""Many segments at once, as arrays: positions and derivatives at common fractions of their parameters."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from perfqr_cad.geometry.arrays import Array, Indices
from perfqr_cad.geometry.outline import Arc, Bezier, Circle, Line, Segment

LEAST_OF_CIRCLE = 8  # chords of a whole circle, however small


def by_kind(segments: Sequence[Segment]) -> dict[type, Indices]:
    """Indices of the lines, the Béziers and the round segments (under `Arc`)."""
    kinds: dict[type, list[int]] = {Line: [], Bezier: [], Arc: []}
    for i, segment in enumerate(segments):
        kinds[Arc if isinstance(segment, Circle) else type(segment)].append(i)
    return {kind: np.array(indices, dtype=np.int64) for kind, indices in kinds.items()}


def positions(segments: Sequence[Segment], fractions: Array) -> Array:
    """Points (k, q, 2) at q fractions of each segment's parameter (the angle, on arcs); the ends to the bit.

    >>> positions([Line((0.0, 0.0), (4.0, 2.0))], np.array([0.25, 1.0])).tolist()
    [[[1.0, 0.5], [4.0, 2.0]]]
    """
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
    arcs = rounds(segments)
    angle = (arcs.start_rad[:, None] + t[..., 0] * arcs.sweep_rad[:, None])[..., None]
    cos, sin = np.cos(angle), np.sin(angle)
    points = arcs.centre[:, None] + arcs.radius[:, None, None] * np.concatenate([cos, sin], axis=-1)
    speed = (arcs.radius * arcs.sweep_rad)[:, None, None]
    return points, speed * np.concatenate([-sin, cos], axis=-1)


class Rounds(NamedTuple):
    """Arcs and circles: centres (k, 2), radii (k,), and where they start and how far they turn, rad (k,);
    positive counter-clockwise."""

    centre: Array
    radius: Array
    start_rad: Array
    sweep_rad: Array


def rounds(segments: Sequence[Segment]) -> Rounds:
    """Arcs and circles as arrays; other segments are left out."""
    arcs = [s for s in segments if isinstance(s, Arc | Circle)]
    rows = np.array(
        [(*s.start, *s.end, *s.centre, s.ccw, isinstance(s, Circle)) for s in arcs], np.float64
    ).reshape(-1, 8)
    start, end, centre = (rows[:, i : i + 2] for i in (0, 2, 4))
    ccw, whole = rows[:, 6] > 0, rows[:, 7] > 0
    begin, stop = (np.arctan2(p[:, 1] - centre[:, 1], p[:, 0] - centre[:, 0]) for p in (start, end))
    turn = np.where(whole & ccw, math.tau, (stop - begin) % math.tau)
    return Rounds(centre, np.hypot(*(start - centre).T), begin, np.where(ccw, turn, turn - math.tau))


def pieces(segments: Sequence[Segment], tolerance_mm: float) -> Indices:
    """In how many equal pieces each segment is to be cut so that chords stay so close, (k,); as
    `Segment.flatten`."""
    counts = np.ones(len(segments), np.int64)
    kinds = by_kind(segments)
    if len(rows := kinds[Arc]):
        _, radius, _, sweep_rad = rounds([segments[i] for i in rows.tolist()])
        most = np.where(
            radius > tolerance_mm,
            2 * np.arccos(1 - tolerance_mm / np.maximum(radius, tolerance_mm)),
            math.pi / 2,
        )
        least = np.where(np.abs(sweep_rad) == math.tau, LEAST_OF_CIRCLE, 1)
        counts[rows] = np.maximum(least, np.ceil(np.abs(sweep_rad) / most))
    if len(rows := kinds[Bezier]):
        p = np.array([s.controls for i in rows.tolist() if isinstance(s := segments[i], Bezier)])
        bend = np.linalg.norm(np.diff(p, 2, axis=1), axis=2).max(axis=1)
        counts[rows] = np.maximum(1, np.ceil(np.sqrt(0.75 * bend / tolerance_mm)))
    return counts


def corners(segments: Sequence[Segment], counts: Indices) -> Array:
    """Corners (n, 2) of loops whose segments are cut in so many equal pieces each."""
    starts = np.cumsum(counts) - counts
    found = np.empty((int(counts.sum()), 2))
    for count in np.flatnonzero(np.bincount(counts)).tolist():
        rows = np.flatnonzero(counts == count)
        points = positions([segments[i] for i in rows.tolist()], np.arange(count) / count)
        found[starts[rows][:, None] + np.arange(count)] = points
    return found


def quarters(angle_rad: Array) -> Indices:
    """How many quarter turns, or parts of one, angles (k,) take: the spans of arcs as rational quadratics."""
    return np.maximum(1, np.ceil(angle_rad / (math.pi / 2) - 1e-9)).astype(np.int64)


def _ends(segments: Sequence[Segment]) -> tuple[Array, Array]:
    """First and last points, (k, 1, 2) each."""
    ends = np.array([(s.start, s.end) for s in segments]).reshape(-1, 2, 1, 2)
    return ends[:, 0], ends[:, 1]
