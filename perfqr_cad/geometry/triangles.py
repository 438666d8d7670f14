"""Closed triangle meshes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Triangles:
    """A closed triangle mesh, oriented outward: vertices (k, 3) in mm, faces (m, 3) of vertex indices."""

    vertices: Array
    faces: NDArray[np.int64]

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
    def closed(self) -> bool:
        """Whether every edge is used exactly once in each direction."""
        edges = self.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
        key = edges[:, 0] * len(self.vertices) + edges[:, 1]
        opposite = edges[:, 1] * len(self.vertices) + edges[:, 0]
        key.sort()
        opposite.sort()
        return bool((np.diff(key) > 0).all()) and np.array_equal(key, opposite)

    def joined(self, *others: Triangles) -> Triangles:
        """This mesh and others as one list of triangles; the bodies stay apart."""
        meshes = (self, *others)
        offsets = np.cumsum([0, *(len(m.vertices) for m in meshes[:-1])])
        return Triangles(
            np.vstack([m.vertices for m in meshes]),
            np.vstack([m.faces + o for m, o in zip(meshes, offsets, strict=True)]),
        )
