"""Printability: what is thinner than the tool can make is dropped, or grown where a module hangs on it."""

from __future__ import annotations

import numpy as np

from perfqr_cad.pattern.cells.brightness import CENTRE_PART, solid_part
from perfqr_cad.pattern.cells.canvas import Canvas
from perfqr_cad.pattern.cells.lattice import Cells, opened

MOST_ROUNDS = 4  # growing material thins the gaps beside it, and the other way round
NAMES = {True: ("webs_dropped", "webs_grown"), False: ("gaps_filled", "gaps_grown")}


def tidy(canvas: Canvas, right_solid: Cells, web: int, gap: int) -> Canvas:
    """No material thinner than `web` cells and no gap thinner than `gap`, as far as modules allow.

    right_solid  (n, n) modules that ought to be material
    """
    for _ in range(MOST_ROUNDS):
        mended = _mended(_mended(canvas, right_solid, web, True), right_solid, gap, False)
        if mended is canvas:
            return canvas
        canvas = mended
    return _without_specks(canvas, web)


def fill_slivers(canvas: Canvas, right_solid: Cells, gap: int) -> Canvas:
    """Gaps thinner than `gap` cells filled, where no module is lost by it."""
    return _mended(canvas, right_solid, gap, solid=False, grow=False)


def _mended(canvas: Canvas, right_solid: Cells, side: int, solid: bool, grow: bool = True) -> Canvas:
    body = canvas.solid if solid else ~canvas.solid
    thin = body & ~opened(body, side)
    if not thin.any():
        return canvas
    import cv2

    count, found, boxes, _ = cv2.connectedComponentsWithStats(thin.astype(np.uint8), connectivity=8)
    parts = np.asarray(found, np.int32)
    needed = _needed(canvas, right_solid, thin, parts, count)
    drop = thin & ~needed[parts]
    grown = canvas.with_cells(drop, not solid) if drop.any() else canvas
    kept = np.flatnonzero(needed)
    if grow and len(kept):
        grown = grown.with_cells(_grown(parts, np.asarray(boxes), kept, side), solid)
    dropped_name, grown_name = NAMES[solid]
    return (
        grown.counted(**{dropped_name: count - 1 - len(kept), grown_name: len(kept) if grow else 0})
        if grown is not canvas
        else canvas
    )


def _needed(canvas: Canvas, right_solid: Cells, thin: Cells, parts: np.ndarray, count: int) -> np.ndarray:
    """(count,) parts without which a module would be misread that is read right with them."""
    lattice = canvas.lattice
    right_now = (solid_part(lattice) >= 0.5) == right_solid
    right_then = (solid_part(lattice.with_solid(canvas.solid ^ thin)) >= 0.5) == right_solid
    needed = np.zeros(count, np.bool_)
    u, edge = lattice.per_module, lattice.quiet * lattice.per_module
    low, high = int(u * (1 - CENTRE_PART) / 2), -int(-u * (1 + CENTRE_PART) // 2)
    for row, column in np.argwhere(right_now & ~right_then).tolist():
        top, left = edge + row * u, edge + column * u
        needed[parts[top + low : top + high, left + low : left + high]] = True
    needed[0] = False
    return needed


def _grown(parts: np.ndarray, boxes: np.ndarray, kept: np.ndarray, side: int) -> Cells:
    """Cells of the kept parts, each widened to `side` in both directions."""
    grown = np.zeros(parts.shape, np.bool_)
    for k in kept.tolist():
        x, y, width, height = (int(v) for v in boxes[k, :4])
        if width <= 2 * side and height <= 2 * side:
            x0, x1 = _widened(x, width, side, parts.shape[1])
            y0, y1 = _widened(y, height, side, parts.shape[0])
            grown[y0:y1, x0:x1] = True
        else:
            grown |= _thickened(parts == k, side)
    return grown


def _widened(low: int, length: int, side: int, limit: int) -> tuple[int, int]:
    more = max(0, side - length)
    first = min(max(0, low - more // 2), max(0, limit - max(length, side)))
    return first, first + max(length, side)


def _thickened(part: Cells, side: int) -> Cells:
    """A long thin part made `side` wide about its own line."""
    import cv2

    half_width = int(cv2.distanceTransform(part.astype(np.uint8), cv2.DIST_C, 3).max())
    more = max(1, side - 2 * half_width + 1)
    return np.asarray(cv2.dilate(part.astype(np.uint8), np.ones((more + 1, more + 1), np.uint8)), np.bool_)


def _without_specks(canvas: Canvas, web: int) -> Canvas:
    """Pieces of material that nowhere reach the least web are given up."""
    import cv2

    count, found = cv2.connectedComponents(canvas.solid.astype(np.uint8), connectivity=4)
    pieces = np.asarray(found, np.int32)
    sound = np.zeros(count, np.bool_)
    sound[np.unique(pieces[opened(canvas.solid, web)])] = True
    lost = canvas.solid & ~sound[pieces]
    if not lost.any():
        return canvas
    return canvas.with_cells(lost, solid=False).counted(specks_lost=count - 1 - int(sound[1:].sum()))
