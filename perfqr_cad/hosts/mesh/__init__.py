"""Codes in triangle meshes: read, mend, hollow, find the place, carve; or fit an exact panel.

Meshes come from files or memory and leave as meshes. What is exact is made in `hosts/step` from the panel.
"""

from perfqr_cad.geometry.mesh_files import read_mesh
from perfqr_cad.hosts.mesh.mesh_target import MeshTarget

__all__ = ["MeshTarget", "read_mesh"]
