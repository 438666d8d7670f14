"""The meshes of tiles: each kind of tile is meshed once, however many of it there are."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry import LinearRing, LineString, Polygon

from perfqr_cad.structure.mesh.gmsh_mesher import Face, triangulate_all
from perfqr_cad.structure.mesh.seeding import MeshSize, seed
from perfqr_cad.structure.mesh.tiling import TileContent, Tiling
from perfqr_cad.structure.mesh.triangle import Floats, Ints, Mesh, with_middles

Flags = NDArray[np.bool_]
Side = frozenset[tuple[float, ...]]


@dataclass(frozen=True)
class TileMesh:
    """The mesh of a tile about its centre: `nodes` (n, 2) in mm, corner nodes first, `corners` of them, and
    six-node `elements` (m, 6) with the `classes` (m,) of their material.

    `seam` (n,) tells which nodes lie on the tile's border. There `halves` (n, 2), in half units, is exact.
    """

    nodes: Floats
    elements: Ints
    classes: Ints
    corners: int
    seam: Flags
    halves: Ints

    @property
    def mesh(self) -> Mesh:
        """The tile's mesh by itself."""
        return Mesh(self.nodes, self.elements, self.corners)


class TileMeshes:
    """TileMeshes by content, made when first asked for. Mutable: it grows, and may serve many analyses."""

    def __init__(self, mesh_size: MeshSize) -> None:
        self.mesh_size = mesh_size
        self._known: dict[tuple[int, int, bytes], TileMesh] = {}

    def of(self, tiling: Tiling) -> list[TileMesh]:
        """The tile_mesh of each content. New ones are meshed in one go."""
        keys = [(tiling.lattice.half, tiling.low, content.key) for content in tiling.contents]
        new = [k for k, key in enumerate(keys) if key not in self._known]
        faces = [_faces(tiling.contents[k], tiling, self.mesh_size) for k in new]
        meshes = iter(triangulate_all([face for tile in faces for face, _ in tile], self.mesh_size.edge_mm))
        for k, tile in zip(new, faces, strict=True):
            parts = [(*next(meshes), index) for _, index in tile]
            self._known[keys[k]] = _tile_mesh(parts, tiling)
        return [self._known[key] for key in keys]


def _faces(content: TileContent, tiling: Tiling, mesh_size: MeshSize) -> list[tuple[Face, int]]:
    """The pieces of a tile, outlines thinned and seeded with nodes, in mm, each with its class."""
    unit, low, high = tiling.lattice.unit_mm, tiling.low, tiling.low + 2 * tiling.lattice.half
    pieces = [
        (piece, index)
        for index in range(len(content.corners))
        for piece in _pieces(content.edges[content.classes == index], content.corners[index], low, high)
    ]
    shared = _shared([piece for piece, _ in pieces])
    tolerance = mesh_size.tolerance_mm / unit
    thick = [(piece, index) for piece, index in pieces if 2 * piece.area / piece.length >= tolerance]
    rings = [
        [_thinned(ring, shared, low, high, tolerance) for ring in shapely.get_rings(p)] for p, _ in thick
    ]
    sides = Counter(side for loops in rings for loop in loops for side in _sides(loop))
    faces = []
    for loops, (_, index) in zip(rings, thick, strict=True):
        flags = [
            np.array([sides[side] > 1 or _on_border(side, low, high) for side in _sides(p)]) for p in loops
        ]
        nodes = [
            unit * seed(points, pinned, mesh_size.scaled(1.0 / unit))
            for points, pinned in zip(loops, flags, strict=True)
        ]
        faces.append((Face(tuple(nodes)), index))
    return faces


def _sides(points: Floats) -> list[Side]:
    """The sides of a loop, from each of its points, the same from both sides."""
    ends = list(map(tuple, points.tolist()))
    return [frozenset(side) for side in zip(ends, ends[1:] + ends[:1], strict=True)]


def _on_border(side: Side, low: int, high: int) -> bool:
    """Whether a side of a piece lies on the tile's border."""
    (x0, y0), (x1, y1) = side
    return (x0 == x1 and x0 in (low, high)) or (y0 == y1 and y0 in (low, high))


