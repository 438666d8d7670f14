"""One factorisation, many bridges: each is a low-rank update, by Woodbury's identity small matrices.

With K = K0 + C Cᵀ and Z0 = K0⁻¹ C, each product with K⁻¹ is one with K0⁻¹ and a correction of the size of
the bridges, for all loads at once. Of Z0 only what the seams between tiles do is kept (see `condensing`).
Nothing is meshed or factorised while bridges are tried; a conforming mesh confirms them at the end.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from perfqr_cad.structure.elements.solvers import Factor
from perfqr_cad.structure.measure import Discs, von_mises
from perfqr_cad.structure.mesh.triangle import Floats, Ints
from perfqr_cad.structure.shell_model import Model

CRITICAL_SHARE = 0.6  # of the largest stress: places that are watched while bridges are tried
CRITICAL_MOST = 400


@dataclass(frozen=True)
class Response:
    """What bars with coupling C (n, k) feel and do on the seams: C as felt there (s, k), and its motion."""

    coupling: sp.csc_matrix
    on_seams: sp.csc_matrix
    motion: Floats

    def take(self, columns: Ints) -> Response:
        """That of some columns of C."""
        return Response(
            sp.csc_matrix(self.coupling[:, columns]),
            sp.csc_matrix(self.on_seams[:, columns]),
            self.motion[:, columns],
        )


@dataclass(frozen=True)
class Watch:
    """Averaged tensors at critical places: an operator (r·5, n·d) on displacements, the load (r,) under which
    each is watched, and the place (r, 2) of each in mm."""

    operator: sp.csr_matrix
    load: Ints
    places_mm: Floats

    def tensors(self, displacements: Floats) -> Floats:
        """The tensors (r, 5) under displacements (n·d, loads)."""
        every = (self.operator @ displacements).reshape(len(self.load), 5, -1)
        return np.take_along_axis(every, self.load[:, None, None], axis=2)[:, :, 0]

    def pull(self, weights: Floats) -> Floats:
        """The forces (n·d, loads) by which displacements count that change the tensors, weighted (r, 5)."""
        count = int(self.load.max()) + 1
        columns = np.repeat(self.load, 5)
        spread = sp.csr_matrix(
            (weights.ravel(), (np.arange(len(columns)), columns)), shape=(len(columns), count)
        )
        return (self.operator.T @ spread).toarray()


class Reanalysis:
    """A model solved under one or several loads (n·d, loads), to which bridges are added.

    Each load counts by itself; forces are scaled so that all of them may reach the same stress. Mutable: it
    lives inside one run of the loop. Corner nodes `apart_from` are not watched: no bridge may help them.
    """

    def __init__(
        self, model: Model, factor: Factor, forces: Floats, nozzle_mm: float, apart_from: Ints | None = None
    ) -> None:
        self.model = model
        self.discs = Discs(model.mesh, nozzle_mm)
        self._factor = factor
        forces = forces.reshape(len(forces), -1)
        self._base = factor.solve(np.where(model.fixed[:, None], 0.0, forces))
        self._added = self.respond(sp.csc_matrix((len(forces), 0)))
        self._small: Floats = np.zeros((0, 0))  # 1 + CᵀZ0
        self.displacements = self._base
        self._own: Floats = np.zeros((0, 0, 5, 0))
        self._critical: list[tuple[Ints, Floats]] | None = None
        self._under: Ints = np.zeros(0, np.int64) if apart_from is None else apart_from

    @property
    def loads(self) -> int:
        """How many loads there are."""
        return self._base.shape[1]

    def solve(self, right: Floats) -> Floats:
        """K⁻¹ of right-hand sides (n·d, k), bridges included."""
        return self._corrected(self._factor.solve(right))

    def respond(self, coupling: sp.csc_matrix) -> Response:
        """What bridges by themselves do, without those added."""
        on_seams = self._factor.onto_seams(coupling)
        motion = self._factor.solve_seams(on_seams.toarray()) if on_seams.nnz else on_seams.toarray()
        return Response(coupling, on_seams, motion)

    def between(self, left: sp.csc_matrix, response: Response) -> Floats:
        """Aᵀ K⁻¹ C for columns A (n, r), added bridges included."""
        alone = self._alone(left, response)
        if not len(self._small):
            return alone
        amplitudes = np.linalg.solve(self._small, self._alone(self._added.coupling, response))
        return alone - self._alone(left, self._added) @ amplitudes

    def add(self, response: Response, own: Floats, under: Ints) -> None:
        """Add bridges for good.

        `own` (k, e, 5, d) are the tensors in each per unit of its mode forces. They stand on the corner nodes
        `under`, whose stress is none of the part's now.
        """
        alone = self._alone(response.coupling, response)
        cross = self._alone(self._added.coupling, response)
        self._small = np.block([[self._small, cross], [cross.T, np.eye(len(alone)) + alone]])
        self._added = Response(
            sp.csc_matrix(sp.hstack([self._added.coupling, response.coupling])),
            sp.csc_matrix(sp.hstack([self._added.on_seams, response.on_seams])),
            np.concatenate([self._added.motion, response.motion], axis=1),
        )
        self.displacements = self._corrected(self._base)
        self._under = np.union1d(self._under, under)
        self._own = np.concatenate([self._own, own]) if len(self._own) else own
        self._critical = None

    def drop(self, modes: int) -> None:
        """Take the last modes away again."""
        if not modes:
            return
        left = np.arange(self.modes - modes)
        self._small = self._small[np.ix_(left, left)]
        self._added = self._added.take(left)
        self._own = self._own[: len(left) // self._own.shape[3]]
        self.displacements = self._corrected(self._base)
        self._critical = None

    def in_bars(self) -> Floats:
        """Tensors (loads, k, e, 5) in the bridges added."""
        forces = np.linalg.solve(self._small, self._added.coupling.T @ self._base)
        return np.einsum("keam,kml->lkea", self._own, forces.reshape(len(self._own), -1, self.loads))

    def relief_in_bars(self, response: Response) -> Floats:
        """What a unit of each of some forces takes off the tensors in the bridges added, (k·e·5, columns)."""
        taken = np.linalg.solve(self._small, self._alone(self._added.coupling, response))
        by_bar = taken.reshape(len(self._own), -1, taken.shape[1])
        return np.einsum("keam,kmc->keac", self._own, by_bar).reshape(-1, taken.shape[1])

    def pull_of_bars(self, weights: Floats) -> Floats:
        """The displacements (n·d, loads) whose work with any forces is what these take off the tensors in the
        bridges added, summed with these weights (loads, k, e, 5)."""
        forces = np.einsum("keam,lkea->kml", self._own, weights).reshape(self.modes, -1)
        return self._from_seams(np.linalg.solve(self._small, forces))

    def subset(self, watch: Watch) -> Callable[[NDArray[np.bool_]], Floats]:
        """The watched tensors (r, 5) if only some of the added modes were there, by flags."""
        base, relief = watch.tensors(self._base), self._alone(sp.csc_matrix(watch.operator.T), self._added)
        strain = self._added.coupling.T @ self._base

        def seen(kept: NDArray[np.bool_]) -> Floats:
            forces = np.zeros((len(kept), self.loads))
            forces[kept] = np.linalg.solve(self._small[np.ix_(kept, kept)], strain[kept])
            taken = (relief @ forces).reshape(len(watch.load), 5, -1)
            return base - np.take_along_axis(taken, watch.load[:, None, None], axis=2)[:, :, 0]

        return seen

    @property
    def modes(self) -> int:
        """Columns of C added so far."""
        return len(self._small)

    def _alone(self, left: sp.csc_matrix, response: Response) -> Floats:
        """Aᵀ K0⁻¹ C, (r, k)."""
        on_seams = response.on_seams if left is response.coupling else self._factor.onto_seams(left)
        return on_seams.T @ response.motion + self._factor.inside(left, response.coupling)

    def _corrected(self, unbridged: Floats) -> Floats:
        """K⁻¹ f (n·d, k) given K0⁻¹ f."""
        if not self.modes:
            return unbridged
        return unbridged - self._from_seams(np.linalg.solve(self._small, self._added.coupling.T @ unbridged))

    def _from_seams(self, amplitudes: Floats) -> Floats:
        """K0⁻¹ C of mode amplitudes (modes, k)."""
        motion, forces = self._added.motion @ amplitudes, self._added.coupling @ amplitudes
        columns = [self._factor.from_seams(m, f) for m, f in zip(motion.T, forces.T, strict=True)]
        return np.stack(columns, axis=1)

    @property
    def critical_places(self) -> list[tuple[Ints, Floats]]:
        """For each load the corner nodes with the largest of the named measure, and it in MPa, largest first.

        Only what comes near to the largest of all counts.
        """
        if self._critical is None:
            found: list[tuple[Ints, Floats]] = []
            for displacement in self.displacements.T:
                stress = self.model.corner_stresses(np.ascontiguousarray(displacement))
                places, measure = self.discs.most_stressed(stress, CRITICAL_SHARE, self._under)
                found.append((places[:CRITICAL_MOST], measure[:CRITICAL_MOST]))
            least = CRITICAL_SHARE * max(float(measure.max(initial=0.0)) for _, measure in found)
            self._critical = [
                (places[measure >= least], measure[measure >= least]) for places, measure in found
            ]
        return self._critical

    @property
    def worst_load(self) -> int:
        """The load with the largest of the named measure."""
        return int(np.argmax([measure.max(initial=0.0) for _, measure in self.critical_places]))

    @property
    def largest_in_part(self) -> float:
        """The largest of the named measure, in MPa, bridges left out."""
        return max(float(measure.max(initial=0.0)) for _, measure in self.critical_places)

    @property
    def largest(self) -> float:
        """The largest of the named measure, in MPa, also in the bridges added."""
        largest = self.largest_in_part
        return max(largest, float(von_mises(self.in_bars()).max())) if self.modes else largest

    def watch(self) -> Watch:
        """The critical places of all loads as they are now."""
        nodes = np.concatenate([places for places, _ in self.critical_places])
        operator = stress_operator(self.model, self.discs, nodes)
        layers = 2 if self.model.flat else 3
        load = np.repeat(np.arange(self.loads), [len(places) for places, _ in self.critical_places])
        return Watch(
            operator, np.repeat(load, layers), np.repeat(self.model.mesh.nodes[nodes], layers, axis=0)
        )


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
