"""Where a structural bridge could go: straight bars across one hole, from light to light."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Literal

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry import Polygon

from perfqr_cad.pattern import Bridge
from perfqr_cad.structure.t6 import Floats, Ints
from perfqr_cad.symbol import ReadabilityTracker, layout
from perfqr_cad.symbol.layout import Role

if TYPE_CHECKING:
    from perfqr_cad.pattern import Pattern

LINES_PER_MODULE = 2  # bars run along module edges and module centres
LONGEST_MODULES = 4.0
DIAGONAL_STEP_MODULES = 1.0
LEAST_SPAN_MM = 1e-6  # rounding of a line that touches a hole
STANDS_ON_WIDTHS = 0.45  # from the middle of a bar's end: its corners, half a width off, are of the part
SLANT = np.sqrt(0.5)
WAYS = tuple(np.array(way) for way in ((1.0, 0.0), (0.0, 1.0), (SLANT, SLANT), (SLANT, -SLANT)))
CENTRE_SAMPLES = 5  # a side, over the centre third of a module: where decoders look (§4.2)
LIGHTENED = 0.5  # share of a module's centre that a bar must cover to turn it light
# Bars across their rings blind most decoders, whatever Eqs. (1)-(3) say of them (they count data only).
KEPT_CLEAR = (Role.FINDER, Role.ALIGNMENT)


@dataclass(frozen=True)
class Candidates:
    """Bars by rows: `start`, `end` (k, 2) on the light boundary, `width_mm` (k,).

    `loss` (k,) is the rise of L(Q), `covered` (k,) how many dark module centres a bar lightens, as a sum of
    shares.
    """

    start: Floats
    end: Floats
    width_mm: Floats
    loss: Floats
    covered: Floats

    def __len__(self) -> int:
        return len(self.start)

    @property
    def length_mm(self) -> Floats:
        """Lengths (k,)."""
        return np.linalg.norm(self.end - self.start, axis=1)

    def take(self, which: NDArray[np.int64] | NDArray[np.bool_]) -> Candidates:
        """The rows chosen."""
        return Candidates(
            self.start[which], self.end[which], self.width_mm[which], self.loss[which], self.covered[which]
        )

    def in_the_way_of(self, row: int, gap_mm: float) -> NDArray[np.bool_]:
        """The bars (k,) that would leave less than a gap to one of them, or cross it; itself too."""
        clear = 0.5 * (self.width_mm + self.width_mm[row]) + gap_mm
        return np.asarray(shapely.distance(self._lines, self._lines[row]) < clear)

    def cover(self, points: Floats) -> NDArray[np.bool_]:
        """Which points of the wall (r, 2) each bar stands on, (r, k)."""
        ends = np.stack([self.start, self.end])
        reach = np.linalg.norm(points[:, None, None] - ends, axis=3).min(axis=1)
        return np.asarray(reach < STANDS_ON_WIDTHS * self.width_mm)

    @cached_property
    def _lines(self) -> NDArray[np.object_]:
        return np.asarray(shapely.linestrings(np.stack([self.start, self.end], axis=1)))

    def bridge(self, row: int, cost: float) -> Bridge:
        """One row as a structural bridge."""
        (x0, y0), (x1, y1) = self.start[row].tolist(), self.end[row].tolist()
        return Bridge((x0, y0), (x1, y1), float(self.width_mm[row]), "structural", cost)


def lattice_candidates(pattern: Pattern, widths_mm: tuple[float, ...]) -> Candidates:
    """Upright and diagonal bars along the lattice that keep the least gap to both sides, all affordable."""
    holes = holes_of(pattern.polygon)
    walls = _lattice_spans(pattern, holes)
    found = [_across(pattern, holes, walls, width) for width in widths_mm]
    start, end, width = (np.concatenate([part[k] for part in found]) for k in range(3))
    return affordable(pattern, start, end, width)


def holes_of(polygon: Polygon) -> NDArray[np.object_]:
    """The holes of a region as polygons."""
    return np.array([Polygon(ring) for ring in polygon.interiors], dtype=object)


def affordable(pattern: Pattern, start: Floats, end: Floats, width: Floats) -> Candidates:
    """The bars that leave L(Q) finite and touch no finder or alignment ring, with their losses."""
    if not len(start):
        return Candidates(start, end, width, width, width)
    tracker = ReadabilityTracker(pattern.symbol, pattern.observed)
    today = tracker.total
    dark = pattern.observed.dark
    roles = layout(pattern.symbol.version, pattern.symbol.level).roles
    forbidden = np.isin(roles, KEPT_CLEAR) & pattern.symbol.matrix.dark
    modules, share, touched = coverage(pattern, start, end, width)
    rows, columns = modules[..., 0], modules[..., 1]
    barred = (forbidden[rows, columns] & touched).any(axis=1)
    flips = (share >= LIGHTENED) & dark[rows, columns]
    loss = np.where(barred, np.inf, 0.0)
    for k in np.flatnonzero(flips.any(axis=1) & ~barred):
        loss[k] = tracker.preview(map(tuple, modules[k, flips[k]].tolist())) - today
    kept = np.isfinite(loss)
    covered = (share * dark[rows, columns]).sum(axis=1)
    return Candidates(start[kept], end[kept], width[kept], loss[kept], covered[kept])


def coverage(
    pattern: Pattern, start: Floats, end: Floats, width: Floats
) -> tuple[Ints, Floats, NDArray[np.bool_]]:
    """What k bars cover of the modules near them.

    Returns rows and columns of the modules (k, w, 2), the share of each one's centre that the bar covers
    (k, w), and whether it enters the module at all (k, w).
    """
    n, m = pattern.symbol.size, pattern.module_mm
    low = (np.minimum(start, end) - width[:, None] / 2) / m + n / 2
    high = (np.maximum(start, end) + width[:, None] / 2) / m + n / 2
    first = np.floor(low).astype(np.int64)
    window = np.arange(int((np.floor(high) - first).max(initial=0)) + 1)
    x = first[:, 0, None, None] + window[None, None, :]
    y = first[:, 1, None, None] + window[None, :, None]
    modules = np.stack(np.broadcast_arrays(n - 1 - y, x), axis=-1).reshape(len(start), -1, 2)
    outside = ((modules < 0) | (modules >= n)).any(axis=2)
    centres = np.stack([modules[..., 1] + 0.5 - n / 2, n / 2 - modules[..., 0] - 0.5], axis=-1) * m
    share = _inside(centres, m / 3, start, end, width).mean(axis=2)
    touched = _inside(centres, m, start, end, width).any(axis=2)
    return np.clip(modules, 0, n - 1), np.where(outside, 0.0, share), np.asarray(touched & ~outside)


def _inside(centres: Floats, edge: float, start: Floats, end: Floats, width: Floats) -> NDArray[np.bool_]:
    """Which samples of squares about the centres (k, w, 2) each bar covers: (k, w, samples)."""
    steps = ((np.arange(CENTRE_SAMPLES) + 0.5) / CENTRE_SAMPLES - 0.5) * edge
    grid = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
    length = np.linalg.norm(end - start, axis=1)[:, None, None]
    along = (end - start) / length[:, 0]
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)
    offset = centres - start[:, None]
    # Position along and across the bar: that of the centre plus that of the sample.
    s = np.einsum("kwc,kc->kw", offset, along)[..., None] + (along @ grid.T)[:, None]
    t = np.einsum("kwc,kc->kw", offset, across)[..., None] + (across @ grid.T)[:, None]
    return (s >= 0) & (s <= length) & (np.abs(t) <= width[:, None, None] / 2)


def _across(
    pattern: Pattern, holes: NDArray[np.object_], walls: list[_Sides], width: float
) -> tuple[Floats, Floats, Floats]:
    """Bars of one width along lattice lines, each across one hole; `walls`: the lines inside whole holes."""
    # A centre line inside the shrunken hole keeps the bar clear of the walls beside it.
    shrunk = shapely.buffer(holes, -(width / 2 + pattern.spec.gap_mm), join_style="mitre")
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
