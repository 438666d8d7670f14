"""Letters on the face of a part: walls that stand out of it, or go into it."""

from __future__ import annotations

from dataclasses import replace

import shapely

from .chart import Level, Well
from .lettering import Lettering
from .sections import Sections


def lettered(sections: Sections, lettering: Lettering) -> Sections:
    """The part with letters on the first piece of its front.

    What a letter encloses is a piece of the front of its own, on which further letters may stand: a ring
    around a letter, say.
    """
    number = max((well.floor for well in sections.wells), default=0)
    piece = sections.pieces
    wells: list[Well] = []
    enclosed: list[tuple[shapely.Polygon, int]] = []  # the smallest last
    for letter in sorted(lettering.letters, key=lambda region: -region.outer.area):
        number += 1
        corner = shapely.Point(letter.outer.segments[0].start)
        ground = next((at for polygon, at in reversed(enclosed) if polygon.contains(corner)), 0)
        for k, loop in enumerate(letter.loops):
            at = piece if k else ground
            if lettering.is_raised:
                levels = Level(-lettering.relief_mm, True), Level(0.0, True)
                wells.append(Well((loop, loop), levels, crest=number, piece=at))
            else:
                levels = Level(0.0, True), Level(-lettering.relief_mm, True)
                hole = loop.reversed()
                wells.append(Well((hole, hole), levels, floor=number, piece=at))
            if k:
                enclosed.append((shapely.Polygon(loop.flatten()), piece))
                piece += 1
    return replace(sections, wells=(*sections.wells, *wells), pieces=piece)
