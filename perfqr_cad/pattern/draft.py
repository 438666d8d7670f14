"""A pattern under way: solid cells, the bridges laid so far, and how to lay one more."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from typing import NamedTuple

import numpy as np

from perfqr_cad.pattern.bridge import Bridge, Stage
from perfqr_cad.pattern.lattice import Cells, Lattice, checkerboards, label
from perfqr_cad.pattern.outline import Loop
from perfqr_cad.pattern.sampling import brightness

FOOT = 0.6  # of the square of a bar's width: half is what a bar along a module's edge needs to turn into it
MAX_LINK_ROUNDS = 8  # a link may make its neighbours touch at a corner; each round only joins more


class Rect(NamedTuple):
    """Cells x0 ≤ x < x1, y0 ≤ y < y1."""

    x0: int
    y0: int
    x1: int
    y1: int

    def of(self, cells: Cells) -> Cells:
        """View of these cells."""
        return cells[self.y0 : self.y1, self.x0 : self.x1]


class Bar(NamedTuple):
    """An upright bridge to be: its cells, whether it runs along x, and what it was held to cost."""

    rect: Rect
    along_x: bool
    cost: float = 0.0

    @property
    def width(self) -> int:
        """Cells across the bar."""
        return self.rect.y1 - self.rect.y0 if self.along_x else self.rect.x1 - self.rect.x0

    @property
    def slenderness(self) -> float:
        """Length in widths."""
        length = self.rect.x1 - self.rect.x0 if self.along_x else self.rect.y1 - self.rect.y0
        return length / self.width


@dataclass(frozen=True, eq=False)
class Draft:
    """The lattice as a reader sees it, and what made it so.

    upright   the solid cells without the slanted bridges, whose exact outlines are added at the end
    asked     the solid cells of the art as it was asked for
    shapes    holes with exact outlines, void in the lattice but not in `upright`
    smooth_mm tolerance within which the outline may be smoothed; 0 keeps it exact
    """

    lattice: Lattice
    upright: Cells
    asked: Cells
    bridges: tuple[Bridge, ...] = ()
    slanted: tuple[Bridge, ...] = ()
    shapes: tuple[Loop, ...] = ()
    smooth_mm: float = 0.0
    edits: Mapping[str, int] = field(default_factory=dict)

    @property
    def solid(self) -> Cells:
        return self.lattice.solid

    def counted(self, **edits: int) -> Draft:
        """The same draft with more edits on its account."""
        total = Counter(self.edits)
        total.update(edits)
        return replace(self, edits={name: count for name, count in sorted(total.items()) if count})

    def with_cells(self, cells: Cells, solid: bool) -> Draft:
        """The draft with the given cells made solid or void."""
        change = np.logical_or if solid else _without
        lattice = self.lattice.with_solid(change(self.solid, cells))
        return replace(self, lattice=lattice, upright=change(self.upright, cells))

    @property
    def recessed(self) -> tuple[Bridge, ...]:
        """The bridges that fill only the back of the part."""
        return tuple(bridge for bridge in self.bridges if bridge.is_recessed)

    def rect(self, bridge: Bridge) -> Rect:
        """The cells of an upright bridge."""
        corners = np.array([self.lattice.from_mm(corner) for corner in bridge.corners()])
        x0, y0 = np.rint(corners.min(axis=0)).astype(int).tolist()
        x1, y1 = np.rint(corners.max(axis=0)).astype(int).tolist()
        return Rect(x0, y0, x1, y1)

    def with_solid(self, rects: Iterable[Rect]) -> Draft:
        """The draft with the given cells made solid."""
        solid, upright = self.solid.copy(), self.upright.copy()
        for rect in rects:
            rect.of(solid)[:] = rect.of(upright)[:] = True
        return replace(self, lattice=self.lattice.with_solid(solid), upright=upright)

    def with_bars(self, ways: Iterable[Sequence[Bar]], stage: Stage, height_mm: float | None = None) -> Draft:
        """Upright bars painted solid, those of one way together.

        Bars over solid ground leave no trace. Where a way bends, a bar that adds less than `FOOT` to the
        longer ones is but their foot, and no bridge of its own.
        """
        solid, upright, laid = self.solid.copy(), self.upright.copy(), []
        for way in ways:
            first = True
            for bar in sorted(way, key=lambda bar: bar.slenderness, reverse=True):
                added = np.count_nonzero(~bar.rect.of(solid)) / bar.width**2
                if added and (first or added >= FOOT):
                    bridge = self._bridge(_void_part(solid, bar), bar, stage)
                    laid.append(replace(bridge, height_mm=height_mm))
                first = first and not added
                bar.rect.of(solid)[:] = bar.rect.of(upright)[:] = True
        return replace(
            self, lattice=self.lattice.with_solid(solid), upright=upright, bridges=(*self.bridges, *laid)
        )

    def with_slanted(self, bridge: Bridge) -> Draft:
        """A bar at any angle, with half its width more at both ends so that it is held by what it joins."""
        solid = self.solid.copy()
        paint_strip(solid, [self.lattice.from_mm(point) for point in strip(bridge)])
        return replace(
            self,
            lattice=self.lattice.with_solid(solid),
            bridges=(*self.bridges, bridge),
            slanted=(*self.slanted, bridge),
        )

    def with_shapes(self, shapes: Sequence[Loop]) -> Draft:
        """Holes with exact outlines cut out; the art is then taken to be asked for with them."""
        solid = self.solid.copy()
        for shape in shapes:
            paint_strip(solid, [self.lattice.from_mm((x, y)) for x, y in shape.flatten().tolist()], False)
        lattice = self.lattice.with_solid(solid)
        return replace(self, lattice=lattice, asked=solid, shapes=tuple(shapes))

    def _bridge(self, rect: Rect, bar: Bar, stage: Stage) -> Bridge:
        middle_x, middle_y = (rect.x0 + rect.x1) / 2, (rect.y0 + rect.y1) / 2
        ends = (
            ((rect.x0, middle_y), (rect.x1, middle_y))
            if bar.along_x
            else ((middle_x, rect.y0), (middle_x, rect.y1))
        )
        to_mm, cell = self.lattice.to_mm, self.lattice.cell_mm
        return Bridge(to_mm(*ends[0]), to_mm(*ends[1]), bar.width * cell, stage, bar.cost)


SUBCELL_BITS = 8  # OpenCV's fixed-point fraction


def paint_strip(solid: Cells, corners: Sequence[tuple[float, float]], value: bool = True) -> None:
    """Paints a convex polygon, given in lattice coordinates, cell by cell."""
    import cv2

    # Pixel centres are at whole numbers for OpenCV, at halves on the lattice.
    points = np.array(corners) - 0.5
    low = np.clip(np.floor(points.min(axis=0)).astype(int) - 1, 0, None)
    high = np.clip(np.ceil(points.max(axis=0)).astype(int) + 2, 0, None)
    window = solid[low[1] : high[1], low[0] : high[0]]
    canvas = window.astype(np.uint8)
    fixed = np.rint((points - low) * (1 << SUBCELL_BITS)).astype(np.int32)
    cv2.fillConvexPoly(canvas, fixed, int(value), shift=SUBCELL_BITS)
    window[:] = canvas


def strip(bridge: Bridge) -> list[tuple[float, float]]:
    """The four corners, mm, of a slanting bridge with its overlap of half a width at both ends."""
    (x0, y0), (x1, y1) = bridge.start, bridge.end
    length = math.dist(bridge.start, bridge.end)
    ux, uy = ((x1 - x0) / length, (y1 - y0) / length) if length > 0 else (1.0, 0.0)
    h = bridge.width_mm / 2
    x0, y0, x1, y1 = x0 - ux * h, y0 - uy * h, x1 + ux * h, y1 + uy * h
    return [
        (x0 + uy * h, y0 - ux * h),
        (x1 + uy * h, y1 - ux * h),
        (x1 - uy * h, y1 + ux * h),
        (x0 - uy * h, y0 + ux * h),
    ]


def link_corners(
    draft: Draft, web_mm: float, gap_mm: float, right_solid: Cells, sparing: bool = False
) -> Draft:
    """Joins solid cells that meet at a corner only, by a 45° band of the least web.

    A corner left as it is would be a non-manifold edge of the solid. The band takes a triangle from each of
    the two voids, the least area of all shapes that leave a neck of the given width. Where that would turn a
    module wrong, the corner is parted by the least gap instead.

    right_solid  (n, n) modules that ought to be material
    sparing      part also the corners of pieces that are joined already: fine art changes less by it
    """
    parted = _superfluous(draft) if sparing else set[tuple[int, int]]()
    linked = draft
    for _ in range(MAX_LINK_ROUNDS):
        linked = _linked(draft, web_mm, gap_mm, parted)
        harmed = ((brightness(draft.lattice) >= 0.5) == right_solid) & (
            (brightness(linked.lattice) >= 0.5) != right_solid
        )
        guilty = _corners_near(draft, harmed) - parted
        if not guilty:
            return linked
        parted |= guilty
    return linked


def _superfluous(draft: Draft) -> set[tuple[int, int]]:
    """Corners, x and y, between pieces that other corners join."""
    labels, _ = label(draft.upright)
    leader: dict[int, int] = {}

    def find(piece: int) -> int:
        while leader.setdefault(piece, piece) != piece:
            leader[piece] = piece = leader[leader[piece]]
        return piece

    spare: set[tuple[int, int]] = set()
    for x, y in checkerboards(draft.upright).tolist():
        falling = bool(draft.upright[y - 1, x - 1])
        one, other = (labels[y - 1, x - 1], labels[y, x]) if falling else (labels[y - 1, x], labels[y, x - 1])
        a, b = find(int(one)), find(int(other))
        if a == b:
            spare.add((x, y))
        leader[a] = b
    return spare


def _corners_near(draft: Draft, modules: Cells) -> set[tuple[int, int]]:
    """Checkerboard corners within the given modules, x and y."""
    if not modules.any():
        return set()
    lattice = draft.lattice
    u, edge = lattice.per_module, lattice.quiet * lattice.per_module
    corners = checkerboards(draft.upright)
    # A corner on the edge between two modules is far from either centre: it may count for any of them.
    column, row = ((corners - edge) // u).T
    inside = (column >= 0) & (row >= 0) & (column < len(modules)) & (row < len(modules))
    column, row, corners = column[inside], row[inside], corners[inside]
    return {(int(x), int(y)) for x, y in corners[modules[row, column]]}


def _linked(draft: Draft, web_mm: float, gap_mm: float, parted: set[tuple[int, int]]) -> Draft:
    """Every corner joined or, if it is named, parted; joining may make others touch, so it is repeated."""
    lattice = draft.lattice
    # One cell more than the neck needs: where a stair is cut by other work its cells alone must hold.
    web_leg = lattice.whole(web_mm / math.sqrt(2)) + 1
    gap_leg = lattice.whole(gap_mm / math.sqrt(2))
    for _ in range(MAX_LINK_ROUNDS):
        corners = checkerboards(draft.upright)
        if not len(corners):
            break
        solid, upright, laid = draft.solid.copy(), draft.upright.copy(), []
        for x, y in corners.tolist():
            falling = bool(draft.upright[y - 1, x - 1])  # solid at the top left and the bottom right
            if (x, y) in parted:
                for cells in (solid, upright):
                    _cut_band(cells, x, y, gap_leg, not falling)
                continue
            for cells in (solid, upright):
                paint_band(cells, x, y, web_leg, falling)
            laid.append(_corner_bridge(lattice, x, y, web_leg, falling))
        draft = replace(
            draft, lattice=lattice.with_solid(solid), upright=upright, bridges=(*draft.bridges, *laid)
        )
    return draft.counted(corners_parted=len(parted))


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


def _without(solid: Cells, cells: Cells) -> Cells:
    return solid & ~cells


def _void_part(solid: Cells, bar: Bar) -> Rect:
    """The stretch of a bar that lies over void."""
    rect, along_x = bar.rect, bar.along_x
    used = np.flatnonzero((~rect.of(solid)).any(axis=0 if along_x else 1))
    first, last = int(used[0]), int(used[-1]) + 1
    if along_x:
        return Rect(rect.x0 + first, rect.y0, rect.x0 + last, rect.y1)
    return Rect(rect.x0, rect.y0 + first, rect.x1, rect.y0 + last)
