"""One factorisation, many bridges: each is a low-rank update, by Woodbury's identity small matrices.

With K = K0 + C Cᵀ and Z0 = K0⁻¹ C, each product with K⁻¹ is one with K0⁻¹ and a correction of the size of
the bridges. Nothing is meshed or factorised while bridges are tried; a conforming mesh confirms them at the
end.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from perfqr_cad.structure.measure import Discs
from perfqr_cad.structure.model import Model
from perfqr_cad.structure.solvers import Factor
from perfqr_cad.structure.t6 import Floats, Ints

HOT_SHARE = 0.6  # of the largest stress: places that are watched while bridges are tried
HOT_MOST = 400
FIRST_ROOM = 64  # columns of Z0 before room is made for more


class Reanalysis:
    """A solved model to which bridges are added. Mutable: it lives inside one run of the loop."""

    def __init__(self, model: Model, factor: Factor, forces: Floats, nozzle_mm: float) -> None:
        self.model = model
        self.discs = Discs(model.mesh, nozzle_mm)
        self._factor = factor
        self._base = factor.solve(np.where(model.fixed, 0.0, forces))
        unknowns = len(forces)
        self._couplings: sp.csc_matrix = sp.csc_matrix((unknowns, 0))
        self._room: Floats = np.empty((unknowns, FIRST_ROOM), order="F")  # Z0 and columns to come
        self._small: Floats = np.zeros((0, 0))  # 1 + CᵀZ0
        self.displacement = self._base
        self._hot: tuple[Ints, Floats] | None = None

    def solve(self, right: Floats) -> Floats:
        """K⁻¹ of one or several right-hand sides, bridges included."""
        return self._corrected(self._factor.solve(right))

    @property
    def _flexibility(self) -> Floats:
        """Z0 (n, modes)."""
        return self._room[:, : self.modes]

    @property
    def modes(self) -> int:
        """Columns of C laid so far."""
        return len(self._couplings.indptr) - 1

    def unbridged(self, coupling: sp.csc_matrix) -> Floats:
        """Z = K0⁻¹ C (n, modes) of bridges by themselves."""
        return self._factor.solve(coupling.toarray())

    def between(self, left: sp.csr_matrix, flexibility: Floats) -> Floats:
        """A K⁻¹ C for rows A (r, n), laid bridges included, given K0⁻¹ C."""
        alone = left @ flexibility
        if not self.modes:
            return alone
        amplitudes = np.linalg.solve(self._small, self._couplings.T @ flexibility)
        return alone - (left @ self._flexibility) @ amplitudes

    def add(self, coupling: sp.csc_matrix, flexibility: Floats | None = None) -> None:
        """Lay bridges for good; C (n, modes) of them all, and K0⁻¹ C where it is known."""
        if flexibility is None:
            flexibility = self.unbridged(coupling)
        before, after = self.modes, self.modes + flexibility.shape[1]
        if after > self._room.shape[1]:
            room = np.empty((len(self._base), 2 * after), order="F")
            room[:, :before] = self._flexibility
            self._room = room
        self._room[:, before:after] = flexibility
        self._couplings = sp.csc_matrix(sp.hstack([self._couplings, coupling]))
        own = self._couplings.T @ flexibility  # the rest of CᵀZ0 is known, and it is symmetric
        small = np.eye(after)
        small[:before, :before] = self._small
        small[:, before:] += own
        small[before:, :before] += own[:before].T
        self._small = small
        self.displacement = self._corrected(self._base)
        self._hot = None

    def subset(self, operator: sp.csr_matrix) -> Callable[[NDArray[np.bool_]], Floats]:
        """What an operator sees of the displacement if only some of the laid modes were there, by flags."""
        base, relief = operator @ self._base, operator @ self._flexibility
        flexibility, strain = self._couplings.T @ self._flexibility, self._couplings.T @ self._base

        def seen(kept: NDArray[np.bool_]) -> Floats:
            small = np.eye(int(kept.sum())) + flexibility[np.ix_(kept, kept)]
            return base - relief[:, kept] @ np.linalg.solve(small, strain[kept])

        return seen

    def _corrected(self, unbridged: Floats) -> Floats:
        if not self.modes:
            return unbridged
        return unbridged - self._flexibility @ np.linalg.solve(self._small, self._couplings.T @ unbridged)

    @property
    def hot_places(self) -> tuple[Ints, Floats]:
        """The corner nodes with the largest of the named measure, and it in MPa, largest first."""
        if self._hot is None:
            stress = self.model.corner_stresses(self.displacement)
            places, measure = self.discs.hottest(stress, HOT_SHARE)
            self._hot = places[:HOT_MOST], measure[:HOT_MOST]
        return self._hot

    @property
    def largest(self) -> float:
        """The largest of the named measure, in MPa."""
        return float(self.hot_places[1][0])


def stress_operator(model: Model, discs: Discs, places: Ints) -> sp.csr_matrix:
    """Averaged tensors at some corner nodes as a matrix (places·layers·5, n·d) on the displacement."""
    rows = discs.matrix(places)
    elements = np.unique(rows.indices // 3).astype(np.int64)
    columns = (elements[:, None] * 3 + np.arange(3)).ravel()
    part = model.alone(elements)
    unknowns = 6 * model.system.dofs
    unit = []
    for k in range(unknowns):
        shape = np.zeros((len(elements), unknowns))
        shape[:, k] = 1.0
        unit.append(part.corner_stresses(shape.ravel()))
    # (elements, 3, layers·5, unknowns of the element)
    blocks = np.stack(unit, axis=-1).reshape(len(elements), 3, -1, unknowns)
    tensors = blocks.shape[2]
    index = model.mesh.elements[elements][:, :, None] * model.system.dofs + np.arange(model.system.dofs)
    index = np.broadcast_to(index.reshape(len(elements), 1, 1, unknowns), blocks.shape)
    row = np.arange(len(elements) * 3 * tensors).reshape(len(elements), 3, tensors, 1)
    row = np.broadcast_to(row, blocks.shape)
    shape = (row.max() + 1, len(model.fixed))
    of_corner = sp.csr_matrix((blocks.ravel(), (row.ravel(), index.ravel())), shape=shape)
    averaging = sp.kron(rows[:, columns], sp.eye_array(tensors), format="csr")
    return sp.csr_matrix(averaging @ of_corner)
