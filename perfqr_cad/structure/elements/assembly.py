"""Element matrices into one sparse symmetric matrix, block by block."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from perfqr_cad.structure.elements.solvers import Factor, factorise
from perfqr_cad.structure.mesh.triangle import Floats, Ints

Flags = NDArray[np.bool_]
Group = tuple[Ints, Floats]  # elements (m, k) by node numbers, and their matrices (m, k·d, k·d)


class Structure(Protocol):
    """A linear structure with `dofs` unknowns a node, numbered node by node; `fixed` (n·d,) ones are held."""

    @property
    def dofs(self) -> int:
        """Unknowns a node."""
        ...

    @property
    def fixed(self) -> Flags:
        """Which unknowns are held."""
        ...

    def factorise(self, solver: str | None = None) -> Factor:
        """See `solvers.factorise`."""
        ...

    def held_forces(self, displacement: Floats) -> Floats:
        """K u of the structure without its supports at the held unknowns, 0 elsewhere: (n·d,)."""
        ...


@dataclass(frozen=True)
class System:
    """A structure of elements of one kind: `elements` (m, k) by node numbers, `matrices` (m, k·d, k·d)."""

    elements: Ints
    dofs: int
    matrices: Floats
    fixed: Flags

    def lower(self) -> sp.csc_matrix:
        """The lower triangle of the stiffness matrix; see `lower_triangle`."""
        return lower_triangle([(self.elements, self.matrices)], self.dofs, self.fixed)

    def factorise(self, solver: str | None = None) -> Factor:
        """See `solvers.factorise`."""
        return factorise(self.lower(), solver)

    def held_forces(self, displacement: Floats) -> Floats:
        """See `Structure`."""
        return np.where(self.fixed, self.internal_forces(displacement), 0.0)

    def internal_forces(self, displacement: Floats) -> Floats:
        """K u of the structure without its supports, (n·d,): the forces that hold this shape."""
        local = displacement.reshape(-1, self.dofs)[self.elements].reshape(len(self.elements), -1)
        forces = np.einsum("mij,mj->mi", self.matrices, local).reshape(-1, self.dofs)
        return scattered(self.elements, forces, len(self.fixed) // self.dofs).ravel()


def scattered(elements: Ints, values: Floats, nodes: int) -> Floats:
    """Sums (nodes, d) at each node of values (m·k, d) at the nodes of elements."""
    sums = np.empty((nodes, values.shape[1]))
    for column in range(values.shape[1]):
        sums[:, column] = np.bincount(elements.ravel(), values[:, column], minlength=nodes)
    return sums


def lower_triangle(groups: Sequence[Group], dofs: int, fixed: Flags) -> sp.csc_matrix:
    """Sum of symmetric matrices, lower triangle only (diagonal blocks are whole).

    Held unknowns have unit rows, so that the numbering stays as it is.
    """
    unknowns = len(fixed)
    nodes = unknowns // dofs
    parts = [_blocks(elements, matrices, dofs, nodes) for elements, matrices in groups]
    keys = np.concatenate([part[0] for part in parts])
    order = np.argsort(keys, kind="stable")
    keys = keys[order]
    starts = np.flatnonzero(np.r_[True, keys[1:] != keys[:-1]])
    sums = np.add.reduceat(np.concatenate([part[1] for part in parts])[order], starts, axis=0)
    rows, columns = np.divmod(keys[starts], nodes)
    free = ~fixed.reshape(nodes, dofs)
    sums *= free[rows][:, :, None] & free[columns][:, None, :]
    pointers = np.searchsorted(rows, np.arange(nodes + 1))
    upper = sp.bsr_matrix((sums, columns, pointers), shape=(unknowns, unknowns)).tocsr()
    # The rows of the upper triangle are the columns of the lower one.
    lower = sp.csc_matrix((upper.data, upper.indices, upper.indptr), shape=upper.shape)
    return (lower + sp.diags_array(fixed.astype(float), format="csc")).tocsc()


def _blocks(elements: Ints, matrices: Floats, dofs: int, nodes: int) -> tuple[Ints, Floats]:
    """Blocks (b, d, d) of the upper triangle and their places, row·nodes + column."""
    m, k = elements.shape
    first, second = np.triu_indices(k)
    i, j = elements[:, first], elements[:, second]
    blocks = matrices.reshape(m, k, dofs, k, dofs).transpose(0, 1, 3, 2, 4)[:, first, second]
    blocks = np.where((i > j)[:, :, None, None], blocks.transpose(0, 1, 3, 2), blocks)
    return (np.minimum(i, j) * np.int64(nodes) + np.maximum(i, j)).ravel(), blocks.reshape(-1, dofs, dofs)
