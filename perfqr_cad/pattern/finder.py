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
# zxing-cpp walks along the inner edge of one dark ring only, and only in small codes, to find the corners of
# the code (FitSquareToPoints on the bottom left finder). A flush bar elsewhere costs nothing up to 30° of
# tilt, and a recessed bar costs reads at 30 to 40°, so no ring gets one that needs none. Its slot is narrowed
# from the outside, over a module beyond the bar (0.8 to 1.3 do alike), and the inner edge left straight.
TRACED_VERSIONS = 6
RECESSED_MIDDLE = 2.0  # modules from the ring's corner to the middle of a recessed bar (1.5 to 2 do alike)
PINCH_REACH = 1.0  # modules by which the pinch of a slot outreaches its recessed bar
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

    pinch  x or y, from and to, between which the slot of a recessed bar is narrowed; None: the bar is flush
    """

    start: tuple[float, float]
    end: tuple[float, float]
    pinch: tuple[float, float] | None = None


def rings(version: int) -> list[Ring]:
    """The three finders and all alignment patterns of a version."""
    last = 17 + 4 * version - 7
    taken = {(6, 6), (6, last), (last, 6)}
    centres = alignment_centres(version)
    finders = [Ring(0, 0, 7), Ring(0, last, 7), Ring(last, 0, 7)]
    return finders + [Ring(r - 2, c - 2, 5) for r in centres for c in centres if (r, c) not in taken]


def is_traced(ring: Ring, version: int) -> bool:
    """Whether a reader needs to find this ring unbroken: a recessed bar must hold it."""
    return version <= TRACED_VERSIONS and ring == Ring(17 + 4 * version - 7, 0, 7)


def ring_bars(ring: Ring, strategy: FinderStrategy, width: float, solid: Solid) -> list[RingBar]:
    """Bars `width` modules wide across the dark ring of a finder or alignment pattern.

    solid tells of a module (row, column), which may lie in the quiet zone, whether it is material. An
    alignment pattern without material near any corner gets no bar: a route of its own does less harm.
    """
    return _BARS[strategy](ring, width, solid)


def core_bar(ring: Ring, strategy: FinderStrategy, width: float) -> RingBar:
    """For dark material: a bar from the pattern's core, beside its middle, to the dark ring."""
    light = ring.inset(1)
    if strategy == "recessed":
        return _slot(light, "left", False, width)
    return _bar(light, "top", CORE_FLUSH - 1 + width / 2)


def _bar(ring: Ring, side: Side, along: float, pinch: tuple[float, float] | None = None) -> RingBar:
    """A bar across one side, `along` it from its upper or left end."""
    top, left = float(ring.row), float(ring.column)
    outer, inner = (0.0, 1.0) if side in ("top", "left") else (float(ring.size), ring.size - 1.0)
    if side in ("top", "bottom"):
        return RingBar((left + along, top + outer), (left + along, top + inner), pinch)
    return RingBar((left + outer, top + along), (left + inner, top + along), pinch)


def _slot(ring: Ring, side: Side, far: bool, width: float) -> RingBar:
    """A recessed bar near an end of one side, in a pinch from that end to a module beyond the bar."""
    origin, high = (
        ring.column if side in ("top", "bottom") else ring.row,
        RECESSED_MIDDLE + width / 2 + PINCH_REACH,
    )
    if far:
        return _bar(ring, side, ring.size - RECESSED_MIDDLE, (origin + ring.size - high, origin + ring.size))
    return _bar(ring, side, RECESSED_MIDDLE, (origin, origin + high))


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


def _recessed_bar(ring: Ring, width: float, solid: Solid) -> list[RingBar]:
    """One bar near a corner, where material lies along the whole pinch."""
    length = math.ceil(RECESSED_MIDDLE + width / 2 + PINCH_REACH)
    for side, far in sorted(PLACES, key=lambda place: place[0] != "left"):
        modules = [ring.size - 1 - k if far else k for k in range(length)]
        if all(solid(*_outside(ring, side, k)) for k in modules):
            return [_slot(ring, side, far, width)]
    return []


def _diagonal_bars(ring: Ring, width: float, solid: Solid) -> list[RingBar]:
    """The paper's: a 45° bar through each corner of the dark ring."""
    low_x, low_y = float(ring.column), float(ring.row)
    high_x, high_y = low_x + ring.size, low_y + ring.size
    return [
        RingBar((low_x, low_y), (low_x + 1, low_y + 1)),
        RingBar((high_x, low_y), (high_x - 1, low_y + 1)),
        RingBar((low_x, high_y), (low_x + 1, high_y - 1)),
        RingBar((high_x, high_y), (high_x - 1, high_y - 1)),
    ]


_BARS: dict[FinderStrategy, Callable[[Ring, float, Solid], list[RingBar]]] = {
    "panel": _side_bar,
    "recessed": _recessed_bar,
    "diagonal": _diagonal_bars,
}
