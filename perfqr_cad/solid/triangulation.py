"""Flat faces cut in triangles, and triangles laid on a surface split until they keep to it."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import shapely
from numpy.typing import NDArray

from perfqr_cad.errors import KernelError

from .sampling import Array, Indices

# The middle of a triangle strays by up to 4/3 of what its sides' middles do on a sphere.
CAP_SHARE = 0.75
MOST_ROUNDS = 30  # of halving: far more than any smooth surface takes


def delaunay(polygons: Sequence[Array]) -> Indices:
    """Constrained Delaunay triangles (m, 3), counter-clockwise, of the first polygon less the others.

    Indices count the corners of all polygons in turn. Raises `KernelError` when the polygons cross or touch.
    """
    outline = shapely.Polygon(polygons[0], list(polygons[1:]))
    if not outline.is_valid:
        raise KernelError(
            f"the outline is no simple region ({shapely.is_valid_reason(outline)}): part its loops"
        )
    corners = shapely.get_coordinates(shapely.constrained_delaunay_triangles(outline)).reshape(-1, 4, 2)[
        :, :3
    ]
    # Triangles come as coordinates; each corner is found again by its exact value.
    points, wanted = complex_of(np.vstack(polygons)), complex_of(corners.reshape(-1, 2))
    order = np.argsort(points)
    faces = order[np.searchsorted(points[order], wanted)].reshape(-1, 3)
    a, b, c = (points[faces[:, i]] for i in range(3))
    clockwise = ((b - a).conjugate() * (c - a)).imag < 0
    faces[clockwise] = faces[clockwise][:, ::-1]
    return faces


def refined(
    uv: Array, faces: Indices, place: Callable[[Array], Array], chord_mm: float
) -> tuple[Array, Indices]:
    """Split inner edges at their midpoints until the laid triangles keep the chord tolerance.

    Boundary edges are never split: the walls share them. Raises `KernelError` on a creased surface.
    """
    for _ in range(MOST_ROUNDS):
        sides = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        keys, side, uses = np.unique(
            sides[:, 0] * len(uv) + sides[:, 1], return_inverse=True, return_counts=True
        )
        ends = np.column_stack([keys // len(uv), keys % len(uv)])
        sagitta = _sagitta(uv, ends, place)
        split = (uses == 2) & (sagitta > CAP_SHARE * chord_mm)
        if not split.any():
            return uv, faces
        fresh = np.where(split, len(uv) + np.cumsum(split) - 1, -1)
        uv = np.vstack([uv, uv[ends[split]].mean(axis=1)])
        faces = _split(faces, fresh[side].reshape(-1, 3))
    raise KernelError(
        f"the surface does not flatten to triangles within {chord_mm:g} mm: move the code away from creases, "
        "or allow a coarser mesh"
    )


def _sagitta(uv: Array, ends: Indices, place: Callable[[Array], Array]) -> Array:
    """How far laid edges stray from their chords, at quarters: the middle alone is blind to an S."""
    start, end = uv[ends[:, 0]], uv[ends[:, 1]]
    laid = place(uv)
    first, last = laid[ends[:, 0]], laid[ends[:, 1]]
    strays = [
        np.linalg.norm(place((1 - t) * start + t * end) - ((1 - t) * first + t * last), axis=1)
        for t in (0.25, 0.5, 0.75)
    ]
    return np.max(strays, axis=0)


def _split(faces: Indices, middles: Indices) -> Indices:
    """Triangles cut at the given midpoints of their sides (−1: side kept), in 1, 2, 3 or 4 pieces."""
    marked = middles >= 0
    count = marked.sum(axis=1)
    pieces = [faces[count == 0]]
    for times, lone in ((1, True), (2, False)):
        rows = count == times
        # Turn each triangle so that side 0 is the only one cut, or the only one kept.
        first = np.argmax(marked[rows] == lone, axis=1)
        turn = (first[:, None] + np.arange(3)) % 3
        (a, b, c), (p, q, r) = (np.take_along_axis(x[rows], turn, axis=1).T for x in (faces, middles))
        if lone:
            pieces += [np.column_stack(t) for t in ((a, p, c), (p, b, c))]
        else:
            pieces += [np.column_stack(t) for t in ((a, b, q), (a, q, r), (r, q, c))]
    (a, b, c), (p, q, r) = faces[count == 3].T, middles[count == 3].T
    pieces += [np.column_stack(t) for t in ((a, p, r), (p, b, q), (r, q, c), (p, q, r))]
    return np.vstack(pieces)


def complex_of(points: Array) -> NDArray[np.complex128]:
    """Points of the plane as complex numbers, which sort and compare as pairs."""
    return points[:, 0] + 1j * points[:, 1]
