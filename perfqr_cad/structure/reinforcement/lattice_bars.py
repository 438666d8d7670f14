"""Bars along the lattice of modules: where structural bridges are looked for."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np
import shapely
from numpy.typing import NDArray

from perfqr_cad.structure.mesh.triangle import Floats
from perfqr_cad.structure.reinforcement.bar_candidates import Allowance, Candidates, affordable, holes_of

if TYPE_CHECKING:
    from perfqr_cad.pattern import Pattern

LINES_PER_MODULE = 2  # bars run along module edges and module centres
LONGEST_MODULES = 4.0
DIAGONAL_STEP_MODULES = 1.0
LEAST_SPAN_MM = 1e-6  # rounding of a line that touches a hole
SLANT = np.sqrt(0.5)
WAYS = tuple(np.array(way) for way in ((1.0, 0.0), (0.0, 1.0), (SLANT, SLANT), (SLANT, -SLANT)))


def lattice_candidates(pattern: Pattern, allowance: Allowance, widths_mm: tuple[float, ...]) -> Candidates:
    """Upright and diagonal bars along the lattice that keep the least gap to both sides, all affordable."""
    holes = holes_of(pattern.polygon)
    walls = _lattice_spans(pattern, holes)
    found = [_across(pattern, holes, walls, width) for width in widths_mm]
    start, end, width = (np.concatenate([part[k] for part in found]) for k in range(3))
    return affordable(pattern, allowance, start, end, width)


def _across(
    pattern: Pattern, holes: NDArray[np.object_], walls: list[_Sides], width: float
) -> tuple[Floats, Floats, Floats]:
    """Bars of one width along lattice lines, each across one hole; `walls`: the lines inside whole holes."""
    # A centre line inside the shrunken hole keeps the bar clear of the walls beside it.
    # Large holes fall into pieces there.
    shrunk = shapely.get_parts(shapely.buffer(holes, -(width / 2 + pattern.spec.gap_mm), join_style="mitre"))
    longest = LONGEST_MODULES * pattern.module_mm
    clear = [above for above, _ in _lattice_spans(pattern, shrunk)]
    ends = [
        inner.reaching(sides, longest).ends(way) for way, sides, inner in zip(WAYS, walls, clear, strict=True)
    ]
    start, end = (np.concatenate([pair[k] for pair in ends]) for k in range(2))
    return start, end, np.full(len(start), width)


@dataclass(frozen=True)
class _Spans:
    """Stretches of parallel lines: at places `at` (k,) across, from `first` to `last` (k,) along.

    Sorted by place, then along; those on one line do not overlap.
    """

    at: Floats
    first: Floats
    last: Floats

    def reaching(self, sides: _Sides, longest: float) -> _Spans:
        """These drawn out to the walls on both sides of their lines, if shorter then than a length."""
        above, below = (self._within(spans) for spans in sides)
        first, last = np.maximum(above[0], below[0]), np.minimum(above[1], below[1])
        kept = (self.last - self.first > LEAST_SPAN_MM) & (last - first < longest)
        at, first, last = np.unique(np.stack([self.at, first, last], axis=1)[kept], axis=0).T
        return _Spans(at, first, last)

    def _within(self, outer: _Spans) -> tuple[Floats, Floats]:
        """Beginning and end (k,) of the outer one that each of these begins in."""
        order = np.lexsort((np.r_[outer.first, self.first], np.r_[outer.at, self.at]))
        is_outer = order < len(outer.at)
        holder = np.empty(len(self.at), np.int64)
        holder[order[~is_outer] - len(outer.at)] = (np.cumsum(is_outer) - 1)[~is_outer]
        return outer.first[holder], outer.last[holder]

    def ends(self, way: Floats) -> tuple[Floats, Floats]:
        """Where they begin and end, (k, 2) each, for lines that run a way (unit vector)."""
        across = self.at[:, None] * np.array([-way[1], way[0]])
        return across + self.first[:, None] * way, across + self.last[:, None] * way


_Sides = tuple[_Spans, _Spans]  # just above lines and just below them: walls may run along a line


def _lattice_spans(pattern: Pattern, polygons: NDArray[np.object_]) -> list[_Sides]:
    """What polygons without holes, apart from each other, cover of the lattice lines of each way."""
    points, ring = shapely.get_coordinates(shapely.get_rings(polygons), return_index=True)
    same = ring[1:] == ring[:-1]
    tails, heads = points[:-1][same], points[1:][same]
    n, m = pattern.symbol.size, pattern.module_mm
    half = n * LINES_PER_MODULE // 2
    straight = (np.arange(-half, half + 1) + 0.5 * (n * LINES_PER_MODULE % 2)) * m / LINES_PER_MODULE
    diagonal = np.arange(-n, n + DIAGONAL_STEP_MODULES, DIAGONAL_STEP_MODULES) * m * SLANT
    lines = (straight, straight, diagonal, diagonal)
    return [
        (_spans(tails, heads, way, at, "right"), _spans(tails, heads, way, at, "left"))
        for way, at in zip(WAYS, lines, strict=True)
    ]


def _spans(
    tails: Floats, heads: Floats, way: Floats, lines: Floats, side: Literal["left", "right"]
) -> _Spans:
    """The stretches inside closed outlines (by edges) of lines that run a way at sorted places."""
    across = np.array([-way[1], way[0]])
    low, high = tails @ across, heads @ across
    # An end on a line counts as above it, or below, so that outlines cross lines an even number of times.
    bounds = np.sort([low, high], axis=0)
    first, last = np.searchsorted(lines, bounds, side)
    count = last - first
    edge = np.repeat(np.arange(len(tails)), count)
    line = np.repeat(first, count) + np.arange(len(edge)) - np.repeat(np.cumsum(count) - count, count)
    share = (lines[line] - low[edge]) / (high[edge] - low[edge])
    along = (tails @ way)[edge] + share * ((heads - tails) @ way)[edge]
    order = np.lexsort((along, line))
    at, along = lines[line[order]][::2], along[order]
    return _Spans(at, along[::2], along[1::2])
