"""Codes in the walls of imported solids (STEP): find the place, map the code onto it, punch the holes.

Every hole runs between the host's own exact faces. Reading STEP itself is in `solid/step`; nothing here knows
of meshes that were imported as such.
"""

from perfqr_cad.hosts.step.imported_face import ImportedFace
from perfqr_cad.hosts.step.meshing import mesh_shape

__all__ = ["ImportedFace", "mesh_shape"]
