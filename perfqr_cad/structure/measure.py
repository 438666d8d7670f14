"""The stress that is compared with the yield stress.

Corners of modules are singular: the peak of von Mises' stress grows without end as the mesh is refined.
The measure used here is **von Mises' stress of the stress tensor averaged over a disc as wide as the
nozzle**, the finest detail the part can have. It converges, it does not depend on the mesh, and it is centred
in turn on every corner node of the mesh, which include all corners of the outline.

An average is never above the largest stress in its disc (von Mises' stress is convex), so only places near
high nodal stress need to be averaged to find the largest of all.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp

from perfqr_cad.structure.mesh.triangle import Floats, Ints, Mesh

# Points of equal weight in the disc. Against 997 of them, on a wall of version 8: 37 are 0.7 % off, 91 0.2 %.
SAMPLES = 91
MAP_SAMPLES = 19  # enough to look at
FIRST_TRIED = 64  # places of highest nodal stress, averaged first
_GOLDEN_ANGLE = math.pi * (3.0 - math.sqrt(5.0))
LONGEST_WALK = 200  # elements crossed by one point; discs are small, a walk this long is lost
_INSIDE = -1e-9  # barycentric coordinate of a point on an edge


def von_mises(stress: Floats) -> Floats:
    """Von Mises' stress of plane tensors (..., 5): σxx, σyy, τxy, τxz, τyz, with σzz = 0."""
    xx, yy, xy, xz, yz = np.moveaxis(stress, -1, 0)
    return np.sqrt(np.maximum(xx**2 + yy**2 - xx * yy + 3.0 * (xy**2 + xz**2 + yz**2), 0.0))


@dataclass(frozen=True)
class Discs:
    """Discs of `width_mm` around the corner nodes of a mesh.

    Stresses are given at the three corners of each element, (m, 3, layers, 5): linear inside it, with jumps
    between elements.
    """

    mesh: Mesh
    width_mm: float

    def matrix(self, vertices: Ints, samples: int = SAMPLES) -> sp.csr_matrix:
        """Averages over the discs of some corner nodes as a matrix (k, 3·m) on values at element corners.

        Parts of a disc that lie in a hole do not count.
        """
        radius = 0.5 * self.width_mm * np.sqrt((np.arange(samples) + 0.5) / samples)
        angle = _GOLDEN_ANGLE * np.arange(samples)
        disc = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1)
        start = self._start[vertices]
        points = (self.mesh.nodes[vertices, None] + disc).reshape(-1, 2)
        element, weights = locate(self.mesh, points, np.repeat(start, samples))
        row = np.repeat(np.arange(len(vertices)), samples)
        inside = element >= 0
        # A vertex whose disc lies in a hole has its own value.
        lost = np.flatnonzero(np.bincount(row[inside], minlength=len(vertices)) == 0)
        own = (self.mesh.elements[start[lost], :3] == vertices[lost, None]).astype(float)
        row, element = np.r_[row[inside], lost], np.r_[element[inside], start[lost]]
        weights = np.r_[weights[inside], own] / np.bincount(row)[row][:, None]
        columns = element[:, None] * 3 + np.arange(3)
        shape = (len(vertices), 3 * len(self.mesh.elements))
        return sp.csr_matrix((weights.ravel(), (np.repeat(row, 3), columns.ravel())), shape=shape)

    def at(self, vertices: Ints, stress: Floats, samples: int = SAMPLES) -> Floats:
        """The measure (k,) at some corner nodes: the largest of the layers."""
        tensors = self.matrix(vertices, samples) @ stress.reshape(3 * len(stress), -1)
        return von_mises(tensors.reshape(-1, *stress.shape[2:])).max(axis=1)

    def most_stressed(
        self, stress: Floats, share: float = 1.0, apart_from: Ints | None = None
    ) -> tuple[Ints, Floats]:
        """The corner nodes whose measure is at least a share of the largest, and it, largest first.

        Nodes `apart_from` are left out.
        """
        peaks = von_mises(stress).max(axis=2)
        nodal = np.zeros(self.mesh.corners)
        np.maximum.at(nodal, self.mesh.elements[:, :3], peaks)
        out = np.zeros(0, np.int64) if apart_from is None else apart_from
        nodal[out] = 0.0
        first = np.argsort(-nodal, kind="stable")[:FIRST_TRIED]
        limit = share * float(self.at(first, stress).max())
        near = self._whose_disc_may_touch(np.flatnonzero(peaks.max(axis=1) >= limit))
        near = near[~np.isin(near, out)]
        measure = self.at(near, stress)
        order = np.argsort(-measure, kind="stable")
        order = order[measure[order] >= share * measure[order[0]]]
        return near[order], measure[order]

    def everywhere(self, stress: Floats) -> Floats:
        """The measure at every corner node, in the quality of a map."""
        return self.at(np.arange(self.mesh.corners), stress, MAP_SAMPLES)

    def _whose_disc_may_touch(self, elements: Ints) -> Ints:
        """The corner nodes nearer to some elements than the radius."""
        corners = self.mesh.nodes[self.mesh.elements[elements, :3]]
        centres = corners.mean(axis=1)
        reach = np.linalg.norm(corners - centres[:, None], axis=2).max(axis=1) + 0.5 * self.width_mm
        found = self.mesh.corner_tree.query_ball_point(centres, reach)
        return np.unique(np.concatenate([np.asarray(rows, np.int64) for rows in found]))

    @cached_property
    def _start(self) -> Ints:
        """An element at each corner node."""
        start = np.empty(self.mesh.corners, np.int64)
        start[self.mesh.elements[:, :3]] = np.arange(len(self.mesh.elements))[:, None]
        return start


def locate(mesh: Mesh, points: Floats, start: Ints) -> tuple[Ints, Floats]:
    """The element of each point (k, 2), walked to from element `start` (k,), and its barycentric coordinates.

    A walk that meets the outline ends there with element -1: the point is in a hole, or behind one.
    """
    beyond = mesh.neighbours
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
