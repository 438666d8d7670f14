"""The six-node triangle: shape functions, quadrature and the mesh made of it.

Nodes 0-2 are the corners, 3-5 the middles of the edges 01, 12 and 20. Reference coordinates are (ξ, η) with
corners (0, 0), (1, 0), (0, 1).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

ALL = slice(None)
EDGES = ((0, 1), (1, 2), (2, 0))
NODES_REF: Floats = np.array([[0, 0], [1, 0], [0, 1], [0.5, 0], [0.5, 0.5], [0, 0.5]], float)

# Symmetric rules on the triangle of area 1/2: Dunavant 1985, degrees 2 and 4.
THREE_POINTS: Floats = np.array([[1 / 6, 1 / 6], [2 / 3, 1 / 6], [1 / 6, 2 / 3]])
THREE_WEIGHTS: Floats = np.full(3, 1 / 6)
CENTRE: Floats = np.full((1, 2), 1 / 3)
_A, _B = 0.445948490915965, 0.091576213509771
SIX_POINTS: Floats = np.array(
    [[_A, _A], [_A, 1 - 2 * _A], [1 - 2 * _A, _A], [_B, _B], [_B, 1 - 2 * _B], [1 - 2 * _B, _B]]
)
SIX_WEIGHTS: Floats = np.repeat([0.223381589678011 / 2, 0.109951743655322 / 2], 3)


def shapes(points: Floats) -> Floats:
    """Values of the six shape functions at reference points (k, 2): an array (k, 6)."""
    x, y = points[:, 0], points[:, 1]
    z = 1.0 - x - y
    return np.stack(
        [z * (2 * z - 1), x * (2 * x - 1), y * (2 * y - 1), 4 * z * x, 4 * x * y, 4 * y * z], axis=1
    )


def gradients(points: Floats) -> Floats:
    """Derivatives by ξ and η at reference points (k, 2): an array (k, 2, 6)."""
    x, y = points[:, 0], points[:, 1]
    z, o = 1.0 - x - y, np.zeros(len(points))
    by_xi = np.stack([1 - 4 * z, 4 * x - 1, o, 4 * (z - x), 4 * y, -4 * y], axis=1)
    by_eta = np.stack([1 - 4 * z, o, 4 * y - 1, -4 * x, 4 * x, 4 * (z - y)], axis=1)
    return np.stack([by_xi, by_eta], axis=1)


# Takes values at the three Gauss points, where stress is best, linearly to the corners.
FROM_GAUSS_TO_CORNERS: Floats = np.c_[np.ones(3), NODES_REF[:3]] @ np.linalg.inv(
    np.c_[np.ones(3), THREE_POINTS]
)


@dataclass(frozen=True)
class Mesh:
    """A plane mesh of straight six-node triangles, counter-clockwise.

    `nodes` is (n, 2) in mm with the corners first, `elements` (m, 6); `corners` counts the corner nodes.
    """

    nodes: Floats
    elements: Ints
    corners: int

    def __post_init__(self) -> None:
        self.nodes.setflags(write=False)
        self.elements.setflags(write=False)

    @cached_property
    def inverse_jacobian(self) -> Floats:
        """∂(ξ, η)/∂(x, y) of each element as (m, 2, 2): row = x or y, column = ξ or η."""
        a, b = self._edge_vectors
        d = self._twice_area
        return (
            np.stack([np.stack([b[:, 1], -a[:, 1]], 1), np.stack([-b[:, 0], a[:, 0]], 1)], 1)
            / d[:, None, None]
        )

    @property
    def area_mm2(self) -> Floats:
        """Area of each element."""
        return self._twice_area / 2.0

    @cached_property
    def _edge_vectors(self) -> tuple[Floats, Floats]:
        p = self.nodes[self.elements[:, :3]]
        return p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]

    @cached_property
    def _twice_area(self) -> Floats:
        a, b = self._edge_vectors
        return a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]

    @cached_property
    def longest_edge_mm(self) -> float:
        """Length of the longest edge."""
        p = self.nodes[self.elements[:, :3]]
        return float(np.linalg.norm(p - np.roll(p, 1, axis=1), axis=2).max())

    def points(self, reference: Floats, which: NDArray[np.bool_] | slice = ALL) -> Floats:
        """Where reference points (k, 2) lie in each element, or in some: (m, k, 2) in mm."""
        a, b = (vector[which] for vector in self._edge_vectors)
        origin = self.nodes[self.elements[which, 0]]
        return origin[:, None] + reference[None, :, :1] * a[:, None] + reference[None, :, 1:] * b[:, None]

    @cached_property
    def corner_tree(self) -> KDTree:
        """The corner nodes, to find them by place."""
        return KDTree(self.nodes[: self.corners])

    @cached_property
    def centre_tree(self) -> KDTree:
        """The centres of the elements, to find them by place."""
        return KDTree(self.nodes[self.elements[:, :3]].mean(axis=1))

    @cached_property
    def boundary(self) -> Ints:
        """The edges that belong to one element only, as (corner, corner, middle) nodes (k, 3)."""
        edges = np.concatenate([self.elements[:, [i, j, 3 + k]] for k, (i, j) in enumerate(EDGES)])
        counts = np.bincount(edges[:, 2], minlength=len(self.nodes))
        return edges[counts[edges[:, 2]] == 1]

    @cached_property
    def neighbours(self) -> Ints:
        """The element across each edge 01, 12, 20: (m, 3), -1 on the outline."""
        middles = self.elements[:, 3:].ravel()
        order = np.argsort(middles, kind="stable")
        pair = np.flatnonzero(middles[order[1:]] == middles[order[:-1]])
        one, other = order[pair], order[pair + 1]
        across = np.full(len(middles), -1, np.int64)
        across[one], across[other] = other // 3, one // 3
        return across.reshape(-1, 3)


def quadratic(vertices: Floats, triangles: Ints) -> Mesh:
    """The six-node mesh on a mesh of corner triangles (m, 3); turns clockwise triangles round."""
    triangles = np.asarray(triangles, np.int64)
    clockwise = twice_areas(vertices, triangles) < 0.0
    triangles = np.where(clockwise[:, None], triangles[:, [0, 2, 1]], triangles)
    elements, ends = with_middles(triangles, len(vertices))
    middles = 0.5 * (vertices[ends[:, 0]] + vertices[ends[:, 1]])
    return Mesh(np.vstack([vertices, middles]), elements, len(vertices))


def twice_areas(vertices: Floats, triangles: Ints) -> Floats:
    """Twice the signed area of each triangle (m,)."""
    p = vertices[triangles]
    a, b = p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]
    return a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]


def with_middles(triangles: Ints, corners: int) -> tuple[Ints, Ints]:
    """Six-node connectivity (m, 6) of corner triangles, and the two ends of each new middle node (k, 2)."""
    edges = np.sort(np.concatenate([triangles[:, edge] for edge in EDGES]), axis=1)
    keys, where = np.unique(edges[:, 0] * np.int64(corners) + edges[:, 1], return_inverse=True)
    elements = np.concatenate([triangles, where.reshape(3, -1).T + corners], axis=1)
    return elements, np.stack([keys // corners, keys % corners], axis=1)
