"""A square brush of the least web that is dragged over the void, and what each of its moves costs.

The brush sits on a coarse grid of positions. Positions where it lies wholly inside one island are that
island; every other position is a junction. Moving the brush by one step paints a strip, whose price is the
sum of the price of its void cells. So any route has the least web along its whole length, by construction.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from perfqr_cad.pattern.cells.lattice import Cells, Indices, Labels, discs

Field = NDArray[np.float64]


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
