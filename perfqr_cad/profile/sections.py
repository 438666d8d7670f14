"""From outlines, walls and bars to the loops at each depth: where every hole begins, flares and ends."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from shapely import Point, Polygon

from perfqr_cad.errors import KernelError
from perfqr_cad.geometry.offset import widened
from perfqr_cad.geometry.outline import LEAST_MM, Arc, Circle, Loop, Region
from perfqr_cad.pattern import Bridge
from perfqr_cad.profile.caps import Cap, caps
from perfqr_cad.profile.flare import Flared, flared_loops
from perfqr_cad.profile.loft import Level, Loft
from perfqr_cad.profile.recess import Mark, Top, crossings, landings, recessed, top_depth_mm
from perfqr_cad.profile.walls import Walls

# Steps from an edge to those that shorten it as they are set back; a rounded corner may lie between.
BESIDE = (1, 2)


@dataclass(frozen=True)
class Sections:
    """What bounds a part: its lofts, the first of them its rim, and the tops of its recessed bars.

    pieces  of the front face
    genus   number of through-holes of the solid; each bar but those that tie a piece on makes one more
    """

    lofts: tuple[Loft, ...]
    tops: tuple[Top, ...] = ()
    pieces: int = 1
    genus: int = 0

    @property
    def between_mm(self) -> tuple[float, float]:
        """Depths of the front and the back of a part with a rim."""
        rim = self.lofts[0].part_of or self.lofts[0]
        return rim.levels[0].depth_mm, rim.levels[-1].depth_mm

    @property
    def seam_mm(self) -> float | None:
        """Depth of the bars' tops, where the walls above and below meet."""
        return self.tops[0].depth_mm if self.tops else None

    @property
    def caps(self) -> tuple[Cap, ...]:
        """Front, back, tops of bosses and floors of pockets."""
        return caps(self.lofts, self.between_mm[1], self.seam_mm)


def sections(
    front: Sequence[Region],
    thickness_mm: float,
    walls: Walls,
    whole_circles: bool,
    *,
    bars: Sequence[Bridge] = (),
    min_web_mm: float = 0.0,
    rim: bool = True,
    mounts: Collection[Circle] = (),
) -> Sections:
    """The pieces of the front face followed to the back, and the bars that join them there.

    The rim, which is the first piece's outline, stays straight; with `rim` False it is left out, for a wall
    that goes on beyond the code. Holes among the `mounts` go straight through too: they are for screws.
    Where a draft would leave less than `min_web_mm` of material at the back, it is less. Pieces over pockets
    stand on the floor and need no bars.

    Raises `DesignError` when pockets leave no floor, a lip leaves nothing to flare or a draft closes an edge,
    `NoRecess` where the bars must be flush.
    """
    _require_lengths(front)
    reach = walls.reach_mm(thickness_mm)
    through = walls.depth_mm is None
    upright = {i for i, loop in enumerate(_loops(front)) if i == 0 or loop.segments[0] in mounts}
    front = [Region(*_charted(region.loops, whole_circles)) for region in front]
    flare = walls.flare_mm(reach)
    paths = _paths(front, flare, min_web_mm, rim)
    floors = [0] * len(paths) if through else _floors(front)
    bars = bars if through else ()
    where = landings([path.loop for path in paths], bars)
    paths = [path.clear_of(bars, where[i]) if i in where else path for i, path in enumerate(paths)]
    top = top_depth_mm(bars, thickness_mm) if bars else reach
    depths = {0.0, walls.lip_mm, reach} if flare and walls.lip_mm > LEAST_MM else {0.0, reach}
    lofts: list[Loft] = []
    for i, (path, floor) in enumerate(zip(paths, floors, strict=True)):
        if i in upright and i not in where:
            lofts.append(path.loft({0.0, thickness_mm}, Walls(), thickness_mm))
        else:
            lofts.append(path.loft(depths | {top} if i in where else depths, walls, reach, top, floor))
    joined, tops = recessed(lofts, bars, where, top) if bars else (tuple(lofts), ())
    holes = sum(len(region.holes) for region in front) if through else len(upright) - 1
    genus = holes + len(bars) - (len(front) - 1 if through else 0)
    return Sections(joined if rim else joined[1:], tops, len(front), genus)


def _require_lengths(front: Sequence[Region]) -> None:
    """Raises `KernelError` for a loop without segments, with one of no length, or with a gap."""
    for loop in _loops(front):
        if not loop.segments:
            raise KernelError("an outline has no segments: leave it out")
        for segment, following in pairwise((*loop.segments, loop.segments[0])):
            (x, y), (x1, y1) = segment.start, segment.end
            length = segment.radius if isinstance(segment, Circle) else math.hypot(x1 - x, y1 - y)
            if not length > LEAST_MM:
                raise KernelError(
                    f"an outline has a segment of {length:.2g} mm at ({x:.3f}, {y:.3f}) mm, at least "
                    f"{LEAST_MM:g} mm is needed: leave it out"
                )
            gap = math.dist(segment.end, following.start)
            if not gap <= LEAST_MM:
                raise KernelError(f"an outline is open by {gap:.2g} mm at ({x1:.3f}, {y1:.3f}) mm: close it")


