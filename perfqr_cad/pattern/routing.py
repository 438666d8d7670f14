"""Routes between islands: a square brush of the least web is dragged over the void and pays for it.

The brush sits on a coarse grid of positions. Positions where it lies wholly inside one island are that
island; every other position is a junction. Moving the brush by one step paints a strip, whose price is the
sum of the price of its void cells. So any route has the least web along its whole length, by construction.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from perfqr_cad.pattern.lattice import Cells, Indices, Labels, erode

Field = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class BrushGrid:
    """Brush positions and what it costs to move between neighbours.

    xs, ys     (kx,), (ky,) cells of the brush's top left corner
    island     (ky, kx) island that holds the brush entirely, 0 for none
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
    """A way to join two islands: brush corners (k, 2) x, y along it, with its price."""

    islands: tuple[int, int]
    corners: Indices
    price: float

    def rectangles(self, brush: int) -> list[tuple[int, int, int, int]]:
        """x0, y0, x1, y1 in cells of each straight stretch of the painted route."""
        runs: list[tuple[int, int, int, int]] = []
        start = 0
        c = self.corners
        for i in range(1, len(c)):
            turning = i + 1 == len(c) or bool(((c[i + 1] - c[i]) * (c[i] - c[i - 1]) == 0).all())
            if turning:
                low, high = np.minimum(c[start], c[i]), np.maximum(c[start], c[i])
                runs.append((int(low[0]), int(low[1]), int(high[0]) + brush, int(high[1]) + brush))
                start = i
        return runs


def brush_grid(solid: Cells, labels: Labels, price: Field, brush: int, step: int) -> BrushGrid:
    """The brush grid of a lattice; `price` is per cell, and counts in void cells only."""
    size = solid.shape[0]
    # Positions are laid so that the brush can stand centred on every multiple of the step.
    first = (-(brush // 2)) % step
    at = np.arange(first, size - brush + 1, step)
    inside = erode(solid, brush)[np.ix_(at, at)]
    island = np.where(inside, labels[np.ix_(at, at)], 0).astype(np.int32)
    total = np.zeros((size + 1, size + 1))
    np.cumsum(np.cumsum(np.where(solid, 0.0, price), axis=0), axis=1, out=total[1:, 1:])
    # A step paints the strip ahead one way and the strip behind the other way: the mean serves both.
    rows = total[at + brush] - total[at]
    columns = total[:, at + brush] - total[:, at]
    left, right = at[:-1], at[1:]
    across = (rows[:, right + brush] - rows[:, left + brush] + rows[:, right] - rows[:, left]) / 2
    down = (columns[right + brush] - columns[left + brush] + columns[right] - columns[left]) / 2
    return BrushGrid(at, at, island, np.maximum(across, 0), np.maximum(down, 0), brush)


def routes(grid: BrushGrid, least: float) -> list[Route]:
    """The cheapest route for each pair of islands whose domains of influence touch (Mehlhorn's graph).

    A minimum spanning tree of these is a minimum spanning tree of all shortest routes. `least` is added to
    the price of each step, so that of two free ways the shorter is taken.
    """
    from scipy.sparse.csgraph import dijkstra

    steps = _Steps.of(grid, least)
    reach, before, origin = dijkstra(
        steps.graph(), directed=False, indices=steps.islands, min_only=True, return_predecessors=True
    )
    a, b = steps.alias[steps.start], steps.alias[steps.end]
    price = reach[a] + steps.price + reach[b]
    low, high = np.minimum(origin[a], origin[b]), np.maximum(origin[a], origin[b])
    meeting = np.flatnonzero((low != high) & (low >= 0))
    order = meeting[np.lexsort((price[meeting], high[meeting], low[meeting]))]
    pairs = low[order].astype(np.int64) * len(before) + high[order]
    cheapest = order[np.unique(pairs, return_index=True)[1]]
    found: list[Route] = []
    for e in cheapest:
        one, other = steps.trail(int(steps.start[e]), before), steps.trail(int(steps.end[e]), before)
        way = np.array(one[::-1] + other)
        ends = int(grid.island.flat[way[0]]), int(grid.island.flat[way[-1]])
        corners = np.stack([grid.xs[way % grid.shape[1]], grid.ys[way // grid.shape[1]]], axis=1)
        found.append(Route(ends, corners, float(price[e])))
    return found


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
        return _Steps(start[apart], end[apart], price[apart], alias, islands, grid)

    def graph(self) -> Any:
        """Sparse matrix of the cheapest move between any two nodes."""
        from scipy.sparse import csr_array

        low = np.minimum(self.alias[self.start], self.alias[self.end])
        high = np.maximum(self.alias[self.start], self.alias[self.end])
        order = np.lexsort((self.price, high, low))
        nodes = len(self.alias) + len(self.islands)
        keep = order[np.unique(low[order] * nodes + high[order], return_index=True)[1]]
        return csr_array((self.price[keep], (low[keep], high[keep])), shape=(nodes, nodes))

    def trail(self, position: int, before: NDArray[np.int32]) -> list[int]:
        """Positions from one back to the island that reached it, the first inside the island included."""
        trail = [position]
        while self.alias[trail[-1]] == trail[-1]:
            towards = int(before[trail[-1]])
            trail.append(towards if towards < len(self.alias) else self._entry(trail[-1], towards))
        return trail

    def _entry(self, position: int, island: int) -> int:
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
