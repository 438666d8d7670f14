"""Lofts become a shell without booleans: loops are edges of faces, walls are stitched between them.

Seen from the reader, the outer loop runs counter-clockwise and holes run clockwise. Out of the material is
then always to the right of travel, for the rim and for every hole alike. All is numbered by arithmetic: a
loft of n segments on m levels has m rings of n edges, n · (m − 1) edges down its walls, and as many walls.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from perfqr_cad.geometry.arrays import Array, Indices, Mask
from perfqr_cad.geometry.cycles import following, numbering, owners, starts_of
from perfqr_cad.geometry.outline import Loop, Point
from perfqr_cad.profile.caps import FIRST, Cap
from perfqr_cad.profile.loft import Loft
from perfqr_cad.profile.sections import Sections
from perfqr_cad.solid.charts.chart import Chart, Columns
from perfqr_cad.solid.tables.batches import Curves, Lines, Surfaces
from perfqr_cad.solid.tables.brep import TOLERANCE_MM, Batch, Brep, CurveTable, SurfaceTable

# Uses of a wall's edges, seen from outside: along the lower edge, up, back along the upper edge, down.
LOWER, END, UPPER, START = range(4)
SIDES = 4

Walk = tuple[Indices, Mask]  # rings of a loop, and which way each is gone through


def panel(sections: Sections, chart: Chart) -> Brep:
    """The shell of a part: its caps (`Sections.caps`), tops of bars, walls.

    Without a rim the front and the back are no faces of their own, but holes in those of something else.
    """
    rings = LoopEdges.of(sections)
    loops = [[rings.end(*end) for end in cap.ends] for cap in sections.caps]
    loops += [[rings.along(top.loop)] for top in sections.tops]
    walks = [walk for face in loops for walk in face]
    cap_uses, cap_ahead = (np.concatenate(part) for part in zip(*walks, strict=True))
    count, upper = len(rings.edge), np.flatnonzero(rings.below >= 0)
    drops = rings.edge_count + np.arange(len(upper))
    drop = numbering(count, upper, drops)
    walls = [rings.edge[rings.below[upper]], drop[rings.after[upper]], rings.edge[upper], drops]
    points = rings.points(sections.lofts, chart)
    along, down = (np.column_stack([rings.vertex, rings.vertex[to]]) for to in (rings.after, rings.below))
    ends = np.concatenate([along[rings.owner], down[upper]])
    numbers = _Numbers(
        edge=np.where(rings.owner, rings.edge, -1),
        cap_use=numbering(count, cap_uses),
        wall_use=numbering(count, upper, len(cap_uses) + SIDES * np.arange(len(upper))),
        wall=numbering(count, upper),
    )
    geometry = _Geometry.of(rings, numbers, sections.lofts, chart)
    surfaces, outward = _caps([*sections.caps, *(top.cap for top in sections.tops)], chart)
    faces = len(loops) + np.arange(len(upper))
    return Brep(
        points=points,
        ends=ends,
        curves=(*geometry.curves, Batch(drops, Lines(points[ends[drops, 0]], points[ends[drops, 1]]))),
        tolerance_mm=np.concatenate([geometry.tolerance_mm, np.full(len(drops), TOLERANCE_MM)]),
        edges=np.concatenate([rings.edge[cap_uses], np.column_stack(walls).ravel()]),
        ahead=np.concatenate([cap_ahead, np.tile([True, False, False, True], len(upper))]),
        images=geometry.images,
        loops=starts_of([*(len(walk) for walk, _ in walks), *[SIDES] * len(upper)]),
        bounds=starts_of([*map(len, loops), *[1] * len(upper)]),
        surfaces=(*surfaces, *(batch.renumbered(faces) for batch in geometry.surfaces)),
        outward=np.concatenate([outward, geometry.outward]),
        shells=np.array([0, len(loops) + len(upper)]),
    )


@dataclass(frozen=True, eq=False)
class LoopEdges:
    """The edges along all loops of all lofts, loft by loft and level by level.

    start   (W + 1,) first ring of each loft; size (W,) its segments on a level
    after   (R,) the next along the same loop
    below   (R,) the one under it, −1 on the last level
    vertex  (R,) at its start
    edge    (R,); at the level of bar tops the walls above and below share theirs
    owner   (R,) whether the edge is this ring's own
    seam    rings at the level of bar tops, by start and end
    """

    start: Indices
    size: Indices
    after: Indices
    below: Indices
    vertex: Indices
    edge: Indices
    owner: Mask
    seam: dict[tuple[Point, Point], int]

    @staticmethod
    def of(sections: Sections) -> LoopEdges:
        lofts = sections.lofts
        size = np.array([len(loft.loops[0].segments) for loft in lofts])
        levels = np.array([len(loft.levels) for loft in lofts])
        start = starts_of(size * levels)
        number = np.arange(start[-1])
        loft = owners(start)
        after = following(starts_of(np.repeat(size, levels)))
        under = number + size[loft]
        below = np.where(under < start[loft + 1], under, -1)
        corner, side = number.copy(), number.copy()
        corners: dict[Point, int] = {}
        seam: dict[tuple[Point, Point], int] = {}
        for i, k in _on_seam(sections):
            for ring, s in enumerate(lofts[i].loops[k].segments, int(start[i] + k * size[i])):
                corner[ring] = corners.setdefault(s.start, ring)
                side[ring] = seam.setdefault((s.start, s.end), ring)
        vertex, edge = (np.unique(a, return_inverse=True)[1] for a in (corner, side))
        return LoopEdges(start, size, after, below, vertex, edge, side == number, seam)

    @property
    def edge_count(self) -> int:
        return int(self.edge.max()) + 1

    def end(self, loft: int, end: int) -> Walk:
        """The first or last loop of a loft, as seen from outside."""
        step = np.arange(self.size[loft])
        if end == FIRST:
            return self.start[loft] + step, np.ones(len(step), np.bool_)
        return self.start[loft + 1] - 1 - step, np.zeros(len(step), np.bool_)

    def along(self, loop: Loop) -> Walk:
        """The rings around the top of a bar."""
        ends = [(s.start, s.end) for s in loop.segments]
        ahead = [pair in self.seam for pair in ends]
        found = [self.seam[a, b] if way else self.seam[b, a] for (a, b), way in zip(ends, ahead, strict=True)]
        return np.array(found), np.array(ahead)

    def points(self, lofts: Sequence[Loft], chart: Chart) -> Array:
        """Of the vertices, (V, 3)."""
        uv = np.array([s.start for loft in lofts for loop in loft.loops for s in loop.segments])
        depths = [level.depth_mm for loft in lofts for level in loft.levels]
        depth = np.repeat(depths, np.repeat(self.size, [len(loft.levels) for loft in lofts]))
        points = np.empty((int(self.vertex.max()) + 1, 3))
        for level in sorted(set(depths)):
            here = np.flatnonzero(depth == level)
            points[self.vertex[here]] = chart.points(uv[here], level)
        return points

    def columns(self, lofts: Sequence[Loft], chart: Chart) -> Iterator[tuple[Columns, list[Indices]]]:
        """The columns of lofts, those of equal levels at once, and the rings that their traces are on each
        level (−1: none: a part of a loft has but some of its levels)."""
        groups: dict[object, list[int]] = {}
        for i, loft in enumerate(lofts):
            groups.setdefault(_whole(loft).levels, []).append(i)
        for members in groups.values():
            levels = _whole(lofts[members[0]]).levels
            n = self.size[members]
            first = np.repeat([levels.index(lofts[i].levels[0]) for i in members], n)
            count = np.repeat([len(lofts[i].levels) for i in members], n)
            top = np.repeat(self.start[members] - starts_of(n)[:-1], n) + np.arange(n.sum())
            rings = [
                np.where((first <= k) & (k < first + count), top + (k - first) * np.repeat(n, n), -1)
                for k in range(len(levels))
            ]
            stacks = [stack for i in members for stack in _whole(lofts[i]).stacks()]
            yield chart.columns(stacks, levels), rings


@dataclass(frozen=True, eq=False)
class _Numbers:
    """By ring, −1 for none: its own edge, its use in a cap, and of the wall below it the number and the first
    use."""

    edge: Indices
    cap_use: Indices
    wall: Indices
    wall_use: Indices


@dataclass(frozen=True, eq=False)
class _Geometry:
    """What a chart gives: the geometry of all rings and walls."""

    curves: CurveTable
    tolerance_mm: Array
    images: CurveTable
    surfaces: SurfaceTable
    outward: Mask

    @staticmethod
    def of(rings: LoopEdges, numbers: _Numbers, lofts: Sequence[Loft], chart: Chart) -> _Geometry:
        tolerance = np.full(rings.edge_count, TOLERANCE_MM)
        outward = np.ones(int(numbers.wall.max()) + 1, np.bool_)
        curves: list[Batch[Curves]] = []
        images: list[Batch[Curves]] = []
        surfaces: list[Batch[Surfaces]] = []
        for columns, at in rings.columns(lofts, chart):
            for traces, ring in zip(columns.traces, at, strict=True):
                edge = _taken(numbers.edge, ring)
                np.maximum.at(tolerance, edge[edge >= 0], traces.tolerance_mm[edge >= 0])
                curves += [batch.renumbered(edge) for batch in traces.curves]
                use = _taken(numbers.cap_use, ring)
                images += [batch.renumbered(use) for batch in traces.images]
            for band, ring, under in zip(columns.bands, at, at[1:], strict=False):
                upper = np.where(under >= 0, ring, -1)
                wall, use = _taken(numbers.wall, upper), _taken(numbers.wall_use, upper)
                outward[wall[wall >= 0]] = band.outward[wall >= 0]
                surfaces += [batch.renumbered(wall) for batch in band.surfaces]
                for table, side in zip(band.images, (UPPER, LOWER, START, END), strict=True):
                    images += [batch.renumbered(np.where(use >= 0, use + side, -1)) for batch in table]
        return _Geometry(_filled(curves), tolerance, _filled(images), _filled(surfaces), outward)


def _caps(caps: Sequence[Cap], chart: Chart) -> tuple[SurfaceTable, Mask]:
    """The surfaces of caps, and whether their own normals point out of the material."""
    by_depth: dict[float, list[int]] = {}
    for face, cap in enumerate(caps):
        by_depth.setdefault(cap.depth_mm, []).append(face)
    surfaces = tuple(
        Batch(np.array(faces), chart.surface(depth)[np.zeros(len(faces), np.int64)])
        for depth, faces in by_depth.items()
    )
    return surfaces, np.array([cap.up == chart.towards_reader(cap.depth_mm) for cap in caps])


def _on_seam(sections: Sections) -> list[tuple[int, int]]:
    """Lofts and levels where the walls above and below bars meet."""
    return [
        (i, k)
        for i, loft in enumerate(sections.lofts)
        for k, level in enumerate(loft.levels)
        if level.depth_mm == sections.seam_mm
    ]


def _whole(loft: Loft) -> Loft:
    return loft.part_of or loft


def _taken(numbers: Indices, at: Indices) -> Indices:
    """The numbers at some places, −1 where the place is −1."""
    return np.where(at >= 0, numbers[at], -1)


def _filled(table: list[Batch[Any]]) -> tuple[Batch[Any], ...]:
    return tuple(batch for batch in table if len(batch.rows))