def _loops(front: Sequence[Region]) -> list[Loop]:
    """Every loop of the pieces, each outline before its holes."""
    return [loop for region in front for loop in region.loops]


def _floors(front: Sequence[Region]) -> list[int]:
    """The floor that each loop bounds: a hole its own, a further piece that of the hole it stands in."""
    numbers: list[int] = []
    holes: list[tuple[float, Polygon, int]] = []
    for region in front:
        corner = Point(region.outer.segments[0].start)
        around = [(size, number) for size, hole, number in holes if hole.contains(corner)]
        numbers.append(min(around)[1] if around else 0)
        for hole in region.holes:
            numbers.append(len(numbers) + 1)
            if len(front) > 1:
                holes.append((abs(hole.area), Polygon(hole.flatten()), numbers[-1]))
    return numbers


@dataclass(frozen=True)
class _Path:
    """A loop of the front, and the same at the far end; None where straight."""

    loop: Loop
    piece: int
    flared: Flared | None

    def clear_of(self, bars: Sequence[Bridge], marks: dict[int, list[Mark]]) -> _Path:
        """The path with the banks of pinched slots upright, so that those stay narrow and dark, and the
        segments beside any bar's edge set back by no more than that can lose."""
        if self.flared is None:
            return self
        flares = self.flared.set_back_mm.copy()
        n = len(flares)
        for s, found in marks.items():
            edge = self.loop.segments[s]
            if any(bars[mark.bar].pinched for mark in found):
                flares[s] = 0.0
            sides = [foot for mark in found for foot in crossings(edge, bars[mark.bar])]
            for way, room in ((-1, min(sides)), (1, edge.length - max(sides))):
                for step in BESIDE:
                    k = (s + way * step) % n
                    flares[k] = min(flares[k], max(room / 2, 0.0))
        return replace(self, flared=Flared(widened([self.loop], flares)[0], flares))

    def loft(
        self,
        depths_mm: set[float],
        walls: Walls,
        reach_mm: float,
        top_mm: float | None = None,
        floor: int = 0,
    ) -> Loft:
        """The loop at some depths of walls that reach so far; faces lie at both ends and at the tops."""
        levels = tuple(Level(depth, depth in (0.0, top_mm, reach_mm)) for depth in sorted(depths_mm))
        loops: list[Loop] = []
        for level in levels:
            share = (level.depth_mm - walls.lip_mm) / (reach_mm - walls.lip_mm)
            if self.flared is None or share <= 0:
                loops.append(self.loop)
            elif share == 1:
                loops.append(self.flared.loop)
            else:
                loops += widened([self.loop], self.flared.set_back_mm, share)
        return Loft(tuple(loops), levels, floor, piece=self.piece)


def _paths(front: Sequence[Region], flare_mm: float, min_web_mm: float, rim: bool) -> list[_Path]:
    """Every loop of the front, outlines before holes; the first outline straight."""
    loops = [(loop, piece) for piece, region in enumerate(front) for loop in region.loops]
    flared: list[Flared | None] = [None] * len(loops)
    if flare_mm and len(loops) > 1:
        outer = front[0].outer
        if not rim:
            outer = _around([loop for loop, _ in loops[1:]], 2 * flare_mm + min_web_mm)
        flared[1:] = flared_loops([Region(outer, front[0].holes), *front[1:]], flare_mm, min_web_mm)
    return [_Path(loop, piece, far) for (loop, piece), far in zip(loops, flared, strict=True)]


def _around(loops: Sequence[Loop], margin_mm: float) -> Loop:
    """A rectangle well clear of all loops."""
    corners = np.vstack([loop.flatten() for loop in loops])
    (x0, y0), (x1, y1) = corners.min(axis=0) - 2 * margin_mm - 1, corners.max(axis=0) + 2 * margin_mm + 1
    return Loop.from_points([(x0, y0), (x1, y0), (x1, y1), (x0, y1)])


def _charted(loops: Sequence[Loop], whole_circles: bool) -> tuple[Loop, tuple[Loop, ...]]:
    """The loops, lone circles cut in two half-circles where the chart wants it so; first and others."""
    first, *others = (loop if whole_circles else halved(loop) for loop in loops)
    return first, tuple(others)


def halved(loop: Loop) -> Loop:
    """A lone circle as two half-circles; other loops as they are."""
    first = loop.segments[0]
    if not isinstance(first, Circle):
        return loop
    (cx, cy), r = first.centre, first.radius
    right, left = (cx + r, cy), (cx - r, cy)
    return Loop((Arc(right, left, first.centre, first.ccw), Arc(left, right, first.centre, first.ccw)))
