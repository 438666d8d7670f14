"""The front face, where recessed bars are missing, and the whole material, where they join its pieces.

A recessed bar ends on straight edges of the front, so the material's outline is the front's own with those
edges cut open and the two sides of the bar put in: nothing is traced or united a second time.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from perfqr_cad.errors import DesignError
from perfqr_cad.geometry.outline import Line, Loop, Point, Points, Region, Segment
from perfqr_cad.pattern.bridge import Bridge
from perfqr_cad.remedy import Remedy

ON_EDGE_MM = 1e-6  # rounding of coordinates


def regions(outers: Sequence[Loop], holes: Sequence[Loop]) -> tuple[Region, ...]:
    """Each hole put into the smallest outer loop around it; the greatest region first."""
    import shapely

    ordered = sorted(outers, key=lambda loop: loop.area)
    points = np.array([hole.segments[0].start for hole in holes]).reshape(-1, 2)
    free = np.ones(len(holes), np.bool_)
    found: list[Region] = []
    for outer in ordered[:-1]:
        corners = outer.flatten()
        near = free & ((points >= corners.min(axis=0)) & (points <= corners.max(axis=0))).all(axis=1)
        inside = np.flatnonzero(near)
        inside = inside[shapely.contains_xy(shapely.Polygon(corners), points[inside])]
        free[inside] = False
        found.append(Region(outer, tuple(holes[k] for k in inside.tolist())))
    found.append(Region(ordered[-1], tuple(holes[k] for k in np.flatnonzero(free).tolist())))
    return tuple(reversed(found))


def front_with_bars(front: Sequence[Region], bars: Sequence[Bridge]) -> Region:
    """The front with its recessed bars as material. DesignError when that is not one piece."""
    loops = [loop for region in front for loop in region.loops]
    outers = [region.outer for region in front]
    if bars:
        outline = _Outline(loops, len(bars))
        for bar in bars:
            outline.join(bar)
        kept, changed = outline.loops()
        loops = kept + changed
        known = set(map(id, outers))
        outers = [loop for loop in kept if id(loop) in known] + [loop for loop in changed if loop.area > 0]
    if len(outers) != 1:
        raise DesignError(
            f"{len(outers)} pieces are left after bridging, 1 is needed", "a larger code", "a finer nozzle"
        )
    return Region(outers[0], tuple(loop for loop in loops if loop is not outers[0]))


def edge_under(point: Point, starts: Points, ends: Points) -> int | None:
    """Index of the straight edge that a point lies on; edges run from (k, 2) starts to ends, mm."""
    along, offset = ends - starts, np.array(point) - starts
    length = np.hypot(along[:, 0], along[:, 1])
    reach, away = (along * offset).sum(axis=1), along[:, 0] * offset[:, 1] - along[:, 1] * offset[:, 0]
    under = np.flatnonzero((reach >= 0) & (reach <= length**2) & (np.abs(away) <= ON_EDGE_MM * length))
    return int(under[0]) if len(under) else None


class _Outline:
    """Loops as one list of segments, each with the index of the one that follows it."""

    def __init__(self, loops: Sequence[Loop], bars: int) -> None:
        self._loops = loops
        self._bounds = np.cumsum([0, *(len(loop.segments) for loop in loops)]).tolist()
        self._segments: list[Segment] = []
        self._after: list[int] = []
        self._new: list[int] = []
        # Ends of the straight ones; no comparison with NaN holds.
        self._ends = np.full((2, self._bounds[-1] + 4 * bars, 2), np.nan)
        for loop, first in zip(loops, self._bounds, strict=False):
            for segment in loop.segments:
                self._add(segment)
            self._after[-1] = first

    def join(self, bar: Bridge) -> None:
        """Opens the edges at both ends of a bar and puts its sides in between."""
        right_start, right_end, left_end, left_start = bar.corners()
        arriving, leaving = self._opened(bar.start, right_start, left_start)
        returning, going_on = self._opened(bar.end, left_end, right_end)
        self._after[arriving] = out = self._add(Line(right_start, right_end))
        self._after[out] = going_on
        self._after[returning] = back = self._add(Line(left_end, left_start))
        self._after[back] = leaving
        self._new += (out, back)

    def loops(self) -> tuple[list[Loop], list[Loop]]:
        """Loops that are as they were, and those with a bar."""
        seen: set[int] = set()
        changed: list[Loop] = []
        for first in self._new:
            chain: list[int] = []
            at = first
            while at not in seen:
                seen.add(at)
                chain.append(at)
                at = self._after[at]
            if chain:
                changed.append(Loop(tuple(self._segments[k] for k in chain)))
        kept = [loop for loop, k in zip(self._loops, self._bounds, strict=False) if k not in seen]
        return kept, changed

    def _add(self, segment: Segment) -> int:
        """Index of a new segment, followed by the next to be added."""
        at = len(self._segments)
        self._segments.append(segment)
        self._after.append(at + 1)
        self._set(at, segment)
        return at

    def _set(self, at: int, segment: Segment) -> None:
        self._segments[at] = segment
        if isinstance(segment, Line):
            self._ends[:, at] = segment.start, segment.end

    def _holds(self, at: int, *points: Point) -> bool:
        """Whether a straight edge reaches as far as these points on its line."""
        start, end = self._ends[:, at]
        along = (np.array(points) - start) @ (end - start) / math.dist(start, end)
        return bool((along >= -ON_EDGE_MM).all() and (along <= math.dist(start, end) + ON_EDGE_MM).all())

    def _opened(self, middle: Point, first: Point, second: Point) -> tuple[int, int]:
        """The edge around a point cut away between two others: its part before and its part after."""
        at = edge_under(middle, *self._ends)
        if at is None or not self._holds(at, first, second):
            raise DesignError(
                f"a recessed bar ends at ({middle[0]:.2f}, {middle[1]:.2f}) mm on no straight edge",
                Remedy(finder="panel"),
            )
        edge = self._segments[at]
        after = self._after[at]
        rest = self._add(Line(second, edge.end))
        self._after[rest] = after
        self._set(at, Line(edge.start, first))
        return at, rest
