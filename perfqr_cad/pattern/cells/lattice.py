"""The integer lattice on which a pattern is drawn: every module is a square of cells, each solid or void.

All widths are whole cells, so joining, cutting and testing are exact. Points of the lattice are cell
corners (x right, y down, from the top left of the quiet zone); millimetres have their origin at the centre
of the code and y up.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from perfqr_cad.geometry.outline import Point, Points

Cells = NDArray[np.bool_]
Labels = NDArray[np.int32]
Indices = NDArray[np.int64]

LEAST_CELLS_PER_MODULE = 24  # webs are snapped up to a 24th of a module at worst
LEAST_CELLS_OF_ART = 36  # the same for modules that are made of dots
CELL_ROUNDING = 1e-6  # of a cell: a width this close to a whole number of cells is that number


@dataclass(frozen=True, eq=False)
class Lattice:
    """Solid cells, (N·u, N·u) bool, of a code of N modules a side including its quiet zone.

    per_module  u, cells along a module's edge, even
    """

    solid: Cells
    per_module: int
    quiet: int
    module_mm: float

    def __post_init__(self) -> None:
        self.solid.setflags(write=False)

    @property
    def cells(self) -> int:
        """Cells along the edge of the whole code."""
        return self.solid.shape[0]

    @property
    def cell_mm(self) -> float:
        return self.module_mm / self.per_module

    @property
    def modules(self) -> int:
        """Modules along the edge of the symbol, without the quiet zone."""
        return self.cells // self.per_module - 2 * self.quiet

    def with_solid(self, solid: Cells) -> Lattice:
        """The same lattice with other cells solid."""
        return replace(self, solid=solid)

    def whole(self, length_mm: float) -> int:
        """The least number of cells, at least 1, that measure `length_mm` or more."""
        return max(1, math.ceil(length_mm / self.cell_mm - CELL_ROUNDING))

    def to_mm(self, x: float, y: float) -> Point:
        """Millimetres of a lattice point (x right, y down)."""
        half = self.cells / 2
        return (x - half) * self.cell_mm, (half - y) * self.cell_mm

    def from_mm(self, point: Point) -> tuple[float, float]:
        """Lattice coordinates (x right, y down) of a point in mm."""
        half = self.cells / 2
        return point[0] / self.cell_mm + half, half - point[1] / self.cell_mm

    def all_to_mm(self, points: Points) -> Points:
        """Millimetres of (k, 2) lattice points."""
        return (points - self.cells / 2) * (self.cell_mm, -self.cell_mm)

    def all_from_mm(self, points: Points) -> Points:
        """Lattice coordinates of (k, 2) points in mm."""
        return points / (self.cell_mm, -self.cell_mm) + self.cells / 2

    def symbol_cells(self) -> Cells:
        """View of the cells of the symbol proper, quiet zone left out."""
        edge = self.quiet * self.per_module
        return self.solid[edge : self.cells - edge, edge : self.cells - edge]


def cells_per_module(scale: int) -> int:
    """The least even multiple of the art's samples per module that is fine enough."""
    step = 2 * scale
    return step * math.ceil((LEAST_CELLS_PER_MODULE if scale == 1 else LEAST_CELLS_OF_ART) / step)


def rasterised(material: Cells, scale: int, quiet: int, module_mm: float, frame: bool) -> Lattice:
    """The lattice of (n·scale, n·scale) samples of material; the quiet zone is solid when `frame`."""
    u = cells_per_module(scale)
    n = material.shape[0] // scale
    solid = np.full(((n + 2 * quiet) * u,) * 2, frame)
    inner = np.s_[quiet * u : (quiet + n) * u]
    solid[inner, inner] = material.repeat(u // scale, axis=0).repeat(u // scale, axis=1)
    return Lattice(solid, u, quiet, module_mm)


def label(solid: Cells) -> tuple[Labels, int]:
    """Pieces that share edges, numbered from 1 (0 is void), and how many there are."""
    import cv2

    count, labels = cv2.connectedComponents(solid.astype(np.uint8), connectivity=4, ltype=cv2.CV_32S)
    return np.asarray(labels, np.int32), count - 1


def checkerboards(solid: Cells) -> Indices:
    """(k, 2) x and y of lattice points where solid cells meet at a corner only."""
    across = solid[:, 1:] != solid[:, :-1]
    # Where a change from left to right lasts into the next row, but not the value itself.
    rows, columns = np.divmod(
        np.flatnonzero(across[1:] & across[:-1] & (solid[1:, 1:] != solid[:-1, 1:])), solid.shape[1] - 1
    )
    return np.stack([columns + 1, rows + 1], axis=1)


def erode(solid: Cells, side: int) -> Cells:
    """Cells that are the top left of a solid square of `side` cells (outside counts as void)."""
    import cv2

    kernel = np.ones((side, side), np.uint8)
    eroded = cv2.erode(
        solid.astype(np.uint8), kernel, anchor=(0, 0), borderType=cv2.BORDER_CONSTANT, borderValue=0
    )
    return np.asarray(eroded, np.bool_)


def discs(solid: Cells, side: int) -> Cells:
    """Cells that are the top left of a square of `side` cells whose inscribed disc is solid."""
    import cv2

    offset = np.arange(side) + 0.5 - side / 2
    disc = (offset[:, None] ** 2 + offset[None, :] ** 2 <= side**2 / 4).astype(np.uint8)
    eroded = cv2.erode(
        solid.astype(np.uint8), disc, anchor=(0, 0), borderType=cv2.BORDER_CONSTANT, borderValue=0
    )
    return np.asarray(eroded, np.bool_)


def dilate(corners: Cells, side: int) -> Cells:
    """Cells covered by squares of `side` cells whose top left cells are given."""
    import cv2

    kernel = np.ones((side, side), np.uint8)
    grown = cv2.dilate(
        corners.astype(np.uint8),
        kernel,
        anchor=(side - 1, side - 1),
        borderType=cv2.BORDER_CONSTANT,
        borderValue=0,
    )
    return np.asarray(grown, np.bool_)


def opened(solid: Cells, side: int) -> Cells:
    """What squares of `side` cells can cover without leaving the solid."""
    return dilate(erode(solid, side), side)
