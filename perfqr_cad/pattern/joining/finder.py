"""Bars that tie the floating rings of finder and alignment patterns to their surroundings (Fig. 7)."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

from perfqr_cad.pattern.spec import FinderStrategy
from perfqr_cad.symbol.tables import alignment_centres

Solid = Callable[[int, int], bool]
Side = Literal["top", "left", "right", "bottom"]

# Why the bar lies where it does: in views of three versions at 4 and 8 pixels a module, tilted by 0, 20 and
# 40°, its place along the top or left side changes nothing for zbar and WeChat, for zxing-cpp no more than
# chance (39-56 % read at 20°, against 100 % without a bar); across the bottom it costs OpenCV a third. A bar
# in the middle of a side breaks the 1:1:3:1:1 line for all. So: by the corner, flush with the light ring,
# which leaves no notch; and no wider than the web: a wide bar costs zxing-cpp more than a narrow one.
FLUSH = 1.0  # modules from the pattern's corner to the near edge of the bar
CORE_FLUSH = 2.0  # the same for a bar from the core
# A bar behind the face lies in shade, and readers see the dark ring go on over it: at 30 and 40° of tilt
# zxing-cpp reads 94 and 92 % of the views with recessed bars on all rings but one, 86 and 67 % with flush
# ones. The edges that it stands on must be straight beyond it where the walls flare.
CLEAR = 0.4  # modules from the corner of the light ring to the near edge of a recessed bar
# zxing-cpp walks around one ring, that of the bottom left finder, and where the walk leaks out over a bar it
# takes the code for untilted (FitSquareToPoints in its QRDetector.cpp): version 7 with a flush bar it reads
# in no view at 20°, without a bar in all. So that bar must look as dark as the ring. Its slot is narrowed
# from the outside, over a module beyond the bar (0.8 to 1.3 do alike), the inner edge left straight. It looks
# for alignment patterns by such walks too (CenterOfRing in its ConcentricFinder.cpp): pinched where they can
# be, 96 instead of 85 % of the views at 40° are read (1.2 mm, six texts). On the upper finders a pinch costs
# more than a light bar: 12 % are read at 20°.
PINCHED = 2.9  # modules from the corner that a pinch spans at least; 2.7 to 3.3 do alike
# Bars on two sides. zxing-cpp compares the middles and the diagonals of all rings with 1:1:3:1:1, walks
# around the lower left one and along the left edge of the upper right one (LocateConcentricPattern,
# FitSquareToPoints, TraceLine). OpenCV fills the dark ring from the middle of its right side and needs the
# outer corners of the code from that; it counts modules along the last row of the upper right finder and the
# last column of the lower left one, and takes the lesser count (computeTransformationPoints and
# versionDefinition in qrcode.cpp). So a pinch keeps clear of corners and middles; the upper left ring may be
# broken on its left, the upper right one at its top; the lower left one must look unbroken all around. Bars
# on two sides of that one cost zxing-cpp a quarter of its reads at 6 pixels a module, and a pinch across its
# middle costs zbar a crisp picture of the face: it has two dark bars on one side.
OFF_MIDDLE = 2.9  # modules from the corner to where such a pinch ends
SHORT_PINCH = 1.9  # to the middle of its bar
WIDEST_OPEN, WIDEST_PINCHED, WIDEST_RIGHT = 1.0, 1.2, 0.5  # modules, of bars on two sides
PLACES: tuple[tuple[Side, bool], ...] = (  # side, and whether by its far end; the top and left before others
    ("top", False),
    ("left", False),
    ("top", True),
    ("left", True),
    ("right", False),
    ("bottom", False),
    ("right", True),
    ("bottom", True),
)


@dataclass(frozen=True, slots=True)
class Ring:
    """A function pattern of `size` modules whose top left module is (row, column)."""

    row: int
    column: int
    size: int

    def inset(self, modules: int) -> Ring:
        """The pattern without its outermost modules."""
        return Ring(self.row + modules, self.column + modules, self.size - 2 * modules)


@dataclass(frozen=True, slots=True)
class RingBar:
    """A bar's centre line in modules of the symbol (x right, y down from its top left), from outside in.

    pinch  x or y, from and to, between which the slot before it is narrowed; None: nowhere
    width  in modules, of a recessed bar
    """

    start: tuple[float, float]
    end: tuple[float, float]
    pinch: tuple[float, float] | None = None
    width: float = 0.0


def rings(version: int) -> list[Ring]:
    """The three finders and all alignment patterns of a version."""
    last = 17 + 4 * version - 7
    taken = {(6, 6), (6, last), (last, 6)}
    centres = alignment_centres(version)
    finders = [Ring(0, 0, 7), Ring(0, last, 7), Ring(last, 0, 7)]
    return finders + [Ring(r - 2, c - 2, 5) for r in centres for c in centres if (r, c) not in taken]


def is_traced(ring: Ring, version: int) -> bool:
    """Whether a reader needs to find this ring unbroken: its bar must look as dark as the ring."""
    return ring == Ring(17 + 4 * version - 7, 0, 7)


def is_located(ring: Ring) -> bool:
    """Whether this is an alignment pattern: readers do without, but from aside they read better with it."""
    return ring.size == 5


def ring_bars(ring: Ring, strategy: FinderStrategy, width: float, solid: Solid) -> list[RingBar]:
    """Flush bars `width` modules wide across the dark ring of a finder or alignment pattern.

    solid tells of a module (row, column), which may lie in the quiet zone, whether it is material. An
    alignment pattern without material near any corner gets no bar: a route of its own does less harm.
    """
    return _diagonal_bars(ring) if strategy == "diagonal" else _side_bar(ring, width, solid)


def recessed_bars(ring: Ring, width: float, clear: float, solid: Solid, pinched: bool) -> list[RingBar]:
    """Where a bar behind the face may lie, the best place first: material must lie all along its bank.

    clear  modules of straight edge beyond the bar, `CLEAR` or more
    """
    reach = FLUSH + clear + width + clear
    modules = range(math.ceil(max(PINCHED, reach))) if pinched else range(1, math.ceil(reach))
    places = sorted(PLACES, key=lambda place: place[0] != "left") if pinched else PLACES
    return [
        _recessed(ring, side, far, width, clear, pinched)
        for side, far in places
        if all(solid(*_outside(ring, side, ring.size - 1 - k if far else k)) for k in modules)
    ]


def paired_bars(ring: Ring, width: float, clear: float, solid: Solid) -> list[list[RingBar]]:
    """Where two bars behind the face may lie by both ends of one side, the best side first."""
    return [
        [_recessed(ring, side, far, width, clear, False) for far in (False, True)]
        for side, far in PLACES
        if not far and all(solid(*_outside(ring, side, k)) for k in range(1, ring.size - 1))
    ]


def opposite_bars(ring: Ring, wide: float, web: float, slot: float) -> list[RingBar]:
    """Bars behind the face on two sides of an upper finder ring, up to `wide` modules and no narrower than a
    web.

    slot   modules of void that a pinch leaves

    See `SHORT_PINCH` for why each lies where it does.
    """
    bar, right_bar = (min(wide, max(web, most)) for most in (WIDEST_OPEN, WIDEST_RIGHT))
    side: Side = "left" if ring.column == 0 else "top"
    two = [_recessed(ring, side, far, bar, CLEAR, False) for far in (False, True)]
    if ring.column == 0:
        return [*two, _dark(ring, "right", False, min(wide, max(web, WIDEST_PINCHED)), slot)]
    return [*two, _recessed(ring, "right", True, right_bar, CLEAR, False)]


def dark_pair(ring: Ring, wide: float, web: float, slot: float) -> list[RingBar]:
    """Two bars behind the face on the left side of a finder ring, which look as dark as that; see
    `opposite_bars`."""
    return [_dark(ring, "left", far, min(wide, max(web, WIDEST_PINCHED)), slot) for far in (False, True)]


def _dark(ring: Ring, side: Side, far: bool, width: float, slot: float) -> RingBar:
    """A bar in a pinch that keeps off the diagonal, from whose corner it is as far as its slot needs."""
    at, end = SHORT_PINCH, ring.size
    pinch = 1.0 - slot, OFF_MIDDLE
    if far:
        at, pinch = end - at, (end - pinch[1], end - pinch[0])
    return _bar(ring, side, at, _along(ring, side, *pinch), width)


def core_bar(ring: Ring, width: float) -> RingBar:
    """For dark material: a bar from the pattern's core, beside its middle, to the dark ring."""
    return _bar(ring.inset(1), "top", CORE_FLUSH - 1 + width / 2)


