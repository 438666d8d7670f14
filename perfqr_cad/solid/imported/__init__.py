"""Codes in the walls of imported solids (STEP): find the place, lay the code on it, punch the holes."""

from perfqr_cad.solid.imported.meshing import mesh_shape
from perfqr_cad.solid.imported.target import ImportedFace

__all__ = ["ImportedFace", "mesh_shape"]
