"""How much material the holes take: the wall integrated over the holes, without the modeller's volumes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from perfqr_cad.geometry.arrays import Array
from perfqr_cad.geometry.outline import Loop
from perfqr_cad.geometry.triangulation import delaunay
from perfqr_cad.hosts.host_placement import HostPlacement
from perfqr_cad.hosts.probe import probe

if TYPE_CHECKING:
    from perfqr_cad.hosts.step.host import Host

# Three points a triangle integrate exactly what is quadratic over it; two depths what is cubic through the
# wall.
TRIANGLE_POINTS = np.array([[4, 1, 1], [1, 4, 1], [1, 1, 4]]) / 6
DEPTH_POINTS = (0.5 - 0.5 / 3**0.5, 0.5 + 0.5 / 3**0.5)
FLATTEN_MM = 1e-4


def removed_volume_mm3(
    host: Host, holes: Sequence[Loop], placement: HostPlacement, depth_mm: float | None
) -> float:
    """Volume of straight holes through the wall, or of pockets `depth_mm` deep, mm³."""
    points, weights = quadrature(holes)
    depth = _wall(host, points, placement) if depth_mm is None else np.full(len(points), depth_mm)
    layers = [placement.volume_density(points, share * depth) for share in DEPTH_POINTS]
    return float(np.sum(weights * depth * np.mean(layers, axis=0)))


def quadrature(holes: Sequence[Loop]) -> tuple[Array, Array]:
    """Points (k, 2) and weights (k,) in mm² that integrate over the holes; the weights sum to their exact
    area."""
    points, weights = [], []
    for hole in holes:
        ring = hole.oriented(ccw=True).flatten(FLATTEN_MM)
        corners = ring[delaunay([ring])]
        a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
        areas = ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]) / 2
        points.append(np.einsum("pj,tjk->tpk", TRIANGLE_POINTS, corners).reshape(-1, 2))
        weights.append(np.repeat(areas / 3, 3) * abs(hole.area) / areas.sum())
    return np.vstack(points), np.concatenate(weights)


def _wall(host: Host, points: Array, placement: HostPlacement) -> Array:
    """Exact wall along each hole's axis."""
    origins, frames = placement.line(points)
    met = probe(host.body, origins, frames[:, 2])
    front = origins + met.offset_mm[:, None] * frames[:, 2]
    back = front - met.wall_mm[:, None] * frames[:, 2]
    ends = []
    for faces, guesses in ((met.front, front), (met.back, back)):
        exact = np.empty_like(guesses)
        for i in np.unique(faces):
            on = faces == i
            exact[on] = host.exact_faces[i].meet(
                origins[on], frames[on], guesses[on], placement.thickness_mm
            )[1]
        ends.append(exact)
    return np.einsum("ki,ki->k", ends[0] - ends[1], frames[:, 2])
