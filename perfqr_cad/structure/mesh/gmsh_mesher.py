"""The only module that talks to gmsh: outlines in, triangles out.

gmsh keeps one global state per process, so every call holds a lock, works in a model of its own, and puts
back the options it changed. `interruptible=False` keeps gmsh from replacing Python's signal handlers, which
also lets it run outside the main thread.
"""

from __future__ import annotations

import threading
from collections.abc import Generator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from types import ModuleType

import numpy as np
import shapely
from shapely.geometry import Polygon

from perfqr_cad.errors import AnalysisError
from perfqr_cad.structure.mesh.seeding import MeshSize, seed
from perfqr_cad.structure.mesh.triangle import Floats, Ints, Mesh, quadratic, twice_areas

_LOCK = threading.Lock()
_DELAUNAY = 5  # gmsh Mesh.Algorithm: the fastest sound one here


@contextmanager
def _session(options: dict[str, float]) -> Generator[ModuleType]:
    """gmsh with a fresh model and these options; everything is as before afterwards."""
    import gmsh

    with _LOCK:
        mine = not gmsh.isInitialized()
        if mine:
            gmsh.initialize(readConfigFiles=False, interruptible=False)
        before = {name: gmsh.option.getNumber(name) for name in ("General.Terminal", *options)}
        gmsh.option.setNumber("General.Terminal", 0)
        for name, value in options.items():
            gmsh.option.setNumber(name, value)
        gmsh.model.add("perfqr")
        try:
            yield gmsh
        except AnalysisError:
            raise
        except Exception as error:
            raise AnalysisError(f"gmsh could not mesh the region: {error}") from error
        finally:
            gmsh.model.remove()
            for name, value in before.items():
                gmsh.option.setNumber(name, value)
            if mine:
                gmsh.finalize()


@dataclass(frozen=True)
class Face:
    """A plane face by its loops of nodes (k, 2) in mm: the outer one, then holes."""

    loops: tuple[Floats, ...]


def triangulate(polygon: Polygon, size_mm: float, corner_mm: float | None = None) -> Mesh:
    """A six-node triangle mesh of a clean polygon, edges up to about `size_mm`, conforming to its outline.

    Re-entrant corners, where stress is singular, get edges of `corner_mm`.

    Raises:
        AnalysisError: gmsh failed, or the mesh does not cover the polygon.
    """
    loops = []
    for ring in shapely.get_rings(shapely.orient_polygons(polygon)):
        points = shapely.get_coordinates(ring)[:-1]
        loops.append(
            seed(points, np.zeros(len(points), bool), MeshSize(size_mm, corner_mm or size_mm, 0.0, 0.0))
        )
    return quadratic(*triangulate_all([Face(tuple(loops))], size_mm)[0])


def triangulate_all(faces: Sequence[Face], size_mm: float) -> list[tuple[Floats, Ints]]:
    """Vertices (n, 2) and triangles (m, 3) of each face, edges up to about `size_mm`.

    Loops are kept as they are; no node is put on them.

    Raises:
        AnalysisError: gmsh failed, or a mesh does not cover its face.
    """
    options = {
        "General.NumThreads": 1,  # the same mesh on every machine
        "Mesh.Algorithm": _DELAUNAY,
        "Mesh.MeshSizeMax": size_mm,
        "Mesh.MeshSizeMin": 0.0,
        "Mesh.MeshSizeFromPoints": 0,
        "Mesh.MeshSizeExtendFromBoundary": 1,
    }
    if not faces:
        return []
    with _session(options) as gmsh:
        surfaces = [
            gmsh.model.geo.addPlaneSurface([_curve_loop(gmsh, loop) for loop in face.loops]) for face in faces
        ]
        gmsh.model.geo.synchronize()
        gmsh.model.mesh.generate(2)
        meshes = [_triangles(gmsh, surface) for surface in surfaces]
    for face, (vertices, triangles) in zip(faces, meshes, strict=True):
        outer, *holes = face.loops
        # A sliver of a hole may have turned over as its corners were put on the grid.
        wanted = abs(_area(outer)) - sum(abs(_area(hole)) for hole in holes)
        meshed = float(np.abs(twice_areas(vertices, triangles)).sum()) / 2
        if abs(meshed - wanted) > 1e-6 * wanted:
            x, y = face.loops[0][0]
            raise AnalysisError(
                f"the mesh covers {meshed:.4f} mm² of {wanted:.4f} mm² at ({x:.2f}, {y:.2f}) mm:"
                " the outline touches or crosses itself"
            )
    return meshes


def _curve_loop(gmsh: ModuleType, outline: Floats) -> int:
    geo = gmsh.model.geo
    points = [geo.addPoint(x, y, 0.0) for x, y in outline.tolist()]
    lines = [geo.addLine(a, b) for a, b in zip(points, points[1:] + points[:1], strict=True)]
    for line in lines:
        geo.mesh.setTransfiniteCurve(line, 2)
    return geo.addCurveLoop(lines)


def _area(loop: Floats) -> float:
    x, y = loop.T
    return float(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2


def _triangles(gmsh: ModuleType, surface: int) -> tuple[Floats, Ints]:
    tags, coordinates, _ = gmsh.model.mesh.getNodes(2, surface, includeBoundary=True)
    _, (flat,) = gmsh.model.mesh.getElements(2, surface)[1:]
    used, first = np.unique(tags, return_index=True)
    return coordinates.reshape(-1, 3)[first, :2], np.searchsorted(used, flat).reshape(-1, 3)
