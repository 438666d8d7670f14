"""Ruled walls: straight lines between a curve on one level and a curve on the next."""

from __future__ import annotations

import numpy as np

from perfqr_cad.geometry.arrays import Array, Indices
from perfqr_cad.geometry.segments import quarters
from perfqr_cad.solid.charts.chart import Images
from perfqr_cad.solid.tables.batches import Arcs, Curves, Lines, Splines, SplineSurfaces
from perfqr_cad.solid.tables.brep import Batch, CurveTable

# A rational quadratic span covers at most a quarter turn; its angle-to-parameter map is fitted by this many
# cubics, which leaves h⁴/384·|t⁗| < 1e-7 of a span.
PIECES = 24


def straight(rows: Indices, start: Array, end: Array) -> CurveTable:
    """Straight images between parameters (k, 2), or the same (2,) for all."""
    shape = len(rows), 2
    return (Batch[Curves](rows, Lines(np.broadcast_to(start, shape), np.broadcast_to(end, shape))),)


def box_images(rows: Indices, u: float = 1.0) -> Images:
    """The images of a ruled wall's edges on surfaces whose parameters run to (u, 1)."""
    foot, head, far_foot, far_head = (np.array(p) for p in ((0, 0.0), (0, 1.0), (u, 0), (u, 1)))
    return (
        straight(rows, head, far_head),
        straight(rows, foot, far_foot),
        straight(rows, head, foot),
        straight(rows, far_head, far_foot),
    )


def grid_images(rows: Indices, turn: Array, fall: Array) -> Images:
    """The images of a cylinder's or cone's edges: along it by some angles `turn` (k,) rad from 0, down its
    rulings by lengths `fall` (k,) mm from 0."""
    none = np.zeros(len(rows))
    begin, foot, end, far_foot = (
        np.column_stack(uv) for uv in ((none, none), (none, fall), (turn, none), (turn, fall))
    )
    return (
        straight(rows, begin, end),
        straight(rows, foot, far_foot),
        straight(rows, begin, foot),
        straight(rows, end, far_foot),
    )


def oblique(top: Arcs, bottom: Arcs, spans: int, rows: Indices) -> tuple[SplineSurfaces, Images]:
    """The ruled faces between circular arcs that are not concentric: oblique cones or cylinders, exact, of so
    many rational spans.

    Their long edges are the arcs themselves, whose images are fitted, since an angle is no rational function
    of the surface's parameter.
    """
    (upper, upper_weights), (lower, lower_weights) = _rational(top, spans), _rational(bottom, spans)
    knots = (0.0, *np.repeat(np.arange(spans + 1.0), 2).tolist(), float(spans))
    plain = SplineSurfaces.ruled(upper, lower, knots, 2)
    weights = np.stack([lower_weights, upper_weights], axis=2)
    surfaces = SplineSurfaces(plain.poles, knots, plain.v_knots, plain.degrees, weights)
    over, under = (
        (Batch[Curves](rows, _turning(arcs.sweep, spans, v)),) for arcs, v in ((top, 1.0), (bottom, 0.0))
    )
    return surfaces, (over, under, *box_images(rows, float(spans))[2:])


def spans_of(top: Arcs, bottom: Arcs) -> Indices:
    """In how many rational spans the wall between two arcs is made, (k,)."""
    return quarters(np.maximum(top.sweep, bottom.sweep))


def _rational(arcs: Arcs, spans: int) -> tuple[Array, Array]:
    """Poles (k, 2·spans + 1, 3) and weights (k, 2·spans + 1) of arcs as rational quadratics."""
    half = arcs.sweep[:, None] / spans / 2
    step = np.arange(2 * spans + 1)
    weights = np.where(step % 2, np.cos(half), 1.0)
    reach = arcs.radius[:, None] / weights
    across, along = reach * np.cos(half * step), reach * np.sin(half * step)
    poles = arcs.centre[:, None] + across[..., None] * arcs.x[:, None] + along[..., None] * arcs.y[:, None]
    return poles, weights


def _turning(sweep: Array, spans: int, v: float) -> Splines:
    """The parameter of rational arcs over their angle, as cubic Hermite pieces at constant v.

    Within a span of half-angle a, t = ½(1 + tan(φ/2)/tan(a/2)) for φ from −a to a.
    """
    half = sweep[:, None] / spans / 2
    phi, step = half * np.linspace(-1.0, 1.0, PIECES + 1), 2 * half / PIECES
    value = (1 + np.tan(phi / 2) / np.tan(half / 2)) / 2
    slope = 1 / (4 * np.cos(phi / 2) ** 2 * np.tan(half / 2))
    # A C¹ cubic spline with double knots has the inner Bézier points of its pieces as poles.
    rise = slope * step / 3
    inner = np.stack([(value + rise)[:, :-1], (value - rise)[:, 1:]], axis=2).reshape(len(sweep), -1)
    zero = np.zeros((len(sweep), 1))
    u = np.concatenate([zero, *(span + inner for span in range(spans)), zero + spans], axis=1)
    breaks = np.linspace(0.0, 1.0, spans * PIECES + 1)
    knots = (0.0, 0.0, *np.repeat(breaks, 2).tolist(), 1.0, 1.0)
    return Splines(np.stack([u, np.full_like(u, v)], axis=2), knots, 3)
