# pyright: reportAttributeAccessIssue=false
# The modeller's stubs are incomplete.
"""Ruled walls: straight lines between a curve on one level and a curve on the next."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from OCP.Geom import Geom_Circle
from OCP.Geom2d import Geom2d_BSplineCurve

from .chart import Trace, Wall
from .occ import Array, line_2d, spline_curve_2d, spline_surface
from .sampling import quarters

RULING_KNOTS = (0.0, 0.0, 1.0, 1.0)
# A rational quadratic span covers at most a quarter turn; its angle-to-parameter map is fitted by this many
# cubics, which leaves h⁴/384·|t⁗| < 1e-7 of a span.
PIECES = 24


def ruled_wall(upper: Array, lower: Array, knots: Sequence[float], degree: int) -> Wall:
    """The ruled face between two splines of the same degree and knots, by their (k, 3) poles; exact on both.

    The surface's second parameter runs from the lower curve (0) to the upper (1), so that its own normal
    points to the right of travel.
    """
    surface = spline_surface(np.stack([lower, upper], axis=1), knots, RULING_KNOTS, (degree, 1))
    images = (
        line_2d(0, 1, 1, 0),
        line_2d(0, 0, 1, 0),
        falling(knots[0], math.dist(upper[0], lower[0])),
        falling(knots[-1], math.dist(upper[-1], lower[-1])),
    )
    return Wall(surface, outward=True, images=images)


def oblique_wall(top: Trace, bottom: Trace) -> Wall:
    """The ruled face between two circular arcs that are not concentric: an oblique cone or cylinder, exact.

    Its long edges are the arcs themselves; their images are fitted, since an angle is no rational function of
    the surface's parameter.
    """
    spans = quarters(max(top.last, bottom.last))
    (upper, upper_weights), (lower, lower_weights) = _rational(top, spans), _rational(bottom, spans)
    knots = [0.0, *np.repeat(np.arange(spans + 1.0), 2), float(spans)]
    surface = spline_surface(
        np.stack([lower, upper], axis=1),
        knots,
        RULING_KNOTS,
        (2, 1),
        np.stack([lower_weights, upper_weights], axis=1),
    )
    images = (
        _turning(top.last, spans, 1.0),
        _turning(bottom.last, spans, 0.0),
        falling(0.0, math.dist(upper[0], lower[0])),
        falling(float(spans), math.dist(upper[-1], lower[-1])),
    )
    return Wall(surface, outward=True, images=images)


def falling(u: float, length: float) -> Geom2d_BSplineCurve:
    """Image of a side edge, by its arc length, on a ruled surface: from the upper curve to the lower."""
    return spline_curve_2d(np.array([[u, 1.0], [u, 0.0]]), (0.0, 0.0, length, length), 1)


def _rational(arc: Trace, spans: int) -> tuple[Array, Array]:
    """Poles (2·spans + 1, 3) and weights of an arc as rational quadratics of equal sweep."""
    circle = arc.curve
    assert isinstance(circle, Geom_Circle)
    centre, frame = circle.Location(), circle.Position()
    x, y = frame.XDirection(), frame.YDirection()
    half = arc.last / spans / 2
    weights = np.tile([1.0, math.cos(half)], spans + 1)[:-1]
    angle = half * np.arange(2 * spans + 1)
    reach = circle.Radius() / weights
    across, along = reach * np.cos(angle), reach * np.sin(angle)
    axes = np.array([[x.X(), x.Y(), x.Z()], [y.X(), y.Y(), y.Z()]])
    poles = np.array([centre.X(), centre.Y(), centre.Z()]) + np.column_stack([across, along]) @ axes
    return poles, weights


def _turning(sweep: float, spans: int, v: float) -> Geom2d_BSplineCurve:
    """The parameter of a rational arc over its angle, as cubic Hermite pieces at constant v.

    Within a span of half-angle a, t = ½(1 + tan(φ/2)/tan(a/2)) for φ from −a to a.
    """
    half = sweep / spans / 2
    phi = np.linspace(-half, half, PIECES + 1)
    step = 2 * half / PIECES
    value = (1 + np.tan(phi / 2) / math.tan(half / 2)) / 2
    slope = 1 / (4 * np.cos(phi / 2) ** 2 * math.tan(half / 2))
    # A C¹ cubic spline with double knots has the inner Bézier points of its pieces as poles.
    inner = np.column_stack([value[:-1] + slope[:-1] * step / 3, value[1:] - slope[1:] * step / 3])
    u = np.concatenate([[0.0], *(span + inner.ravel() for span in range(spans)), [float(spans)]])
    breaks = np.linspace(0, sweep, spans * PIECES + 1)
    knots = [breaks[0], breaks[0], *np.repeat(breaks, 2), breaks[-1], breaks[-1]]
    return spline_curve_2d(np.column_stack([u, np.full_like(u, v)]), knots, 3)
