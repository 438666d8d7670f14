"""From a region and its walls to the loops at each depth: where every hole begins, flares and ends."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from perfqr_cad.errors import DesignError
from perfqr_cad.pattern.outline import Arc, Circle, Loop, Region, Segment

from .chart import Level
from .flare import flares, webs
from .offset import widened
from .walls import Walls

LEAST_WEB_MM = 1e-3  # at the back, where no minimum is asked for: holes must not touch
HALVINGS = 6  # of the flares beside a web that comes out too thin
WEB_SLACK = (
    0.02  # corners of two holes that meet diagonally give way along their mitres, a little more than edges
)


@dataclass(frozen=True)
class Well:
    """One loop followed from the front into the material, material to the left of travel.

    loops   one for each level, front first, with equally many segments
    levels  their depths
    floor   whether the last loop bounds a floor (a blind pocket); else it lies on the back face
    """

    loops: tuple[Loop, ...]
    levels: tuple[Level, ...]
    floor: bool = False

    def stacks(self) -> list[tuple[Segment, ...]]:
        """The segments that lie above one another."""
        return list(zip(*(loop.segments for loop in self.loops), strict=True))


def wells(
    region: Region, thickness_mm: float, walls: Walls, whole_circles: bool, min_web_mm: float = 0.0
) -> tuple[Well, ...]:
    """The outer loop, straight from front to back, and then every hole.

    Raises `DesignError` when pockets leave no floor, a lip leaves nothing to flare, or a draft closes an
    edge.
    """
    outer = _laid(region.outer, whole_circles)
    rim = Well((outer, outer), (Level(0.0, True), Level(thickness_mm, True)))
    holes = hole_wells(
        region.holes, thickness_mm, walls, whole_circles, outer=region.outer, min_web_mm=min_web_mm
    )
    return (rim, *holes)


def hole_wells(
    holes: tuple[Loop, ...],
    thickness_mm: float,
    walls: Walls,
    whole_circles: bool,
    *,
    outer: Loop | None = None,
    min_web_mm: float = 0.0,
) -> tuple[Well, ...]:
    """The holes alone, clockwise loops. Where a draft would leave less than `min_web_mm` of material at
    the back,
    it is less; `outer` bounds the material, None where it goes on beyond the holes.
    """
    reach = walls.reach_mm(thickness_mm)
    flare = walls.flare_mm(reach)
    front = [_laid(hole, whole_circles) for hole in holes]
    if flare == 0:
        depths: tuple[float, ...] = (0.0, reach)
        columns = [(hole, hole) for hole in front]
    else:
        region = Region(outer or _around(front, 2 * flare + min_web_mm), tuple(front))
        wide = _flared(region, flare, min_web_mm)
        lip = walls.lip_mm > 0
        depths = (0.0, walls.lip_mm, reach) if lip else (0.0, reach)
        columns = [(hole, hole, w) if lip else (hole, w) for hole, w in zip(front, wide, strict=True)]
    levels = tuple(Level(d, d in (0.0, reach)) for d in depths)
    return tuple(Well(loops, levels, walls.depth_mm is not None) for loops in columns)


def _flared(region: Region, flare_mm: float, min_web_mm: float) -> list[Loop]:
    """The holes as they are at the back: set back by the flare, or by what the webs and short edges bear.

    Raises `DesignError` where no edge can give way at all.
    """
    least = max(min_web_mm, LEAST_WEB_MM)
    front = webs(region, least)
    back = flares(region, flare_mm, least)
    wide = [widened(hole, set_back) for hole, set_back in zip(region.holes, back, strict=True)]
    for attempt in range(HALVINGS):
        found = webs(Region(region.outer, tuple(wide)), least)
        # A web that is thinner at the front already cannot be asked to be wider at the back.
        thin = [f < (1 - WEB_SLACK) * np.minimum(least, g) for f, g in zip(found, front, strict=True)]
        if not any(t.any() for t in thin):
            break
        share = 0.5 if attempt < HALVINGS - 2 else 0.0
        for k in [k for k, t in enumerate(thin) if t.any()]:
            back[k] = np.where(thin[k], share * back[k], back[k])
            wide[k] = widened(region.holes[k], back[k])
    if wide == list(region.holes) or not Region(region.outer, tuple(wide)).polygon().is_valid:
        raise DesignError(
            f"no hole can be flared by up to {flare_mm:.3g} mm with webs of {least:.3g} mm at the back: "
            "take a smaller draft, a longer lip, a thinner plate or larger modules"
        )
    return wide


def _around(holes: list[Loop], margin_mm: float) -> Loop:
    """A rectangle well clear of all holes."""
    corners = np.vstack([hole.flatten() for hole in holes])
    (x0, y0), (x1, y1) = corners.min(axis=0) - 2 * margin_mm - 1, corners.max(axis=0) + 2 * margin_mm + 1
    return Loop.from_points([(x0, y0), (x1, y0), (x1, y1), (x0, y1)])


def _laid(loop: Loop, whole_circles: bool) -> Loop:
    """The loop with a lone circle cut in two half-circles, where the chart wants it so."""
    first = loop.segments[0]
    if whole_circles or not isinstance(first, Circle):
        return loop
    (cx, cy), r = first.centre, first.radius
    right, left = (cx + r, cy), (cx - r, cy)
    return Loop((Arc(right, left, first.centre, first.ccw), Arc(left, right, first.centre, first.ccw)))
