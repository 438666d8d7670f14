"""The integer lattice on which a pattern is drawn: every module is a square of cells, each solid or void.

All widths are whole cells, so joining, cutting and testing are exact. Points of the lattice are cell
corners (x right, y down, from the top left of the quiet zone); millimetres have their origin at the centre
of the code and y up.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from perfqr_cad.errors import DesignError
from perfqr_cad.pattern.outline import Point

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

    def symbol_cells(self) -> Cells:
        """View of the cells of the symbol proper, quiet zone left out."""
        edge = self.quiet * self.per_module
        return self.solid[edge : self.cells - edge, edge : self.cells - edge]


def cells_per_module(scale: int) -> int:
    """The least even multiple of the art's samples per module that is fine enough."""
    step = 2 * scale
    return step * math.ceil((LEAST_CELLS_PER_MODULE if scale == 1 else LEAST_CELLS_OF_ART) / step)


def draw(material: Cells, scale: int, quiet: int, module_mm: float, frame: bool) -> Lattice:
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
    a, b, c, d = solid[:-1, :-1], solid[:-1, 1:], solid[1:, :-1], solid[1:, 1:]
    rows, columns = np.nonzero((a == d) & (b == c) & (a != b))
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


def trace(solid: Cells) -> list[Indices]:
    """Boundary loops as (k, 2) corners in lattice x, y; the solid lies on the left with y up.

    Every vertex is a true corner. Rows of corners pair up into horizontal edges and columns into vertical
    ones, so a loop is a walk that alternates between the two pairings.
    """
    if len(checkerboards(solid)):
        raise DesignError("solid cells meet at a corner only: join or part them before tracing")
    padded = np.pad(solid, 1).astype(np.int8)
    bend = padded[:-1, :-1] - padded[:-1, 1:] - padded[1:, :-1] + padded[1:, 1:]
    y, x = np.nonzero(bend)
    across = _paired(np.arange(len(x)))
    upright_order = np.lexsort((y, x))
    down = _paired(upright_order)
    # Every edge is walked so that its solid side is on the left: leftwards where the solid is below.
    solid_below = padded[y + 1, np.minimum(x, x[across]) + 1] == 1
    forwards = np.where(solid_below, x > x[across], x < x[across])
    return _walk(x, y, across, down, forwards)


def _paired(order: Indices) -> Indices:
    """Partner of each corner when corners are taken two by two in the given order."""
    partner = np.empty(len(order), np.int64)
    partner[order[0::2]], partner[order[1::2]] = order[1::2], order[0::2]
    return partner


def _walk(x: Indices, y: Indices, across: Indices, down: Indices, forwards: Cells) -> list[Indices]:
    loops: list[Indices] = []
    seen = [False] * len(x)
    over, under = across.tolist(), down.tolist()
    for first in np.flatnonzero(forwards).tolist():
        if seen[first]:
            continue
        chain: list[int] = []
        at = first
        while not seen[at]:
            seen[at] = True
            chain += (at, over[at])
            at = under[over[at]]
        loops.append(np.stack([x[chain], y[chain]], axis=1))
    return loops


def sharpened(loop: Indices) -> NDArray[np.float64]:
    """(k, 2) corners of a traced loop whose stairs of single cells are read as 45° edges.

    Every edge becomes a line, a stair one line through the solid's outward corners; corners are where
    consecutive lines meet. Nothing but 45° edges is drawn in single cells, so nothing else changes.
    """
    edge = after(loop) - loop
    single = np.abs(edge).sum(axis=1) == 1
    turn = _cross(before(edge), edge)
    outward = single & before(single) & (turn < 0)  # y runs down
    outward &= ~(before(outward) | after(outward))  # a bump of one cell is no stair
    if not outward.any():
        return loop.astype(np.float64)
    first, second = after(outward), outward  # the edges before and after an outward corner
    point = np.where(first[:, None], after(loop), loop)[~second]
    along = np.where(first[:, None], edge + after(edge), np.sign(edge))[~second]
    same = (_cross(before(along), along) == 0) & (_cross(along, before(point) - point) == 0)
    point, along = point[~same], along[~same]
    origin, towards = before(point), before(along)
    turning = _cross(towards, along)
    if len(point) < 3 or not turning.all():
        return loop.astype(np.float64)
    reach = _cross(point - origin, along) / turning
    return origin + reach[:, None] * towards


def before(around: NDArray[Any]) -> NDArray[Any]:
    """For each item of a ring the item before it (`numpy.roll` is ten times slower on short rings)."""
    return np.concatenate((around[-1:], around[:-1]))


def after(around: NDArray[Any]) -> NDArray[Any]:
    """For each item of a ring the item after it."""
    return np.concatenate((around[1:], around[:1]))


def _cross(a: NDArray[Any], b: NDArray[Any]) -> NDArray[Any]:
    return a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
