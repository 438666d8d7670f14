"""Flat faces cut in triangles, and triangles mapped onto a surface split until they keep to it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

from perfqr_cad.errors import KernelError
from perfqr_cad.geometry.arrays import Array, Indices, Mask
from perfqr_cad.geometry.triangles import directed_edges

# The middle of a triangle strays by up to 4/3 of what its sides' middles do on a sphere.
CAP_SHARE = 0.75
# Corners of a face from which it pays to begin with the plain Delaunay triangulation.
MANY = 20_000
BASE = 1 << 31  # above any number of corners
MOST_ROUNDS = 30  # of halving: far more than any smooth surface takes


def delaunay(polygons: Sequence[Array]) -> Indices:
    """Constrained Delaunay triangles (m, 3), counter-clockwise, of the first polygon less the others.

    Indices count the corners of all polygons in turn. Raises `KernelError` when the polygons cross or touch.

    >>> len(delaunay([np.array([[0.0, 0.0], [3.0, 0.0], [3.0, 2.0], [0.0, 2.0]])]))
    2
    """
    outline = shapely.Polygon(polygons[0], list(polygons[1:]))
    if not outline.is_valid:
        raise KernelError(
            f"the outline is no simple region ({shapely.is_valid_reason(outline)}): part its loops"
        )
    points = np.vstack(polygons)
    if len(points) > MANY:
        patched = _patched(outline, polygons, points)
        if len(patched) == len(points) + 2 * len(polygons) - 4:  # what Euler's formula asks for
            return patched
    return _cut(np.array([outline]), points)


def _cut(regions: NDArray[np.object_], points: Array) -> Indices:
    """Constrained Delaunay triangles of some regions, whose corners are among the points.

    GEOS gives all of them clockwise. Flat ones, between corners in a line, stay: without them gaps would.
    """
    return _indexed(shapely.constrained_delaunay_triangles(regions), points)[:, ::-1]


def _indexed(triangles: Any, points: Array) -> Indices:
    """Triangles by the places of their corners among the points."""
    corners = shapely.get_coordinates(triangles)  # the first corner of each repeated
    return _found(corners.reshape(-1, 4, 2)[:, :3].reshape(-1, 2), points).reshape(-1, 3)


def _patched(outline: shapely.Polygon, polygons: Sequence[Array], points: Array) -> Indices:
    """The same in less than quadratic time: the plain Delaunay triangles of all corners that no side of the
    outline runs across, and the gaps between them cut by themselves.

    What it gives may lack triangles where the plain triangulation has flat ones.
    """
    rim = np.concatenate(_sides(polygons))
    kept = _uncrossed(outline, rim, points)
    own = directed_edges(kept)
    known = np.sort(_key(own))
    # Gaps have the sides of the outline on their left that no kept triangle has, and kept triangles around.
    bare = rim[~among(_key(rim), known)]
    shared = among(_key(own[:, ::-1]), known) | among(_key(own), np.sort(_key(rim)))
    open_sides = np.concatenate([bare, own[~shared][:, ::-1]])
    if not len(open_sides):
        return kept
    pieces = shapely.polygonize(np.asarray(shapely.linestrings(points[open_sides])))
    gaps = np.asarray(shapely.orient_polygons(shapely.get_parts(pieces)))
    rings = shapely.get_exterior_ring(gaps)
    side = [_found(shapely.get_coordinates(shapely.get_point(rings, k)), points) for k in (0, 1)]
    gaps = gaps[among(_key(np.column_stack(side)), np.sort(_key(open_sides)))]
    return np.concatenate([kept, _cut(gaps, points)])


def _uncrossed(outline: shapely.Polygon, rim: Indices, points: Array) -> Indices:
    """The Delaunay triangles of all points that lie in the outline, to the left of its sides `rim` (n, 2)."""
    faces = _turned(_indexed(shapely.delaunay_triangles(shapely.MultiPoint(points)), points), points)
    sides = directed_edges(faces)
    either = np.sort(np.concatenate([_key(sides), _key(sides[:, ::-1])]))
    missing = points[rim[~among(_key(rim), either)]]
    tree = shapely.STRtree(np.asarray(shapely.polygons(points[faces])))
    _, crossed = tree.query(np.asarray(shapely.linestrings(missing)), predicate="crosses")
    whole = np.ones(len(faces), np.bool_)
    whole[crossed] = False
    inside, outside = (
        np.reshape(among(_key(sides), np.sort(_key(way))), (-1, 3)).any(axis=1) for way in (rim, rim[:, ::-1])
    )
    unknown = np.flatnonzero(whole & ~inside & ~outside)
    shapely.prepare(outline)
    within = shapely.contains_xy(outline, *points[faces[unknown]].mean(axis=1).T)
    return faces[np.union1d(np.flatnonzero(whole & inside), unknown[within])]


def _sides(polygons: Sequence[Array]) -> list[Indices]:
    """The sides (n, 2) of each polygon by its corners' places among all, the region to the left."""
    sides: list[Indices] = []
    first = 0
    for i, polygon in enumerate(polygons):
        x, y = (polygon - polygon[0]).T
        ccw = float(x @ np.roll(y, -1) - y @ np.roll(x, -1)) > 0
        corner = first + np.arange(len(polygon))
        side = np.column_stack([corner, np.roll(corner, -1)])
        sides.append(side if ccw == (i == 0) else side[:, ::-1])
        first += len(polygon)
    return sides


def _key(sides: Indices) -> Indices:
    """(n,) one number for each side (n, 2)."""
    return sides[:, 0] * BASE + sides[:, 1]


def among(numbers: Indices, known: Indices) -> Mask:
    """Whether numbers are among others, which are sorted; `numpy.isin` takes ten times as long."""
    return known[np.minimum(np.searchsorted(known, numbers), len(known) - 1)] == numbers


def _found(wanted: Array, points: Array) -> Indices:
    """The places of some points among all, by their exact values."""
    known = complex_of(points)
    order = np.argsort(known)
    return order[np.searchsorted(known[order], complex_of(wanted))]


def _turned(faces: Indices, points: Array) -> Indices:
    """Triangles turned counter-clockwise, without flat ones."""
    a, b, c = (points[faces[:, i]] for i in range(3))
    area = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    faces = np.where((area < 0)[:, None], faces[:, ::-1], faces)
    return faces[area != 0]


def refined(
    uv: Array, faces: Indices, place: Callable[[Array], Array], chord_mm: float
) -> tuple[Array, Indices]:
    """Split inner edges at their midpoints until the mapped triangles keep the chord tolerance.

    Boundary edges are never split: the walls share them. Raises `KernelError` on a creased surface.
    """
    for _ in range(MOST_ROUNDS):
        sides = np.sort(directed_edges(faces), axis=1)
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
    """How far mapped edges stray from their chords, at quarters: the middle alone is blind to an S."""
    start, end = uv[ends[:, 0]], uv[ends[:, 1]]
    mapped = place(uv)
    first, last = mapped[ends[:, 0]], mapped[ends[:, 1]]
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
