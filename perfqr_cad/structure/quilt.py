"""Patches sewn into one mesh: tile after tile, nodes on a common border counted once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from shapely.geometry import MultiPolygon, Polygon

from perfqr_cad.errors import AnalysisError
from perfqr_cad.structure.patches import Flags, Patch, Patches
from perfqr_cad.structure.t6 import Ints, Mesh
from perfqr_cad.structure.tiling import Lattice, Tiling, cut

AREA_TOLERANCE = 0.02  # thinning may move the outline, never lose a web


@dataclass(frozen=True)
class Block:
    """All tiles of one patch: their `nodes` (tiles, n) in the mesh and the first of their elements.

    The elements of a block follow each other in the mesh, tile by tile.
    """

    patch: Patch
    nodes: Ints
    first_element: int

    @property
    def elements(self) -> Ints:
        """Node numbers (tiles, m, 6)."""
        return self.nodes[:, self.patch.elements]


@dataclass(frozen=True)
class Quilt:
    """A mesh and the blocks that it is made of; `classes` (m,) are those of the elements' material."""

    mesh: Mesh
    blocks: tuple[Block, ...]
    classes: Ints


def patched(regions: Sequence[Polygon | MultiPolygon], lattice: Lattice, patches: Patches) -> Quilt:
    """The mesh of a clean region that is parted by classes of material; `patches` learn its tiles.

    Raises:
        AnalysisError: gmsh failed, or the mesh does not cover the region.
    """
    tiling = cut(regions, lattice)
    quilt = sew(tiling, patches.of(tiling))
    meshed, wanted = float(quilt.mesh.area_mm2.sum()), sum(region.area for region in regions)
    if abs(meshed - wanted) > AREA_TOLERANCE * wanted:
        raise AnalysisError(
            f"the mesh covers {meshed:.4f} mm² of {wanted:.4f} mm²: the outline touches or crosses itself"
        )
    return quilt


def sew(tiling: Tiling, patches: Sequence[Patch]) -> Quilt:
    """The mesh of a tiling whose contents have these patches."""
    used = [
        (patch, np.flatnonzero(tiling.content_of == k))
        for k, patch in enumerate(patches)
        if len(patch.elements)
    ]
    centres = tiling.centres - tiling.centres.min(axis=0)
    keys = [_keys(patch, centres[rows], 2 * tiling.lattice.half) for patch, rows in used]
    corner = [np.tile(np.arange(len(patch.nodes)) < patch.corners, len(rows)) for patch, rows in used]
    numbers, corners = _numbered(np.concatenate([key.ravel() for key in keys]), np.concatenate(corner))
    nodes = np.empty((int(numbers.max()) + 1, 2))
    blocks: list[Block] = []
    elements: list[Ints] = []
    start = first_element = 0
    for (patch, rows), key in zip(used, keys, strict=True):
        number = numbers[start : start + key.size].reshape(key.shape)
        nodes[number] = tiling.centres_mm[rows][:, None] + patch.nodes
        elements.append(number[:, patch.elements].reshape(-1, 6))
        blocks.append(Block(patch, number, first_element))
        start += key.size
        first_element += len(elements[-1])
    classes = np.concatenate([np.tile(patch.classes, len(rows)) for patch, rows in used])
    return Quilt(Mesh(nodes, np.concatenate(elements), corners), tuple(blocks), classes)


def _keys(patch: Patch, centres: Ints, size: int) -> Ints:
    """For each tile and node the place of a node on the border as one number, -1 for one inside."""
    halves = patch.halves + 2 * (centres[:, None] + size)
    return np.where(patch.seam, (halves[..., 0] << 31) + halves[..., 1], -1)


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
