"""A pattern under way: solid cells, the bridges laid so far, and how to lay one more."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from perfqr_cad.geometry.outline import Loop
from perfqr_cad.pattern.bridge import Bridge, Stage
from perfqr_cad.pattern.cells.lattice import Cells, Lattice

FOOT = 0.6  # of the square of a bar's width: half is what a bar along a module's edge needs to turn into it


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
class Canvas:
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

    def counted(self, **edits: int) -> Canvas:
        """The same canvas with more edits on its account."""
        total = Counter(self.edits)
        total.update(edits)
        return replace(self, edits={name: count for name, count in sorted(total.items()) if count})

    def with_cells(self, cells: Cells, solid: bool) -> Canvas:
        """The canvas with the given cells made solid or void."""
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

    def with_solid(self, rects: Iterable[Rect]) -> Canvas:
        """The canvas with the given cells made solid."""
        solid, upright = self.solid.copy(), self.upright.copy()
        for rect in rects:
            rect.of(solid)[:] = rect.of(upright)[:] = True
        return replace(self, lattice=self.lattice.with_solid(solid), upright=upright)

    def with_bars(
        self,
        ways: Iterable[Sequence[Bar]],
        stage: Stage,
        *,
        height_mm: float | None = None,
        pinched: bool = False,
    ) -> Canvas:
        """Upright bars painted solid, those of one way together; the last two as of their `Bridge`.

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
                    laid.append(replace(bridge, height_mm=height_mm, pinched=pinched))
                first = first and not added
                bar.rect.of(solid)[:] = bar.rect.of(upright)[:] = True
        return replace(
            self, lattice=self.lattice.with_solid(solid), upright=upright, bridges=(*self.bridges, *laid)
        )

    def with_slanted(self, bridge: Bridge) -> Canvas:
        """A bar at any angle, with half its width more at both ends so that it is held by what it joins."""
        solid = self.solid.copy()
        paint_strip(solid, [self.lattice.from_mm(point) for point in bridge.overlapping().corners()])
        return replace(
            self,
            lattice=self.lattice.with_solid(solid),
            bridges=(*self.bridges, bridge),
            slanted=(*self.slanted, bridge),
        )

    def with_shapes(self, shapes: Sequence[Loop]) -> Canvas:
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
