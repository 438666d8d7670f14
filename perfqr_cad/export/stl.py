"""Binary STL, millimetres: one body a file, and no colour; a backing is left out, or has its own file."""

from __future__ import annotations

import re
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from perfqr_cad.export.design_view import DesignView

if TYPE_CHECKING:
    from perfqr_cad.solid import Solid

# Must not begin with "solid", the mark of the text form; 80 bytes.
HEADER = b"binary STL, millimetres, perfqr-cad".ljust(80)
FACET = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def write(design: DesignView, path: Path, *, body: Solid | None = None) -> None:
    """Write the closed mesh of the part, or of another body where it lies; the bytes depend on the mesh
    alone."""
    triangles = (body or design.solid).triangles
    corners = triangles.vertices.astype("<f4")[triangles.faces]
    corners = corners[~_collapsed(corners)]
    a, b, c = np.moveaxis(corners.astype(np.float64), 1, 0)
    normals = np.cross(b - a, c - a)
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    facets = np.zeros(len(corners), FACET)
    facets["normal"] = normals / np.where(length > 0, length, 1.0)
    facets["corners"] = corners
    path.write_bytes(HEADER + np.uint32(len(facets)).astype("<u4").tobytes() + facets.tobytes())


def further(design: DesignView, path: Path) -> dict[Path, Solid]:
    """Files beside that of the part, each for another body and named after it."""
    files: dict[Path, Solid] = {}
    for body in design.solid.extras:
        plain = re.sub(r"[^\w-]+", "-", body.name).strip("-") or "body"
        stem = f"{path.stem}-{plain}"
        names = (path.with_stem(stem if k == 1 else f"{stem}-{k}") for k in count(1))
        files[next(name for name in names if name not in files)] = body
    return files


def _collapsed(corners: np.ndarray) -> np.ndarray:
    """Triangles that lost an edge to single precision: without them the mesh is closed as before."""
    following = np.roll(corners, -1, axis=1)
    return np.any(np.all(corners == following, axis=2), axis=1)
