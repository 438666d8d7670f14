"""The volume a solid must have, from the outline and the map alone: no modeller, no triangles.

V = ∫ dd ∬ J(u, v, d) du dv over the material at each depth d, with J the map's volume density. Green's theorem
turns the inner integral into ∮ G dv along the loops, G = ∫₀ᵘ J du. Every integral is a Gauss rule: exact on a
plate (to rounding), spectrally close on smooth surfaces.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from perfqr_cad.pattern.outline import Arc, Segment
from perfqr_cad.surface import Placement

from .sampling import Array, by_kind, derivatives
from .sections import Well

NODES = 8  # of each Gauss rule; exact to degree 15
ARC_PANELS = 4  # a whole circle is integrated by quarters

Band = tuple[float, float]


def volume_mm3(wells: Sequence[Well], placement: Placement) -> float:
    """Volume of the panel whose first well is its rim."""
    bands: dict[Band, tuple[list[Segment], list[Segment]]] = {}
    for well in wells:
        for k in range(len(well.levels) - 1):
            band = well.levels[k].depth_mm, well.levels[k + 1].depth_mm
            upper, lower = bands.setdefault(band, ([], []))
            upper += well.loops[k].segments
            lower += well.loops[k + 1].segments
    return sum(_band_volume(upper, lower, band, placement) for band, (upper, lower) in bands.items())


def _band_volume(upper: list[Segment], lower: list[Segment], band: Band, placement: Placement) -> float:
    """Between two levels the loops move along straight lines, as the ruled walls do."""
    node, weight = _gauss(1)
    top, bottom = band
    total = 0.0
    for kind, rows in by_kind(upper).items():
        if not len(rows):
            continue
        along, along_weight = _gauss(ARC_PANELS if kind is Arc else 1)
        p0, v0 = derivatives([upper[i] for i in rows], along)
        p1, v1 = derivatives([lower[i] for i in rows], along)
        still = np.array_equal(p0, p1) and placement.is_flat
        for s, w in ((0.0, 1.0),) if still else zip(node, weight, strict=True):
            point, slope = (1 - s) * p0 + s * p1, (1 - s) * v0 + s * v1
            swept = _swept(point.reshape(-1, 2), top + s * (bottom - top), placement)
            total += w * float(np.sum(swept * (slope[..., 1] * along_weight).ravel()))
    return total * (bottom - top)


def _swept(at: Array, depth_mm: float, placement: Placement) -> Array:
    """G at pattern points: the density integrated along u from 0, (k,)."""
    if placement.is_flat:
        return at[:, 0]
    node, weight = _gauss(1)
    total = np.zeros(len(at))
    for s, w in zip(node, weight, strict=True):
        total += w * placement.volume_density(at * (s, 1.0), depth_mm)
    return total * at[:, 0]


def _gauss(panels: int) -> tuple[Array, Array]:
    """Nodes and weights on [0, 1], composite over equal panels."""
    node, weight = np.polynomial.legendre.leggauss(NODES)
    node, weight = (node + 1) / 2, weight / 2
    starts = np.arange(panels)[:, None]
    return ((starts + node) / panels).ravel(), np.tile(weight / panels, panels)