def _pieces(edges: Ints, corners: Flags, low: int, high: int) -> list[Polygon]:
    """What lies to the left of directed edges in the square between low and high."""
    square = [(low, low), (high, low), (high, high), (low, high)]
    if not len(edges):
        return [Polygon(square)] if corners.all() else []
    ends = edges.reshape(-1, 2)
    stops = np.unique(np.concatenate([ends[((ends == low) | (ends == high)).any(axis=1)], square]), axis=0)
    x, y = stops.T
    round_the_border = np.argsort(
        np.select(
            [y == low, x == high, y == high],
            [x - low, high + y - 2 * low, 3 * high - x - 2 * low],
            4 * high - y - 3 * low,
        )
    )
    border = stops[round_the_border]
    walls = shapely.linestrings(edges.reshape(-1, 2, 2).astype(float))
    sides = shapely.linestrings(np.stack([border, np.roll(border, -1, axis=0)], axis=1).astype(float))
    directed = set(map(tuple, edges.tolist()))
    found = []
    lines = np.append(np.asarray(walls), np.asarray(sides))
    for face in shapely.get_parts(shapely.polygonize(lines)):
        face = shapely.orient_polygons(face)
        for ring in shapely.get_rings(face):
            points = shapely.get_coordinates(ring)
            steps = np.hstack([points[:-1], points[1:]]).astype(np.int64)
            if not directed.isdisjoint(map(tuple, steps.tolist())):
                found.append(face)
                break
    return found


def _shared(pieces: Sequence[Polygon]) -> set[tuple[float, float]]:
    """Points that belong to more than one piece."""
    if len(pieces) < 2:
        return set()
    points = np.concatenate([np.unique(shapely.get_coordinates(piece), axis=0) for piece in pieces])
    found, counts = np.unique(points, axis=0, return_counts=True)
    return set(map(tuple, found[counts > 1].tolist()))


def _thinned(
    ring: LinearRing, shared: set[tuple[float, float]], low: int, high: int, tolerance: float
) -> Floats:
    """The points (k, 2) of a ring without those that its shape does not need; what pieces share is kept."""
    points = shapely.get_coordinates(ring)[:-1]
    kept = ((points == low) | (points == high)).any(axis=1)
    if shared:
        kept |= np.array([tuple(point) in shared for point in points.tolist()])
    if not kept.any():
        return shapely.get_coordinates(shapely.simplify(ring, tolerance))[:-1]
    first = int(np.argmax(kept))
    closed = np.vstack([np.roll(points, -first, axis=0), points[first]])
    stops = np.append(np.flatnonzero(np.roll(kept, -first)), len(points))
    chains = [closed[start : end + 1] for start, end in pairwise(stops)]
    return np.concatenate(
        [
            shapely.get_coordinates(shapely.simplify(LineString(chain), tolerance))[:-1]
            if len(chain) > 2
            else chain[:-1]
            for chain in chains
        ]
    )


def _tile_mesh(parts: list[tuple[Floats, Ints, int]], tiling: Tiling) -> TileMesh:
    """The meshes (vertices in mm, triangles, class) of a tile's pieces as one, joined where they touch."""
    unit = tiling.lattice.unit_mm
    vertices = np.concatenate([part[0] for part in parts] or [np.zeros((0, 2))])
    starts = np.cumsum([0, *(len(part[0]) for part in parts)])
    triangles = np.concatenate(
        [part[1] + start for part, start in zip(parts, starts, strict=False)] or [np.zeros((0, 3), np.int64)]
    )
    classes = np.repeat([part[2] for part in parts], [len(part[1]) for part in parts])
    units, first, same = np.unique(
        np.rint(vertices / unit).astype(np.int64), axis=0, return_index=True, return_inverse=True
    )
    elements, ends = with_middles(same.reshape(-1)[triangles], len(units))
    vertices = vertices[first]
    halves = np.concatenate([2 * units, units[ends[:, 0]] + units[ends[:, 1]]])
    border = np.array([tiling.low, tiling.low + 2 * tiling.lattice.half]) * 2
    return TileMesh(
        nodes=np.vstack([vertices, 0.5 * (vertices[ends[:, 0]] + vertices[ends[:, 1]])]),
        elements=elements,
        classes=classes.astype(np.int64),
        corners=len(units),
        seam=np.asarray(np.isin(halves, border).any(axis=1)),
        halves=halves,
    )
