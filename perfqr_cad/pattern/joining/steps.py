"""Moves of the brush between neighbouring positions, as a graph in which a bend has a price."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from perfqr_cad.pattern.cells.lattice import Indices, Labels
from perfqr_cad.pattern.joining.brush import BrushGrid, Field


@dataclass(frozen=True, eq=False)
class Steps:
    """Moves between nodes: a position on the way along its row, the same along its column, or an island.

    Position p of P is node p along its row and node P + p along its column; to change from one to the other
    costs `bend`. All positions that an island holds are one node, from 2P on in the order of `names`.

    start, end  (e,) positions of each move; one, other (e,) its nodes; price (e,)
    """

    grid: BrushGrid
    start: Indices
    end: Indices
    one: Indices
    other: Indices
    price: Field
    names: Labels

    @staticmethod
    def of(grid: BrushGrid, least: float, bend: float) -> Steps:
        """`least` is added to the price of each move, so that of two free ways the shorter is taken."""
        at = np.arange(grid.island.size).reshape(grid.shape)
        names = np.unique(grid.island[grid.island > 0])
        island = 2 * at.size + np.searchsorted(names, grid.island)
        along_row = np.where(grid.island > 0, island, at)
        along_column = np.where(grid.island > 0, island, at.size + at)
        start = np.concatenate([at[:, :-1].ravel(), at[:-1].ravel(), at.ravel()])
        end = np.concatenate([at[:, 1:].ravel(), at[1:].ravel(), at.ravel()])
        one = np.concatenate([along_row[:, :-1].ravel(), along_column[:-1].ravel(), along_row.ravel()])
        other = np.concatenate([along_row[:, 1:].ravel(), along_column[1:].ravel(), along_column.ravel()])
        price = np.concatenate(
            [grid.across.ravel() + least, grid.down.ravel() + least, np.full(at.size, bend)]
        )
        apart = one != other
        return Steps(grid, start[apart], end[apart], one[apart], other[apart], price[apart], names)

    @property
    def first_island(self) -> int:
        """The least node that is an island."""
        return 2 * self.grid.island.size

    @property
    def islands(self) -> Indices:
        """(i,) nodes that are islands."""
        return self.first_island + np.arange(len(self.names))

    def name(self, node: int) -> int:
        """The island of a node."""
        return int(self.names[node - self.first_island])

    def node(self, name: int) -> int:
        """The node of an island."""
        return self.first_island + int(np.searchsorted(self.names, name))

    @cached_property
    def graph(self) -> Any:
        """Sparse matrix of the cheapest move between any two nodes, both ways."""
        from scipy.sparse import csr_array

        low, high = np.minimum(self.one, self.other), np.maximum(self.one, self.other)
        nodes = self.first_island + len(self.names)
        # Two positions are neighbours once; an island may be left for a position in several ways.
        landing = np.flatnonzero(high >= self.first_island)
        order = landing[np.lexsort((self.price[landing], high[landing], low[landing]))]
        cheapest = order[np.unique(low[order] * nodes + high[order], return_index=True)[1]]
        keep = np.concatenate([np.flatnonzero(high < self.first_island), cheapest])
        a, b = low[keep].astype(np.int32), high[keep].astype(np.int32)
        ends = np.concatenate([a, b]), np.concatenate([b, a])
        return csr_array((np.tile(self.price[keep], 2), ends), shape=(nodes, nodes))

    def trail(self, position: int, node: int, before: NDArray[Any]) -> list[int]:
        """Positions from one back to the island that reached its node, the first inside it included."""
        trail = [position]
        while node < self.first_island:
            towards = int(before[node])
            trail.append(
                self.entry(node, towards) if towards >= self.first_island else self.position(towards)
            )
            node = towards
        return trail

    def position(self, node: int) -> int:
        """The position of a node that is no island."""
        return node % self.grid.island.size

    def entry(self, node: int, island: int) -> int:
        """The neighbouring position through which an island reached a node most cheaply."""
        size = self.grid.island.size
        along_column, at = divmod(node, size)
        row, column = divmod(at, self.grid.shape[1])
        name = self.name(island)
        prices = self.grid.down[:, column] if along_column else self.grid.across[row]
        line = self.grid.island[:, column] if along_column else self.grid.island[row]
        k, stride = (row, self.grid.shape[1]) if along_column else (column, 1)
        moves = [(prices[k - 1], at - stride)] if k and line[k - 1] == name else []
        if k < len(prices) and line[k + 1] == name:
            moves.append((prices[k], at + stride))
        return min(moves)[1]
