"""A solid body made into a shell of given thickness."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from perfqr_cad.errors import DesignError, KernelError
from perfqr_cad.geometry import Triangles
from perfqr_cad.geometry.arrays import Array, Mask
from perfqr_cad.hosts.body import Body, body_of_mesh
from perfqr_cad.hosts.manifold import manifold_of, triangles_of

CELLS_PER_WALL = 2.0  # grid cells across the wall
MOST_CELLS = 6_000_000  # of the distance grid, about 50 MB; a coarser grid serves larger bodies
LEAST_CELLS_PER_WALL = 1.0
BAND_CELLS = 1.5  # to each side of the wanted depth, distances are exact
SAMPLES_PER_CELL = 1.5  # spacing of the points that stand for the surface
SIMPLIFY_SHARE = 0.02  # of a cell: facets that lie flatter are joined
POCKET_SHARE = 1e-3  # of the cavity: smaller bubbles are left filled


def hollowed(mesh: Triangles, thickness_mm: float) -> Triangles:
    """The closed body less everything deeper than `thickness_mm` below its surface.

    The depth is a true distance, sampled on a grid and contoured; it errs by about (cell/4)²/thickness.
    Raises `DesignError` when nothing of the body is that deep, or the wall is too thin for the grid.
    """
    body = body_of_mesh(mesh)
    low, extent = mesh.vertices.min(axis=0), np.ptp(mesh.vertices, axis=0)
    cell = max(thickness_mm / CELLS_PER_WALL, float(np.prod(extent) / MOST_CELLS) ** (1 / 3))
    if cell * LEAST_CELLS_PER_WALL > thickness_mm:
        raise DesignError(
            f"a shell of {thickness_mm:g} mm is too thin for a body of {extent.max():.4g} mm: "
            f"take at least {cell * LEAST_CELLS_PER_WALL:.3g} mm"
        )
    depth = _depths(body, low, extent, cell, thickness_mm)
    if depth.max() <= thickness_mm:
        raise DesignError(
            f"no part of the body is deeper than {thickness_mm:g} mm: carve it as it is, or take a "
            f"thinner shell"
        )
    inner = _contour(depth, low, cell, thickness_mm)
    shell = manifold_of(mesh) - inner
    if len(shell.decompose()) < 1 or shell.volume() <= 0:
        raise KernelError("hollowing left nothing: take another thickness")
    return triangles_of(shell)


def _depths(body: Body, low: Array, extent: Array, cell: float, wanted_mm: float) -> Array:
    """Distance to the surface at grid nodes inside the body, 0 outside; exact in a band about the wanted
    depth."""
    from scipy.ndimage import distance_transform_edt
    from scipy.spatial import cKDTree

    counts = np.ceil(extent / cell).astype(int) + 2
    inside = _inside(body, low, counts, cell)
    depth = np.asarray(distance_transform_edt(inside)) * cell
    band = np.flatnonzero((np.abs(depth - wanted_mm) < BAND_CELLS * cell) & inside)
    nodes = low + (np.column_stack(np.unravel_index(band, inside.shape)) - 0.5) * cell
    surface = manifold_of(body.triangles).refine_to_length(cell / SAMPLES_PER_CELL)
    points = np.asarray(surface.to_mesh64().vert_properties)[:, :3]
    depth.ravel()[band] = cKDTree(points).query(nodes)[0]
    return depth


def _inside(body: Body, low: Array, counts: NDArray[np.int64], cell: float) -> Mask:
    """Which grid nodes lie inside: parity of crossings along columns in z."""
    x, y = (
        a.ravel()
        for a in np.meshgrid(*(low[i] + (np.arange(counts[i]) - 0.5) * cell for i in (0, 1)), indexing="ij")
    )
    # A shift that is no fraction of a cell keeps columns off vertices and edges of gridded meshes.
    shift = cell * np.array([1.7e-4, 2.3e-4])
    start = low[2] - 2 * cell
    origins = np.column_stack([x + shift[0], y + shift[1], np.full(x.size, start)])
    met = body.crossings(origins, np.tile([0.0, 0.0, 1.0], (len(origins), 1)))
    level = np.clip(np.ceil((met.distance_mm - 2 * cell) / cell + 0.5).astype(int), 0, counts[2] - 1)
    steps = np.zeros((len(origins), counts[2]), np.int32)
    np.add.at(steps, (met.ray, level), np.where(met.entering, 1, -1))
    return (np.cumsum(steps, axis=1) > 0).reshape(tuple(counts.tolist()))


def _contour(depth: Array, low: Array, cell: float, at_mm: float):
    """The closed surface where the depth is `at_mm`, without small bubbles."""
    import manifold3d
    from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
    from vtkmodules.vtkCommonDataModel import vtkImageData
    from vtkmodules.vtkFiltersCore import vtkFlyingEdges3D

    image = vtkImageData()
    image.SetDimensions(*(int(n) for n in depth.shape))
    image.SetSpacing(cell, cell, cell)
    image.SetOrigin(*(low - 0.5 * cell).tolist())
    image.GetPointData().SetScalars(numpy_to_vtk(depth.ravel(order="F"), deep=True))
    contour = vtkFlyingEdges3D()
    contour.SetInputData(image)
    contour.SetValue(0, at_mm)
    contour.ComputeNormalsOff()
    contour.Update()
    surface = contour.GetOutput()
    points = vtk_to_numpy(surface.GetPoints().GetData()).astype(np.float64)
    faces = np.asarray(vtk_to_numpy(surface.GetPolys().GetConnectivityArray()), np.int64).reshape(-1, 3)
    inner = Triangles(points, faces)
    inner = inner if inner.volume_mm3 > 0 else Triangles(points, inner.faces[:, ::-1])
    bubbles = manifold_of(inner).simplify(SIMPLIFY_SHARE * cell).decompose()
    greatest = max(b.volume() for b in bubbles)
    return manifold3d.Manifold.compose([b for b in bubbles if b.volume() > POCKET_SHARE * greatest])
