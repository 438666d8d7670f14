"""The finished pattern: one piece of material in the plane, and how it came to be one."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Literal, NamedTuple

from .outline import Point, Region
from .spec import PatternSpec

if TYPE_CHECKING:
    from shapely.geometry import Polygon

    from ..symbol import Matrix, Readability, Symbol

Stage = Literal["function", "connectivity", "structural"]


@dataclass(frozen=True, slots=True)
class Bridge:
    """A straight bar of material from `start` to `end` (centre line, mm) that joins two boundaries.

    recess_mm is how far the bar's reading side lies behind the face: 0 is flush. A recessed bar fills only
    the back part of the thickness, so that a reader sees it in the shade of the slot.
    """

    start: Point
    end: Point
    width_mm: float
    stage: Stage
    cost: float
    recess_mm: float = 0.0


class Optimality(NamedTuple):
    """What the solver proved about the chosen bridges."""

    objective: float
    bound: float
    gap: float
    seconds: float


@dataclass(frozen=True)
class Pattern:
    """The 2-D design: material as one region in mm, origin at the centre of the code, y up.

    region            outline of the material with curves kept as curves
    skeleton          the same before corners are rounded: what bridges are added to
    bridges           in the order in which they were laid
    islands_before    pieces of material before any bridge (sharing a corner is not joined)
    observed          the matrix as sampled on the finished region
    changed_area_mm2  area where the material differs from the art that was asked for
    edits             counts of clean-up changes by name
    optimality        what was proved, None for the baselines
    """

    symbol: Symbol
    spec: PatternSpec
    module_mm: float
    quiet_modules: int
    region: Region
    bridges: tuple[Bridge, ...]
    islands_before: int
    observed: Matrix
    readability: Readability
    changed_area_mm2: float
    edits: Mapping[str, int]
    optimality: Optimality | None = None
    skeleton: Region | None = field(default=None, repr=False)

    @property
    def size_mm(self) -> float:
        """Edge of the whole code with its quiet zone, mm."""
        return self.module_mm * (self.symbol.size + 2 * self.quiet_modules)

    @cached_property
    def polygon(self) -> Polygon:
        """The region as a shapely polygon, curves within the default tolerance."""
        return self.region.polygon()
