"""Which loops bound the faces at the ends of wells: front, back, floors of pockets, crests of letters."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from perfqr_cad.profile.well import Well

FIRST, LAST = 0, -1  # the ends of a well


@dataclass(frozen=True)
class Cap:
    """A face at a level, bounded by ends of wells (number of the well, `FIRST` or `LAST`), its outline first.

    up  whether it looks at the reader

    Seen from outside, first loops run in their direction of travel and last loops against it.
    """

    depth_mm: float
    ends: tuple[tuple[int, int], ...]
    up: bool = True


def caps(wells: Sequence[Well], back_mm: float, seam_mm: float | None = None) -> tuple[Cap, ...]:
    """The pieces of the front, the back if there is one, crests and floors.

    seam_mm  depth of bar tops, where storeys of walls meet and no face lies
    """
    fronts: dict[int, list[tuple[int, int]]] = {}
    crests: dict[int, list[tuple[int, int]]] = {}
    floors: dict[int, list[tuple[int, int]]] = {}
    back: list[tuple[int, int]] = []
    for i, well in enumerate(wells):
        begin, end = well.levels[0].depth_mm, well.levels[-1].depth_mm
        if well.crest:
            crests.setdefault(well.crest, []).append((i, FIRST))
            fronts.setdefault(well.piece, []).append((i, LAST))
            continue
        if begin != seam_mm:
            fronts.setdefault(well.piece, []).append((i, FIRST))
        if well.floor:
            floors.setdefault(well.floor, []).append((i, LAST))
        elif end != seam_mm:
            back.append((i, LAST))
    front_mm = wells[0].levels[0].depth_mm
    return (
        *(Cap(front_mm, tuple(ends)) for _, ends in sorted(fronts.items())),
        *([Cap(back_mm, tuple(back), up=False)] if back else []),
        *(Cap(wells[ends[0][0]].levels[0].depth_mm, tuple(ends)) for ends in crests.values()),
        *(Cap(wells[ends[0][0]].levels[-1].depth_mm, tuple(ends)) for ends in floors.values()),
    )
