"""Boundaries of solid cells: closed chains of corners, all chains of a pattern in one array."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from perfqr_cad.errors import DesignError
from perfqr_cad.geometry.cycles import following, owners, preceding, starts_of
from perfqr_cad.geometry.outline import LEAST_MM, Line, Loop, Points
from perfqr_cad.pattern.cells.lattice import Cells, Indices, checkerboards

if TYPE_CHECKING:
    from shapely.geometry import Polygon

Items = NDArray[Any]


@dataclass(frozen=True, eq=False)
class Boundaries:
    """Closed chains of corners: ring i is `points[bounds[i]:bounds[i + 1]]`, the first corner not repeated.

    points  (k, 2) x, y; bounds (rings + 1,)
    """

    points: Points
    bounds: Indices

    @staticmethod
    def of(chains: list[Points]) -> Boundaries:
        """Boundaries of (k, 2) corners each."""
        points = np.concatenate(chains) if chains else np.empty((0, 2))
        return Boundaries(points.astype(np.float64), starts_of(map(len, chains)))

    def __len__(self) -> int:
        return len(self.bounds) - 1

    @cached_property
    def sizes(self) -> Indices:
        """(rings,) corners of each ring."""
        return np.diff(self.bounds)

    @cached_property
    def owner(self) -> Indices:
        """(k,) ring of each corner."""
        return owners(self.bounds)

    def after(self, items: Items) -> Items:
        """For each corner the item of the corner that follows it."""
        return items[self._following]

    def before(self, items: Items) -> Items:
        """For each corner the item of the corner that it follows."""
        return items[self._preceding]

    @cached_property
    def _following(self) -> Indices:
        return following(self.bounds)

    @cached_property
    def _preceding(self) -> Indices:
        return preceding(self.bounds)

    def total(self, items: Items) -> Items:
        """(rings,) sum over the corners of each ring."""
        return np.bincount(self.owner, weights=items, minlength=len(self))

    @cached_property
    def areas(self) -> Items:
        """(rings,) signed areas, positive when counter-clockwise with y up."""
        return self.total(_cross(self.points, self.after(self.points))) / 2

    def loops(self) -> list[Loop]:
        """The rings as loops of lines; of corners closer than `LEAST_MM` one is kept."""
        step = np.abs(self.points - self.before(self.points)).max(axis=1)
        rings = self if (step > LEAST_MM).all() else self.only(step > LEAST_MM)
        corners = list(zip(rings.points[:, 0].tolist(), rings.points[:, 1].tolist(), strict=True))
        lines = [Line(corners[k], corners[j]) for k, j in enumerate(rings._following.tolist())]
        return [Loop(tuple(lines[a:b])) for a, b in pairwise(rings.bounds.tolist())]

    def only(self, corners: Cells) -> Boundaries:
        """The rings with the given corners left, of some rings perhaps none."""
        return Boundaries(self.points[corners], starts_of(self.total(corners).astype(np.int64)))

    def where(self, chosen: Cells, other: Boundaries) -> Boundaries:
        """The chosen rings as here, the rest as they are in `other`."""
        sizes = np.where(chosen, self.sizes, other.sizes)
        points = np.empty((int(sizes.sum()), 2))
        here = np.repeat(chosen, sizes)
        points[here] = self.points[np.repeat(chosen, self.sizes)]
        points[~here] = other.points[np.repeat(~chosen, other.sizes)]
        return Boundaries(points, starts_of(sizes))

    def polygons(self) -> Items:
        """(rings,) shapely polygons, one for each ring."""
        import shapely

        return np.asarray(shapely.polygons(self.lines))

    def polygon(self) -> Polygon | None:
        """The shapely polygon with the one outer ring and all holes; None when there are more outer rings."""
        import shapely

        outers = np.flatnonzero(self.areas > 0)
        if len(outers) != 1:
            return None
        holes = np.delete(self.lines, outers[0])
        return shapely.Polygon(self.lines[outers[0]], holes.tolist())

    @cached_property
    def lines(self) -> Items:
        """(rings,) shapely rings."""
        import shapely

        return np.asarray(shapely.linearrings(self.points, indices=self.owner))


def trace(solid: Cells) -> Boundaries:
    """Boundary rings in lattice x, y; the solid lies on the left with y up.

    Every vertex is a true corner. Rows of corners pair up into horizontal edges and columns into vertical
    ones, so a ring is a walk that alternates between the two pairings.
    """
    if len(checkerboards(solid)):
        raise DesignError("solid cells meet at a corner only: join or part them before tracing")
    padded = np.pad(solid, 1)
    across = padded[:, 1:] != padded[:, :-1]
    width = across.shape[1]
    y, x = np.divmod(np.flatnonzero(across[1:] != across[:-1]), width)
    beside = _paired(np.arange(len(x)))
    down = _paired(np.lexsort((y, x)))
    # Every edge is walked so that its solid side is on the left: leftwards where the solid is below.
    solid_below = padded[y + 1, np.minimum(x, x[beside]) + 1]
    forwards = np.where(solid_below, x > x[beside], x < x[beside])
    return _walk(np.stack([x, y], axis=1), beside, down, forwards)


def _paired(order: Indices) -> Indices:
    """Partner of each corner when corners are taken two by two in the given order."""
    partner = np.empty(len(order), np.int64)
    partner[order[0::2]], partner[order[1::2]] = order[1::2], order[0::2]
    return partner


def _walk(corners: Indices, across: Indices, down: Indices, forwards: Cells) -> Boundaries:
    order: list[int] = []
    bounds = [0]
    seen = [False] * len(corners)
    over, under = across.tolist(), down.tolist()
    for first in np.flatnonzero(forwards).tolist():
        if seen[first]:
            continue
        at = first
        while not seen[at]:
            seen[at] = True
            order += (at, over[at])
            at = under[over[at]]
        bounds.append(len(order))
    return Boundaries(corners[order].astype(np.float64), np.array(bounds))


def sharpened(rings: Boundaries) -> Boundaries:
    """Traced rings whose stairs of single cells are read as 45° edges.

    Every edge becomes a line, a stair one line through the solid's outward corners; corners are where
    consecutive lines meet. Nothing but 45° edges is drawn in single cells, so nothing else changes.
    """
    points, after, before = rings.points, rings.after, rings.before
    edge = after(points) - points
    single = np.abs(edge).sum(axis=1) == 1
    turn = _cross(before(edge), edge)
    outward = single & before(single) & (turn < 0)  # y runs down
    outward &= ~(before(outward) | after(outward))  # a bump of one cell is no stair
    first = after(outward)  # the edge before an outward corner, where the one after it is `outward`
    point = np.where(first[:, None], after(points), points)
    along = np.where(first[:, None], edge + after(edge), np.sign(edge))
    lines = Boundaries(point, rings.bounds).only(~outward)
    along = along[~outward]
    same = _cross(lines.before(along), along) == 0
    same &= _cross(along, lines.before(lines.points) - lines.points) == 0
    lines, along = lines.only(~same), along[~same]
    origin, towards = lines.before(lines.points), lines.before(along)
    turning = _cross(towards, along)
    sound = (rings.total(outward) > 0) & (lines.sizes >= 3) & (lines.total(turning == 0) == 0)
    reach = _cross(lines.points - origin, along) / np.where(turning == 0, 1, turning)
    return Boundaries(origin + reach[:, None] * towards, lines.bounds).where(sound, rings)


def _cross(a: Items, b: Items) -> Items:
    return a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
