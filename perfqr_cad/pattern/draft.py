"""A pattern under way: solid cells, the bridges laid so far, and how to lay one more."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from perfqr_cad.pattern.lattice import Cells, Lattice, checkerboards
from perfqr_cad.pattern.pattern import Bridge, Stage

MAX_LINK_ROUNDS = 8  # a link may make its neighbours touch at a corner; each round only joins more


class Rect(NamedTuple):
    """Cells x0 ≤ x < x1, y0 ≤ y < y1."""

    x0: int
    y0: int
    x1: int
    y1: int


@dataclass(frozen=True, eq=False)
class Draft:
    """The lattice as a reader sees it, and what made it so.

    upright   the solid cells without the slanting bridges, whose exact outline is added at the end
    asked     the solid cells of the art as it was asked for
    """

    lattice: Lattice
    upright: Cells
    asked: Cells
    bridges: tuple[Bridge, ...] = ()
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

    def with_bars(self, bars: Iterable[tuple[Rect, bool]], stage: Stage, cost: float = 0.0) -> Draft:
        """Upright bars painted solid; the flag says that a bar runs along x. Bars over solid ground leave no trace."""
        solid, upright, laid = self.solid.copy(), self.upright.copy(), []
        for rect, along_x in bars:
            if (shown := _void_part(solid, rect, along_x)) is None:
                continue
            at = np.s_[rect.y0 : rect.y1, rect.x0 : rect.x1]
            solid[at] = upright[at] = True
            laid.append(self._bridge(shown, along_x, stage, cost))
        return replace(
            self, lattice=self.lattice.with_solid(solid), upright=upright, bridges=(*self.bridges, *laid)
        )

    def with_slanted(self, bridge: Bridge) -> Draft:
        """A bar at any angle, with half its width more at both ends so that it is held by what it joins."""
        import cv2

        outline = [self.lattice.from_mm(p) for p in strip(bridge)]
        sub = 1 << SUBCELL_BITS
        # Pixel centres are at whole numbers for OpenCV, at halves on the lattice.
        corners = np.rint((np.array(outline) - 0.5) * sub).astype(np.int32)
        canvas = self.solid.astype(np.uint8)
        cv2.fillConvexPoly(canvas, corners, 1, shift=SUBCELL_BITS)
        solid = np.asarray(canvas, np.bool_)
        return replace(self, lattice=self.lattice.with_solid(solid), bridges=(*self.bridges, bridge))

    def _bridge(self, rect: Rect, along_x: bool, stage: Stage, cost: float) -> Bridge:
        middle_x, middle_y = (rect.x0 + rect.x1) / 2, (rect.y0 + rect.y1) / 2
        ends = ((rect.x0, middle_y), (rect.x1, middle_y)) if along_x else ((middle_x, rect.y0), (middle_x, rect.y1))
        width = (rect.y1 - rect.y0) if along_x else (rect.x1 - rect.x0)
        to_mm, cell = self.lattice.to_mm, self.lattice.cell_mm
        return Bridge(to_mm(*ends[0]), to_mm(*ends[1]), width * cell, stage, cost)


SUBCELL_BITS = 8  # OpenCV's fixed-point fraction


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


def is_slanted(bridge: Bridge) -> bool:
    """Whether a bridge runs neither along x nor along y, and so is not drawn on the lattice."""
    (x0, y0), (x1, y1) = bridge.start, bridge.end
    return x0 != x1 and y0 != y1


def link_corners(draft: Draft, web_mm: float) -> Draft:
    """Joins solid cells that meet at a corner only, by a square whose diagonal is the least web.

    A corner left as it is would be a non-manifold edge of the solid. The square takes the least area of
    all shapes that leave a neck of the given width.
    """
    lattice = draft.lattice
    half = lattice.whole(web_mm / (2 * math.sqrt(2)))
    neck_mm = 2 * math.sqrt(2) * half * lattice.cell_mm
    for _ in range(MAX_LINK_ROUNDS):
        corners = checkerboards(draft.upright)
        if not len(corners):
            return draft
        solid, upright, laid = draft.solid.copy(), draft.upright.copy(), []
        for x, y in corners.tolist():
            falling = draft.upright[y - 1, x - 1]  # solid at the top left and the bottom right
            at = np.s_[max(y - half, 0) : y + half, max(x - half, 0) : x + half]
            solid[at] = upright[at] = True
            slope = half if falling else -half
            ends = lattice.to_mm(x - half, y - slope), lattice.to_mm(x + half, y + slope)
            laid.append(Bridge(*ends, neck_mm, "connectivity", 0.0))
        draft = replace(
            draft, lattice=lattice.with_solid(solid), upright=upright, bridges=(*draft.bridges, *laid)
        )
    return draft


def _without(solid: Cells, cells: Cells) -> Cells:
    return solid & ~cells


def _void_part(solid: Cells, rect: Rect, along_x: bool) -> Rect | None:
    """The stretch of a bar that lies over void, or None when the bar adds nothing."""
    covered = ~solid[rect.y0 : rect.y1, rect.x0 : rect.x1]
    used = np.flatnonzero(covered.any(axis=0 if along_x else 1))
    if not len(used):
        return None
    first, last = int(used[0]), int(used[-1]) + 1
    if along_x:
        return Rect(rect.x0 + first, rect.y0, rect.x0 + last, rect.y1)
    return Rect(rect.x0, rect.y0 + first, rect.x1, rect.y0 + last)
