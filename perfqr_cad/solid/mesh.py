"""Triangles from the same loops as the B-rep, closed by construction.

The loops are flattened once, with as many corners on every level. Each cap is a constrained Delaunay
triangulation of its own level's corners, mapped onto the surface; the walls are quads between corresponding
corners of consecutive levels. So caps and walls share every boundary edge.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Protocol

import numpy as np

from perfqr_cad.geometry import Triangles
from perfqr_cad.geometry.arrays import Array, Indices
from perfqr_cad.geometry.cycles import following, starts_of
from perfqr_cad.geometry.outline import Point, Segment
from perfqr_cad.geometry.segments import corners, pieces, positions
from perfqr_cad.geometry.triangulation import delaunay, refined
from perfqr_cad.profile.caps import caps
from perfqr_cad.profile.loft import Loft
from perfqr_cad.profile.recess import Top

CHORD_MM = 0.01  # greatest distance between mesh and surface; a twentieth of a printed layer

# Of the chord, for rings: finer than for the caps beside them, whose triangles would be split for ever else.
RING_SHARE = 0.4
PROBES = 32  # steps at which the bend of a mapped segment is measured


class Map(Protocol):
    """Points (k, 3) of (k, 2) pattern points at one depth, or at one each."""

    def __call__(self, uv: Array, depth_mm: float | Array) -> Array: ...


@dataclass(frozen=True)
class FlatLoft:
    """A flattened loft: one (n, 2) polygon for each level, corresponding corner by corner.

    pieces  in how many sides each segment of the loft's loops is cut, (k,)
    """

    loft: Loft
    levels: tuple[Array, ...]
    pieces: Indices

    @property
    def depths_mm(self) -> tuple[float, ...]:
        return tuple(level.depth_mm for level in self.loft.levels)


def triangulate(
    lofts: Sequence[Loft],
    back_mm: float,
    place: Map,
    *,
    tops: Sequence[Top] = (),
    chord_mm: float = CHORD_MM,
    flat: bool = False,
) -> Triangles:
    """The closed mesh of a panel: the first loft is its rim. `flat` maps need no refinement.

    back_mm  depth of the back face
    """
    rings = flattened(lofts, place, chord_mm, flat, tops)
    mesh = _Mesh(place, chord_mm, flat)
    seam = _Seam(tops[0].depth_mm if tops else None, mesh)
    columns = [[seam.ring(ring, k) for k in range(len(ring.levels))] for ring in rings]
    for cap in caps(lofts, back_mm, seam.depth_mm):
        index, polygons = [columns[i][k] for i, k in cap.ends], [rings[i].levels[k] for i, k in cap.ends]
        mesh.cap(index, polygons, cap.depth_mm, up=cap.up)
    mesh.walls([band for column in columns for band in pairwise(column)])
    for top in tops:
        mesh.cap(*seam.around(top), top.depth_mm, up=True)
    return mesh.triangles()


def flattened(
    lofts: Sequence[Loft], place: Map, chord_mm: float, flat: bool, tops: Sequence[Top] = ()
) -> list[FlatLoft]:
    """The lofts as polygons whose corresponding sides keep the chord tolerance on every level."""
    counts = _pieces(lofts, place, chord_mm, flat)
    if tops:
        _agree(lofts, counts, tops[0].depth_mm)
    by_loft = np.split(counts, np.cumsum([len(loft.loops[0].segments) for loft in lofts])[:-1])
    polygons: list[list[Array]] = [[] for _ in lofts]
    for k in range(max(len(loft.loops) for loft in lofts)):
        deep = [i for i, loft in enumerate(lofts) if len(loft.loops) > k]
        segments = [segment for i in deep for segment in lofts[i].loops[k].segments]
        points = corners(segments, np.concatenate([by_loft[i] for i in deep]))
        bounds = np.cumsum([int(by_loft[i].sum()) for i in deep])[:-1]
        for i, polygon in zip(deep, np.split(points, bounds), strict=True):
            polygons[i].append(polygon)
    return [FlatLoft(loft, tuple(p), n) for loft, p, n in zip(lofts, polygons, by_loft, strict=True)]


def _agree(lofts: Sequence[Loft], counts: Indices, depth_mm: float) -> None:
    """Cut the segments that meet at a depth, of the walls above and below, in as many pieces."""
    rows: dict[tuple[Point, Point], list[int]] = {}
    first = 0
    for loft in lofts:
        for loop, level in zip(loft.loops, loft.levels, strict=True):
            if level.depth_mm == depth_mm:
                for row, segment in enumerate(loop.segments, first):
                    rows.setdefault((segment.start, segment.end), []).append(row)
        first += len(loft.loops[0].segments)
    for pair in rows.values():
        counts[pair] = counts[pair].max()


def _pieces(lofts: Sequence[Loft], place: Map, chord_mm: float, flat: bool) -> Indices:
    """In how many pieces each segment of the lofts' loops is cut, the same on all its levels."""
    counts = np.ones(sum(len(loft.loops[0].segments) for loft in lofts), np.int64)
    by_depth: dict[float, tuple[list[int], list[Segment]]] = {}
    first = 0
    for loft in lofts:
        for loop, level in zip(loft.loops, loft.levels, strict=True):
            rows, segments = by_depth.setdefault(level.depth_mm, ([], []))
            rows += range(first, first + len(loop.segments))
            segments += loop.segments
        first += len(loft.loops[0].segments)
    for rows, segments in by_depth.values():
        np.maximum.at(counts, rows, pieces(segments, chord_mm))
    if flat:
        return counts
    for depth, (rows, segments) in by_depth.items():
        mapped = place(positions(segments, np.linspace(0, 1, PROBES + 1)).reshape(-1, 2), depth)
        bend = np.linalg.norm(np.diff(mapped.reshape(-1, PROBES + 1, 3), 2, axis=1), axis=2).max(axis=1)
        # A second difference b over steps of 1/N is a sagitta of b (N/n)² / 8 in n pieces.
        sharp = np.ceil(PROBES * np.sqrt(bend / (8 * RING_SHARE * chord_mm))).astype(np.int64)
        np.maximum.at(counts, rows, sharp)
    return counts


