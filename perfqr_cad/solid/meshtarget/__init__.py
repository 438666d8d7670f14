"""Codes in triangle meshes: read, mend, hollow, find the place, carve; or fit an exact panel."""

from perfqr_cad.surface.mesh_files import read_mesh
from perfqr_cad.solid.meshtarget.target import MeshTarget

__all__ = ["MeshTarget", "read_mesh"]
