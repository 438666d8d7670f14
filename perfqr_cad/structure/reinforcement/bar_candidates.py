"""Where a structural bridge could go: straight bars across one hole, from light to light."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache, cached_property
from typing import TYPE_CHECKING

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry import Polygon

from perfqr_cad.pattern import Bridge
from perfqr_cad.structure.mesh.triangle import Floats, Ints
from perfqr_cad.symbol import Readability, ReadabilityTracker, layout
from perfqr_cad.symbol.layout import Role

if TYPE_CHECKING:
    from perfqr_cad.pattern import Pattern

ENTERED = 1e-3  # share of a module that a bar may overlap without entering it: rounding
STANDS_ON_WIDTHS = 0.45  # from the middle of a bar's end: its corners, half a width off, are of the part
CENTRE_SAMPLES = 5  # a side, over the centre third of a module: where decoders look (§4.2)
TURNED = 0.5  # share of a module's centre that a bar must fill to turn it
# Bars across their rings blind most decoders, whatever Eqs. (1)-(3) say of them (they count data only).
KEPT_CLEAR = (Role.FINDER, Role.SEPARATOR, Role.ALIGNMENT)
SPENT_SHARE = 0.5  # of what each block can still correct: a part must also read when it is dirty or lit badly


@dataclass(frozen=True)
class Candidates:
    """Bars by rows: `start`, `end` (k, 2) on the light boundary, `width_mm` (k,).

    `loss` (k,) is the rise of L(Q), `covered` (k,) how many module centres a bar fills, as a sum of shares,
    `turned` (k,) the modules that it turns, as tuples of (row, column).
    """

    start: Floats
    end: Floats
    width_mm: Floats
    loss: Floats
    covered: Floats
    turned: NDArray[np.object_]

    def __len__(self) -> int:
        return len(self.start)

    @cached_property
    def length_mm(self) -> Floats:
        """Lengths (k,)."""
        return np.linalg.norm(self.end - self.start, axis=1)

    def take(self, which: NDArray[np.int64] | NDArray[np.bool_]) -> Candidates:
        """The rows chosen."""
        return Candidates(
            self.start[which],
            self.end[which],
            self.width_mm[which],
            self.loss[which],
            self.covered[which],
            self.turned[which],
        )

    def in_the_way_of(self, row: int, gap_mm: float) -> NDArray[np.bool_]:
        """The bars (k,) that would leave less than a gap to one of them, or cross it; itself too."""
        clear = 0.5 * (self.width_mm + self.width_mm[row]) + gap_mm
        middle = 0.5 * (self.start + self.end)
        apart = np.linalg.norm(middle - middle[row], axis=1) - 0.5 * (self.length_mm + self.length_mm[row])
        near = np.flatnonzero(apart < clear)
        hit = np.zeros(len(self), np.bool_)
        hit[near] = shapely.distance(self._lines[near], self._lines[row]) < clear[near]
        return hit

    def cover(self, points: Floats) -> NDArray[np.bool_]:
        """Which points of the wall (r, 2) each bar stands on, (r, k)."""
        ends = np.stack([self.start, self.end])
        reach = np.linalg.norm(points[:, None, None] - ends, axis=3).min(axis=1)
        return np.asarray(reach < STANDS_ON_WIDTHS * self.width_mm)

    @cached_property
    def _lines(self) -> NDArray[np.object_]:
        return np.asarray(shapely.linestrings(np.stack([self.start, self.end], axis=1)))

    def bridge(self, row: int, cost: float) -> Bridge:
        """One row as a structural bridge."""
        (x0, y0), (x1, y1) = self.start[row].tolist(), self.end[row].tolist()
        return Bridge((x0, y0), (x1, y1), float(self.width_mm[row]), "structural", cost)


def holes_of(polygon: Polygon) -> NDArray[np.object_]:
    """The holes of a region as polygons."""
    return np.array([Polygon(ring) for ring in polygon.interiors], dtype=object)


@dataclass(frozen=True)
class Allowance:
    """How many codewords may be wrong in each block, and how many format regions, once bridges are added."""

    errors: tuple[int, ...]
    format_regions: int

    @staticmethod
    def of(pattern: Pattern) -> Allowance:
        """That of a pattern as it comes in: some of what it can still correct."""
        today = pattern.readability
        errors = tuple(
            errors + int(SPENT_SHARE * max(0, capacity - errors))
            for errors, capacity in zip(today.errors, today.capacity, strict=True)
        )
        return Allowance(errors, today.format_regions_damaged)

    def covers(self, readability: Readability) -> bool:
        """Whether a pattern that reads so well is within it."""
        return readability.format_regions_damaged <= self.format_regions and all(
            errors <= most for errors, most in zip(readability.errors, self.errors, strict=True)
        )


class Budget:
    """What is left of an allowance while modules turn. Mutable."""

    def __init__(self, pattern: Pattern, allowance: Allowance) -> None:
        self._allowance = allowance
        self._tracker = ReadabilityTracker(pattern.symbol, pattern.observed)

    def rise(self, modules: Iterable[tuple[int, int]]) -> float:
        """Rise of L(Q) if some modules turn; infinite beyond the allowance."""
        before = self._tracker.total
        self._turn(modules)
        rise = self._tracker.total - before if self._allowance.covers(self._tracker.readability()) else np.inf
        self._turn(modules)
        return rise

    def spend(self, modules: Iterable[tuple[int, int]]) -> bool:
        """Turn some modules for good, if that is within the allowance."""
        affordable = bool(np.isfinite(self.rise(modules)))
        if affordable:
            self._turn(modules)
        return affordable

    def _turn(self, modules: Iterable[tuple[int, int]]) -> None:
        for row, column in modules:
            self._tracker.flip(row, column)


def affordable(
    pattern: Pattern, allowance: Allowance, start: Floats, end: Floats, width: Floats
) -> Candidates:
    """The bars that are within the allowance and touch no finder or alignment ring, with their losses."""
    budget = Budget(pattern, allowance)
    open_tone = pattern.spec.tone != "inverted"  # of holes: dark, or light
    roles = layout(pattern.symbol.version, pattern.symbol.level).roles
    forbidden = np.isin(roles, KEPT_CLEAR) & (pattern.symbol.matrix.dark == open_tone)
    modules, inside = _windows(pattern, start, end, width)
    rows, columns = modules[..., 0], modules[..., 1]
    centres = _centres(pattern, modules)
    clear = ~_entered(centres, pattern.module_mm, (start, end, width), inside & forbidden[rows, columns])
    is_open = (pattern.observed.dark == open_tone)[rows, columns]
    share = _fills(centres, pattern.module_mm / 3, (start, end, width), inside & is_open & clear[:, None])
    turned = np.empty(len(start), object)
    for k in range(len(start)):
        turned[k] = ()
    turns = share >= TURNED
    for k in np.flatnonzero(turns.any(axis=1)):
        turned[k] = tuple(map(tuple, modules[k, turns[k]].tolist()))
    loss = np.where(clear, 0.0, np.inf)
    rise = cache(budget.rise)  # many bars turn the same modules
    for k in np.flatnonzero(turns.any(axis=1) & clear):
        loss[k] = rise(turned[k])
    kept = np.isfinite(loss)
    return Candidates(start, end, width, loss, share.sum(axis=1), turned).take(kept)


def _windows(pattern: Pattern, start: Floats, end: Floats, width: Floats) -> tuple[Ints, NDArray[np.bool_]]:
    """Modules (row, column) near k bars (k, w, 2), and which of them are in the symbol (k, w)."""
    n, m = pattern.symbol.size, pattern.module_mm
    low = (np.minimum(start, end) - width[:, None] / 2) / m + n / 2
    high = (np.maximum(start, end) + width[:, None] / 2) / m + n / 2
    first = np.floor(low).astype(np.int64)
    window = np.arange(int((np.floor(high) - first).max(initial=0)) + 1)
    x = first[:, 0, None, None] + window[None, None, :]
    y = first[:, 1, None, None] + window[None, :, None]
    modules = np.stack(np.broadcast_arrays(n - 1 - y, x), axis=-1).reshape(len(start), len(window) ** 2, 2)
    inside = ((modules >= 0) & (modules < n)).all(axis=2)
    return np.clip(modules, 0, n - 1), np.asarray(inside)


def _centres(pattern: Pattern, modules: Ints) -> Floats:
    n, m = pattern.symbol.size, pattern.module_mm
    x, y = modules[..., 1] + 0.5 - n / 2, n / 2 - modules[..., 0] - 0.5
    return np.multiply(m, np.stack([x, y], axis=-1))


def _entered(
    centres: Floats, edge: float, bars: tuple[Floats, Floats, Floats], asked: NDArray[np.bool_]
) -> NDArray[np.bool_]:
    """Which bars (k,) enter any of the modules about the centres (k, w, 2) that are asked about."""
    start, end, width = bars
    bar, which = np.nonzero(asked)
    x, y = centres[bar, which].T
    half = edge / 2
    modules = shapely.box(x - half, y - half, x + half, y + half)
    across = np.stack([start[:, 1] - end[:, 1], end[:, 0] - start[:, 0]], axis=1)
    across *= (width / 2 / np.linalg.norm(across, axis=1))[:, None]
    outlines = np.asarray(
        shapely.polygons(np.stack([start + across, start - across, end - across, end + across], axis=1))
    )
    entered = np.zeros(len(start), np.bool_)
    entered[bar[shapely.area(shapely.intersection(modules, outlines[bar])) > ENTERED * edge**2]] = True
    return entered


def _fills(
    centres: Floats, edge: float, bars: tuple[Floats, Floats, Floats], asked: NDArray[np.bool_]
) -> Floats:
    """The share of squares about the centres (k, w, 2) that each bar fills, where it is asked: (k, w)."""
    start, end, width = bars
    steps = ((np.arange(CENTRE_SAMPLES) + 0.5) / CENTRE_SAMPLES - 0.5) * edge
    grid = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
    bar, which = np.nonzero(asked)
    length = np.linalg.norm(end - start, axis=1)
    along = (end - start) / length[:, None]
    offset = (centres[bar, which] - start[bar])[:, None] + grid
    s = np.einsum("psc,pc->ps", offset, along[bar])
    t = np.einsum("psc,pc->ps", offset, np.stack([-along[:, 1], along[:, 0]], axis=1)[bar])
    within = (s >= 0) & (s <= length[bar, None]) & (np.abs(t) <= width[bar, None] / 2)
    share = np.zeros(asked.shape)
    share[bar, which] = within.mean(axis=1)
    return share
