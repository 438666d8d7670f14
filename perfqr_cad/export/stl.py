"""Binary STL of the part, millimetres; a mesh has one body and no colour, so a backing is left out."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from perfqr_cad.export.design_view import DesignView

# Must not begin with "solid", the mark of the text form; 80 bytes.
HEADER = b"binary STL, millimetres, perfqr-cad".ljust(80)
FACET = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def write(design: DesignView, path: Path) -> None:
    """Write the closed mesh of the part; the bytes depend on the mesh alone."""
    triangles = design.solid.triangles
    corners = triangles.vertices.astype("<f4")[triangles.faces]
    corners = corners[~_collapsed(corners)]
    a, b, c = np.moveaxis(corners.astype(np.float64), 1, 0)
    normals = np.cross(b - a, c - a)
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    facets = np.zeros(len(corners), FACET)
    facets["normal"] = normals / np.where(length > 0, length, 1.0)
    facets["corners"] = corners
    path.write_bytes(HEADER + np.uint32(len(facets)).astype("<u4").tobytes() + facets.tobytes())


def _collapsed(corners: np.ndarray) -> np.ndarray:
    """Triangles that lost an edge to single precision: without them the mesh is closed as before."""
    following = np.roll(corners, -1, axis=1)
    return np.any(np.all(corners == following, axis=2), axis=1)
