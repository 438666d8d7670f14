"""The volume a solid must have, from the outline and the map alone: no modeller, no triangles.

V = ∫ dd ∬ J(u, v, d) du dv over the material at each depth d, with J the map's volume density. Green's theorem
turns the inner integral into ∮ G dv along the loops, ∂G/∂u = J. On a plate G = u and all is exact; elsewhere G
is tabulated on a fine grid, and the integrals along edges and depths are Gauss rules.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
from scipy.interpolate import RectBivariateSpline, make_interp_spline

from perfqr_cad.pattern.outline import Circle, Line, Segment
from perfqr_cad.surface import Placement, Revolved

from .sampling import Array, derivatives
from .sections import Well

NODES = 8  # of the Gauss rule along an edge panel; exact to degree 15
DEPTH_NODES = 4  # J is quadratic in depth, and ruled walls move the edges linearly
CIRCLE_PANELS = 4  # a whole circle is integrated by quarters
PANEL_MM = 2.0  # on curved walls, where splines join between modules
TABLE = 161  # grid lines of G over the code: a quarter of a module, or less

Band = tuple[float, float]
Swept = Callable[[Array], Array]


def volume_mm3(wells: Sequence[Well], placement: Placement) -> float:
    """Volume of the panel whose first well is its rim."""
    bands: dict[Band, tuple[list[Segment], list[Segment]]] = {}
    for well in wells:
        for k in range(len(well.levels) - 1):
            band = well.levels[k].depth_mm, well.levels[k + 1].depth_mm
            upper, lower = bands.setdefault(band, ([], []))
            upper += well.loops[k].segments
            lower += well.loops[k + 1].segments
    rim = wells[0].loops[0].flatten(PANEL_MM)
    box = rim.min(axis=0), rim.max(axis=0)
    return sum(_band_volume(upper, lower, band, placement, box) for band, (upper, lower) in bands.items())


def _band_volume(
    upper: list[Segment], lower: list[Segment], band: Band, placement: Placement, box: tuple[Array, Array]
) -> float:
    """Between two levels the loops move along straight lines, as the ruled walls do."""
    top, bottom = band
    still = placement.is_flat and upper == lower
    rules = ((0.0, 1.0),) if still else list(zip(*gauss(DEPTH_NODES, 1), strict=True))
    tables = [_swept(placement, top + s * (bottom - top), box) for s, _ in rules]
    total = 0.0
    for panels, rows in _by_panels(upper, placement.is_flat).items():
        node, weight = gauss(NODES, panels)
        p0, v0 = derivatives([upper[i] for i in rows], node)
        p1, v1 = derivatives([lower[i] for i in rows], node)
        for (s, share), swept in zip(rules, tables, strict=True):
            point, slope = (1 - s) * p0 + s * p1, (1 - s) * v0 + s * v1
            total += share * float(np.sum(swept(point.reshape(-1, 2)) * (slope[..., 1] * weight).ravel()))
    return total * (bottom - top)


def _by_panels(segments: Sequence[Segment], flat: bool) -> dict[int, list[int]]:
    """Segments by the number of panels they are integrated in."""
    found: dict[int, list[int]] = {}
    for i, segment in enumerate(segments):
        panels = 1 if isinstance(segment, Line) else CIRCLE_PANELS if isinstance(segment, Circle) else 2
        if not flat:
            panels = max(panels, math.ceil(segment.length / PANEL_MM))
        found.setdefault(panels, []).append(i)
    return found


def _swept(placement: Placement, depth_mm: float, box: tuple[Array, Array]) -> Swept:
    """G at one depth. Its lower limit is free: over closed loops ∮ c(v) dv = 0."""
    if placement.is_flat:
        return lambda at: at[:, 0]
    if isinstance(placement, Revolved):  # the same density all around
        return lambda at: at[:, 0] * placement.volume_density(at * (0.0, 1.0), depth_mm)
    low, high = box
    u, v = np.linspace(low[0], high[0], TABLE), np.linspace(low[1], high[1], TABLE)
    grid = np.stack(np.meshgrid(u, v, indexing="ij"), axis=-1).reshape(-1, 2)
    density = placement.volume_density(grid, depth_mm).reshape(TABLE, TABLE)
    swept = make_interp_spline(u, density, axis=0).antiderivative()(u)
    table = RectBivariateSpline(u, v, swept, s=0)
    return lambda at: table.ev(at[:, 0], at[:, 1])


def gauss(nodes: int, panels: int) -> tuple[Array, Array]:
    """Nodes and weights on [0, 1], composite over equal panels."""
    node, weight = np.polynomial.legendre.leggauss(nodes)
    node, weight = (node + 1) / 2, weight / 2
    starts = np.arange(panels)[:, None]
    return ((starts + node) / panels).ravel(), np.tile(weight / panels, panels)
