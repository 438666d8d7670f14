"""Element matrices into one sparse symmetric matrix, block by block."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from perfqr_cad.structure.t6 import Floats, Ints

Flags = NDArray[np.bool_]


@dataclass(frozen=True)
class System:
    """A linear structure: element matrices (m, k·d, k·d) and flags (n·d,) of the unknowns that are held.

    `elements` (m, k) are node numbers; every node has `dofs` unknowns, numbered node by node.
    """

    elements: Ints
    dofs: int
    matrices: Floats
    fixed: Flags

    def lower(self) -> sp.csc_matrix:
        """The lower triangle, held unknowns replaced by unit rows so that numbering stays as it is."""
        free = ~self.fixed.reshape(-1, self.dofs)[self.elements].reshape(len(self.elements), -1)
        held = lower_triangle(
            self.elements, self.matrices * (free[:, :, None] & free[:, None, :]), self.dofs, len(self.fixed)
        )
        return (held + sp.diags_array(self.fixed.astype(float), format="csc")).tocsc()

    def internal_forces(self, displacement: Floats) -> Floats:
        """K u of the structure without its supports, (n·d,): the forces that hold this shape."""
        local = displacement.reshape(-1, self.dofs)[self.elements].reshape(len(self.elements), -1)
        local_forces = np.einsum("mij,mj->mi", self.matrices, local).reshape(-1, self.dofs)
        out = np.zeros((len(self.fixed) // self.dofs, self.dofs))
        for dof in range(self.dofs):
            out[:, dof] = np.bincount(self.elements.ravel(), local_forces[:, dof], minlength=len(out))
        return out.ravel()


def lower_triangle(elements: Ints, matrices: Floats, dofs: int, unknowns: int) -> sp.csc_matrix:
    """Sum of symmetric element matrices, lower triangle only (diagonal blocks are whole)."""
    m, k = elements.shape
    nodes = unknowns // dofs
    first, second = np.triu_indices(k)
    i, j = elements[:, first], elements[:, second]
    blocks = matrices.reshape(m, k, dofs, k, dofs).transpose(0, 1, 3, 2, 4)[:, first, second]
    blocks = np.where((i > j)[:, :, None, None], blocks.transpose(0, 1, 3, 2), blocks).reshape(-1, dofs, dofs)
    keys = (np.minimum(i, j) * np.int64(nodes) + np.maximum(i, j)).ravel()
    order = np.argsort(keys, kind="stable")
    keys = keys[order]
    starts = np.flatnonzero(np.r_[True, keys[1:] != keys[:-1]])
    sums = np.add.reduceat(blocks[order], starts, axis=0)
    rows, columns = np.divmod(keys[starts], nodes)
    pointers = np.searchsorted(rows, np.arange(nodes + 1))
    upper = sp.bsr_matrix((sums, columns, pointers), shape=(unknowns, unknowns)).tocsr()
    # The rows of the upper triangle are the columns of the lower one.
    return sp.csc_matrix((upper.data, upper.indices, upper.indptr), shape=upper.shape)
