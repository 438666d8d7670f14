"""Letters on the face of a part: walls that stand out of it, or go into it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import shapely

from perfqr_cad.geometry.outline import Region
from perfqr_cad.profile.loft import Level, Loft
from perfqr_cad.profile.sections import Sections


def lettered(sections: Sections, letters: Sequence[Region], relief_mm: float) -> Sections:
    """The part with letters on the first piece of its front, which stand `relief_mm` out of it; below 0 they
    are engraved.

    What a letter encloses is a piece of the front of its own, on which further letters may stand: a c in
    a ring, say.
    """
    number = max((loft.floor for loft in sections.lofts), default=0)
    piece = sections.pieces
    lofts: list[Loft] = []
    enclosed: list[tuple[shapely.Polygon, int]] = []  # what lies within others after them
    for letter in sorted(letters, key=lambda region: -region.outer.area):
        number += 1
        corner = shapely.Point(letter.outer.segments[0].start)
        ground = next((at for polygon, at in reversed(enclosed) if polygon.contains(corner)), 0)
        for k, loop in enumerate(letter.loops):
            at = piece if k else ground
            if relief_mm > 0:
                levels = Level(-relief_mm, True), Level(0.0, True)
                lofts.append(Loft((loop, loop), levels, boss=number, piece=at))
            else:
                levels = Level(0.0, True), Level(-relief_mm, True)
                hole = loop.reversed()
                lofts.append(Loft((hole, hole), levels, floor=number, piece=at))
            if k:
                enclosed.append((shapely.Polygon(loop.flatten()), piece))
                piece += 1
    return replace(sections, lofts=(*sections.lofts, *lofts), pieces=piece)
