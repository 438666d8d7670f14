"""Corners at which solid cells meet without an edge between them: linked by a neck, or parted by a gap."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from functools import cache

import numpy as np

from perfqr_cad.pattern.bridge import Bridge
from perfqr_cad.pattern.cells.brightness import solid_part
from perfqr_cad.pattern.cells.canvas import Canvas
from perfqr_cad.pattern.cells.lattice import Cells, Lattice, checkerboards, label

MAX_LINK_ROUNDS = 8  # a link may make its neighbours touch at a corner; each round only joins more


def link_corners(
    canvas: Canvas, web_mm: float, gap_mm: float, right_solid: Cells, sparing: bool = False
) -> Canvas:
    """Joins solid cells that meet at a corner only, by a 45° band of the least web.

    A corner left as it is would be a non-manifold edge of the solid. The band takes a triangle from each of
    the two voids, the least area of all shapes that leave a neck of the given width. Where that would turn a
    module wrong, the corner is parted by the least gap instead.

    right_solid  (n, n) modules that ought to be material
    sparing      part also the corners of pieces that are joined already: fine art changes less by it
    """
    parted = _superfluous(canvas) if sparing else set[tuple[int, int]]()
    linked = canvas
    for _ in range(MAX_LINK_ROUNDS):
        linked = _linked(canvas, web_mm, gap_mm, parted)
        harmed = ((solid_part(canvas.lattice) >= 0.5) == right_solid) & (
            (solid_part(linked.lattice) >= 0.5) != right_solid
        )
        guilty = _corners_near(canvas, harmed) - parted
        if not guilty:
            return linked
        parted |= guilty
    return linked


def _superfluous(canvas: Canvas) -> set[tuple[int, int]]:
    """Corners, x and y, between pieces that other corners join."""
    from scipy.cluster.hierarchy import DisjointSet

    labels, count = label(canvas.upright)
    pieces = DisjointSet(range(count + 1))
    spare: set[tuple[int, int]] = set()
    for x, y in checkerboards(canvas.upright).tolist():
        falling = bool(canvas.upright[y - 1, x - 1])
        one, other = (labels[y - 1, x - 1], labels[y, x]) if falling else (labels[y - 1, x], labels[y, x - 1])
        if not pieces.merge(int(one), int(other)):
            spare.add((x, y))
    return spare


def _corners_near(canvas: Canvas, modules: Cells) -> set[tuple[int, int]]:
    """Checkerboard corners within the given modules, x and y."""
    if not modules.any():
        return set()
    lattice = canvas.lattice
    u, edge = lattice.per_module, lattice.quiet * lattice.per_module
    corners = checkerboards(canvas.upright)
    # A corner on the edge between two modules is far from either centre: it may count for any of them.
    column, row = ((corners - edge) // u).T
    inside = (column >= 0) & (row >= 0) & (column < len(modules)) & (row < len(modules))
    column, row, corners = column[inside], row[inside], corners[inside]
    return {(int(x), int(y)) for x, y in corners[modules[row, column]]}


def _linked(canvas: Canvas, web_mm: float, gap_mm: float, parted: set[tuple[int, int]]) -> Canvas:
    """Every corner joined or, if it is named, parted; joining may make others touch, so it is repeated."""
    lattice = canvas.lattice
    # One cell more than the neck needs: where a stair is cut by other work its cells alone must hold.
    web_leg = lattice.whole(web_mm / math.sqrt(2)) + 1
    gap_leg = lattice.whole(gap_mm / math.sqrt(2))
    for _ in range(MAX_LINK_ROUNDS):
        corners = checkerboards(canvas.upright)
        if not len(corners):
            break
        solid, upright, laid = canvas.solid.copy(), canvas.upright.copy(), []
        for x, y in corners.tolist():
            falling = bool(canvas.upright[y - 1, x - 1])  # solid at the top left and the bottom right
            if (x, y) in parted:
                for cells in (solid, upright):
                    _cut_band(cells, x, y, gap_leg, not falling)
                continue
            for cells in (solid, upright):
                paint_band(cells, x, y, web_leg, falling)
            laid.append(_corner_bridge(lattice, x, y, web_leg, falling))
        canvas = replace(
            canvas, lattice=lattice.with_solid(solid), upright=upright, bridges=(*canvas.bridges, *laid)
        )
    return canvas.counted(corners_parted=len(parted))


def paint_band(solid: Cells, x: int, y: int, leg: int, falling: bool) -> None:
    """Paints the two triangles with the given legs that make a neck through a lattice point.

    The stairs of their cells are read back as straight 45° edges when the outline is drawn.
    """
    for quarter, triangle in _quarters(solid, x, y, _triangle(leg), falling):
        quarter |= triangle


def _cut_band(solid: Cells, x: int, y: int, leg: int, falling: bool) -> None:
    """Cuts the two triangles with the given legs that part a corner; the slope is that of the gap."""
    for quarter, triangle in _quarters(solid, x, y, _triangle(leg + 1), falling):
        quarter &= ~triangle


def _quarters(solid: Cells, x: int, y: int, triangle: Cells, falling: bool) -> Iterator[tuple[Cells, Cells]]:
    """The two quarters beside a diagonal band through a point, each with the triangle turned to fit it."""
    reach = min(len(triangle), x, y, solid.shape[1] - x, solid.shape[0] - y)
    triangle = triangle[:reach, :reach]
    above, below = solid[y - reach : y, x - reach : x + reach], solid[y : y + reach, x - reach : x + reach]
    if falling:
        yield above[:, reach:], triangle[::-1]
        yield below[:, :reach], triangle[:, ::-1]
    else:
        yield above[:, :reach], triangle[::-1, ::-1]
        yield below[:, reach:], triangle


@cache
def _triangle(leg: int) -> Cells:
    """Cells that lie wholly within x + y ≤ leg, from the corner (0, 0)."""
    step = np.arange(leg)
    return step[:, None] + step[None, :] + 2 <= leg


def _corner_bridge(lattice: Lattice, x: int, y: int, leg: int, falling: bool) -> Bridge:
    """The neck as a bridge along the diagonal of the solid, as long as it is wide."""
    across, drop = leg / 2, leg / 2 if falling else -leg / 2
    ends = lattice.to_mm(x - across, y - drop), lattice.to_mm(x + across, y + drop)
    return Bridge(*ends, math.sqrt(2) * leg * lattice.cell_mm, "connectivity", 0.0)
