"""Routes between islands: the cheapest for each two that are neighbours, and junctions of three."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations, pairwise
from typing import Any

import numpy as np

from perfqr_cad.pattern.cells.lattice import Indices
from perfqr_cad.pattern.joining.brush import BrushGrid, Field
from perfqr_cad.pattern.joining.steps import Steps

MOST_STAR_WORK = 80_000_000  # islands times nodes: beyond about a second only pairs are candidates
ISLANDS_AT_ONCE = 16  # searches for arms that share one call, and its memory
SAME_PRICE = 1e-9  # two prices closer than this are equal


@dataclass(frozen=True, eq=False)
class Route:
    """A way to join islands: the brush's corners (k, 2) x, y along each arm, with the price of all arms.

    Two islands are joined by one arm; three by three arms that meet in a junction.
    """

    islands: tuple[int, ...]
    arms: tuple[Indices, ...]
    price: float

    def rectangles(self, brush: int) -> list[tuple[int, int, int, int]]:
        """x0, y0, x1, y1 in cells of each straight stretch of the painted route."""
        return [rect for arm in self.arms for rect in _stretches(arm, brush)]


def _stretches(arm: Indices, brush: int) -> list[tuple[int, int, int, int]]:
    move = np.diff(arm, axis=0) != 0
    bends = np.flatnonzero((move[1:] != move[:-1]).any(axis=1)) + 1
    stops = [0, *bends.tolist(), len(arm) - 1]
    runs: list[tuple[int, int, int, int]] = []
    for first, last in pairwise(stops):
        low, high = np.minimum(arm[first], arm[last]), np.maximum(arm[first], arm[last])
        runs.append((int(low[0]), int(low[1]), int(high[0]) + brush, int(high[1]) + brush))
    return runs


class Router:
    """Shortest ways between the islands of one brush grid."""

    def __init__(self, grid: BrushGrid, least: float, bar: float) -> None:
        """`least` is added to the price of each move, `bar` to that of each straight bar."""
        self._grid, self._bar = grid, bar
        self._steps = Steps.of(grid, least, bar)

    def pairs(self) -> list[Route]:
        """The cheapest route for each pair of islands whose domains of influence touch (Mehlhorn's graph).

        A minimum spanning tree of these is a minimum spanning tree of all shortest routes.
        """
        from scipy.sparse.csgraph import dijkstra

        steps = self._steps
        self._reach, before, origin = dijkstra(
            steps.graph, indices=steps.islands, min_only=True, return_predecessors=True
        )
        one, other = origin[steps.one], origin[steps.other]
        price = self._bar + self._reach[steps.one] + steps.price + self._reach[steps.other]
        low, high = np.minimum(one, other), np.maximum(one, other)
        meeting = np.flatnonzero((low != high) & (low >= 0))
        order = meeting[np.lexsort((price[meeting], high[meeting], low[meeting]))]
        pairs = low[order].astype(np.int64) * len(before) + high[order]
        cheapest = order[np.unique(pairs, return_index=True)[1]]
        found: list[Route] = []
        for e in cheapest.tolist():
            way = steps.trail(int(steps.start[e]), int(steps.one[e]), before)[::-1]
            way += steps.trail(int(steps.end[e]), int(steps.other[e]), before)
            ends = steps.name(int(one[e])), steps.name(int(other[e]))
            found.append(Route(ends, (self._corners(way),), float(price[e])))
        return found

    def stars(self, pairs: Sequence[Route], limit: float) -> list[Route]:
        """Junctions of three islands cheaper than any two of their `pairs`, no arm over `limit`.

        None on a code so large that finding them would take long. Their arms are not drawn yet: `with_arms`
        does that for those that are chosen.
        """
        from scipy.sparse.csgraph import dijkstra

        self._near = np.flatnonzero(self._reach <= limit)
        first_island = int(np.searchsorted(self._near, self._steps.first_island))
        # No arm need run through a fourth island: without ways into islands, searches stay short.
        self._nearby = self._steps.graph[self._near][:, self._near[:first_island]]
        self._nearby.resize((len(self._near),) * 2)
        islands = np.arange(first_island, len(self._near))
        if len(islands) * len(self._near) > MOST_STAR_WORK:
            return []
        price = np.full((3, first_island), np.inf)
        owner = np.zeros((3, first_island), np.int64)
        for some in np.array_split(islands, -(-len(islands) // ISLANDS_AT_ONCE)):
            arms = dijkstra(self._nearby, indices=some, limit=limit)
            for island, arm in zip(some.tolist(), arms, strict=True):
                _insert(price, owner, arm[:first_island], island)
        return self._best_stars(price, owner, pairs)

    def _best_stars(self, price: Field, owner: Indices, pairs: Sequence[Route]) -> list[Route]:
        """The cheapest junction of each three islands, where it beats the two cheapest of their pairs."""
        known = {frozenset(route.islands): route.price for route in pairs}
        whole = np.flatnonzero(np.isfinite(price[2]))
        total = self._bar + price[:, whole].sum(axis=0)
        trios = np.sort(owner[:, whole], axis=0)
        size = len(self._near)
        code = (trios[0] * size + trios[1]) * size + trios[2]
        order = np.lexsort((total, code))
        first = order[np.unique(code[order], return_index=True)[1]]
        found: list[Route] = []
        for k in first.tolist():
            names = tuple(self._steps.name(int(self._near[i])) for i in trios[:, k])
            links = sorted(known.get(frozenset(pair), np.inf) for pair in combinations(names, 2))
            if total[k] < links[0] + links[1] - SAME_PRICE:
                junction = np.array([[self._near[whole[k]]]])
                found.append(Route(names, (junction,), float(total[k])))
        return found

    def with_arms(self, star: Route) -> Route:
        """A star with its arms drawn."""
        from scipy.sparse.csgraph import dijkstra

        junction = int(star.arms[0][0, 0])
        start = int(np.searchsorted(self._near, junction))
        before = dijkstra(self._homewards, indices=start, limit=star.price, return_predecessors=True)[1]
        arms: list[Indices] = []
        for name in star.islands:
            island = self._steps.node(name)
            at = int(np.searchsorted(self._near, island))
            way = [self._steps.entry(int(self._near[before[at]]), island)]
            while at != start:
                at = int(before[at])
                way.append(self._steps.position(int(self._near[at])))
            arms.append(self._corners(way))
        return Route(star.islands, tuple(arms), star.price)

    @cached_property
    def _homewards(self) -> Any:
        """The ways of `_nearby` turned round: from positions to islands."""
        return self._nearby.T.tocsr()

    def _corners(self, way: Sequence[int]) -> Indices:
        rows, columns = np.divmod(
            np.array([at for at, before in pairwise([*way, -1]) if at != before]), self._grid.shape[1]
        )
        return np.stack([self._grid.xs[columns], self._grid.ys[rows]], axis=1)


def _insert(price: Field, owner: Indices, arm: Field, island: int) -> None:
    """Puts an island's arms in their place among the three cheapest of each junction, in place."""
    at = np.flatnonzero(arm < price[2])
    arms = np.concatenate([price[:, at], arm[None, at]])
    owners = np.concatenate([owner[:, at], np.full((1, len(at)), island)])
    order = np.argsort(arms, axis=0, kind="stable")[:3]
    price[:, at] = np.take_along_axis(arms, order, 0)
    owner[:, at] = np.take_along_axis(owners, order, 0)
