"""The paper's own connectivity optimisation (§5.1, Eq. (4), Fig. 8): the baseline of every comparison.

Points p on the contour of each island look out in a fan of directions; what they see first, q, is a
candidate. From an island picked at random the piece grows: each time the cheapest of λ·L(Q) + ‖p − q‖² is
laid, and Q is sampled again. The paper names no unit of length; here it is the edge of the symbol, so that
both terms lie between 0 and 1 and λ = 1 weighs them alike.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from perfqr_cad.pattern.bridge import Bridge
from perfqr_cad.pattern.cells.brightness import sampled, solid_part
from perfqr_cad.pattern.cells.canvas import Canvas, paint_strip
from perfqr_cad.pattern.cells.corners import paint_band
from perfqr_cad.pattern.cells.lattice import Cells, Labels, label
from perfqr_cad.symbol import Matrix, ReadabilityTracker, Symbol

DIRECTIONS = 16  # of the fan that a contour point looks out in
SIGHT_MODULES = 12.0  # how far it looks
MOST_PER_PAIR = 24  # nearest candidates that are weighed for each two islands


@dataclass(frozen=True)
class SightLine:
    """Cells p and q of two islands that see each other; `gap` is what lies between, in cells."""

    islands: tuple[int, int]
    p: tuple[int, int]
    q: tuple[int, int]
    gap: float


def join_paper(
    canvas: Canvas, symbol: Symbol, web_mm: float, loss_weight: float, solid_is_dark: bool, seed: int
) -> tuple[Canvas, tuple[float, ...]]:
    """Islands merged by Eq. (4), and L(Q) after each connector; λ = 0 is the plain spanning tree."""
    labels, count = label(canvas.solid)
    work = _Work(canvas, symbol, web_mm, solid_is_dark)
    outlook: dict[int, list[SightLine]] = {}
    for sight in sights(labels, canvas.lattice.per_module):
        outlook.setdefault(sight.islands[0], []).append(sight)
    start = int(np.random.default_rng(seed).integers(1, count + 1))
    inside, losses = {start}, [work.loss]
    heap: list[tuple[float, int, int, SightLine]] = []
    order = 0

    def look_out(island: int) -> None:
        nonlocal order
        for sight in outlook.get(island, ()):
            if sight.islands[1] not in inside:
                order += 1
                heapq.heappush(heap, (work.squared_length(sight), order, -1, sight))

    look_out(start)
    while heap:
        _, tie, weighed_at, sight = heapq.heappop(heap)
        if sight.islands[1] in inside:
            continue
        if weighed_at != len(losses):  # Q has changed since: weigh again, lazily
            price = work.squared_length(sight) + (loss_weight * work.preview(sight) if loss_weight else 0.0)
            heapq.heappush(heap, (price, tie, len(losses), sight))
            continue
        work.lay(sight, loss_weight)
        losses.append(work.loss)
        inside.add(sight.islands[1])
        look_out(sight.islands[1])
    return work.canvas(), tuple(losses)


def sights(labels: Labels, per_module: int) -> Iterator[SightLine]:
    """What contour cells see first in each direction of the fan, the nearest few for each two islands."""
    solid = labels > 0
    inner = solid.copy()
    inner[1:-1, 1:-1] &= solid[:-2, 1:-1] & solid[2:, 1:-1] & solid[1:-1, :-2] & solid[1:-1, 2:]
    ys, xs = np.nonzero(solid & ~inner)
    kept = (xs % (per_module // 8) == 0) | (ys % (per_module // 8) == 0)
    ys, xs = ys[kept], xs[kept]
    seen = [_cast(labels, xs, ys, k * math.tau / DIRECTIONS, per_module) for k in range(DIRECTIONS)]
    own, other, x0, y0, x1, y1 = np.concatenate(seen, axis=1)
    gap = np.hypot(np.maximum(np.abs(x1 - x0) - 1, 0), np.maximum(np.abs(y1 - y0) - 1, 0))
    order = np.lexsort((gap, other, own))
    pair = own[order] * (int(labels.max()) + 1) + other[order]
    first = np.searchsorted(pair, pair)  # where the run of the same two islands begins
    rank = np.arange(len(order)) - first
    for k in order[rank < MOST_PER_PAIR].tolist():
        yield SightLine(
            (int(own[k]), int(other[k])), (int(x0[k]), int(y0[k])), (int(x1[k]), int(y1[k])), float(gap[k])
        )


def _cast(
    labels: Labels, xs: NDArray[np.int64], ys: NDArray[np.int64], angle: float, per_module: int
) -> NDArray[np.int64]:
    """(6, k) own island, island seen, and the x and y of both cells, along one direction."""
    longest = max(abs(math.cos(angle)), abs(math.sin(angle)))
    dx, dy = math.cos(angle) / longest, math.sin(angle) / longest
    own = labels[ys, xs].astype(np.int64)
    at = np.arange(len(xs))
    found: list[NDArray[np.int64]] = []
    for t in range(1, int(SIGHT_MODULES * per_module)):
        x, y = np.rint(xs[at] + t * dx).astype(np.int64), np.rint(ys[at] + t * dy).astype(np.int64)
        valid = (x >= 0) & (y >= 0) & (x < labels.shape[1]) & (y < labels.shape[0])
        at, x, y = at[valid], x[valid], y[valid]
        hit = labels[y, x]
        other = (hit > 0) & (hit != own[at])
        seen = at[other]
        columns = (own[seen], hit[other], xs[seen], ys[seen], x[other], y[other])
        found.append(np.stack([column.astype(np.int64) for column in columns]))
        at = at[hit == 0]
        if not len(at):
            break
    return np.concatenate(found, axis=1)


class _Work:
    """Cells and Q while connectors are laid one by one."""

    def __init__(self, canvas: Canvas, symbol: Symbol, web_mm: float, solid_is_dark: bool) -> None:
        self._draft, self._web_mm, self._solid_is_dark = canvas, web_mm, solid_is_dark
        self._solid, self._upright = canvas.solid.copy(), canvas.upright.copy()
        self._laid: list[Bridge] = []
        self._slanted: list[Bridge] = []
        observed = Matrix((solid_part(canvas.lattice) >= 0.5) == solid_is_dark)
        self._dark = observed.dark.copy()
        self._tracker = ReadabilityTracker(symbol, observed)

    @property
    def loss(self) -> float:
        return self._tracker.total

    def squared_length(self, sight: SightLine) -> float:
        """‖p − q‖², in edges of the symbol."""
        lattice = self._draft.lattice
        return (sight.gap / (lattice.per_module * lattice.modules)) ** 2

    def preview(self, sight: SightLine) -> float:
        """L(Q) if the connector were laid."""
        changed, _ = self._changed(sight, self._solid)
        return self._tracker.preview(changed)

    def lay(self, sight: SightLine, loss_weight: float) -> None:
        """Lays a connector and samples Q again."""
        changed, _ = self._changed(sight, self._solid)
        for row, column in changed:
            self._tracker.flip(row, column)
            self._dark[row, column] ^= True
        price = self.squared_length(sight) + (loss_weight * self.loss if loss_weight else 0.0)
        bridge = self._bridge(sight, price)
        self._laid.append(bridge)
        slanted = self._paint(sight, self._solid, (0, 0))
        if slanted:
            self._slanted.append(bridge)
        else:
            self._paint(sight, self._upright, (0, 0))

    def canvas(self) -> Canvas:
        """The canvas with all connectors laid so far."""
        return replace(
            self._draft,
            lattice=self._draft.lattice.with_solid(self._solid),
            upright=self._upright,
            bridges=(*self._draft.bridges, *self._laid),
            slanted=(*self._draft.slanted, *self._slanted),
        )

    def _changed(self, sight: SightLine, solid: Cells) -> tuple[list[tuple[int, int]], Cells]:
        """Modules that a connector flips."""
        lattice = self._draft.lattice
        u, quiet, n = lattice.per_module, lattice.quiet, lattice.modules
        reach = lattice.whole(self._web_mm) + 1
        (px, py), (qx, qy) = sight.p, sight.q
        c0, c1 = (min(px, qx) - reach) // u - quiet, (max(px, qx) + reach) // u - quiet + 1
        r0, r1 = (min(py, qy) - reach) // u - quiet, (max(py, qy) + reach) // u - quiet + 1
        c0, r0, c1, r1 = max(c0, 0), max(r0, 0), min(c1, n), min(r1, n)
        if c0 >= c1 or r0 >= r1:
            return [], solid
        left, top = (c0 + quiet) * u, (r0 + quiet) * u
        part = solid[top : (r1 + quiet) * u, left : (c1 + quiet) * u].copy()
        self._paint(sight, part, (left, top))
        dark = (sampled(part, u) >= 0.5) == self._solid_is_dark
        flips = np.argwhere(dark != self._dark[r0:r1, c0:c1]) + np.array([r0, c0])
        return [(int(r), int(c)) for r, c in flips], part

    def _paint(self, sight: SightLine, cells: Cells, origin: tuple[int, int]) -> bool:
        """Paints a connector on cells that start at the origin; True when it is slanted."""
        lattice = self._draft.lattice
        (px, py), (qx, qy) = sight.p, sight.q
        left, top = origin
        if sight.gap == 0 and px != qx and py != qy:
            leg = lattice.whole(self._web_mm / math.sqrt(2)) + 1
            falling = (qx > px) == (qy > py)
            paint_band(cells, max(px, qx) - left, max(py, qy) - top, leg, falling)
            return False
        width = lattice.whole(self._web_mm)
        half = -(-width // 2)
        if px == qx or py == qy:
            along_x = py == qy
            # A connector that meets an island half beside it is held by its length along it.
            x0, x1 = (min(px, qx) - width, max(px, qx) + width) if along_x else (px - half, px + half)
            y0, y1 = (py - half, py + half) if along_x else (min(py, qy) - width, max(py, qy) + width)
            cells[max(y0 - top, 0) : max(y1 - top, 0), max(x0 - left, 0) : max(x1 - left, 0)] = True
            return False
        corners = [lattice.from_mm(point) for point in self._bridge(sight, 0.0).overlapping().corners()]
        paint_strip(cells, [(x - left, y - top) for x, y in corners])
        return True

    def _bridge(self, sight: SightLine, price: float) -> Bridge:
        lattice = self._draft.lattice
        (px, py), (qx, qy) = sight.p, sight.q
        start, end = lattice.to_mm(px + 0.5, py + 0.5), lattice.to_mm(qx + 0.5, qy + 0.5)
        return Bridge(start, end, self._web_mm, "connectivity", price)
