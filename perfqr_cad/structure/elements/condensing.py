"""A structure of repeated tiles: the inside of each kind is eliminated once, only the seams are factorised.

With unknowns parted into those on seams (s) and those inside tiles (i), K_ii u_i = f_i - K_is u_s inside, and
the seams carry S = K_ss - K_si K_ii⁻¹ K_is. Tiles that are congruent and held alike share K_ii⁻¹ and S. Tiles
without a like are left whole: their elements join the seams.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from scipy.linalg import cho_factor, cho_solve

from perfqr_cad.errors import AnalysisError
from perfqr_cad.structure.elements.assembly import Flags, Group, lower_triangle, scattered
from perfqr_cad.structure.elements.solvers import FREE_TO_MOVE, factorise
from perfqr_cad.structure.mesh.tiled_mesh import TileBlock
from perfqr_cad.structure.mesh.triangle import Floats, Ints

LEAST_COPIES = 4  # of a tile for which eliminating its inside is worth dense matrices


@dataclass(frozen=True)
class TiledStructure:
    """A linear structure of blocks of tiles: element matrices (m, k·d, k·d) for each block's tile_mesh.

    Every node has `dofs` unknowns, numbered node by node; `fixed` (n·d,) flags those that are held.
    """

    blocks: tuple[TileBlock, ...]
    matrices: tuple[Floats, ...]
    dofs: int
    fixed: Flags

    def held_forces(self, displacement: Floats) -> Floats:
        """See `assembly.Structure`."""
        u = displacement.reshape(-1, self.dofs)
        out = np.zeros_like(u)
        held = np.asarray(self.fixed.reshape(-1, self.dofs).any(axis=1))
        for block, matrices in zip(self.blocks, self.matrices, strict=True):
            elements = block.elements[held[block.nodes].any(axis=1)]
            local = u[elements].reshape(*elements.shape[:2], matrices.shape[2])
            forces = np.matmul(matrices, local.transpose(1, 2, 0)).transpose(2, 0, 1)
            out += scattered(elements, forces.reshape(-1, self.dofs), len(u))
        return np.where(self.fixed, out.ravel(), 0.0)

    def factorise(self, solver: str | None = None) -> Condensed:
        """See `solvers.factorise`."""
        return Condensed(self, solver)


@dataclass(frozen=True)
class _Kind:
    """Congruent tiles held alike: unknowns on their seams (t, a), free ones inside (t, b), matrices."""

    seam: Ints
    inner: Ints
    flexibility: Floats  # K_ii⁻¹ (b, b)
    follow: Floats  # K_ii⁻¹ K_is (b, a)


class Condensed:
    """The factor of a tiled structure."""

    def __init__(self, structure: TiledStructure, solver: str | None) -> None:
        d, nodes = structure.dofs, len(structure.fixed) // structure.dofs
        uses = np.bincount(np.concatenate([b.nodes.ravel() for b in structure.blocks]), minlength=nodes)
        self._kinds: list[_Kind] = []
        groups: list[Group] = []
        for block, matrices in zip(structure.blocks, structure.matrices, strict=True):
            shared, held = uses[block.nodes] > 1, structure.fixed.reshape(nodes, d)[block.nodes]
            for rows in _alike(shared, held):
                if len(rows) < LEAST_COPIES:
                    elements = block.elements[rows]
                    groups.append(
                        (elements.reshape(-1, elements.shape[2]), np.tile(matrices, (len(rows), 1, 1)))
                    )
                    continue
                seam = np.flatnonzero(shared[rows[0]])
                kind, stiffness = _condense(block, matrices, d, rows, seam, held[rows[0]])
                self._kinds.append(kind)
                groups.append(
                    (
                        block.nodes[np.ix_(rows, seam)],
                        np.broadcast_to(stiffness, (len(rows), *stiffness.shape)),
                    )
                )
        kept = np.unique(np.concatenate([elements.ravel() for elements, _ in groups]))
        self._kept = (kept[:, None] * d + np.arange(d)).ravel()
        self._unknowns = len(structure.fixed)
        groups = [(np.searchsorted(kept, elements), matrices) for elements, matrices in groups]
        self._factor = factorise(lower_triangle(groups, d, structure.fixed[self._kept]), solver)
        self.name = self._factor.name

    def solve(self, right: Floats) -> Floats:
        """See `solvers.Factor`."""
        columns = right.reshape(len(right), -1)
        on_seams, pushed = self._onto_seams(columns)
        out = np.zeros_like(columns)
        out[self._kept] = self._factor.solve(on_seams)
        for kind, rows in zip(self._kinds, pushed, strict=True):
            inside = -np.matmul(kind.follow, out[kind.seam])
            inside[rows] += np.matmul(kind.flexibility, columns[kind.inner[rows]])
            out[kind.inner] = inside
        return out.reshape(right.shape)

    def work(self, right: Floats) -> Floats:
        """See `solvers.Factor`."""
        on_seams, pushed = self._onto_seams(right)
        total = self._factor.work(on_seams)
        for kind, rows in zip(self._kinds, pushed, strict=True):
            inside = right[kind.inner[rows]]
            total += np.einsum("tbk,tbk->k", inside, np.matmul(kind.flexibility, inside))
        return total

    def onto_seams(self, forces: sp.csc_matrix) -> sp.csc_matrix:
        """See `solvers.Factor`."""
        rows = _used(forces)
        return sp.csc_matrix(self._influence(rows).T @ forces.tocsr()[rows])

    def solve_seams(self, on_seams: Floats) -> Floats:
        """See `solvers.Factor`."""
        return self._factor.solve(on_seams)

    def from_seams(self, motion: Floats, forces: Floats) -> Floats:
        """See `solvers.Factor`."""
        out = np.zeros(self._unknowns)
        out[self._kept] = motion
        for kind in self._kinds:
            inside = -out[kind.seam] @ kind.follow.T
            rows = np.flatnonzero(forces[kind.inner].any(axis=1))
            inside[rows] += forces[kind.inner[rows]] @ kind.flexibility
            out[kind.inner] = inside
        return out

    def inside(self, left: sp.csc_matrix, right: sp.csc_matrix) -> Floats:
        """See `solvers.Factor`."""
        rows, columns = _used(left), _used(right)
        alike = (self._tiles_of(rows) @ self._tiles_of(columns).T).tocoo()
        first, second = rows[alike.row], columns[alike.col]
        kind_of, _, position = self._homes
        values = np.empty(len(first))
        for number, kind in enumerate(self._kinds):
            mine = kind_of[first] == number
            values[mine] = kind.flexibility[position[first[mine]], position[second[mine]]]
        flexibility = sp.csr_matrix((values, (alike.row, alike.col)), shape=(len(rows), len(columns)))
        return (left.tocsr()[rows].T @ (flexibility @ right.tocsr()[columns])).toarray()

    @cached_property
    def _homes(self) -> Ints:
        """Of each unknown (3, n): kind of tile or -1, tile among all kinds', position in it."""
        homes = np.full((3, self._unknowns), -1)
        first = 0
        for number, kind in enumerate(self._kinds):
            tiles, inner = kind.inner.shape
            homes[0, kind.inner] = number
            homes[1, kind.inner] = first + np.arange(tiles)[:, None]
            homes[2, kind.inner] = np.arange(inner)
            first += tiles
        return homes

    def _tiles_of(self, rows: Ints) -> sp.csr_matrix:
        """Which tile each of some unknowns is inside of: ones in a matrix (rows, tiles)."""
        tile = self._homes[1, rows]
        inner = np.flatnonzero(tile >= 0)
        tiles = sum(len(kind.inner) for kind in self._kinds)
        return sp.csr_matrix((np.ones(len(inner)), (inner, tile[inner])), shape=(len(rows), tiles))

    def _influence(self, rows: Ints) -> sp.csr_matrix:
        """How some unknowns move with those on seams, (rows, s)."""
        kind_of, tile, position = self._homes[:, rows]
        places = np.searchsorted(self._kept, rows)
        kept = np.flatnonzero(self._kept[np.minimum(places, len(self._kept) - 1)] == rows)
        row, column, value = [kept], [places[kept]], [np.ones(len(kept))]
        first = 0
        for number, kind in enumerate(self._kinds):
            mine = np.flatnonzero(kind_of == number)
            seam = kind.seam[tile[mine] - first]
            row.append(np.repeat(mine, seam.shape[1]))
            column.append(np.searchsorted(self._kept, seam).ravel())
            value.append(-kind.follow[position[mine]].ravel())
            first += len(kind.inner)
        entries = np.concatenate(value), (np.concatenate(row), np.concatenate(column))
        return sp.csr_matrix(entries, shape=(len(rows), len(self._kept)))

    def _onto_seams(self, right: Floats) -> tuple[Floats, list[Ints]]:
        """Right-hand sides as the seams feel them, and the tiles of each kind with any of it inside."""
        on_seams = right.copy()
        pushed: list[Ints] = []
        loaded = np.asarray(right.any(axis=1))
        for kind in self._kinds:
            pushed.append(np.flatnonzero(loaded[kind.inner].any(axis=1)))
            rows = pushed[-1]
            onto = np.matmul(kind.follow.T, right[kind.inner[rows]])
            np.subtract.at(on_seams, kind.seam[rows].ravel(), onto.reshape(-1, right.shape[1]))
        return on_seams[self._kept], pushed


