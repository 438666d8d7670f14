"""From a region and its walls to the loops at each depth: where every hole begins, flares and ends."""

from __future__ import annotations

from dataclasses import dataclass

from perfqr_cad.pattern.outline import Arc, Circle, Loop, Region, Segment

from .chart import Level
from .offset import widened
from .walls import Walls


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


def wells(region: Region, thickness_mm: float, walls: Walls, whole_circles: bool) -> tuple[Well, ...]:
    """The outer loop, straight from front to back, and then every hole.

    Raises `DesignError` when pockets leave no floor or a lip leaves nothing to flare.
    """
    outer = _laid(region.outer, whole_circles)
    rim = Well((outer, outer), (Level(0.0, True), Level(thickness_mm, True)))
    return (rim, *hole_wells(region.holes, thickness_mm, walls, whole_circles))


def hole_wells(
    holes: tuple[Loop, ...], thickness_mm: float, walls: Walls, whole_circles: bool
) -> tuple[Well, ...]:
    """The holes alone: clockwise loops, as for `wells`."""
    reach = walls.reach_mm(thickness_mm)
    flare = walls.flare_mm(reach)
    floor = walls.depth_mm is not None
    found: list[Well] = []
    for hole in holes:
        loop = _laid(hole, whole_circles)
        if flare == 0:
            loops, depths = (loop, loop), (0.0, reach)
        elif walls.lip_mm == 0:
            loops, depths = (loop, widened(loop, flare)), (0.0, reach)
        else:
            loops, depths = (loop, loop, widened(loop, flare)), (0.0, walls.lip_mm, reach)
        levels = tuple(Level(d, d in (0.0, reach)) for d in depths)
        found.append(Well(loops, levels, floor))
    return tuple(found)


def _laid(loop: Loop, whole_circles: bool) -> Loop:
    """The loop with a lone circle cut in two half-circles, where the chart wants it so."""
    first = loop.segments[0]
    if whole_circles or not isinstance(first, Circle):
        return loop
    (cx, cy), r = first.centre, first.radius
    right, left = (cx + r, cy), (cx - r, cy)
    return Loop((Arc(right, left, first.centre, first.ccw), Arc(left, right, first.centre, first.ccw)))
