"""Corners and edges of the finished outline: exact fillets, smooth contours of free-form art."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from perfqr_cad.geometry.outline import LEAST_MM, Arc, Bezier, Line, Loop, Point, Points, Region, Segment
from perfqr_cad.pattern.bridge import Bridge
from perfqr_cad.pattern.cells.tracing import Boundaries
from perfqr_cad.pattern.drawing.front import edge_under

Flags: TypeAlias = NDArray[np.bool_]
Lengths: TypeAlias = NDArray[np.float64]

LEAST_EDGE_MM = 0.1  # a quarter of a nozzle: what no slicer resolves and every mesher stumbles over
STRAIGHT_TURN_RAD = 1e-6  # a turn below this is rounding
SMOOTH_TURN_RAD = math.radians(60)  # a sharper turn is a corner that the art meant
SIMPLIFY_PART = 0.7  # of the tolerance goes into straightening stairs, the rest into rounding


def filleted(region: Region, radius_mm: float) -> Region:
    """Every re-entrant corner of the material between two lines rounded by an arc of at most the radius.

    Fillets only add material, so what was one piece stays one. An edge too short for its two fillets gets
    smaller ones, and so does a hole whose fillets would run into each other.
    """
    if radius_mm <= 0:
        return region
    straight = [loop for loop in region.loops if all(isinstance(s, Line) for s in loop.segments)]
    rounded = dict(zip(map(id, straight), _simple(straight, radius_mm), strict=True))
    outer, *holes = (rounded.get(id(loop), loop) for loop in region.loops)
    return Region(outer, tuple(holes))


def _simple(straight: Sequence[Loop], radius_mm: float) -> list[Loop]:
    """The loops with their corners rounded; those that cross themselves then, with half the radius."""
    import shapely

    made = _filleted(
        Boundaries.of([np.array([segment.start for segment in loop.segments]) for loop in straight]),
        radius_mm,
    )
    if radius_mm < LEAST_EDGE_MM / 2:  # as they were
        return made
    crossing = [k for k, loop in enumerate(made) if not shapely.Polygon(loop.flatten()).is_valid]
    if crossing:
        for k, loop in zip(crossing, _simple([straight[k] for k in crossing], radius_mm / 2), strict=True):
            made[k] = loop
    return made


def _filleted(rings: Boundaries, radius_mm: float) -> list[Loop]:
    before, after = rings.before, rings.after
    along, lengths, turn = _course(rings)
    # The material lies on the left: a turn to the right is re-entrant.
    rounded = turn < -STRAIGHT_TURN_RAD
    tangent = np.tan(np.abs(turn) / 2)
    behind = np.where(after(rounded), lengths / 2, lengths)  # half where the next corner takes the rest
    ahead = np.where(before(rounded), before(lengths) / 2, before(lengths))
    cut = np.where(rounded, np.minimum(radius_mm * tangent, np.minimum(behind, ahead)), 0.0)
    cut = _without_remnants(rings, cut, lengths)
    cut[cut < LEAST_EDGE_MM / 2] = 0.0
    starts, ends, gone = _joints(rings, along, lengths, cut)
    radius = np.divide(cut, tangent, out=np.zeros_like(cut), where=cut > 0)
    right = np.stack([before(along)[:, 1], -before(along)[:, 0]], axis=1)  # where the void lies
    joints = zip(
        cut > 0, *(_tuples(p) for p in (starts, ends, starts + right * radius[:, None])), strict=True
    )
    curves = [Arc(start, end, centre, ccw=False) if bent else None for bent, start, end, centre in joints]
    return _chained(rings, curves, starts, ends, gone)


def _course(rings: Boundaries) -> tuple[Points, Lengths, Lengths]:
    """Direction and length of the edge after each corner, and the turn at the corner, left positive."""
    edges = rings.after(rings.points) - rings.points
    lengths = np.hypot(edges[:, 0], edges[:, 1])
    arriving = rings.before(edges)
    cross = arriving[:, 0] * edges[:, 1] - arriving[:, 1] * edges[:, 0]
    return edges / lengths[:, None], lengths, np.arctan2(cross, (arriving * edges).sum(axis=1))


def _joints(rings: Boundaries, along: Points, lengths: Lengths, cut: Lengths) -> tuple[Points, Points, Flags]:
    """Where the curve at each corner starts and ends, and whether no line follows it.

    A line too short to have a direction is left out: what came before it ends where the next begins.
    """
    starts = rings.points - rings.before(along) * cut[:, None]
    ends = rings.points + along * cut[:, None]
    gone = lengths - cut - rings.after(cut) <= LEAST_MM
    ends[gone] = rings.after(starts)[gone]
    starts[gone & (cut == 0)] = ends[gone & (cut == 0)]
    return starts, ends, gone


def _chained(
    rings: Boundaries, curves: Sequence[Segment | None], starts: Points, ends: Points, gone: Flags
) -> list[Loop]:
    """Loops of the curves at the corners and the lines between them."""
    lines = [
        None if none else Line(end, start)
        for none, end, start in zip(gone, _tuples(ends), _tuples(rings.after(starts)), strict=True)
    ]
    both = [pair for pairs in zip(curves, lines, strict=True) for pair in pairs]
    spans = pairwise((2 * rings.bounds).tolist())
    return [Loop(tuple(s for s in both[first:end] if s is not None)) for first, end in spans]


def _without_remnants(rings: Boundaries, cut: Lengths, lengths: Lengths) -> Lengths:
    """Cuts reduced where they would leave a straight remnant too short to be meshed or offset."""
    for _ in range(2):  # the two ends of an edge may both give way
        taken = cut + rings.after(cut)
        rest = lengths - taken
        short = (rest > LEAST_MM) & (rest < LEAST_EDGE_MM) & (taken > 0)
        factor = np.where(short, np.maximum(lengths - LEAST_EDGE_MM, 0) / np.maximum(taken, LEAST_MM), 1.0)
        cut = cut * np.minimum(factor, rings.before(factor))
    return cut


def smoothed(region: Region, tolerance_mm: float, bars: Sequence[Bridge] = ()) -> Region:
    """Stairs of pixels drawn as smooth edges that stay within the tolerance of them.

    Stairs are straightened first (Douglas and Peucker), then gentle corners become Bézier arcs that leave and
    meet the edges along their direction. Corners sharper than 60° and the edges on which bars end stay.
    """
    tips = [tip for bar in bars for tip in (bar.start, bar.end)]
    loops = [_straightened(loop.flatten(), tips, SIMPLIFY_PART * tolerance_mm) for loop in region.loops]
    kept = np.concatenate([kept for _, kept in loops])
    outer, *holes = _bent(Boundaries.of([corners for corners, _ in loops]), kept, tolerance_mm)
    return Region(outer, tuple(holes))


def _straightened(corners: Points, tips: Sequence[Point], tolerance_mm: float) -> tuple[Points, Flags]:
    """Corners of a loop with its stairs straightened, and which of them end an edge that a tip lies on."""
    import shapely

    low, high = corners.min(axis=0) - LEAST_MM, corners.max(axis=0) + LEAST_MM
    near = [tip for tip in tips if (low <= tip).all() and (tip <= high).all()]
    under = sorted(
        {k for tip in near if (k := edge_under(tip, corners, np.roll(corners, -1, axis=0))) is not None}
    )
    if not under:
        ring = shapely.simplify(shapely.Polygon(corners), tolerance_mm)
        found = shapely.get_coordinates(ring)[:-1]
        return found, np.zeros(len(found), np.bool_)
    turned = np.roll(corners, -(under[0] + 1), axis=0)
    ends = [k - under[0] for k in (*under[1:], under[0] + len(corners))]  # of the chains between those edges
    chains: list[Points] = []
    first = 0
    for end in ends:
        chain = turned[first:end]
        if len(chain) > 1:
            chain = shapely.get_coordinates(shapely.simplify(shapely.LineString(chain), tolerance_mm))
        chains.append(chain)
        first = end
    kept = [np.isin(np.arange(len(chain)), (0, len(chain) - 1)) for chain in chains]
    return np.concatenate(chains), np.concatenate(kept)


def _bent(rings: Boundaries, kept: Flags, tolerance_mm: float) -> list[Loop]:
    along, lengths, turn = _course(rings)
    turn = np.abs(turn)
    # A quadratic arc over cuts c passes its corner at c·sin(φ/2)/2.
    bow = np.maximum(np.sin(turn / 2), 1e-9)
    room = np.minimum(lengths, rings.before(lengths)) / 2
    cut = np.minimum(2 * (1 - SIMPLIFY_PART) * tolerance_mm / bow, room)
    cut[kept | (turn > SMOOTH_TURN_RAD) | (turn < STRAIGHT_TURN_RAD)] = 0.0
    cut = _without_remnants(rings, cut, lengths)
    cut[cut < LEAST_EDGE_MM / 10] = 0.0
    starts, ends, gone = _joints(rings, along, lengths, cut)
    inner = (starts + (rings.points - starts) * 2 / 3, ends + (rings.points - ends) * 2 / 3)
    joints = zip(cut > 0, *(_tuples(p) for p in (starts, *inner, ends)), strict=True)
    curves = [Bezier(start, c1, c2, end) if bent else None for bent, start, c1, c2, end in joints]
    return _chained(rings, curves, starts, ends, gone)


def _tuples(points: Points) -> list[Point]:
    return list(zip(points[:, 0].tolist(), points[:, 1].tolist(), strict=True))
