"""Bars that fill only the back of a wall: loops are cut where a bar ends, and joined around it below.

Above the bars the front's own loops then bound the part, below them the loops of front and bars together;
each bar has a top between. Nothing is cut by the modeller.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from perfqr_cad.errors import DesignError
from perfqr_cad.geometry.outline import Line, Loop, Point, Segment
from perfqr_cad.pattern import Bridge
from perfqr_cad.pattern.bridge import LEAST_SLOT_DEPTH_MM
from perfqr_cad.profile.caps import Cap
from perfqr_cad.profile.loft import Level, Loft

CLEAR_MM = 1e-3  # between a bar's side and the ends of the edge that it stands on
ON_EDGE_MM = 1e-6  # between the end of a bar and the edge that it stands on
STEEP = 0.5  # least sine of the angle between a bar and its edge
ROUND = 1e-9  # rounding of depths, mm

Stack = tuple[Segment, ...]


class NoRecess(DesignError):
    """A bar cannot lie behind the face: it must be flush."""


@dataclass(frozen=True)
class Top:
    """The face of a bar that looks at the reader: a counter-clockwise loop of four lines at a depth."""

    loop: Loop
    depth_mm: float

    @property
    def cap(self) -> Cap:
        """Its face, which no end of a loft bounds."""
        return Cap(self.depth_mm, ())


class Mark(NamedTuple):
    """Which end of which bar."""

    bar: int
    end: int

    @property
    def opposite(self) -> Mark:
        return Mark(self.bar, 1 - self.end)


Landings = dict[int, dict[int, list[Mark]]]  # by loop and segment


class _Cut(NamedTuple):
    """A stack of a loop that is cut where bars end, and the bar that stands on it."""

    stack: Stack
    mark: Mark | None = None


def top_depth_mm(bars: Sequence[Bridge], thickness_mm: float) -> float:
    """Depth of the bars' tops, all as high as the highest. Raises `NoRecess` where the wall is too thin."""
    height = max(bar.height_mm or 0.0 for bar in bars)
    if thickness_mm - height < LEAST_SLOT_DEPTH_MM - ROUND:
        raise NoRecess(
            f"the bars are flush with the face: {height:g} mm high in a wall of {thickness_mm:g} mm, they "
            f"leave no slot of {LEAST_SLOT_DEPTH_MM:g} mm"
        )
    return thickness_mm - height


def landings(loops: Sequence[Loop], bars: Sequence[Bridge]) -> Landings:
    """Where bars end on loops of the front. Raises `NoRecess` where that is on no straight edge."""
    found: Landings = {}
    edges = [
        (segment, (k, s))
        for k, loop in enumerate(loops)
        for s, segment in enumerate(loop.segments)
        if isinstance(segment, Line)
    ]
    starts, ends = (
        np.array([getattr(segment, end) for segment, _ in edges]).reshape(-1, 2) for end in ("start", "end")
    )
    along = ends - starts
    length = np.linalg.norm(along, axis=1)
    for bar, bridge in enumerate(bars):
        for end, point in enumerate((bridge.start, bridge.end)):
            off = np.array(point) - starts
            across = np.abs(along[:, 0] * off[:, 1] - along[:, 1] * off[:, 0]) / length
            share = np.einsum("ki,ki->k", along, off) / length**2
            hit = np.flatnonzero((across <= ON_EDGE_MM) & (share > 0) & (share < 1))
            if not len(hit):
                raise _flush(bridge, "does not end on a straight edge")
            k, s = edges[hit[0]][1]
            found.setdefault(k, {}).setdefault(s, []).append(Mark(bar, end))
    return found


def recessed(
    lofts: Sequence[Loft], bars: Sequence[Bridge], where: Landings, depth_mm: float
) -> tuple[tuple[Loft, ...], tuple[Top, ...]]:
    """Lofts and bar tops of a wall whose bars fill what is behind a depth.

    Lofts that bars end on have a level there, and all of them the same levels. Raises `NoRecess` where a bar
    leaves its edges.
    """
    levels = lofts[next(iter(where))].levels
    k = [level.depth_mm for level in levels].index(depth_mm)
    cuts = {w: _cuts(lofts[w].stacks(), marks, bars) for w, marks in sorted(where.items())}
    ends = {cut.mark: cut.stack for row in cuts.values() for cut in row if cut.mark is not None}
    sides = {mark: _side(stack, ends[mark.opposite]) for mark, stack in ends.items()}
    above = {w: _between([c.stack for c in row], levels, 0, k, lofts[w].piece) for w, row in cuts.items()}
    below = [_between(stacks, levels, k, len(levels) - 1) for stacks in _joined(cuts, sides)]
    tops = tuple(_top(ends, sides, bar, k, depth_mm) for bar in range(len(bars)))
    return (*(above.get(w, loft) for w, loft in enumerate(lofts)), *below), tops


