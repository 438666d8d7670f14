"""Which loops bound the faces at the ends of lofts: front, back, floors of pockets, tops of bosses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from perfqr_cad.profile.loft import Loft

FIRST, LAST = 0, -1  # the ends of a loft


@dataclass(frozen=True)
class Cap:
    """A face at a level, bounded by ends of lofts (number of the loft, `FIRST` or `LAST`), its outline first.

    up  whether it looks at the reader

    Seen from outside, first loops run in their direction of travel and last loops against it.
    """

    depth_mm: float
    ends: tuple[tuple[int, int], ...]
    up: bool = True


def caps(lofts: Sequence[Loft], back_mm: float, seam_mm: float | None = None) -> tuple[Cap, ...]:
    """The pieces of the front, the back if there is one, tops of bosses and floors of pockets.

    seam_mm  depth of bar tops, where the walls above and below meet and no face lies
    """
    fronts: dict[int, list[tuple[int, int]]] = {}
    bosses: dict[int, list[tuple[int, int]]] = {}
    floors: dict[int, list[tuple[int, int]]] = {}
    back: list[tuple[int, int]] = []
    for i, loft in enumerate(lofts):
        begin, end = loft.levels[0].depth_mm, loft.levels[-1].depth_mm
        if loft.boss:
            bosses.setdefault(loft.boss, []).append((i, FIRST))
            fronts.setdefault(loft.piece, []).append((i, LAST))
            continue
        if begin != seam_mm:
            fronts.setdefault(loft.piece, []).append((i, FIRST))
        if loft.floor:
            floors.setdefault(loft.floor, []).append((i, LAST))
        elif end != seam_mm:
            back.append((i, LAST))
    front_mm = lofts[0].levels[0].depth_mm
    return (
        *(Cap(front_mm, tuple(ends)) for _, ends in sorted(fronts.items())),
        *([Cap(back_mm, tuple(back), up=False)] if back else []),
        *(Cap(lofts[ends[0][0]].levels[0].depth_mm, tuple(ends)) for ends in bosses.values()),
        *(Cap(lofts[ends[0][0]].levels[-1].depth_mm, tuple(ends)) for ends in floors.values()),
    )
