"""The volume a solid must have, from the outline and the map alone: no modeller, no triangles.

3 V = ∮ p · dA over the front, the back (or the floors) and the walls. On the caps dA = p_u × p_v du dv, and
Green's theorem turns the area integral into ∮ G dv along the loops, ∂G/∂u = p · (p_u × p_v): G = z u on a
plate, G = u · density around an axis, a fine table elsewhere. Walls are ruled between mapped segments. All is
integrated by Gauss rules: exact on a plate up to rounding.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from scipy.interpolate import RectBivariateSpline, make_interp_spline

from perfqr_cad.geometry.arrays import Array, Indices
from perfqr_cad.geometry.outline import Arc, Bezier, Segment
from perfqr_cad.geometry.segments import by_kind, derivatives, positions, quarters, rounds
from perfqr_cad.profile.sections import Loft
from perfqr_cad.surface import Placement, Revolved

NODES = 8  # of the Gauss rule along an edge panel; exact to degree 15
RULING_NODES = 2  # p · (p_t × p_s) is quadratic along a ruling
PANEL_MM = 2.0  # on curved walls, where splines join between modules
TABLE = 161  # grid lines of G over the code: a quarter of a module, or less

AtDepths = list[tuple[Segment, float]]  # segments with their depths, mm
Swept = Callable[[Array], Array]


def volume_mm3(lofts: Sequence[Loft], placement: Placement) -> float:
    """Volume of the panel whose first loft is its rim."""
    rim = lofts[0].loops[0].flatten(PANEL_MM)
    box = rim.min(axis=0), rim.max(axis=0)
    origin = np.zeros(3) if isinstance(placement, Revolved) else placement.point((0.0, 0.0))[0]
    mouths = [(s, loft.levels[0].depth_mm) for loft in lofts for s in loft.loops[0].segments]
    feet = [(s, loft.levels[-1].depth_mm) for loft in lofts for s in loft.loops[-1].segments]
    caps = _caps(mouths, placement, origin, box) - _caps(feet, placement, origin, box)
    return (caps + _walls(lofts, placement, origin)) / 3


def _caps(segments_at: AtDepths, placement: Placement, origin: Array, box: tuple[Array, Array]) -> float:
    """∬ (p − origin) · (p_u × p_v) du dv inside loops, by depth."""
    by_depth: dict[float, list[Segment]] = {}
    for segment, depth in segments_at:
        by_depth.setdefault(depth, []).append(segment)
    total = 0.0
    for depth, segments in by_depth.items():
        swept = _swept(placement, depth, origin, box)
        for panels, rows in _by_panels(segments, placement.is_flat).items():
            node, weight = gauss(NODES, panels)
            point, slope = derivatives([segments[i] for i in rows], node)
            total += float(np.sum(swept(point.reshape(-1, 2)) * (slope[..., 1] * weight).ravel()))
    return total


def _walls(lofts: Sequence[Loft], placement: Placement, origin: Array) -> float:
    """∬ p · dA over the ruled walls, dA to the right of travel."""
    bands: dict[tuple[float, float], tuple[list[Segment], list[Segment]]] = {}
    for loft in lofts:
        for k in range(len(loft.levels) - 1):
            band = loft.levels[k].depth_mm, loft.levels[k + 1].depth_mm
            upper, lower = bands.setdefault(band, ([], []))
            upper += loft.loops[k].segments
            lower += loft.loops[k + 1].segments
    total = 0.0
    for (top, bottom), (upper, lower) in bands.items():
        for panels, rows in _by_panels(upper, placement.is_flat).items():
            node, weight = gauss(NODES, panels)
            over, under = [upper[i] for i in rows], [lower[i] for i in rows]
            spans = _spans(over, under) if placement.is_flat else None
            drawn = _drawn(over, node, spans)
            p1, t1 = _mapped(*drawn, top, placement)
            if any(a is not b for a, b in zip(over, under, strict=True)):  # not upright
                drawn = _drawn(under, node, spans)
            p0, t0 = _mapped(*drawn, bottom, placement)
            p1, p0 = p1 - origin, p0 - origin
            for s, share in zip(*gauss(RULING_NODES, 1), strict=True):
                at, along = (1 - s) * p0 + s * p1, (1 - s) * t0 + s * t1
                flux = np.einsum("kqi,kqi->kq", at, np.cross(along, p1 - p0))
                total += float(share * np.sum(flux * weight))
    return total


def _drawn(segments: list[Segment], node: Array, spans: Indices | None) -> tuple[Array, Array]:
    """Points and derivatives (k, q, 2) of segments."""
    at, slope = derivatives(segments, node)
    if spans is not None:
        _by_rationals(segments, node, spans, at, slope)
    return at, slope


def _mapped(at: Array, slope: Array, depth_mm: float, placement: Placement) -> tuple[Array, Array]:
    """The same, (k, q, 3), at a depth."""
    flat = at.reshape(-1, 2)
    along_u, along_v = (x.reshape(*at.shape[:2], 3) for x in placement.tangents(flat, depth_mm))
    points = placement.at_depth(flat, depth_mm).reshape(*at.shape[:2], 3)
    return points, along_u * slope[..., :1] + along_v * slope[..., 1:]


def _spans(upper: Sequence[Segment], lower: Sequence[Segment]) -> Indices:
    """Rational spans (k,) of the wall between two arcs, 0 for other segments."""
    spans = np.zeros(len(upper), np.int64)
    rows = by_kind(upper)[Arc]
    turns = [np.abs(rounds([row[i] for i in rows.tolist()]).sweep_rad) for row in (upper, lower)]
    spans[rows] = quarters(np.maximum(*turns))
    return spans


def _by_rationals(segments: Sequence[Segment], node: Array, spans: Indices, at: Array, slope: Array) -> None:
    """Points and derivatives of arcs where their rational spans have them, in place.

    On a plate the wall between two arcs of unlike sweep is ruled between equal parameters of their rational
    forms (`ruled.oblique`), which are not equal shares of their angles.
    """
    rows = np.flatnonzero(spans)
    arcs = rounds([segments[i] for i in rows.tolist()])
    count = spans[rows][:, None]
    turn = arcs.sweep_rad[:, None]
    quarter = np.tan(np.abs(turn) / count / 4)
    span = np.minimum(np.floor(node * count), count - 1)
    local = 2 * (node * count - span) - 1
    half = np.abs(turn) / count / 2
    share = (span + (2 * np.arctan(local * quarter) / half + 1) / 2) / count
    speed = 2 * quarter / (1 + (local * quarter) ** 2) / half
    angle = arcs.start_rad[:, None] + share * turn
    ray = np.stack([np.cos(angle), np.sin(angle)], axis=-1) * arcs.radius[:, None, None]
    at[rows] = arcs.centre[:, None] + ray
    slope[rows] = np.stack([-ray[..., 1], ray[..., 0]], axis=-1) * (turn * speed)[..., None]


def _by_panels(segments: Sequence[Segment], flat: bool) -> dict[int, list[int]]:
    """Segments by the number of panels they are integrated in."""
    kinds = by_kind(segments)
    panels = np.ones(len(segments), np.int64)
    panels[kinds[Bezier]] = 2
    # No panel runs over the joint of two rational spans.
    panels[kinds[Arc]] = 2 * quarters(np.abs(rounds(segments).sweep_rad))
    if not flat:
        steps = np.diff(positions(segments, np.linspace(0.0, 1.0, NODES)), axis=1)
        length = np.hypot(steps[..., 0], steps[..., 1]).sum(axis=1)
        panels = np.maximum(panels, np.ceil(length / PANEL_MM).astype(np.int64))
    counts = np.flatnonzero(np.bincount(panels)).tolist()
    return {count: np.flatnonzero(panels == count).tolist() for count in counts}


def _swept(placement: Placement, depth_mm: float, origin: Array, box: tuple[Array, Array]) -> Swept:
    """G at one depth. Its lower limit is free: over closed loops ∮ c(v) dv = 0."""

    def density(at: Array) -> Array:
        area = np.cross(*placement.tangents(at, depth_mm))
        return np.einsum("ki,ki->k", placement.at_depth(at, depth_mm) - origin, area)

    if placement.is_flat:
        height = float(density(np.zeros((1, 2)))[0])
        return lambda at: height * at[:, 0]
    if isinstance(placement, Revolved):  # the same density all around
        return lambda at: at[:, 0] * density(at * (0.0, 1.0))
    low, high = box
    u, v = np.linspace(low[0], high[0], TABLE), np.linspace(low[1], high[1], TABLE)
    grid = np.stack(np.meshgrid(u, v, indexing="ij"), axis=-1).reshape(-1, 2)
    swept = make_interp_spline(u, density(grid).reshape(TABLE, TABLE), axis=0).antiderivative()(u)
    table = RectBivariateSpline(u, v, swept, s=0)
    return lambda at: np.asarray(table.ev(at[:, 0], at[:, 1]), np.float64)


def gauss(nodes: int, panels: int) -> tuple[Array, Array]:
    """Nodes and weights on [0, 1], composite over equal panels.

    >>> node, weight = gauss(2, 3)
    >>> round(float(node**3 @ weight), 12)
    0.25
    """
    node, weight = np.polynomial.legendre.leggauss(nodes)
    node, weight = (node + 1) / 2, weight / 2
    starts = np.arange(panels)[:, None]
    return ((starts + node) / panels).ravel(), np.tile(weight / panels, panels)