def _cuts(stacks: list[Stack], marks: dict[int, list[Mark]], bars: Sequence[Bridge]) -> list[_Cut]:
    """The stacks of a loft, those under bars cut in three and more."""
    found: list[_Cut] = []
    for s, stack in enumerate(stacks):
        found += _parted(stack, marks[s], bars) if s in marks else [_Cut(stack)]
    return found


def _parted(stack: Stack, marks: Sequence[Mark], bars: Sequence[Bridge]) -> list[_Cut]:
    """A stack of lines cut where the sides of bars meet it, in the order of travel."""
    order = sorted(marks, key=lambda mark: crossings(stack[0], bars[mark.bar]))
    rows: list[list[Segment]] = []
    for line in stack:
        feet = [0.0, *(foot for mark in order for foot in crossings(line, bars[mark.bar])), line.length]
        if min(np.diff(feet)) < CLEAR_MM:
            raise _flush(bars[order[0].bar], "meets a corner of its edge")
        corners = [line.start, *(_along(line, foot / line.length) for foot in feet[1:-1]), line.end]
        rows.append([Line(a, b) for a, b in pairwise(corners)])
    names: list[Mark | None] = [None]
    for mark in order:
        names += [mark, None]
    return [_Cut(piece, name) for piece, name in zip(zip(*rows, strict=True), names, strict=True)]


def crossings(line: Segment, bar: Bridge) -> tuple[float, float]:
    """How far along a line, mm, the two sides of a bar cross it, in the order of travel."""
    way, along = (np.subtract(s.end, s.start) / np.hypot(*np.subtract(s.end, s.start)) for s in (bar, line))
    turn = float(way[0] * along[1] - way[1] * along[0])
    if abs(turn) < STEEP:
        raise _flush(bar, "lies along its edge")
    off = np.subtract(bar.start, line.start)
    middle = float(way[0] * off[1] - way[1] * off[0]) / turn
    half = bar.width_mm / 2 / abs(turn)
    return middle - half, middle + half


def _along(line: Segment, share: float) -> Point:
    (x, y), (x1, y1) = line.start, line.end
    return x + share * (x1 - x), y + share * (y1 - y)


def _side(here: Stack, there: Stack) -> Stack:
    """The side of a bar, its material to the left: it leaves from where travel meets the bar."""
    return tuple(Line(a.start, b.end) for a, b in zip(here, there, strict=True))


def _joined(cuts: dict[int, list[_Cut]], sides: dict[Mark, Stack]) -> list[list[Stack]]:
    """The loops below the bars: along the old ones, and along a side wherever a bar begins."""
    place = {cut.mark: (w, i) for w, row in cuts.items() for i, cut in enumerate(row) if cut.mark}
    todo = {(w, i): None for w, row in cuts.items() for i, cut in enumerate(row) if not cut.mark}
    loops: list[list[Stack]] = []
    while todo:
        here = first = next(iter(todo))
        loop: list[Stack] = []
        while not loop or here != first:
            (w, i), cut = here, cuts[here[0]][here[1]]
            if cut.mark:  # along the bar to its other end, and on behind it
                loop.append(sides[cut.mark])
                w, i = place[cut.mark.opposite]
            else:
                loop.append(cut.stack)
                del todo[here]
            here = w, (i + 1) % len(cuts[w])
        loops.append(loop)
    return loops


def _between(
    stacks: Sequence[Stack], levels: tuple[Level, ...], first: int, last: int, piece: int = 0
) -> Loft:
    """A loft between two of the levels, as a part of the loft through them all."""
    loops = tuple(Loop(segments) for segments in zip(*stacks, strict=True))
    return Loft(loops[first : last + 1], levels[first : last + 1], piece=piece, part_of=Loft(loops, levels))


def _top(ends: dict[Mark, Stack], sides: dict[Mark, Stack], bar: int, k: int, depth_mm: float) -> Top:
    one, two = Mark(bar, 0), Mark(bar, 1)
    loop = sides[one][k], ends[two][k].reversed(), sides[two][k], ends[one][k].reversed()
    return Top(Loop(loop), depth_mm)


def _flush(bar: Bridge, reason: str) -> NoRecess:
    x, y = bar.start
    return NoRecess(f"the bars are flush with the face: the one at ({x:.3f}, {y:.3f}) mm {reason}")
