"""Nodes along an outline: fine at re-entrant corners, where stress is singular, coarse between them.

A mesher that is given these nodes fills the inside to match, so the grading is set here and nowhere else.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from perfqr_cad.structure.mesh.triangle import Floats

REENTRANT_DEG = 50.0  # a gentler bend, as between two chords of a fillet, needs no finer mesh
GROWTH = 2.0  # length of an edge over that of the one nearer to the corner
CORNER_NOZZLES = 1.0  # element edges at sharp re-entrant corners
LAYER_EDGES = 0.25  # edges next to free walls
TOLERANCE_NOZZLES = 0.05  # how far the outline may move in the model
COARSENING = 1.5  # of edges from one mesh to the next coarser one
LAYER_SHARE = 0.7  # of an edge: what its layers may take up at most

Flags = NDArray[np.bool_]


@dataclass(frozen=True)
class MeshSize:
    """How fine a mesh is, lengths in mm.

    edge_mm       largest edge
    corner_mm     edges at sharp re-entrant corners
    layer_mm      edges of seams next to free walls, where twisting has its boundary layer; 0: no finer
    tolerance_mm  how far the outline may move
    """

    edge_mm: float
    corner_mm: float
    layer_mm: float
    tolerance_mm: float

    @staticmethod
    def graded(edge_mm: float, nozzle_mm: float) -> MeshSize:
        """Finer where stress varies most, as answers need it."""
        return MeshSize(
            edge_mm, CORNER_NOZZLES * nozzle_mm, LAYER_EDGES * edge_mm, TOLERANCE_NOZZLES * nozzle_mm
        )

    @staticmethod
    def even(edge_mm: float, nozzle_mm: float) -> MeshSize:
        """The same everywhere: enough to compare bridges on."""
        return MeshSize(edge_mm, edge_mm, 0.0, TOLERANCE_NOZZLES * nozzle_mm)

    def coarser(self) -> MeshSize:
        """The next size: larger edges, and none finer where seams meet free walls."""
        return replace(self, edge_mm=COARSENING * self.edge_mm, layer_mm=0.0)

    def scaled(self, factor: float) -> MeshSize:
        """The size in another unit of length."""
        return MeshSize(
            self.edge_mm * factor, self.corner_mm * factor, self.layer_mm * factor, self.tolerance_mm * factor
        )


def seed(outline: Floats, pinned: Flags, mesh_size: MeshSize) -> Floats:
    """The points (k, 2) of a loop with material on its left, and nodes between them.

    Edges start fine at re-entrant corners and grow. Pinned edges (flags by their first point) get nodes that
    are the same, whole numbers, when the edge is run the other way.
    """
    fine = reentrant(outline)
    pieces: list[Floats] = []
    ends = np.roll(outline, -1, axis=0)
    for k, (a, b) in enumerate(zip(outline, ends, strict=True)):
        after = (k + 1) % len(outline)
        if pinned[k]:
            pieces.append(_pinned(a, b, not pinned[k - 1], not pinned[after], mesh_size)[:-1])
            continue
        length = float(np.hypot(*(b - a)))
        first, last = (mesh_size.corner_mm if fine[end] else mesh_size.edge_mm for end in (k, after))
        pieces.append(a + _stations(length, mesh_size.edge_mm, first, last)[:, None] * (b - a) / length)
    return np.concatenate(pieces)


def _pinned(a: Floats, b: Floats, wall_at_a: bool, wall_at_b: bool, mesh_size: MeshSize) -> Floats:
    """Nodes from a to b, both included: even ones, and a layer at each end that is at a wall."""
    if tuple(b) < tuple(a):
        return _pinned(b, a, wall_at_b, wall_at_a, mesh_size)[::-1]
    length = float(np.hypot(*(b - a)))
    layers = mesh_size.layer_mm * np.array([wall_at_a, wall_at_b])
    if layers.sum() > LAYER_SHARE * length:
        layers = np.zeros(2)
    inner = length - layers.sum()
    parts = max(1, int(np.ceil(length / mesh_size.edge_mm - 0.01)))
    at = layers[0] + inner * np.arange(parts + 1) / parts
    at = np.unique(np.r_[0.0, at, length]) / length
    return np.rint(a + at[:, None] * (b - a))


def reentrant(outline: Floats) -> Flags:
    """Which corners of a loop with material on its left stick into the material."""
    before, after = outline - np.roll(outline, 1, axis=0), np.roll(outline, -1, axis=0) - outline
    cross = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    turn = np.arctan2(cross, np.einsum("kc,kc->k", before, after))
    return turn < -np.radians(REENTRANT_DEG)


def _stations(length: float, size: float, first: float, last: float) -> Floats:
    """Where nodes lie along an edge, from 0 and short of its length: growing from both ends."""
    head, tail = [0.0], [length]
    while True:
        left = tail[-1] - head[-1]
        step = min(first, last)
        if left <= 1.5 * step or step >= size:
            break
        if first <= last:
            head.append(head[-1] + first)
            first = min(GROWTH * first, size)
        else:
            tail.append(tail[-1] - last)
            last = min(GROWTH * last, size)
    left = tail[-1] - head[-1]
    parts = max(1, round(left / min(first, last, size)))
    middle = head[-1] + left * np.arange(1, parts) / parts
    return np.array([*head, *middle, *reversed(tail[1:])])