def _used(matrix: sp.csc_matrix) -> Ints:
    """Rows of a matrix that hold anything, in order."""
    return np.unique(matrix.indices).astype(np.int64)


def _alike(shared: Flags, held: Flags) -> Iterator[Ints]:
    """Rows of the tiles of a block that have the same nodes on seams and the same unknowns held."""
    flags = np.concatenate([shared, held.reshape(len(held), -1)], axis=1)
    _, group = np.unique(np.packbits(flags, axis=1), axis=0, return_inverse=True)
    group = group.reshape(-1)
    order = np.argsort(group, kind="stable")
    yield from np.split(order, np.flatnonzero(np.diff(group[order])) + 1)


def _condense(
    block: TileBlock, matrices: Floats, dofs: int, rows: Ints, seam: Ints, held: Flags
) -> tuple[_Kind, Floats]:
    """The inside of some tiles of a block eliminated, and the stiffness S (a, a) left on their seams."""
    count = block.nodes.shape[1]
    local = (block.tile_mesh.elements[:, :, None] * dofs + np.arange(dofs)).reshape(len(matrices), -1)
    whole = np.zeros((count * dofs, count * dofs))
    np.add.at(whole, (local[:, :, None], local[:, None, :]), matrices)
    on_seam = (seam[:, None] * dofs + np.arange(dofs)).ravel()
    inside = np.setdiff1d(np.flatnonzero(~held.ravel()), on_seam)
    # A held unknown on a seam does not move: what it would do inside the tile does not count.
    moving = ~held.ravel()[on_seam]
    try:
        factor = cho_factor(whole[np.ix_(inside, inside)])
    except np.linalg.LinAlgError as error:
        raise AnalysisError(FREE_TO_MOVE) from error
    follow = cho_solve(factor, whole[np.ix_(inside, on_seam)] * moving)
    stiffness = whole[np.ix_(on_seam, on_seam)] - whole[np.ix_(on_seam, inside)] @ follow
    unknowns = (block.nodes[rows][:, :, None] * dofs + np.arange(dofs)).reshape(len(rows), -1)
    kind = _Kind(unknowns[:, on_seam], unknowns[:, inside], cho_solve(factor, np.eye(len(inside))), follow)
    return kind, stiffness
