"""Plates for the tests: light modules as material, square holes, cut from shapely polygons."""

import numpy as np
import segno
import trimesh
from shapely.geometry import box
from shapely.ops import unary_union

from perfqr_cad.geometry import Triangles


def modules(text: str, version: int = 5, level: str = "m") -> np.ndarray:
    return np.array([list(row) for row in segno.make(text, version=version, error=level).matrix], bool)


def plate(dark: np.ndarray, size_mm: float, thickness_mm: float, quiet: int = 4) -> Triangles:
    """Front face at z = thickness; holes a hair too large, so that no two pieces touch at corners."""
    n = len(dark)
    m = size_mm / (n + 2 * quiet)
    holes = unary_union([
        box((c - n / 2) * m, (n / 2 - r - 1) * m, (c + 1 - n / 2) * m, (n / 2 - r) * m)
        for r, c in zip(*np.nonzero(dark), strict=True)
    ]).buffer(0.005, join_style="mitre")  # fmt: skip
    half = size_mm / 2
    material = box(-half, -half, half, half).difference(holes)
    pieces = getattr(material, "geoms", [material])
    mesh = trimesh.util.concatenate([trimesh.creation.extrude_polygon(p, thickness_mm) for p in pieces])
    return Triangles(mesh.vertices, mesh.faces)
