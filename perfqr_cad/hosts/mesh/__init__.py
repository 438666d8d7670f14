"""Codes in triangle meshes: read, mend, hollow, find the place, carve; or fit an exact panel.

Meshes come from files or memory and leave as meshes. What is exact is made in `hosts/step` from the panel.
"""

from perfqr_cad.hosts.mesh.mesh_target import MeshTarget
from perfqr_cad.hosts.mesh.reader import read_mesh

__all__ = ["MeshTarget", "read_mesh"]
