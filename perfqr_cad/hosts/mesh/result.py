"""A carved mesh as the project's `Solid`: triangles only, checked."""

from __future__ import annotations

from perfqr_cad.errors import KernelError
from perfqr_cad.geometry import Triangles
from perfqr_cad.hosts.manifold import manifold_of
from perfqr_cad.solid.shape import Solid


def mesh_solid(mesh: Triangles, name: str, notes: tuple[str, ...] = ()) -> Solid:
    """Raises `KernelError` unless the mesh is closed."""
    body = manifold_of(mesh)
    if not mesh.closed:
        raise KernelError("the carved mesh is not closed: move the code a little")
    return Solid(
        exact=None,
        triangles=mesh,
        valid=True,
        solids=1,
        faces=len(mesh.faces),
        edges=len(mesh.faces) * 3 // 2,
        volume_mm3=float(body.volume()),
        bbox_mm=mesh.bounds_mm,
        notes=notes,
        name=name,
    )
