# pyright: reportAttributeAccessIssue=false
# The modeller's stubs are incomplete.
"""Columns on any wall: cubic splines through points of the map, fitted to a stated tolerance, ruled faces
between.

All segments are sampled at once. Each is interpolated at m + 1 equal fractions of its parameter and
checked at
the fractions between; those that miss the tolerance are taken again with twice as many pieces.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from typing import TYPE_CHECKING, Protocol

import numpy as np
from OCP.Geom import Geom_CylindricalSurface, Geom_Plane

from perfqr_cad.errors import KernelError
from perfqr_cad.pattern.outline import Arc, Line, Segment
from perfqr_cad.surface.spline import collocation, not_a_knot

from .chart import Column, Level, Trace, Wall
from .evaluate import evaluator
from .occ import TOLERANCE_MM, Array, axes, line_2d, spline_curve, spline_curve_2d
from .ruled import ruled_wall
from .sampling import positions, sweep

if TYPE_CHECKING:
    from OCP.Geom import Geom_Surface

# Between a fitted edge and the map. Edges of modules keep 1e-8; the bound is for long edges over many knots.
FIT_MM = 1e-5
FEWEST, MOST = 4, 512  # pieces of an edge
DEGREE = 3


@dataclass(frozen=True)
class Sight:
    """A parallel projection: the pattern point (x, y) lies at origin + x e1 + y e2 + s n for some s.

    origin  (3,); frame (3, 3), rows e1, e2 and n, n towards the reader
    """

    origin: Array
    frame: Array

    def at(self, point: tuple[float, float]) -> Array:
        """A pattern point in the plane through the origin, (3,)."""
        return self.origin + np.asarray(point) @ self.frame[:2]


class Surveyor(Protocol):
    """What a fit needs to know of a wall."""

    @property
    def sight(self) -> Sight | None:
        """The projection, where all holes run along one direction; None where they follow the normals."""
        ...

    def points(self, uv: Array, depth_mm: float) -> Array:
        """Points (k, 3) in space of (k, 2) pattern points at a depth."""
        ...

    def parameters(self, uv: Array, depth_mm: float) -> Array:
        """The same points in the parameters of `surface(depth_mm)`, (k, 2); without jumps along a segment."""
        ...

    def surface(self, depth_mm: float) -> Geom_Surface:
        """The surface of a face at that depth."""
        ...


@dataclass(frozen=True)
class _Rung:
    """Segments of one level as splines: poles (k, n, 3), error (k,); on faces also image poles (k, n, 2) and
    how far curves and images are apart there, (k,)."""

    level: Level
    poles: Array
    error_mm: Array
    images: Array | None = None
    apart_mm: Array | None = None


def lay_fitted(
    stacks: Sequence[tuple[Segment, ...]], levels: tuple[Level, ...], wall: Surveyor
) -> list[Column]:
    """Columns on stacks of segments, one segment for each level, front first.

    Raises `KernelError` where no spline of `MOST` pieces keeps `FIT_MM`.
    """
    columns: dict[int, Column] = {}
    todo = list(range(len(stacks)))
    pieces = FEWEST
    while todo:
        if pieces > MOST:
            raise KernelError(
                f"an edge of the pattern misses the surface by over {FIT_MM:g} mm with {MOST} pieces: "
                "move the code away from creases of the surface"
            )
        chosen = [stacks[i] for i in todo]
        rungs = [_rung([s[k] for s in chosen], level, wall, pieces) for k, level in enumerate(levels)]
        good = np.max([rung.error_mm for rung in rungs], axis=0) <= FIT_MM
        for row in np.flatnonzero(good):
            columns[todo[row]] = _column(chosen[row], rungs, int(row), pieces, wall)
        todo = [i for i, done in zip(todo, good, strict=True) if not done]
        pieces *= 2
    return [columns[i] for i in range(len(stacks))]


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


def _rung(segments: Sequence[Segment], level: Level, wall: Surveyor, pieces: int) -> _Rung:
    net = _net(pieces)
    uv = positions(segments, net.nodes)
    shape = (len(segments), len(net.nodes), -1)
    laid = wall.points(uv.reshape(-1, 2), level.depth_mm).reshape(shape)
    poles = net.to_poles @ laid[:, ::2]
    poles[:, 0], poles[:, -1] = laid[:, 0], laid[:, -1]  # to the bit, so that neighbours meet
    error = np.linalg.norm(net.to_middles @ poles - laid[:, 1::2], axis=2).max(axis=1)
    if not level.on_face:
        return _Rung(level, poles, error)
    at = uv[:, ::2].reshape(-1, 2)
    images = net.to_poles @ wall.parameters(at, level.depth_mm).reshape(len(segments), pieces + 1, 2)
    drawn = (net.to_middles @ images).reshape(-1, 2)
    on_surface = evaluator(wall.surface(level.depth_mm))(drawn, 1).reshape(len(segments), pieces, 3)
    apart = np.linalg.norm(net.to_middles @ poles - on_surface, axis=2).max(axis=1)
    return _Rung(level, poles, error, images, apart)


def _column(stack: tuple[Segment, ...], rungs: list[_Rung], row: int, pieces: int, wall: Surveyor) -> Column:
    net = _net(pieces)
    traces = tuple(_trace(rung, row, net) for rung in rungs)
    walls = tuple(
        _wall(stack[k], stack[k + 1], upper.poles[row], lower.poles[row], net, wall)
        for k, (upper, lower) in enumerate(pairwise(rungs))
    )
    return Column(traces, walls)


def _trace(rung: _Rung, row: int, net: _Net) -> Trace:
    """The curve and its image on the face."""
    curve = spline_curve(rung.poles[row], net.knots, DEGREE)
    error = float(rung.error_mm[row])
    if rung.apart_mm is not None:
        error = max(error, float(rung.apart_mm[row]))
    # The greatest distance may lie beside the samples; twice the sampled one bounds a cubic's error curve.
    slack = TOLERANCE_MM + 2 * error
    image = None if rung.images is None else spline_curve_2d(rung.images[row], net.knots, DEGREE)
    return Trace(curve, 0.0, 1.0, image, slack)


def _wall(upper: Segment, lower: Segment, above: Array, below: Array, net: _Net, wall: Surveyor) -> Wall:
    """Along one direction, lines stand in planes and arcs in cylinders; all else is ruled."""
    sight = wall.sight
    if sight is not None and upper == lower:
        if isinstance(upper, Line):
            return upright_plane(upper, sight)
        if isinstance(upper, Arc):
            return _upright_cylinder(upper, above, below, net, sight)
    return ruled_wall(above, below, net.knots, DEGREE)


def upright_plane(line: Line, sight: Sight) -> Wall:
    """The plane through a line of the pattern along the line of sight; its normal is to the right of
    travel."""
    start, end = sight.at(line.start), sight.at(line.end)
    return Wall(Geom_Plane(axes(start, np.cross(end - start, sight.frame[2]), end - start)), outward=True)


def _upright_cylinder(arc: Arc, above: Array, below: Array, net: _Net, sight: Sight) -> Wall:
    """The cylinder through an arc of the pattern along the line of sight; its angle is the arc's own."""
    centre = sight.at(arc.centre)
    up = sight.frame[2] if arc.ccw else -sight.frame[2]
    surface = Geom_CylindricalSurface(axes(centre, up, sight.at(arc.start) - centre), arc.radius)
    angle = abs(sweep(arc))
    # Spline poles transform as points do: heights of poles are poles of heights.
    turned = angle * _identity(net)
    images = [
        spline_curve_2d(np.column_stack([turned, (poles - centre) @ up]), net.knots, DEGREE)
        for poles in (above, below)
    ]
    fall = -1.0 if arc.ccw else 1.0
    sides = [line_2d(u, float((above[i] - centre) @ up), 0.0, fall) for u, i in ((0.0, 0), (angle, -1))]
    return Wall(surface, outward=arc.ccw, images=(images[0], images[1], sides[0], sides[1]))


def _identity(net: _Net) -> Array:
    """Poles of the spline that is its own parameter."""
    return net.to_poles @ net.nodes[::2]
