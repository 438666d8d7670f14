"""Making one piece of many: routes between islands, cheapest first."""

from __future__ import annotations

import numpy as np

from perfqr_cad.pattern.draft import Bar, Draft, Rect
from perfqr_cad.pattern.lattice import label
from perfqr_cad.pattern.routing import Field, Route, brush_grid, routes
from perfqr_cad.pattern.sampling import blur_weights, misread_chance, right_contrast, sample_weights
from perfqr_cad.symbol import Symbol

AREA_PRICE = 0.02  # expected misread modules that a module's area of change is worth: appearance comes last
BRIDGE_DOSE = (
    0.3  # brightness that a bridge along its edge adds to a module: the rise of its risk is taken over this
)
CENTRE_PRICE = 4.0  # expected misread modules for painting over the whole sampled centre of a module
STEPS_PER_MODULE = 4


def cell_price(draft: Draft, symbol: Symbol, solid_is_dark: bool) -> Field:
    """(cells, cells) price of making a cell solid: expected misread modules more, and its area."""
    lattice = draft.lattice
    u, quiet, n = lattice.per_module, lattice.quiet, lattice.modules
    contrast = right_contrast(lattice, symbol, solid_is_dark)
    harmful = symbol.matrix.dark != solid_is_dark
    rise = harmful * (misread_chance(contrast - BRIDGE_DOSE) - misread_chance(contrast)) / BRIDGE_DOSE
    weights = blur_weights(n + 2 * quiet, u)[quiet : quiet + n]
    price = weights.T @ rise @ weights + AREA_PRICE / u**2
    centre = np.kron(CENTRE_PRICE * harmful, np.outer(sample_weights(u), sample_weights(u)))
    edge = quiet * u
    price[edge : edge + n * u, edge : edge + n * u] += centre
    return price


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
    return draft.with_bars([bar for route in chosen for bar in route_bars(route, brush)], "connectivity")


def route_bars(route: Route, brush: int) -> list[Bar]:
    """The straight bars that paint a route."""
    return [Bar(Rect(*r), r[2] - r[0] > r[3] - r[1], route.price) for r in route.rectangles(brush)]


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
