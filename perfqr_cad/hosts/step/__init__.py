"""Codes in the walls of imported solids (STEP): find the place, lay the code on it, punch the holes."""

from perfqr_cad.hosts.step.imported_face import ImportedFace
from perfqr_cad.hosts.step.meshing import mesh_shape

__all__ = ["ImportedFace", "mesh_shape"]
