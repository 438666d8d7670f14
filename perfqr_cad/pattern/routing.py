"""Routes between islands: a square brush of the least web is dragged over the void and pays for it.

The brush sits on a coarse grid of positions. Positions where it lies wholly inside one island are that
island; every other position is a junction. Moving the brush by one step paints a strip, whose price is the
sum of the price of its void cells. So any route has the least web along its whole length, by construction.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations, pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from perfqr_cad.pattern.lattice import Cells, Indices, Labels, discs

Field = NDArray[np.float64]

MOST_STAR_WORK = 40_000_000  # islands times positions: beyond about a second only pairs are candidates
ISLANDS_AT_ONCE = 16  # searches for arms that share one call, and its memory
PRICE_TOL = 1e-9  # two prices closer than this are equal


@dataclass(frozen=True, eq=False)
class BrushGrid:
    """Brush positions and what it costs to move between neighbours.

    xs, ys     (kx,), (ky,) cells of the brush's top left corner
    island     (ky, kx) island that holds the disc inside the brush, 0 for none
    across     (ky, kx-1) price of a step to the right; `down` (ky-1, kx) of a step down
    brush      side of the brush, cells
    """

    xs: Indices
    ys: Indices
    island: Labels
    across: Field
    down: Field
    brush: int

    @property
    def shape(self) -> tuple[int, int]:
        return self.island.shape[0], self.island.shape[1]


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


def brush_positions(size: int, brush: int, step: int) -> Indices:
    """Cells at which the brush's corner may lie, so that it can stand centred on multiples of the step."""
    return np.arange((-(brush // 2)) % step, size - brush + 1, step)


def held_positions(solid: Cells, brush: int, step: int) -> Cells:
    """(k, k) brush positions whose inscribed disc is solid."""
    at = brush_positions(solid.shape[0], brush, step)
    return discs(solid, brush)[np.ix_(at, at)]


def brush_grid(labels: Labels, held: Cells, price: Field, brush: int, step: int) -> BrushGrid:
    """The brush grid of a lattice; `price` is per cell, 0 where it is solid."""
    at = brush_positions(len(labels), brush, step)
    middle = at + brush // 2
    island = np.where(held, labels[np.ix_(middle, middle)], 0).astype(np.int32)
    edges = np.unique(np.concatenate([[0], at, at + brush]))
    total = _prefix_sums(price, edges)
    first, last = np.searchsorted(edges, at), np.searchsorted(edges, at + brush)
    # A step paints the strip ahead one way and the strip behind the other way: the mean serves both.
    rows, columns = total[last] - total[first], total[:, last] - total[:, first]
    both = rows[:, first] + rows[:, last], columns[first] + columns[last]
    across, down = np.diff(both[0], axis=1) / 2, np.diff(both[1], axis=0) / 2
    return BrushGrid(at, at, island, np.maximum(across, 0), np.maximum(down, 0), brush)


def _prefix_sums(values: Field, edges: Indices) -> Field:
    """(e, e) sum of the values above and left of each pair of edges; the first edge is 0."""
    from scipy.sparse import csr_array

    cells = int(edges[-1])
    ones = csr_array((np.ones(cells), np.arange(cells), edges), shape=(len(edges) - 1, values.shape[0]))
    blocks = ones @ (ones @ values).T  # transposed, between neighbouring edges
    total = np.zeros((len(edges),) * 2)
    np.cumsum(np.cumsum(blocks.T, axis=0), axis=1, out=total[1:, 1:])
    return total


class Router:
    """Shortest ways between the islands of one brush grid."""

    def __init__(self, grid: BrushGrid, least: float) -> None:
        """`least` is added to the price of each step, so that of two free ways the shorter is taken."""
        self._grid = grid
        self._steps = _Steps.of(grid, least)
        self._graph = self._steps.graph()

    def pairs(self) -> list[Route]:
        """The cheapest route for each pair of islands whose domains of influence touch (Mehlhorn's graph).

        A minimum spanning tree of these is a minimum spanning tree of all shortest routes.
        """
        from scipy.sparse.csgraph import dijkstra

        steps = self._steps
        self._reach, before, origin = dijkstra(
            self._graph, indices=steps.islands, min_only=True, return_predecessors=True
        )
        a, b = steps.alias[steps.start], steps.alias[steps.end]
        price = self._reach[a] + steps.price + self._reach[b]
        low, high = np.minimum(origin[a], origin[b]), np.maximum(origin[a], origin[b])
        meeting = np.flatnonzero((low != high) & (low >= 0))
        order = meeting[np.lexsort((price[meeting], high[meeting], low[meeting]))]
        pairs = low[order].astype(np.int64) * len(before) + high[order]
        cheapest = order[np.unique(pairs, return_index=True)[1]]
        found: list[Route] = []
        for e in cheapest.tolist():
            one, other = steps.trail(int(steps.start[e]), before), steps.trail(int(steps.end[e]), before)
            way = one[::-1] + other
            ends = self._island(way[0]), self._island(way[-1])
            found.append(Route(ends, (self._corners(way),), float(price[e])))
        return found

    def stars(self, pairs: Sequence[Route], limit: float) -> list[Route]:
        """Junctions of three islands cheaper than any two of their `pairs`, no arm over `limit`.

        None on a code so large that finding them would take long. Their arms are not drawn yet: `drawn`
        does that for those that are chosen.
        """
        from scipy.sparse.csgraph import dijkstra

        self._near = np.flatnonzero(self._reach <= limit)
        first_island = int(np.searchsorted(self._near, len(self._steps.alias)))
        # No arm need run through a fourth island: without ways into islands, searches stay short.
        self._nearby = self._graph[self._near][:, self._near[:first_island]]
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
        total = price[:, whole].sum(axis=0)
        trios = np.sort(owner[:, whole], axis=0)
        size = len(self._near)
        code = (trios[0] * size + trios[1]) * size + trios[2]
        order = np.lexsort((total, code))
        first = order[np.unique(code[order], return_index=True)[1]]
        found: list[Route] = []
        for k in first.tolist():
            names = tuple(self._name(int(self._near[i])) for i in trios[:, k])
            links = sorted(known.get(frozenset(pair), np.inf) for pair in combinations(names, 2))
            if total[k] < links[0] + links[1] - PRICE_TOL:
                junction = np.array([[self._near[whole[k]]]])
                found.append(Route(names, (junction,), float(total[k])))
        return found

    def drawn(self, star: Route) -> Route:
        """A star with its arms drawn."""
        from scipy.sparse.csgraph import dijkstra

        junction = int(star.arms[0][0, 0])
        start = int(np.searchsorted(self._near, junction))
        before = dijkstra(self._homewards, indices=start, limit=star.price, return_predecessors=True)[1]
        arms: list[Indices] = []
        for name in star.islands:
            island = len(self._steps.alias) + int(np.searchsorted(self._steps.names, name))
            at = int(np.searchsorted(self._near, island))
            way = [self._steps.entry(int(self._near[before[at]]), island)]
            while at != start:
                at = int(before[at])
                way.append(int(self._near[at]))
            arms.append(self._corners(way))
        return Route(star.islands, tuple(arms), star.price)

    @cached_property
    def _homewards(self) -> Any:
        """The ways of `_nearby` turned round: from positions to islands."""
        return self._nearby.T.tocsr()

    def _corners(self, way: Sequence[int]) -> Indices:
        rows, columns = np.divmod(np.array(way), self._grid.shape[1])
        return np.stack([self._grid.xs[columns], self._grid.ys[rows]], axis=1)

    def _island(self, position: int) -> int:
        return int(self._grid.island.flat[position])

    def _name(self, node: int) -> int:
        """The island of a node."""
        return int(self._steps.names[node - len(self._steps.alias)])


def _insert(price: Field, owner: Indices, arm: Field, island: int) -> None:
    """Puts an island's arms in their place among the three cheapest of each junction, in place."""
    at = np.flatnonzero(arm < price[2])
    arms = np.concatenate([price[:, at], arm[None, at]])
    owners = np.concatenate([owner[:, at], np.full((1, len(at)), island)])
    order = np.argsort(arms, axis=0, kind="stable")[:3]
    price[:, at] = np.take_along_axis(arms, order, 0)
    owner[:, at] = np.take_along_axis(owners, order, 0)


@dataclass(frozen=True, eq=False)
class _Steps:
    """Moves of the brush between neighbouring positions; all positions of one island are one node.

    start, end  (e,) flat positions; alias (positions,) node of each; islands (i,) nodes that are islands
    """

    start: Indices
    end: Indices
    price: Field
    alias: Indices
    islands: Indices
    names: Labels
    grid: BrushGrid

    @staticmethod
    def of(grid: BrushGrid, least: float) -> _Steps:
        at = np.arange(grid.island.size).reshape(grid.shape)
        start = np.concatenate([at[:, :-1].ravel(), at[:-1].ravel()])
        end = np.concatenate([at[:, 1:].ravel(), at[1:].ravel()])
        price = np.concatenate([grid.across.ravel(), grid.down.ravel()]) + least
        held = grid.island.ravel()
        names = np.unique(held[held > 0])
        alias = np.where(held > 0, at.size + np.searchsorted(names, held), at.ravel())
        apart = alias[start] != alias[end]
        islands = at.size + np.arange(len(names))
        return _Steps(start[apart], end[apart], price[apart], alias, islands, names, grid)

    def graph(self) -> Any:
        """Sparse matrix of the cheapest move between any two nodes, both ways."""
        from scipy.sparse import csr_array

        low = np.minimum(self.alias[self.start], self.alias[self.end])
        high = np.maximum(self.alias[self.start], self.alias[self.end])
        nodes = len(self.alias) + len(self.islands)
        # Two positions are neighbours once; an island may be left for a position in several ways.
        landing = np.flatnonzero(high >= len(self.alias))
        order = landing[np.lexsort((self.price[landing], high[landing], low[landing]))]
        cheapest = order[np.unique(low[order] * nodes + high[order], return_index=True)[1]]
        keep = np.concatenate([np.flatnonzero(high < len(self.alias)), cheapest])
        one, other = low[keep].astype(np.int32), high[keep].astype(np.int32)
        ends = np.concatenate([one, other]), np.concatenate([other, one])
        return csr_array((np.tile(self.price[keep], 2), ends), shape=(nodes, nodes))

    def trail(self, position: int, before: NDArray[Any]) -> list[int]:
        """Positions from one back to the island that reached it, the first inside the island included."""
        trail = [position]
        while self.alias[trail[-1]] == trail[-1]:
            towards = int(before[trail[-1]])
            trail.append(towards if towards < len(self.alias) else self.entry(trail[-1], towards))
        return trail

    def entry(self, position: int, island: int) -> int:
        """The neighbouring position through which an island reached this one most cheaply."""
        row, column = divmod(position, self.grid.shape[1])
        across, down = self.grid.across, self.grid.down
        moves = [
            (position - 1, across[row, column - 1] if column else None),
            (position + 1, across[row, column] if column < across.shape[1] else None),
            (position - self.grid.shape[1], down[row - 1, column] if row else None),
            (position + self.grid.shape[1], down[row, column] if row < down.shape[0] else None),
        ]
        return min((price, to) for to, price in moves if price is not None and self.alias[to] == island)[1]
