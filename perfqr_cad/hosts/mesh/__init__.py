"""Codes in triangle meshes: read, mend, hollow, find the place, carve; or fit an exact panel."""

from perfqr_cad.geometry.mesh_files import read_mesh
from perfqr_cad.hosts.mesh.target import MeshTarget

__all__ = ["MeshTarget", "read_mesh"]
