"""The only module that talks to gmsh: outlines in, triangles out; B-rep files in, tetrahedra out.

gmsh keeps one global state per process, so every call holds a lock, works in a model of its own, and puts
back the options it changed. `interruptible=False` keeps gmsh from replacing Python's signal handlers, which
also lets it run outside the main thread.
"""

from __future__ import annotations

import threading
from collections.abc import Generator
from contextlib import contextmanager
from types import ModuleType

import numpy as np
from numpy.typing import NDArray
from shapely.geometry import LinearRing, Polygon

from perfqr_cad.errors import AnalysisError
from perfqr_cad.structure.seeding import seed
from perfqr_cad.structure.t6 import Floats, Ints, Mesh, quadratic

_LOCK = threading.Lock()
_TRIANGLE, _TETRAHEDRON_10 = 2, 11  # gmsh element types
_DELAUNAY, _DELAUNAY_3D = 5, 1  # gmsh Mesh.Algorithm, Mesh.Algorithm3D: the fastest sound ones here


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


def triangulate(polygon: Polygon, size_mm: float, corner_mm: float | None = None) -> Mesh:
    """A six-node triangle mesh of a clean polygon, edges up to about `size_mm`, conforming to its outline.

    Re-entrant corners, where stress is singular, get edges of `corner_mm`.

    Raises:
        AnalysisError: gmsh failed, or the mesh does not cover the polygon.
    """
    options = {
        "General.NumThreads": 1,  # the same mesh on every machine
        "Mesh.Algorithm": _DELAUNAY,
        "Mesh.MeshSizeMax": size_mm,
        "Mesh.MeshSizeMin": 0.0,
        "Mesh.MeshSizeFromPoints": 0,
        "Mesh.MeshSizeExtendFromBoundary": 1,
    }
    with _session(options) as gmsh:
        loops = [
            _curve_loop(gmsh, ring, size_mm, corner_mm or size_mm)
            for ring in (polygon.exterior, *polygon.interiors)
        ]
        gmsh.model.geo.addPlaneSurface(loops)
        gmsh.model.geo.synchronize()
        gmsh.model.mesh.generate(2)
        vertices, triangles = _elements(gmsh, _TRIANGLE, 3)
    mesh = quadratic(vertices[:, :2], triangles)
    meshed, wanted = float(mesh.area_mm2.sum()), polygon.area
    if abs(meshed - wanted) > 1e-6 * wanted:
        raise AnalysisError(
            f"the mesh covers {meshed:.4f} mm² of {wanted:.4f} mm²: the outline touches or crosses itself"
        )
    return mesh


def _curve_loop(gmsh: ModuleType, ring: LinearRing, size_mm: float, corner_mm: float) -> int:
    geo = gmsh.model.geo
    outline = seed(np.asarray(ring.coords)[:-1], size_mm, corner_mm)
    points = [geo.addPoint(x, y, 0.0, size_mm) for x, y in outline.tolist()]
    lines = [geo.addLine(a, b) for a, b in zip(points, points[1:] + points[:1], strict=True)]
    for line in lines:
        geo.mesh.setTransfiniteCurve(line, 2)
    return geo.addCurveLoop(lines)


def _elements(gmsh: ModuleType, kind: int, nodes_per_element: int) -> tuple[Floats, Ints]:
    """Coordinates (n, 3) of the nodes in use and connectivity of the elements of one kind."""
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    _, flat = gmsh.model.mesh.getElementsByType(kind)
    if not len(flat):
        raise AnalysisError("gmsh made no elements: the region is empty or crosses itself")
    used, connectivity = np.unique(np.asarray(flat, np.int64), return_inverse=True)
    row_of_tag: NDArray[np.int64] = np.empty(int(tags.max()) + 1, np.int64)
    row_of_tag[tags.astype(np.int64)] = np.arange(len(tags))
    return coordinates.reshape(-1, 3)[row_of_tag[used]], connectivity.reshape(-1, nodes_per_element)
