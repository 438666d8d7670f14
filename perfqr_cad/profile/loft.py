"""Lofts: loops of a pattern followed into the material, level by level."""

from __future__ import annotations

from dataclasses import dataclass

from perfqr_cad.geometry.outline import Loop, Segment


@dataclass(frozen=True)
class Level:
    """Loops of the pattern at one depth: on a face (front, back, floor of a pocket) or between faces."""

    depth_mm: float
    on_face: bool


@dataclass(frozen=True)
class Loft:
    """One loop followed into the material, which lies to the left of travel.

    loops   one for each level, the uppermost first, with equally many segments
    levels  their depths: from the front, or from the level of the bars for what stands below it
    floor   number of the floor that the last loop bounds (a blind pocket's), from 1; 0: none
    boss    number of the raised face that the first loop bounds (a letter's), from 1; 0: none
    piece   which piece of the front face a loop at the front bounds; under a boss, the last one
    part_of the loft from front to back of which this holds some levels: curves are fitted to the whole
    """

    loops: tuple[Loop, ...]
    levels: tuple[Level, ...]
    floor: int = 0
    boss: int = 0
    piece: int = 0
    part_of: Loft | None = None

    def stacks(self) -> list[tuple[Segment, ...]]:
        """The segments that lie above one another."""
        return list(zip(*(loop.segments for loop in self.loops), strict=True))
