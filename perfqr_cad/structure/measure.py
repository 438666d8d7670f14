"""The stress that is compared with the yield stress.

Corners of modules are singular: the peak of von Mises' stress grows without end as the mesh is refined.
The measure used here is **von Mises' stress of the stress tensor averaged over a disc as wide as the
nozzle**, the finest detail the part can have. It converges, it does not depend on the mesh, and it is centred
in turn on every corner node of the mesh, which include all corners of the outline.

Averaging is linear in the displacement, so it is one sparse matrix that serves every load and every bridge.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from perfqr_cad.structure.t6 import EDGES, Floats, Ints, Mesh

SAMPLES = 19  # points of equal weight in the disc; 37 move the measure by less than 1 %
_GOLDEN_ANGLE = math.pi * (3.0 - math.sqrt(5.0))
LONGEST_WALK = 200  # elements crossed by one point; discs are small, a walk this long is lost
_INSIDE = -1e-9  # barycentric coordinate of a point on an edge


def von_mises(stress: Floats) -> Floats:
    """Von Mises' stress of plane tensors (..., 5): σxx, σyy, τxy, τxz, τyz, with σzz = 0."""
    xx, yy, xy, xz, yz = np.moveaxis(stress, -1, 0)
    return np.sqrt(np.maximum(xx**2 + yy**2 - xx * yy + 3.0 * (xy**2 + xz**2 + yz**2), 0.0))


@dataclass(frozen=True)
class DiscAverage:
    """Averages over discs of `width_mm` around the corner nodes of a mesh, as a matrix (corners, 3·elements).

    It acts on values at the three corners of each element, linear inside it and with jumps between elements.
    """

    width_mm: float
    matrix: sp.csr_matrix

    def __call__(self, corner_values: Floats) -> Floats:
        """Averages (corners, ...) of values (elements, 3, ...)."""
        tail = corner_values.shape[2:]
        flat = corner_values.reshape(3 * len(corner_values), -1)
        return (self.matrix @ flat).reshape(-1, *tail)


def disc_average(mesh: Mesh, width_mm: float, samples: int = SAMPLES) -> DiscAverage:
    """The averaging matrix of a mesh. Parts of the disc that lie in a hole do not count."""
    radius = 0.5 * width_mm * np.sqrt((np.arange(samples) + 0.5) / samples)
    angle = _GOLDEN_ANGLE * np.arange(samples)
    disc = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1)
    vertices = np.arange(mesh.corners)
    start = np.empty(mesh.corners, np.int64)
    start[mesh.elements[:, :3]] = np.arange(len(mesh.elements))[:, None]
    points = (mesh.nodes[: mesh.corners, None] + disc).reshape(-1, 2)
    element, weights = locate(mesh, points, np.repeat(start, samples))
    row = np.repeat(vertices, samples)
    # The centre itself always counts, so that a vertex whose disc lies in a hole still has a value.
    inside = element >= 0
    row = np.r_[row[inside], vertices]
    element = np.r_[element[inside], start]
    weights = np.r_[weights[inside], (mesh.elements[start, :3] == vertices[:, None]).astype(float)]
    weights /= np.bincount(row)[row][:, None]
    columns = element[:, None] * 3 + np.arange(3)
    shape = (mesh.corners, 3 * len(mesh.elements))
    return DiscAverage(
        width_mm, sp.csr_matrix((weights.ravel(), (np.repeat(row, 3), columns.ravel())), shape=shape)
    )


def locate(mesh: Mesh, points: Floats, start: Ints) -> tuple[Ints, Floats]:
    """The element of each point (k, 2), walked to from element `start` (k,), and its barycentric coordinates.

    A walk that meets the outline ends there with element -1: the point is in a hole, or behind one.
    """
    beyond = neighbours(mesh)
    element, weights = start.copy(), np.zeros((len(points), 3))
    active = np.arange(len(points))
    for _ in range(LONGEST_WALK):
        if not len(active):
            break
        here = element[active]
        offset = points[active] - mesh.nodes[mesh.elements[here, 0]]
        local = np.einsum("kap,ka->kp", mesh.inverse_jacobian[here], offset)
        bary = np.stack([1.0 - local.sum(axis=1), local[:, 0], local[:, 1]], axis=1)
        worst = np.argmin(bary, axis=1)
        done = bary[np.arange(len(bary)), worst] >= _INSIDE
        weights[active[done]] = bary[done]
        # The edge opposite corner 0, 1, 2 is edge 1, 2, 0.
        onwards = beyond[here, (worst + 1) % 3]
        element[active[~done]] = onwards[~done]
        active = active[~done & (onwards >= 0)]
    element[active] = -1
    return element, weights


def neighbours(mesh: Mesh) -> Ints:
    """The element across each edge 01, 12, 20: (m, 3), -1 on the outline."""
    count = len(mesh.elements)
    middles = mesh.elements[:, 3:].ravel()
    order = np.argsort(middles, kind="stable")
    pair = np.flatnonzero(middles[order[1:]] == middles[order[:-1]])
    one, other = order[pair], order[pair + 1]
    across = np.full(count * len(EDGES), -1, np.int64)
    across[one], across[other] = other // 3, one // 3
    return across.reshape(count, 3)
