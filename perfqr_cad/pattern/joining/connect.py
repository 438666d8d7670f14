"""One piece of many, losing as little as can be: codewords first, then decoding margin, then area."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from perfqr_cad.pattern.cells.brightness import (
    blur_weights,
    module_misread_chance,
    right_contrast,
    sample_weights,
    sampled,
    sampled_part,
    solid_part,
)
from perfqr_cad.pattern.cells.canvas import Bar, Canvas, Rect
from perfqr_cad.pattern.cells.lattice import Cells, Labels, label
from perfqr_cad.pattern.joining.brush import Field, brush_grid, brush_positions, held_positions
from perfqr_cad.pattern.joining.junctions import cheapest_without_loss
from perfqr_cad.pattern.joining.routing import Route, Router
from perfqr_cad.pattern.joining.spanning import Conflict, Link, Optimality, cheapest, kruskal
from perfqr_cad.symbol import Role, Symbol, layout

AREA_PRICE = 0.06  # expected misread modules that a module's area of change is worth: appearance comes last
BRIDGE_DOSE = 0.3  # brightness that a bridge along its edge adds to a module: risk is measured over this rise
CENTRE_PRICE = 4.0  # expected misread modules for painting over the whole sampled centre of a module
FINDER_PRICE = 8.0  # expected misread modules for painting over a module that a reader finds the code by
QUIET_PRICE = 8.0  # expected misread modules for a module's area of material in a void quiet zone
BAR_PRICE = 0.005  # expected misread modules that one bar less is worth: a twelfth of a module's area
LENGTH_PRICE = 1e-3  # of the area price: of two routes that cost the same, the shorter
LEAST_STEPS, MOST_STEPS = 4, 16  # of the brush along a module
CONFLICT_ROUNDS = 6  # of the solver that share the limit of nodes
MOST_CONFLICTS = 200  # then what was found is taken
STAR_QUANTILE = 0.5  # of the tree's prices: no arm of a junction is dearer


def join(
    canvas: Canvas,
    symbol: Symbol,
    scale: int,
    web_mm: float,
    solid_is_dark: bool,
    most_nodes: int,
    pieces: Labels | None = None,
) -> tuple[Canvas, Optimality | None]:
    """All islands joined at the least cost over the candidate routes, and the proof.

    pieces  numbers the cells of what is to be joined, where it is not simply the solid cells that share edges
    """
    labels = label(canvas.solid)[0] if pieces is None else pieces
    count = int(labels.max())
    if count <= 1:
        return canvas, Optimality(0.0, 0.0, 0.0)
    lattice = canvas.lattice
    brush, step = lattice.whole(web_mm), brush_step(lattice.per_module, scale)
    canvas, labels, held = widened_to_grid(canvas, labels, count, brush, step)
    grid = brush_grid(labels, held, cell_price(canvas, symbol, solid_is_dark), brush, step)
    router = Router(grid, LENGTH_PRICE * AREA_PRICE * brush * step / lattice.per_module**2, BAR_PRICE)
    pairs = router.pairs()
    prices = [pairs[k].price for k in kruskal([Link(route.islands, route.price) for route in pairs])]
    stars = router.stars(pairs, float(np.quantile(prices, STAR_QUANTILE)))
    links = [Link(route.islands, route.price) for route in pairs + stars]
    chosen, optimality = cheapest_without_loss(links[: len(pairs)], links[len(pairs) :])
    routes = [(pairs + stars)[k] for k in chosen]
    routes = [router.with_arms(route) if len(route.islands) > 2 else route for route in routes]
    painted = _painted(canvas, routes, brush)
    damage = Damage.of(canvas, symbol, solid_is_dark)
    if damage.joint(painted, routes, chosen, links, brush):
        routes, optimality = _least_loss(canvas, damage, pairs + routes, brush, most_nodes)
        painted = _painted(canvas, routes, brush)
    return painted, optimality


def _painted(canvas: Canvas, routes: Sequence[Route], brush: int) -> Canvas:
    return canvas.with_bars([route_bars(route, brush) for route in routes], "connectivity")


def _least_loss(
    canvas: Canvas, damage: Damage, candidates: Sequence[Route], brush: int, most_nodes: int
) -> tuple[list[Route], Optimality]:
    """The routes that lose the fewest codewords, where every choice by price alone loses some."""
    links = [Link(r.islands, r.price, damage.codewords(r.rectangles(brush))) for r in candidates]
    conflicts: list[Conflict] = []
    while True:
        chosen, optimality = cheapest(links, conflicts, most_nodes // CONFLICT_ROUNDS)
        routes = [candidates[k] for k in chosen]
        more = damage.joint(_painted(canvas, routes, brush), routes, chosen, links, brush)
        conflicts += more
        if not more or len(conflicts) > MOST_CONFLICTS:
            return routes, optimality


def brush_step(per_module: int, scale: int) -> int:
    """Cells between brush positions: half a dot of the art, so that every dot has one at its middle.

    Of finer art so many halves as make the least step, of coarser art the greatest step.
    """
    half = per_module // (2 * scale)
    return min(half * math.ceil(per_module / MOST_STEPS / half), per_module // LEAST_STEPS)


def widened_to_grid(
    canvas: Canvas, labels: Labels, count: int, brush: int, step: int
) -> tuple[Canvas, Labels, Cells]:
    """The islands on which the brush has no position on its grid widened, so that it has.

    Returns the positions, too, on which the brush is held.
    """
    at = brush_positions(len(canvas.solid), brush, step)
    held = held_positions(canvas.solid, brush, step)
    middle = np.ix_(at + brush // 2, at + brush // 2)
    reached = np.zeros(count + 1, np.bool_)
    reached[0] = True
    reached[labels[middle][held]] = True
    if reached.all():
        return canvas, labels, held
    import cv2

    depth = cv2.distanceTransform(canvas.solid.astype(np.uint8), cv2.DIST_L2, 5)
    ys, xs = np.nonzero(~reached[labels])
    order = np.lexsort((-depth[ys, xs], labels[ys, xs]))
    first = order[np.unique(labels[ys, xs][order], return_index=True)[1]]
    widened, labels = np.zeros_like(canvas.solid), labels.copy()
    for y, x in zip(ys[first].tolist(), xs[first].tolist(), strict=True):
        # The brush where the island is deepest, and at the nearest position: a web all the way.
        (left, right), (top, bottom) = (
            (min(k - brush // 2, near), max(k - brush // 2, near) + brush)
            for k in (x, y)
            for near in (int(at[np.abs(at + brush // 2 - k).argmin()]),)
        )
        square = np.s_[max(top, 0) : bottom, max(left, 0) : right]
        widened[square] = True
        labels[square] = labels[y, x]
    canvas = canvas.with_cells(widened, solid=True).counted(webs_grown=len(first))
    return canvas, labels, held_positions(canvas.solid, brush, step)


def cell_price(canvas: Canvas, symbol: Symbol, solid_is_dark: bool) -> Field:
    """(cells, cells) price of making a void cell solid: expected misread modules more, and its area."""
    lattice = canvas.lattice
    u, quiet, n = lattice.per_module, lattice.quiet, lattice.modules
    contrast = right_contrast(lattice, symbol, solid_is_dark)
    harmful = symbol.matrix.dark != solid_is_dark
    before, after = module_misread_chance(contrast), module_misread_chance(contrast - BRIDGE_DOSE)
    rise = harmful * (after - before) / BRIDGE_DOSE
    weights = blur_weights(n, quiet, u).T.tocsr()
    price = weights @ (weights @ rise.T).T
    by_module = price.reshape(n + 2 * quiet, u, n + 2 * quiet, u)
    finder = layout(symbol.version, symbol.level).roles == Role.FINDER
    flat = AREA_PRICE + np.pad(FINDER_PRICE * finder, quiet, constant_values=QUIET_PRICE)
    by_module += flat[:, None, :, None] / u**2
    part, centre = sampled_part(u), sample_weights(u)
    inner = by_module[quiet : quiet + n, part, quiet : quiet + n, part]
    inner += np.einsum("rc,y,x->rycx", CENTRE_PRICE * harmful, centre[part], centre[part])
    price *= ~canvas.solid
    return price


def route_bars(route: Route, brush: int) -> list[Bar]:
    """The straight bars that paint a route."""
    return [Bar(Rect(*r), r[2] - r[0] > r[3] - r[1], route.price) for r in route.rectangles(brush)]


@dataclass(frozen=True, eq=False)
class Damage:
    """Which codewords painted cells turn wrong.

    wrong  (n, n) modules that are read wrong before any route is painted
    """

    canvas: Canvas
    codeword_of: np.ndarray
    solid_is_right: Cells
    wrong: Cells

    @staticmethod
    def of(canvas: Canvas, symbol: Symbol, solid_is_dark: bool) -> Damage:
        right = symbol.matrix.dark == solid_is_dark
        wrong = (solid_part(canvas.lattice) >= 0.5) != right
        return Damage(canvas, _protected_groups(symbol), right, wrong)

    def codewords(self, rectangles: Sequence[tuple[int, int, int, int]]) -> frozenset[int]:
        """Codewords that are right before and wrong after these cells are painted."""
        return self._lost(self._flipped(self.canvas.solid, rectangles))

    def joint(
        self,
        painted: Canvas,
        routes: Sequence[Route],
        chosen: Sequence[int],
        links: Sequence[Link],
        brush: int,
    ) -> list[Conflict]:
        """Losses of a whole choice that no single route accounts for, each with the routes that share it."""
        wrong = ((solid_part(painted.lattice) >= 0.5) != self.solid_is_right) & ~self.wrong
        known = set[int]().union(*(links[k].codewords for k in chosen))
        found: list[Conflict] = []
        for row, column in np.argwhere(wrong & (self.codeword_of >= 0)).tolist():
            lost = self._lost(np.array([[row, column]]))
            if lost and not lost <= known:
                guilty = [
                    k
                    for k, route in zip(chosen, routes, strict=True)
                    if any(self._covers(rect, row, column) for rect in route.rectangles(brush))
                ]
                if guilty:
                    found.append(Conflict(tuple(guilty), lost))
        return found

    def _flipped(self, solid: Cells, rectangles: Sequence[tuple[int, int, int, int]]) -> np.ndarray:
        """(k, 2) row and column of modules that the painted cells turn wrong."""
        lattice = self.canvas.lattice
        u, quiet, n = lattice.per_module, lattice.quiet, lattice.modules
        x0, y0 = (max(0, min(r[k] for r in rectangles) // u - quiet) for k in (0, 1))
        x1, y1 = (min(n, -(-max(r[k] for r in rectangles) // u) - quiet) for k in (2, 3))
        if x1 <= x0 or y1 <= y0:
            return np.empty((0, 2), np.int64)
        left, top = (x0 + quiet) * u, (y0 + quiet) * u
        part = solid[top : (y1 + quiet) * u, left : (x1 + quiet) * u].copy()
        for a, b, c, d in rectangles:
            part[max(b - top, 0) : max(d - top, 0), max(a - left, 0) : max(c - left, 0)] = True
        here = np.s_[y0:y1, x0:x1]
        wrong = ((sampled(part, u) >= 0.5) != self.solid_is_right[here]) & ~self.wrong[here]
        return np.argwhere(wrong) + np.array([y0, x0])

    def _lost(self, modules: np.ndarray) -> frozenset[int]:
        groups = self.codeword_of[modules[:, 0], modules[:, 1]]
        already = np.unique(self.codeword_of[self.wrong])
        return frozenset(np.setdiff1d(groups[groups >= 0], already).tolist())

    def _covers(self, rect: tuple[int, int, int, int], row: int, column: int) -> bool:
        u, quiet = self.canvas.lattice.per_module, self.canvas.lattice.quiet
        left, top = (column + quiet) * u, (row + quiet) * u
        return rect[0] < left + u and rect[2] > left and rect[1] < top + u and rect[3] > top


def _protected_groups(symbol: Symbol) -> np.ndarray:
    """(n, n) what a wrong module damages: its codeword or, numbered after them, format region; −1 none."""
    plan = layout(symbol.version, symbol.level)
    return np.where(plan.format_region >= 0, plan.blocks.codewords + plan.format_region, plan.codeword_of)
