"""Making one piece of many: routes between islands, cheapest first."""

from __future__ import annotations

import numpy as np

from perfqr_cad.pattern.draft import Draft, Rect
from perfqr_cad.pattern.lattice import label
from perfqr_cad.pattern.routing import Field, Route, brush_grid, routes
from perfqr_cad.pattern.sampling import NOISE_SIGMA, blur_weights, right_contrast
from perfqr_cad.symbol import Symbol

AREA_PRICE = 0.02  # expected misread modules that a module's area of change is worth: appearance comes last
STEPS_PER_MODULE = 4


def cell_price(draft: Draft, symbol: Symbol, solid_is_dark: bool) -> Field:
    """(cells, cells) price of making a cell solid: rise in the expected number of misread modules, and its area."""
    lattice = draft.lattice
    u, quiet, n = lattice.per_module, lattice.quiet, lattice.modules
    contrast = right_contrast(lattice, symbol, solid_is_dark) / NOISE_SIGMA
    slope = np.exp(-(contrast**2) / 2) / (NOISE_SIGMA * np.sqrt(2 * np.pi))
    harmful = symbol.matrix.dark != solid_is_dark
    weights = blur_weights(n + 2 * quiet, u)[quiet : quiet + n]
    rise = weights.T @ (slope * harmful) @ weights
    return rise + AREA_PRICE / u**2


def join(draft: Draft, symbol: Symbol, web_mm: float, solid_is_dark: bool) -> Draft:
    """All islands joined by the cheapest routes."""
    labels, count = label(draft.solid)
    if count <= 1:
        return draft
    lattice = draft.lattice
    price = cell_price(draft, symbol, solid_is_dark)
    brush = lattice.whole(web_mm)
    grid = brush_grid(draft.solid, labels, price, brush, lattice.per_module // STEPS_PER_MODULE)
    least = AREA_PRICE * brush * (lattice.per_module // STEPS_PER_MODULE) / lattice.per_module**2 * 1e-3
    chosen = spanning_tree(routes(grid, least))
    for route in chosen:
        draft = draft.with_bars(route_bars(route, brush), "connectivity", route.price)
    return draft


def route_bars(route: Route, brush: int) -> list[tuple[Rect, bool]]:
    """The straight bars that paint a route, each with whether it runs along x."""
    return [(Rect(*r), r[2] - r[0] > r[3] - r[1]) for r in route.rectangles(brush)]


def spanning_tree(links: list[Route]) -> list[Route]:
    """The links of a minimum spanning tree (Kruskal), cheapest first."""
    leader: dict[int, int] = {}

    def find(a: int) -> int:
        while leader.setdefault(a, a) != a:
            leader[a] = a = leader[leader[a]]
        return a

    chosen: list[Route] = []
    for link in sorted(links, key=lambda link: link.price):
        a, b = find(link.islands[0]), find(link.islands[1])
        if a != b:
            leader[a] = b
            chosen.append(link)
    return chosen
