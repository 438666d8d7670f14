"""One factorisation, many bridges: each is a low-rank update, by Woodbury's identity small matrices.

With K = K0 + C Cᵀ and Z0 = K0⁻¹ C, each product with K⁻¹ is one with K0⁻¹ and a correction of the size of
the bridges. Of Z0 only what the seams between tiles do is kept (see `condensing`). Nothing is meshed or
factorised while bridges are tried; a conforming mesh confirms them at the end.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from perfqr_cad.structure.measure import Discs
from perfqr_cad.structure.model import Model
from perfqr_cad.structure.solvers import Factor
from perfqr_cad.structure.t6 import Floats, Ints

HOT_SHARE = 0.6  # of the largest stress: places that are watched while bridges are tried
HOT_MOST = 400


@dataclass(frozen=True)
class Response:
    """What bars with coupling C (n, k) feel and do on the seams: C as felt there (s, k), and its motion."""

    coupling: sp.csc_matrix
    felt: sp.csc_matrix
    motion: Floats

    def take(self, columns: Ints) -> Response:
        """That of some columns of C."""
        return Response(
            sp.csc_matrix(self.coupling[:, columns]),
            sp.csc_matrix(self.felt[:, columns]),
            self.motion[:, columns],
        )


class Reanalysis:
    """A solved model to which bridges are added. Mutable: it lives inside one run of the loop."""

    def __init__(self, model: Model, factor: Factor, forces: Floats, nozzle_mm: float) -> None:
        self.model = model
        self.discs = Discs(model.mesh, nozzle_mm)
        self._factor = factor
        self._base = factor.solve(np.where(model.fixed, 0.0, forces))
        self._laid = self.respond(sp.csc_matrix((len(forces), 0)))
        self._small: Floats = np.zeros((0, 0))  # 1 + CᵀZ0
        self.displacement = self._base
        self._hot: tuple[Ints, Floats] | None = None
        self._under: Ints = np.zeros(0, np.int64)

    def solve(self, right: Floats) -> Floats:
        """K⁻¹ of a right-hand side, bridges included."""
        return self._corrected(self._factor.solve(right))

    def respond(self, coupling: sp.csc_matrix) -> Response:
        """What bridges by themselves do, without those laid."""
        felt = self._factor.onto_seams(coupling)
        motion = self._factor.solve_seams(felt.toarray()) if felt.nnz else felt.toarray()
        return Response(coupling, felt, motion)

    def between(self, left: sp.csc_matrix, response: Response) -> Floats:
        """Aᵀ K⁻¹ C for columns A (n, r), laid bridges included."""
        alone = self._alone(left, response)
        if not len(self._small):
            return alone
        amplitudes = np.linalg.solve(self._small, self._alone(self._laid.coupling, response))
        return alone - self._alone(left, self._laid) @ amplitudes

    def add(self, response: Response, under: Ints) -> None:
        """Lay bridges for good. They stand on some corner nodes, whose stress is none of the part's now."""
        own = self._alone(response.coupling, response)
        cross = self._alone(self._laid.coupling, response)
        self._small = np.block([[self._small, cross], [cross.T, np.eye(len(own)) + own]])
        self._laid = Response(
            sp.csc_matrix(sp.hstack([self._laid.coupling, response.coupling])),
            sp.csc_matrix(sp.hstack([self._laid.felt, response.felt])),
            np.concatenate([self._laid.motion, response.motion], axis=1),
        )
        self.displacement = self._corrected(self._base)
        self._under = np.union1d(self._under, under)
        self._hot = None

    def drop(self, modes: int) -> None:
        """Take the last modes away again."""
        left = np.arange(self.modes - modes)
        self._small = self._small[np.ix_(left, left)]
        self._laid = self._laid.take(left)
        self.displacement = self._corrected(self._base)
        self._hot = None

    def subset(self, operator: sp.csr_matrix) -> Callable[[NDArray[np.bool_]], Floats]:
        """What an operator sees of the displacement if only some of the laid modes were there, by flags."""
        base, relief = operator @ self._base, self._alone(sp.csc_matrix(operator.T), self._laid)
        strain = self._laid.coupling.T @ self._base

        def seen(kept: NDArray[np.bool_]) -> Floats:
            small = self._small[np.ix_(kept, kept)]
            return base - relief[:, kept] @ np.linalg.solve(small, strain[kept])

        return seen

    @property
    def modes(self) -> int:
        """Columns of C laid so far."""
        return len(self._small)

    def _alone(self, left: sp.csc_matrix, response: Response) -> Floats:
        """Aᵀ K0⁻¹ C, (r, k)."""
        felt = response.felt if left is response.coupling else self._factor.onto_seams(left)
        return felt.T @ response.motion + self._factor.inside(left, response.coupling)

    def _corrected(self, unbridged: Floats) -> Floats:
        """K⁻¹ f (n,) given K0⁻¹ f."""
        if not self.modes:
            return unbridged
        amplitudes = np.linalg.solve(self._small, self._laid.coupling.T @ unbridged)
        forces = self._laid.coupling @ amplitudes
        return unbridged - self._factor.from_seams(self._laid.motion @ amplitudes, forces)

    @property
    def hot_places(self) -> tuple[Ints, Floats]:
        """The corner nodes with the largest of the named measure, and it in MPa, largest first."""
        if self._hot is None:
            stress = self.model.corner_stresses(self.displacement)
            places, measure = self.discs.hottest(stress, HOT_SHARE, self._under)
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
