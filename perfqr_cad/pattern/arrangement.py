"""Free bits spent on material: each module that can still have either colour takes the one that is expected
to need less joining, the most telling modules first.

This is the method of conditional expectations (Erdős and Selfridge 1973): modules that are still open count
as half solid. A round settles all free bits; the next one minds more what the last one left to be joined.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from perfqr_cad.pattern.cells.lattice import Cells, checkerboards, label
from perfqr_cad.symbol.drawing import Symbol
from perfqr_cad.symbol.freedom import Freedom, Wishes

LINK_AREA = 0.27  # modules of area that a link at a corner paints, by a web of two thirds of a module
ROUTE_AREA = 1.5  # the same for a route between islands
SOLID_BONUS = 0.02  # of a solid module over a hole, other things equal: stiffer, and one outline less
TOLD_APART = 0.3  # modules as telling as this share of the most telling one are settled at the same time
MINDED_MORE = 0.3  # a corner that was left to be linked counts for so much more in the next round
WANTED_MORE = 0.3  # the same, in modules of area, for a hole that would join pieces if it were solid
FORGOTTEN = 0.1  # share of what was minded that a round forgets
JITTER = 0.03  # modules of area; breaks ties otherwise in each round

Field = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Joining:
    """What is left to be joined in a symbol with its quiet zone, (N, N) modules.

    corners (k, 2)   x and y of lattice points where solid modules meet at a corner only
    pieces (N, N)    number of each module's piece once those are linked; 0 for holes
    count            pieces then
    area             modules of area that all of it would paint, estimated
    """

    corners: NDArray[np.int64]
    pieces: NDArray[np.int32]
    count: int
    area: float


def joining(symbol: Symbol, solid_is_dark: bool, quiet_modules: int) -> Joining:
    """What is left to be joined in a plain code; the quiet zone is solid where light is."""
    solid = np.pad(symbol.matrix.dark == solid_is_dark, quiet_modules, constant_values=not solid_is_dark)
    corners = checkerboards(solid)
    linked = solid.repeat(2, axis=0).repeat(2, axis=1)
    for x, y in corners.tolist():
        linked[2 * y - 1 : 2 * y + 1, 2 * x - 1 : 2 * x + 1] = True
    pieces, count = label(linked)
    area = LINK_AREA * len(corners) + ROUTE_AREA * (count - 1)
    return Joining(corners, np.where(solid, pieces[::2, ::2], 0), count, area)


def arranged(
    space: Freedom, solid_is_dark: bool, quiet_modules: int, rounds: int, seed: int
) -> tuple[Symbol, Joining]:
    """The symbol of a space that needs the least joining of those tried, and what is left to be joined."""
    random = np.random.default_rng(seed)
    opened = np.pad(space.is_open, quiet_modules)
    minded = np.ones((opened.shape[0] + 1,) * 2)  # by lattice point
    wanted = np.zeros(opened.shape)  # solid, in modules of area
    best: tuple[Symbol, Joining] | None = None
    for number in range(rounds):
        bias = wanted + SOLID_BONUS
        if number:
            bias = bias + JITTER * random.standard_normal(opened.shape)
        symbol = _settled(space, LINK_AREA * minded, bias, solid_is_dark)
        left = joining(symbol, solid_is_dark, quiet_modules)
        if best is None or left.area < best[1].area:
            best = symbol, left
        minded = 1 + (1 - FORGOTTEN) * (minded - 1)
        minded[left.corners[:, 1], left.corners[:, 0]] += MINDED_MORE
        wanted = (1 - FORGOTTEN) * wanted + WANTED_MORE * np.where(opened, _joined_by(left.pieces), 0)
    assert best is not None, "at least one round"
    return best


def _settled(space: Freedom, weight: Field, bias: Field, solid_is_dark: bool) -> Symbol:
    """All free bits spent, one group of modules after the other, far enough apart not to mind each other.

    weight (N + 1, N + 1)  modules of area that a link at each lattice point costs
    bias (N, N)            modules of area by which each module is better solid
    """
    wishes = Wishes(space)
    quiet = (bias.shape[0] - space.symbol.size) // 2
    opened = np.pad(space.is_open, quiet)
    solid = np.pad(space.symbol.matrix.dark == solid_is_dark, quiet, constant_values=not solid_is_dark)
    share = np.where(opened, 0.5, solid)  # the chance of being solid
    while wishes.left and opened.any():
        cost = _link_cost(share, weight) - bias
        telling = np.where(opened, np.abs(cost), -1.0)
        chosen = np.argwhere(_is_peak(telling) & (telling >= TOLD_APART * telling.max()) & opened)
        order = np.argsort(-telling[chosen[:, 0], chosen[:, 1]], kind="stable")
        for row, column in chosen[order].tolist():
            want_solid = bool(cost[row, column] < 0)
            granted = wishes.grant(row - quiet, column - quiet, dark=want_solid == solid_is_dark)
            share[row, column] = want_solid == granted
            opened[row, column] = False
    return wishes.symbol()


def _link_cost(share: Field, weight: Field) -> Field:
    """(N, N) how many more links are to be expected if a module is solid than if it is a hole, weighed."""
    around = np.pad(share, 1, mode="edge")
    count = share.shape[0]
    cost = np.zeros_like(share)
    for down in (0, 2):
        for right in (0, 2):
            opposite = around[down : down + count, right : right + count]
            beside = around[1:-1, right : right + count]
            below = around[down : down + count, 1:-1]
            more = opposite * (1 - beside) * (1 - below) - (1 - opposite) * beside * below
            cost += weight[down // 2 : down // 2 + count, right // 2 : right // 2 + count] * more
    return cost


def _is_peak(telling: Field) -> Cells:
    """Modules as telling as any of their eight neighbours."""
    import cv2

    highest: Any = cv2.dilate(telling, np.ones((3, 3), np.uint8))
    return telling >= highest


def _joined_by(pieces: NDArray[np.int32]) -> NDArray[np.int64]:
    """(N, N) of each hole how many pieces fewer there would be, at most 2, if it were solid."""
    around = np.pad(pieces, 1)
    count = pieces.shape[0]
    beside = np.stack(
        [around[down : down + count, right : right + count] for down in range(3) for right in range(3)]
    )
    beside.sort(axis=0)
    distinct = ((np.diff(beside, axis=0) != 0) & (beside[1:] > 0)).sum(axis=0) + (beside[0] > 0)
    return np.where(pieces == 0, np.clip(distinct - 1, 0, 2), 0)
