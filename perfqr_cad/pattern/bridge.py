"""A bar of material that joins two pieces."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal

from perfqr_cad.geometry.outline import Point

Stage = Literal["function", "connectivity", "structural"]

LEAST_SLOT_DEPTH_MM = 0.4  # of the slot before a recessed bar; in a shallower one a bar is seen as if flush


@dataclass(frozen=True, slots=True)
class Bridge:
    """A straight bar of material from `start` to `end` (centre line, mm) that joins two boundaries.

    height_mm is None for a bar through the whole thickness. A recessed bar fills only the last height_mm
    before the back, so that a reader sees it in the shade of its slot; `start` and `end` then lie on straight
    edges of `Pattern.front`, square to the bar. Where that slot is pinched, walls that flare leave its two
    banks upright.
    """

    start: Point
    end: Point
    width_mm: float
    stage: Stage
    cost: float
    height_mm: float | None = None
    pinched: bool = False

    @property
    def is_recessed(self) -> bool:
        return self.height_mm is not None

    def corners(self) -> tuple[Point, Point, Point, Point]:
        """Right of the start, right and left of the end, left of the start, mm: counter-clockwise.

        >>> Bridge((0, 0), (2, 0), 1.0, "connectivity", 0.0).corners()
        ((0.0, -0.5), (2.0, -0.5), (2.0, 0.5), (0.0, 0.5))
        """
        (x0, y0), (x1, y1) = self.start, self.end
        reach = self.width_mm / 2 / math.dist(self.start, self.end)
        dx, dy = (y1 - y0) * reach, (x0 - x1) * reach  # half the width to the right
        return (x0 + dx, y0 + dy), (x1 + dx, y1 + dy), (x1 - dx, y1 - dy), (x0 - dx, y0 - dy)

    def mirrored(self) -> Bridge:
        """The same bar at −x."""
        return replace(self, start=(-self.start[0], self.start[1]), end=(-self.end[0], self.end[1]))

    def lengthened(self, by_mm: float) -> Bridge:
        """The same bar, longer by so much at both ends."""
        (x0, y0), (x1, y1) = self.start, self.end
        share = by_mm / math.dist(self.start, self.end)
        dx, dy = (x1 - x0) * share, (y1 - y0) * share
        return replace(self, start=(x0 - dx, y0 - dy), end=(x1 + dx, y1 + dy))

    def overlapping(self) -> Bridge:
        """With half its width more at both ends, by which what it joins holds it; along x if it is a point.

        Not by `lengthened`, which rounds otherwise: the last digits of finished patterns would change.
        """
        (x0, y0), (x1, y1) = self.start, self.end
        length = math.dist(self.start, self.end)
        ux, uy = ((x1 - x0) / length, (y1 - y0) / length) if length > 0 else (1.0, 0.0)
        h = self.width_mm / 2
        return replace(self, start=(x0 - ux * h, y0 - uy * h), end=(x1 + ux * h, y1 + uy * h))