def recessed_core_bar(ring: Ring, width: float, clear: float) -> RingBar:
    """The same behind the face, in a pinched slot."""
    return _recessed(ring.inset(1), "left", False, width, clear, pinched=True)


def _bar(
    ring: Ring, side: Side, along: float, pinch: tuple[float, float] | None = None, width: float = 0.0
) -> RingBar:
    """A bar across one side, `along` it from its upper or left end."""
    top, left = float(ring.row), float(ring.column)
    outer, inner = (0.0, 1.0) if side in ("top", "left") else (float(ring.size), ring.size - 1.0)
    if side in ("top", "bottom"):
        return RingBar((left + along, top + outer), (left + along, top + inner), pinch, width)
    return RingBar((left + outer, top + along), (left + inner, top + along), pinch, width)


def _recessed(ring: Ring, side: Side, far: bool, width: float, clear: float, pinched: bool) -> RingBar:
    """A bar behind the face near an end of one side; pinched from that end to beyond the bar."""
    middle = FLUSH + clear + width / 2
    reach, end = max(PINCHED, middle + width / 2 + clear), ring.size
    pinch = _along(ring, side, *((end - reach, end) if far else (0, reach))) if pinched else None
    return _bar(ring, side, end - middle if far else middle, pinch, width)


def _along(ring: Ring, side: Side, start: float, end: float) -> tuple[float, float]:
    """A stretch of a side, from its upper or left end, in modules of the symbol."""
    first = ring.column if side in ("top", "bottom") else ring.row
    return first + start, first + end


def _outside(ring: Ring, side: Side, k: int) -> tuple[int, int]:
    """Row and column of the k-th module beside a ring."""
    beyond = -1 if side in ("top", "left") else ring.size
    row, column = (beyond, k) if side in ("top", "bottom") else (k, beyond)
    return ring.row + row, ring.column + column


def _side_bar(ring: Ring, width: float, solid: Solid) -> list[RingBar]:
    """One bar near a corner: the first, clockwise from the left end of the top, that leads to material."""
    low = FLUSH + width / 2
    for side, far in PLACES:
        if solid(*_outside(ring, side, ring.size - 2 if far else 1)):
            return [_bar(ring, side, ring.size - low if far else low)]
    return []


def _diagonal_bars(ring: Ring) -> list[RingBar]:
    """The paper's: a 45° bar through each corner of the dark ring."""
    low_x, low_y = float(ring.column), float(ring.row)
    high_x, high_y = low_x + ring.size, low_y + ring.size
    return [
        RingBar((low_x, low_y), (low_x + 1, low_y + 1)),
        RingBar((high_x, low_y), (high_x - 1, low_y + 1)),
        RingBar((low_x, high_y), (low_x + 1, high_y - 1)),
        RingBar((high_x, high_y), (high_x - 1, high_y - 1)),
    ]
