"""Columns on any wall: cubic splines through points of the map, fitted to a stated tolerance, ruled faces
between.

All segments are sampled at once. Each is interpolated at m + 1 equal fractions of its parameter and checked
at the fractions between; those that miss the tolerance are taken again with twice as many pieces.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from typing import Protocol

import numpy as np

from perfqr_cad.errors import KernelError
from perfqr_cad.geometry.arrays import Array, Indices, Mask
from perfqr_cad.geometry.outline import Arc, Line, Segment
from perfqr_cad.geometry.segments import by_kind, positions, rounds
from perfqr_cad.geometry.spline import collocation, not_a_knot
from perfqr_cad.profile.loft import Level
from perfqr_cad.solid.charts.chart import Band, Columns, Images, Traces
from perfqr_cad.solid.charts.ruled import box_images, straight
from perfqr_cad.solid.tables.batches import Cones, Curves, Planes, Splines, SplineSurfaces, Surfaces
from perfqr_cad.solid.tables.brep import TOLERANCE_MM, Batch

# Between a fitted edge and the map. Edges of modules keep 1e-8; the bound is for long edges over many knots.
FIT_MM = 1e-5
FEWEST, MOST = 4, 512  # pieces of an edge
DEGREE = 3


@dataclass(frozen=True)
class Projection:
    """A parallel projection: the pattern point (x, y) lies at origin + x e1 + y e2 + s n for some s.

    origin  (3,); frame (3, 3), rows e1, e2 and n, n towards the reader
    """

    origin: Array
    frame: Array

    def at(self, points: Array) -> Array:
        """Pattern points (k, 2) in the plane through the origin, (k, 3)."""
        return self.origin + points @ self.frame[:2]

    def planes(self, lines: Sequence[Segment]) -> Planes:
        """The planes through straight segments along the line of sight; normals to the right of travel."""
        start, end = (self.at(np.array([getattr(s, name) for s in lines])) for name in ("start", "end"))
        along = (end - start) / np.linalg.norm(end - start, axis=1)[:, None]
        return Planes(start, np.cross(along, self.frame[2]), along)


class FittedWall(Protocol):
    """What a fit needs to know of a wall."""

    @property
    def projection(self) -> Projection | None:
        """The projection, where all holes run along one direction; None where they follow the normals."""
        ...

    def points(self, uv: Array, depth_mm: float) -> Array:
        """Points (k, 3) in space of (k, 2) pattern points at a depth."""
        ...

    def parameters(self, uv: Array, depth_mm: float) -> Array:
        """The same points in the parameters of `surface(depth_mm)`, (k, 2); without jumps along a segment."""
        ...

    def surface(self, depth_mm: float) -> Surfaces:
        """The surface of a face at that depth, one."""
        ...


@dataclass(frozen=True, eq=False)
class _LevelFit:
    """Segments of one level as splines: poles (k, n, 3), error (k,); on a face also image poles (k, n, 2),
    and how far curves and images are apart if that is more, (k,)."""

    poles: Array
    error_mm: Array
    apart_mm: Array
    images: Array | None = None

    def of(self, rows: Indices) -> _LevelFit:
        images = None if self.images is None else self.images[rows]
        return _LevelFit(self.poles[rows], self.error_mm[rows], self.apart_mm[rows], images)


def fitted_columns(
    stacks: Sequence[tuple[Segment, ...]], levels: tuple[Level, ...], wall: FittedWall
) -> Columns:
    """Columns on stacks of segments, one segment for each level, front first.

    Raises `KernelError` where no spline of `MOST` pieces keeps `FIT_MM`.
    """
    good_parts: list[tuple[Indices, Columns]] = []
    todo = np.arange(len(stacks))
    pieces = FEWEST
    while len(todo):
        if pieces > MOST:
            raise KernelError(
                f"an edge of the pattern misses the surface by over {FIT_MM:g} mm with {MOST} pieces: "
                "move the code away from creases of the surface"
            )
        chosen = [stacks[i] for i in todo.tolist()]
        fits = [_level_fit([s[k] for s in chosen], level, wall, pieces) for k, level in enumerate(levels)]
        good = np.max([fit.error_mm for fit in fits], axis=0) <= FIT_MM
        if good.any():
            rows = np.flatnonzero(good)
            columns = _columns(
                [chosen[i] for i in rows.tolist()], [fit.of(rows) for fit in fits], pieces, wall.projection
            )
            good_parts.append((todo[rows], columns))
        todo = todo[~good]
        pieces *= 2
    return Columns.joined(len(stacks), len(levels), good_parts)


@dataclass(frozen=True)
class _Net:
    """Interpolation at m + 1 equal fractions: flat knots, samples → poles, poles → values half-way
    between."""

    nodes: Array
    knots: tuple[float, ...]
    to_poles: Array
    to_middles: Array


@lru_cache(maxsize=16)
def _net(pieces: int) -> _Net:
    nodes = np.linspace(0.0, 1.0, 2 * pieces + 1)
    knots = not_a_knot(nodes[::2])
    to_poles = np.asarray(np.linalg.inv(collocation(knots, nodes[::2])), np.float64)
    return _Net(nodes, tuple(knots.tolist()), to_poles, collocation(knots, nodes[1::2]))


def _level_fit(segments: Sequence[Segment], level: Level, wall: FittedWall, pieces: int) -> _LevelFit:
    net = _net(pieces)
    uv = positions(segments, net.nodes)
    shape = (len(segments), len(net.nodes), -1)
    mapped = wall.points(uv.reshape(-1, 2), level.depth_mm).reshape(shape)
    poles = net.to_poles @ mapped[:, ::2]
    poles[:, 0], poles[:, -1] = mapped[:, 0], mapped[:, -1]  # to the bit, so that neighbours meet
    error = np.linalg.norm(net.to_middles @ poles - mapped[:, 1::2], axis=2).max(axis=1)
    if not level.on_face:
        return _LevelFit(poles, error, error)
    at = uv[:, ::2].reshape(-1, 2)
    images = net.to_poles @ wall.parameters(at, level.depth_mm).reshape(len(segments), pieces + 1, 2)
    drawn = (net.to_middles @ images).reshape(1, -1, 2)
    on_surface = wall.surface(level.depth_mm).at(np.zeros(1, np.int64), drawn)
    apart = net.to_middles @ poles - on_surface.reshape(len(segments), pieces, 3)
    return _LevelFit(poles, error, np.maximum(error, np.linalg.norm(apart, axis=2).max(axis=1)), images)


def _columns(
    stacks: Sequence[tuple[Segment, ...]], fits: list[_LevelFit], pieces: int, projection: Projection | None
) -> Columns:
    net, rows = _net(pieces), np.arange(len(stacks))
    traces: list[Traces] = []
    for fit in fits:
        curves = (Batch[Curves](rows, Splines(fit.poles, net.knots, DEGREE)),)
        images = () if fit.images is None else (Batch[Curves](rows, Splines(fit.images, net.knots, DEGREE)),)
        # The greatest distance may lie beside the samples; twice the sampled one bounds a cubic's error.
        traces.append(Traces(curves, TOLERANCE_MM + 2 * fit.apart_mm, images))
    bands = [
        _band([(stack[k], stack[k + 1]) for stack in stacks], upper.poles, lower.poles, net, projection)
        for k, (upper, lower) in enumerate(pairwise(fits))
    ]
    return Columns(tuple(traces), tuple(bands))


def _band(
    pairs: Sequence[tuple[Segment, Segment]],
    above: Array,
    below: Array,
    net: _Net,
    projection: Projection | None,
) -> Band:
    """Along one direction, lines stand in planes and arcs in cylinders; all else is ruled."""
    upright = np.array([projection is not None and upper == lower for upper, lower in pairs], np.bool_)
    kinds = by_kind([upper for upper, _ in pairs])
    kind_of = np.zeros(len(pairs), np.int64)
    kind_of[kinds[Line]], kind_of[kinds[Arc]] = 1, 2
    ruled, flat, round_ = (np.flatnonzero(np.where(upright, kind_of, 0) == k) for k in range(3))
    outward = np.ones(len(pairs), np.bool_)
    surfaces = [Batch[Surfaces](ruled, SplineSurfaces.ruled(above[ruled], below[ruled], net.knots, DEGREE))]
    images = box_images(ruled)
    if projection is not None and len(flat):
        surfaces.append(Batch[Surfaces](flat, projection.planes([pairs[i][0] for i in flat.tolist()])))
    if projection is not None and len(round_):
        arcs = [pairs[i][0] for i in round_.tolist()]
        cylinders, sides, outward[round_] = _upright(
            arcs, round_, above[round_], below[round_], net, projection
        )
        surfaces.append(Batch[Surfaces](round_, cylinders))
        images = tuple(a + b for a, b in zip(images, sides, strict=True))
    return Band(tuple(surfaces), outward, images)


def _upright(
    segments: Sequence[Segment], rows: Indices, above: Array, below: Array, net: _Net, projection: Projection
) -> tuple[Cones, Images, Mask]:
    """Cylinders through arcs of the pattern along the line of sight; their angles are the arcs' own."""
    arcs = rounds(segments)
    centre, ccw = projection.at(arcs.centre), arcs.sweep_rad > 0
    up = np.where(ccw, 1.0, -1.0)[:, None] * projection.frame[2]
    ray = np.column_stack([np.cos(arcs.start_rad), np.sin(arcs.start_rad)]) @ projection.frame[:2]
    surfaces = Cones(centre, up, ray, arcs.radius, np.zeros(len(arcs.radius)))
    # Spline poles transform as points do: heights of poles are poles of heights.
    turned = np.abs(arcs.sweep_rad)[:, None] * (net.to_poles @ net.nodes[::2])
    over, under = (
        np.stack([turned, np.einsum("kni,ki->kn", poles - centre[:, None], up)], axis=2)
        for poles in (above, below)
    )
    images = (
        *((Batch[Curves](rows, Splines(poles, net.knots, DEGREE)),) for poles in (over, under)),
        *(straight(rows, over[:, end], under[:, end]) for end in (0, -1)),
    )
    return surfaces, images, ccw
