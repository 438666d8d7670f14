"""Holes widened in the plane, segment by segment, so that the walls between stay planes, cones and ruled
faces.

`shapely.buffer` would flatten arcs and drop segments; here every segment of the widened loop lies above the
segment it came from. Loops run with the material on their left; a set-back moves a segment to the left. All
segments of all loops are moved at once.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from perfqr_cad.geometry.arrays import Array, Indices, Mask
from perfqr_cad.geometry.cycles import following, owners, preceding, starts_of
from perfqr_cad.geometry.graph import components
from perfqr_cad.geometry.outline import Arc, Bezier, Circle, Line, Loop, Segment
from perfqr_cad.geometry.vectors import cross, crossing, left, unit

SMOOTH = 1e-6  # sine of the turn below which two segments join smoothly
EVEN = 0.35  # sine of the turn (20°) below which a mitre between unlike flares would be a long spike
ROUNDS = 8  # of giving way: the flare of an edge that closes is halved, in the last two dropped
REACH = 2  # an edge and so many neighbours on either side, rounded corners between them included
SHORTEST = 0.05  # an edge that keeps less of its length than this counts as closed
MOST_TURN_RAD = 1.0  # an arc whose sweep changes more has closed and come out on the other side
SHARE = 0.5  # a rounded corner that would shrink below this share of its radius keeps the radius instead
MOST_STEPS = 20  # of Newton's iteration towards a corner
CORNER_MM = 1e-13  # where it ends


def widened(loops: Sequence[Loop], flares_mm: Array, share: float = 1.0) -> list[Loop]:
    """The loops with each segment, of all in turn, set back to its left by its own flare (k,); half-way there
    by a `share`.

    Rounded corners between lines stay tangent; joints that hardly turn take the lesser flare of the two.
    Where a segment would vanish or turn over, it and its neighbours give way: their flares are halved, in the
    end dropped. A loop where that does not help stays as it is.

    >>> hole = Loop.from_points([(0, 0), (2, 0), (2, 2), (0, 2)]).oriented(ccw=False)
    >>> widened([hole], np.full(4, 0.5))[0].area
    -9.0
    """
    if not loops:
        return []
    chain = _Chain.of(loops)
    back = flares_mm.copy()
    moved = chain.set_back(back)
    bad = chain.turned_over(moved)
    for attempt in range(ROUNDS):
        if not bad.any():
            break
        back[chain.around(bad)] *= 0.5 if attempt < ROUNDS - 2 else 0.0
        moved = chain.set_back(back)
        bad = chain.turned_over(moved)
    given_up = np.unique(chain.loop[bad]).tolist()
    if share != 1.0:
        moved = chain.set_back(share * back)
    return [loops[i] if i in given_up else made for i, made in enumerate(chain.loops(moved))]


@dataclass(frozen=True, eq=False)
class _Moved:
    """Corners (k, 2) at the start of each segment, centres (k, 2) and radii (k,) of round ones, and the inner
    control points (k, 2, 2) of Béziers."""

    corner: Array
    centre: Array
    radius: Array
    control: Array


@dataclass(frozen=True, eq=False)
class _Chain:
    """The segments of some loops as arrays: Béziers by their four control points, others by theirs repeated.

    loop    (k,) which loop each belongs to; start (L + 1,) where loops begin
    points  (k, 4, 2)
    centre  (k, 2) and radius (k,) of round segments; side (k,): 1 where they run counter-clockwise, −1, 0
    """

    segments: tuple[Segment, ...]
    start: Indices
    loop: Indices
    points: Array
    centre: Array
    radius: Array
    side: Array

    @staticmethod
    def of(loops: Sequence[Loop]) -> _Chain:
        segments = tuple(segment for loop in loops for segment in loop.segments)
        start = starts_of(len(loop.segments) for loop in loops)
        points = np.array(
            [s.controls if isinstance(s, Bezier) else (s.start, s.start, s.end, s.end) for s in segments]
        )
        circles = np.array(
            [
                (*s.centre, 1.0 if s.ccw else -1.0) if isinstance(s, Arc | Circle) else (0.0, 0.0, 0.0)
                for s in segments
            ]
        )
        centre, side = circles[:, :2], circles[:, 2]
        radius = np.hypot(*(points[:, 0] - centre).T)
        return _Chain(segments, start, owners(start), points, centre, radius, side)

    @cached_property
    def after(self) -> Indices:
        """(k,) the next segment of the same loop."""
        return following(self.start)

    @cached_property
    def before(self) -> Indices:
        """(k,) the one before."""
        return preceding(self.start)

    @cached_property
    def ahead(self) -> tuple[Array, Array]:
        """Unit directions of travel at the start and at the end, (k, 2) each."""
        legs = np.where(self._bezier[:, None, None], np.diff(self.points, axis=1)[:, [0, -1]], 0.0)
        chord = (self.points[:, 3] - self.points[:, 0])[:, None].repeat(2, axis=1)
        rays = self.points[:, [0, 3]] - self.centre[:, None]
        tangents = np.where(self._bezier[:, None, None], legs, chord)
        tangents = np.where(self._round[:, None, None], self.side[:, None, None] * left(rays), tangents)
        one, two = unit(tangents).swapaxes(0, 1)
        return one, two

    @cached_property
    def fillet(self) -> Mask:
        """(k,) arcs tangent to a line on either side, which make a corner (a slot's end does not)."""
        begin, end = self.ahead
        smooth = self._smooth(SMOOTH)
        turn = np.abs(cross(end[self.before], begin[self.after]))
        lines = ~self._round & ~self._bezier
        arcs = self._round & lines[self.before] & lines[self.after]
        return arcs & smooth[self.before] & smooth & (turn > EVEN) & (np.abs(self._sweep(None)) < math.pi)

    def set_back(self, flares_mm: Array) -> _Moved:
        """The segments set back, whether or not they still make a loop."""
        back = self._evened(flares_mm)
        radius = self.radius - self.side * back
        least = np.minimum(back[self.before], back[self.after])
        rounded = self.radius - self.side * least
        # Concentric where that leaves enough of the radius, else the radius itself: an oblique wall.
        rounded = np.where((self.side > 0) & (rounded <= SHARE * self.radius), self.radius, rounded)
        corner = self._corners(back, radius)
        centre = self.centre.copy()
        i = np.flatnonzero(self.fillet)
        centre[i], corner[i], corner[self.after[i]] = self._fillets(i, back, rounded[i])
        radius = np.where(self.fillet, rounded, radius)
        return _Moved(corner, centre, radius, self._controls(back))

    def turned_over(self, moved: _Moved) -> Mask:
        """(k,) whether a segment has vanished, or runs the other way: the corners beside it have met."""
        start, end = moved.corner, moved.corner[self.after]
        old, new = self.points[:, 3] - self.points[:, 0], end - start
        with np.errstate(invalid="ignore"):
            short = np.einsum("ki,ki->k", old, new) < SHORTEST * np.einsum("ki,ki->k", old, old)
            reach = [np.hypot(*(p - moved.centre).T) for p in (start, end)]
            astray = np.abs(reach[1] - reach[0]) > SMOOTH * reach[0]
            turned = np.abs(self._sweep(moved) - self._sweep(None)) > MOST_TURN_RAD
        found = np.where(self._round, astray | turned, short)
        found |= ~np.isfinite(new).all(axis=1) | (start == end).all(axis=1)
        return np.where(self._whole, moved.radius <= 0, found)

    def around(self, bad: Mask) -> Mask:
        """(k,) segments and their neighbours."""
        found = bad.copy()
        for _ in range(REACH):
            found |= found[self.after] | found[self.before]
        return found

    def loops(self, moved: _Moved) -> list[Loop]:
        """Segments of the same kinds between the new corners."""
        starts, centres = ([(x, y) for x, y in a.tolist()] for a in (moved.corner, moved.centre))
        radii, controls, after = moved.radius.tolist(), moved.control.tolist(), self.after.tolist()
        made: list[Segment] = []
        for i, segment in enumerate(self.segments):
            start, end = starts[i], starts[after[i]]
            match segment:
                case Line():
                    made.append(Line(start, end))
                case Arc():
                    made.append(Arc(start, end, centres[i], segment.ccw))
                case Circle():
                    made.append(Circle(segment.centre, radii[i], segment.ccw))
                case Bezier():
                    (x, y), (x1, y1) = controls[i]
                    made.append(Bezier(start, (x, y), (x1, y1), end))
        return [Loop(tuple(made[a:b])) for a, b in zip(self.start[:-1], self.start[1:], strict=True)]

    @cached_property
    def _round(self) -> Mask:
        return self.side != 0

    @cached_property
    def _whole(self) -> Mask:
        return np.array([isinstance(s, Circle) for s in self.segments])

    @cached_property
    def _bezier(self) -> Mask:
        return np.array([isinstance(s, Bezier) for s in self.segments])

    def _smooth(self, sine: float) -> Mask:
        """(k,) whether each segment goes on into the next without a corner."""
        one, two = self.ahead[1], self.ahead[0][self.after]
        return (np.abs(cross(one, two)) < sine) & (np.einsum("ki,ki->k", one, two) > 0)

    def _sweep(self, moved: _Moved | None) -> Array:
        """(k,) angles that arcs turn, rad, positive counter-clockwise."""
        if moved is None:
            start, end, centre = self.points[:, 0], self.points[:, 3], self.centre
        else:
            start, end, centre = moved.corner, moved.corner[self.after], moved.centre
        angles = [np.arctan2(*(p - centre).T[::-1]) for p in (start, end)]
        turn = (angles[1] - angles[0]) % math.tau
        return np.where(self.side < 0, turn - math.tau, turn)

    def _evened(self, flares_mm: Array) -> Array:
        """Flares made equal across smooth joints, save those of a fillet, which adapts."""
        joined = np.flatnonzero(self._smooth(EVEN) & ~self.fillet & ~self.fillet[self.after])
        run = components(np.column_stack([joined, self.after[joined]]), len(flares_mm))
        least = np.full(len(flares_mm), math.inf)
        np.minimum.at(least, run, flares_mm)
        return least[run]

    def _fillets(self, i: Indices, back: Array, radius: Array) -> tuple[Array, Array, Array]:
        """Centre, start and end of arcs that round the corner of their two lines, set back by their own
        flares."""
        reach = self.side[i] * radius  # the centre lies to the left of a counter-clockwise arc
        before, after = self.before[i], self.after[i]
        d, e = self.ahead[1][before], self.ahead[0][after]
        p = self.points[before, 3] + (back[before] + reach)[:, None] * left(d)
        q = self.points[after, 0] + (back[after] + reach)[:, None] * left(e)
        centre = crossing(p, d, q, e)
        return centre, centre - reach[:, None] * left(d), centre - reach[:, None] * left(e)

    def _corners(self, back: Array, radius: Array) -> Array:
        """Where each set-back segment meets the one before, (k, 2)."""
        before = self.before
        d, e = self.ahead[1][before], self.ahead[0]
        p = self.points[before, 3] + back[before][:, None] * left(d)
        q = self.points[:, 0] + back[:, None] * left(e)
        smooth = self._smooth(SMOOTH)[before]
        meet = np.where(smooth[:, None], q, crossing(p, d, q, e))
        # On arcs the tangents only give the first guess: Newton on both offset curves' equations.
        rows = np.flatnonzero(~smooth & (self._round | self._round[before]) & np.isfinite(meet).all(axis=1))
        for _ in range(MOST_STEPS):
            sides = [(before[rows], p[rows], d[rows]), (rows, q[rows], e[rows])]
            gaps = [self._gap(segment, radius, point, way, meet[rows]) for segment, point, way in sides]
            residual = np.stack([gap for gap, _ in gaps], axis=1)
            going = np.abs(residual).max(axis=1, initial=0.0) >= CORNER_MM
            rows, residual = rows[going], residual[going]
            if not len(rows):
                break
            slopes = np.stack([slope for _, slope in gaps], axis=1)[going]
            meet[rows] -= np.einsum("kij,kj->ki", np.linalg.pinv(slopes), residual)
        return meet

    def _gap(self, of: Indices, radius: Array, point: Array, way: Array, at: Array) -> tuple[Array, Array]:
        """Signed distance (k,) of points from set-back segments' carriers, circles or tangent lines, and its
        gradient (k, 2)."""
        ray = at - self.centre[of]
        reach = np.hypot(*ray.T)
        from_line = np.einsum("ki,ki->k", at - point, left(way))
        round_ = self._round[of]
        return (
            np.where(round_, reach - radius[of], from_line),
            np.where(round_[:, None], ray / np.where(reach > 0, reach, 1.0)[:, None], left(way)),
        )

    def _controls(self, back: Array) -> Array:
        """Inner control points (k, 2, 2): the legs of the control polygon set back in parallel (Tiller and
        Hanson, 1984)."""
        inner = np.zeros((len(back), 2, 2))
        i = np.flatnonzero(self._bezier)
        p, shift = self.points[i], back[i, None]
        ways = unit(np.diff(p, axis=1)).swapaxes(0, 1)
        for k in (0, 1):
            d, e = ways[k], ways[k + 1]
            straight = np.abs(cross(d, e)) < SMOOTH
            meet = crossing(p[:, k] + shift * left(d), d, p[:, k + 1] + shift * left(e), e)
            inner[i, k] = np.where(straight[:, None], p[:, k + 1] + shift * left(d), meet)
        return inner
