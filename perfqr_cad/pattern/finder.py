"""Bars that tie the floating rings of finder and alignment patterns to their surroundings (Fig. 7)."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from perfqr_cad.pattern.spec import FinderStrategy
from perfqr_cad.symbol.tables import alignment_centres

Solid = Callable[[int, int], bool]

# Distance of the bar's middle from the pattern's corner, in modules: over the corner of the light ring, where
# a scan line through the middle of the pattern does not meet it.
BAR_OFFSET = 1.5
# The same for a bar from the core: over the core's left module.
CORE_BAR_OFFSET = 2.5


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


def bars(version: int, strategy: FinderStrategy, solid: Solid) -> list[RingBar]:
    """Bars across the dark ring of every finder and alignment pattern.

    solid tells of a module (row, column), which may lie in the quiet zone, whether it is material. An
    alignment pattern without material near any corner gets no bar: a route of its own does less harm.
    """
    return [bar for ring in rings(version) for bar in _BARS[strategy](ring, solid)]


def core_bars(version: int) -> list[RingBar]:
    """For dark material: a bar from the top of each pattern's core, beside its middle, to the dark ring."""
    return [
        RingBar((x, float(ring.row + 1)), (x, float(ring.row + 2)))
        for ring in rings(version)
        for x in (ring.column + CORE_BAR_OFFSET,)
    ]


def _side_bar(ring: Ring, solid: Solid) -> list[RingBar]:
    """One bar near a corner: the first, clockwise from the left end of the top, that leads to material."""
    low, high = BAR_OFFSET, ring.size - BAR_OFFSET
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


def _diagonal_bars(ring: Ring, solid: Solid) -> list[RingBar]:
    """The paper's: a 45° bar through each corner of the dark ring."""
    low_x, low_y = float(ring.column), float(ring.row)
    high_x, high_y = low_x + ring.size, low_y + ring.size
    return [
        RingBar((low_x, low_y), (low_x + 1, low_y + 1)),
        RingBar((high_x, low_y), (high_x - 1, low_y + 1)),
        RingBar((low_x, high_y), (low_x + 1, high_y - 1)),
        RingBar((high_x, high_y), (high_x - 1, high_y - 1)),
    ]


_BARS: dict[FinderStrategy, Callable[[Ring, Solid], list[RingBar]]] = {
    "panel": _side_bar,
    "recessed": _side_bar,
    "diagonal": _diagonal_bars,
}