class _Mesh:
    """Vertices and faces as they are collected."""

    def __init__(self, place: Map, chord_mm: float, flat: bool) -> None:
        self._place = place
        self._chord_mm = chord_mm
        self._flat = flat
        self._points: list[tuple[Array, float]] = []
        self._faces: list[Indices] = []
        self._count = 0
        self._last: tuple[Sequence[Array], Indices] | None = None

    def ring(self, uv: Array, depth_mm: float) -> Indices:
        """Points at a depth; their indices."""
        self._points.append((uv, depth_mm))
        self._count += len(uv)
        return np.arange(self._count - len(uv), self._count)

    def walls(self, bands: Sequence[tuple[Indices, Indices]]) -> None:
        """Quads between the upper and the lower ring of each, outside to the right of travel."""
        upper, lower = (np.concatenate(rings) for rings in zip(*bands, strict=True))
        after = following(starts_of(len(ring) for ring, _ in bands))
        self._faces += [
            np.column_stack([lower, lower[after], upper[after]]),
            np.column_stack([lower, upper[after], upper]),
        ]

    def cap(self, rings: Sequence[Indices], polygons: Sequence[Array], depth_mm: float, *, up: bool) -> None:
        """Fill the first ring, less the others, at a depth; `up` looks at the reader."""
        uv, index = np.vstack(polygons), np.concatenate(rings)
        faces = self._triangles(polygons)
        if not self._flat:
            corners = len(uv)
            uv, faces = refined(uv, faces, lambda points: self._place(points, depth_mm), self._chord_mm)
            index = np.concatenate([index, self.ring(uv[corners:], depth_mm)])
        faces = index[faces]
        self._faces.append(faces if up else faces[:, ::-1])

    def _triangles(self, polygons: Sequence[Array]) -> Indices:
        """Those of the cap before, if it had the same polygons: the front and the back of straight walls."""
        before = self._last
        if before is None or not _same(before[0], polygons):
            before = self._last = polygons, delaunay(polygons)
        return before[1]

    def triangles(self) -> Triangles:
        uv, depth_mm = zip(*self._points, strict=True)
        depths_mm = np.repeat(depth_mm, [len(points) for points in uv])
        return Triangles(self._place(np.vstack(uv), depths_mm), np.vstack(self._faces))


def _same(one: Sequence[Array], other: Sequence[Array]) -> bool:
    return len(one) == len(other) and all(map(np.array_equal, one, other))


class _Seam:
    """The corners at the level of bar tops, which the walls above and below share."""

    def __init__(self, depth_mm: float | None, mesh: _Mesh) -> None:
        self.depth_mm = depth_mm
        self._mesh = mesh
        self._sides: dict[tuple[Point, Point], tuple[Indices, Array]] = {}
        self._ends: dict[Point, int] = {}

    def ring(self, ring: FlatLoft, k: int) -> Indices:
        """The corners of a loft on a level; on that of the tops, new ones only where no loft has any."""
        if ring.depths_mm[k] != self.depth_mm:
            return self._mesh.ring(ring.levels[k], ring.depths_mm[k])
        found: list[Indices] = []
        sides = pairwise(starts_of(ring.pieces).tolist())
        for segment, (a, b) in zip(ring.loft.loops[k].segments, sides, strict=True):
            ends = segment.start, segment.end
            if ends not in self._sides:
                uv = ring.levels[k][a:b]
                index = self._mesh.ring(uv, ring.depths_mm[k])
                index[0] = self._ends.setdefault(segment.start, int(index[0]))
                self._sides[ends] = index, uv
            found.append(self._sides[ends][0])
        return np.concatenate(found)

    def around(self, top: Top) -> tuple[list[Indices], list[Array]]:
        """Corners and polygon around the top of a bar, as one ring each."""
        indices: list[Indices] = []
        polygon: list[Array] = []
        for segment in top.loop.segments:
            side = self._sides.get((segment.start, segment.end))
            if side is None:  # the edge runs the other way round
                index, uv = self._sides[(segment.end, segment.start)]
                first = np.array([self._ends[segment.start]])
                side = np.append(first, index[:0:-1]), np.vstack([segment.start, uv[:0:-1]])
            indices.append(side[0])
            polygon.append(side[1])
        return [np.concatenate(indices)], [np.vstack(polygon)]
