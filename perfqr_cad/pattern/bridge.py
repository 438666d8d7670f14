"""A bar of material that joins two pieces."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from perfqr_cad.pattern.outline import Point

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
