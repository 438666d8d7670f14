"""Closed meshes as manifold3d takes them, and back."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from perfqr_cad.errors import KernelError
from perfqr_cad.geometry import Triangles

if TYPE_CHECKING:
    from manifold3d import Manifold


def manifold_of(mesh: Triangles) -> Manifold:
    """manifold3d's form of a closed mesh. Raises `KernelError` when it is none."""
    import manifold3d

    made = manifold3d.Manifold(
        manifold3d.Mesh64(np.array(mesh.vertices, np.float64), np.array(mesh.faces, np.uint64))
    )
    if made.status() != manifold3d.Error.NoError:
        raise KernelError(f"the mesh is not a closed body ({made.status().name}): repair it first")
    return made


def triangles_of(manifold: Manifold) -> Triangles:
    """Triangles of a manifold."""
    mesh = manifold.to_mesh64()
    return Triangles(np.asarray(mesh.vert_properties)[:, :3], np.asarray(mesh.tri_verts))
