"""TileMeshes joined into one mesh: tile after tile, nodes on a common border counted once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from shapely.geometry import MultiPolygon, Polygon

from perfqr_cad.errors import AnalysisError
from perfqr_cad.structure.mesh.tile_meshes import Flags, TileMesh, TileMeshes
from perfqr_cad.structure.mesh.tiling import TileLattice, Tiling, cut
from perfqr_cad.structure.mesh.triangle import Ints, Mesh

AREA_TOLERANCE = 0.02  # thinning may move the outline, never lose a web


@dataclass(frozen=True)
class TileBlock:
    """All tiles of one mesh: their `nodes` (tiles, n) in the whole. Elements follow tile by tile."""

    tile_mesh: TileMesh
    nodes: Ints

    @property
    def elements(self) -> Ints:
        """Node numbers (tiles, m, 6)."""
        return self.nodes[:, self.tile_mesh.elements]


@dataclass(frozen=True)
class TiledMesh:
    """A mesh and the blocks that it is made of; `classes` (m,) are those of the elements' material."""

    mesh: Mesh
    blocks: tuple[TileBlock, ...]
    classes: Ints


def tiled_mesh(
    regions: Sequence[Polygon | MultiPolygon], lattice: TileLattice, tile_meshes: TileMeshes
) -> TiledMesh:
    """The mesh of a clean region that is parted by classes of material; `tile_meshes` learn its tiles.

    Raises:
        AnalysisError: gmsh failed, or the mesh does not cover the region.
    """
    tiling = cut(regions, lattice)
    tiled = join(tiling, tile_meshes.of(tiling))
    meshed, wanted = float(tiled.mesh.area_mm2.sum()), sum(region.area for region in regions)
    if abs(meshed - wanted) > AREA_TOLERANCE * wanted:
        raise AnalysisError(
            f"the mesh covers {meshed:.4f} mm² of {wanted:.4f} mm²: the outline touches or crosses itself"
        )
    return tiled


def join(tiling: Tiling, tile_meshes: Sequence[TileMesh]) -> TiledMesh:
    """The mesh of a tiling whose contents have these meshes."""
    used = [
        (tile_mesh, np.flatnonzero(tiling.content_of == k))
        for k, tile_mesh in enumerate(tile_meshes)
        if len(tile_mesh.elements)
    ]
    centres = tiling.centres - tiling.centres.min(axis=0)
    keys = [_keys(tile_mesh, centres[rows], 2 * tiling.lattice.half) for tile_mesh, rows in used]
    corner = [
        np.tile(np.arange(len(tile_mesh.nodes)) < tile_mesh.corners, len(rows)) for tile_mesh, rows in used
    ]
    numbers, corners = _numbered(np.concatenate([key.ravel() for key in keys]), np.concatenate(corner))
    nodes = np.empty((int(numbers.max()) + 1, 2))
    blocks: list[TileBlock] = []
    elements: list[Ints] = []
    start = 0
    for (tile_mesh, rows), key in zip(used, keys, strict=True):
        number = numbers[start : start + key.size].reshape(key.shape)
        nodes[number] = tiling.centres_mm[rows][:, None] + tile_mesh.nodes
        elements.append(number[:, tile_mesh.elements].reshape(-1, 6))
        blocks.append(TileBlock(tile_mesh, number))
        start += key.size
    classes = np.concatenate([np.tile(tile_mesh.classes, len(rows)) for tile_mesh, rows in used])
    return TiledMesh(Mesh(nodes, np.concatenate(elements), corners), tuple(blocks), classes)


def _keys(tile_mesh: TileMesh, centres: Ints, size: int) -> Ints:
    """For each tile and node the place of a node on the border as one number, -1 for one inside."""
    halves = tile_mesh.halves + 2 * (centres[:, None] + size)
    return np.where(tile_mesh.seam, (halves[..., 0] << 31) + halves[..., 1], -1)


def _numbered(keys: Ints, is_corner: Flags) -> tuple[Ints, int]:
    """Node numbers, one for equal keys from 0 and one for each -1, corner nodes first, and their count."""
    inside = keys < 0
    places, common = np.unique(keys[~inside], return_inverse=True)
    number = np.empty(len(keys), np.int64)
    number[~inside] = common
    number[inside] = len(places) + np.arange(np.count_nonzero(inside))
    corner_of = np.zeros(len(places) + np.count_nonzero(inside), bool)
    corner_of[number] = is_corner
    rank = np.where(corner_of, np.cumsum(corner_of), corner_of.sum() + np.cumsum(~corner_of)) - 1
    return rank[number], int(corner_of.sum())
