"""Bars that tie the floating rings of finder and alignment patterns to their surroundings (Fig. 7)."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from perfqr_cad.pattern.spec import FinderStrategy
from perfqr_cad.symbol.tables import alignment_centres

Solid = Callable[[int, int], bool]

# Why the bar lies where it does: in views of three versions at 4 and 8 pixels a module, tilted by 0, 20 and
# 40°, its place along the top or left side changes nothing for zbar and WeChat, for zxing-cpp no more than
# chance (39-56 % read at 20°, against 100 % without a bar); across the bottom it costs OpenCV a third. A bar
# in the middle of a side breaks the 1:1:3:1:1 line for all. So: by the corner, flush with the light ring,
# which leaves no notch; and no wider than the web: a wide bar costs zxing-cpp more than a narrow one.
FLUSH = 1.0  # modules from the pattern's corner to the near edge of the bar
CORE_FLUSH = 2.0  # the same for a bar from the core


@dataclass(frozen=True, slots=True)
class Ring:
    """A function pattern of `size` modules whose top left module is (row, column)."""

    row: int
    column: int
    size: int


@dataclass(frozen=True, slots=True)
class RingBar:
    """A bar's centre line in modules of the symbol (x right, y down from its top left), tips included."""

    start: tuple[float, float]
    end: tuple[float, float]


def rings(version: int) -> list[Ring]:
    """The three finders and all alignment patterns of a version."""
    last = 17 + 4 * version - 7
    taken = {(6, 6), (6, last), (last, 6)}
    centres = alignment_centres(version)
    finders = [Ring(0, 0, 7), Ring(0, last, 7), Ring(last, 0, 7)]
    return finders + [Ring(r - 2, c - 2, 5) for r in centres for c in centres if (r, c) not in taken]


def bars(version: int, strategy: FinderStrategy, width: float, solid: Solid) -> list[RingBar]:
    """Bars `width` modules wide across the dark ring of every finder and alignment pattern.

    solid tells of a module (row, column), which may lie in the quiet zone, whether it is material. An
    alignment pattern without material near any corner gets no bar: a route of its own does less harm.
    """
    return [bar for ring in rings(version) for bar in _BARS[strategy](ring, width, solid)]


def core_bars(version: int, width: float) -> list[RingBar]:
    """For dark material: a bar from the top of each pattern's core, beside its middle, to the dark ring."""
    return [
        RingBar((x, float(ring.row + 1)), (x, float(ring.row + 2)))
        for ring in rings(version)
        for x in (ring.column + CORE_FLUSH + width / 2,)
    ]


def _side_bar(ring: Ring, width: float, solid: Solid) -> list[RingBar]:
    """One bar near a corner: the first, clockwise from the left end of the top, that leads to material."""
    low = FLUSH + width / 2
    high = ring.size - low
    top, left, size = float(ring.row), float(ring.column), ring.size
    choices = [
        (RingBar((left + low, top), (left + low, top + 1)), (-1, low)),
        (RingBar((left, top + low), (left + 1, top + low)), (low, -1)),
        (RingBar((left + high, top), (left + high, top + 1)), (-1, high)),
        (RingBar((left, top + high), (left + 1, top + high)), (high, -1)),
        (RingBar((left + size - 1, top + low), (left + size, top + low)), (low, size)),
        (RingBar((left + low, top + size - 1), (left + low, top + size)), (size, low)),
        (RingBar((left + size - 1, top + high), (left + size, top + high)), (high, size)),
        (RingBar((left + high, top + size - 1), (left + high, top + size)), (size, high)),
    ]
    for bar, (row, column) in choices:
        if solid(ring.row + math.floor(row), ring.column + math.floor(column)):
            return [bar]
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
    "recessed": _side_bar,
    "diagonal": _diagonal_bars,
}
