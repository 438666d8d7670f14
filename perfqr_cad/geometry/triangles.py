"""Closed triangle meshes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from perfqr_cad.geometry.arrays import Array, Indices
from perfqr_cad.geometry.graph import components

Corner: TypeAlias = tuple[float, float, float]


@dataclass(frozen=True)
class Triangles:
    """A closed triangle mesh, oriented outward: vertices (k, 3) in mm, faces (m, 3) of vertex indices.

    >>> corner = Triangles(np.eye(4, 3, -1), [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    >>> corner.closed, round(6 * corner.volume_mm3, 9), corner.bounds_mm
    (True, 1.0, ((0.0, 0.0, 0.0), (1.0, 1.0, 1.0)))
    """

    vertices: Array
    faces: Indices

    def __post_init__(self) -> None:
        vertices = np.array(self.vertices, dtype=np.float64).reshape(-1, 3)
        faces = np.array(self.faces, dtype=np.int64).reshape(-1, 3)
        vertices.setflags(write=False)
        faces.setflags(write=False)
        object.__setattr__(self, "vertices", vertices)
        object.__setattr__(self, "faces", faces)

    @property
    def volume_mm3(self) -> float:
        """Enclosed volume by the divergence theorem, positive when oriented outward."""
        corners = self.vertices[self.faces] - self.vertices.mean(axis=0)
        return float(np.einsum("ij,ij->", np.cross(corners[:, 0], corners[:, 1]), corners[:, 2]) / 6)

    @property
    def bounds_mm(self) -> tuple[Corner, Corner]:
        """Least and greatest corner of the bounding box."""
        low, high = self.vertices.min(axis=0).tolist(), self.vertices.max(axis=0).tolist()
        return (low[0], low[1], low[2]), (high[0], high[1], high[2])

    @property
    def closed(self) -> bool:
        """Whether every edge is used exactly once in each direction."""
        edges = directed_edges(self.faces)
        key = edges[:, 0] * len(self.vertices) + edges[:, 1]
        opposite = edges[:, 1] * len(self.vertices) + edges[:, 0]
        key.sort()
        opposite.sort()
        return bool((np.diff(key) > 0).all()) and np.array_equal(key, opposite)

    @property
    def vertex_components(self) -> Indices:
        """(k,) number of the body that each vertex belongs to: triangles that share a vertex are one."""
        return components(self.faces[:, [0, 1, 1, 2]].reshape(-1, 2), len(self.vertices))

    @property
    def body_count(self) -> int:
        """How many bodies there are; vertices that no triangle has are none."""
        return len(np.unique(self.vertex_components[self.faces]))

    def joined(self, *others: Triangles) -> Triangles:
        """This mesh and others as one list of triangles; the bodies stay apart."""
        meshes = (self, *others)
        offsets = np.cumsum([0, *(len(m.vertices) for m in meshes[:-1])])
        return Triangles(
            np.vstack([m.vertices for m in meshes]),
            np.vstack([m.faces + o for m, o in zip(meshes, offsets, strict=True)]),
        )


def directed_edges(faces: Indices) -> Indices:
    """The three sides of each triangle (m, 3) as it turns, (3 m, 2)."""
    return faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
