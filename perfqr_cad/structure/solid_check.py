"""The shell put through three-dimensional elasticity: 18-node wedges on the same triangles.

Quadratic in the plane and through the thickness, so the section may warp, which a shell's straight normals
may not. Walls are upright in both, so what their flare takes away is not in the comparison. Recessed bars are
a layer at the back.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from perfqr_cad.errors import AnalysisError
from perfqr_cad.remedy import Remedy
from perfqr_cad.structure.analysis import prepare
from perfqr_cad.structure.assessment import assess
from perfqr_cad.structure.case import Case
from perfqr_cad.structure.elements import wedge
from perfqr_cad.structure.elements.assembly import Flags, System
from perfqr_cad.structure.elements.solvers import factorise
from perfqr_cad.structure.handling.capacity import STRESS_MARGIN, Capacity, Hand
from perfqr_cad.structure.loads import Hold
from perfqr_cad.structure.measure import Discs
from perfqr_cad.structure.mesh.seeding import MeshSize
from perfqr_cad.structure.mesh.triangle import Floats
from perfqr_cad.structure.part import Part
from perfqr_cad.structure.shell_model import Model, forces_of
from perfqr_cad.structure.supports import pins
from perfqr_cad.surface import Placement

if TYPE_CHECKING:
    from perfqr_cad.pattern import Pattern

EDGE_MODULES = 1.0  # shell and solid are compared on one mesh, which need not be fine
OUTLINE_NOZZLES = (0.05, 0.25)  # how far outlines may move: the finest of these that fits into memory counts
MOST_BYTES = 2e9
# Bytes of a SuperLU factor of n unknowns: this times n^(4/3), measured on one of 135,000.
BYTES_OF_FACTOR = 90.0
BYTES_OF_WEDGE = 2.0 * 54 * 54 * 8  # its matrix, and what assembling copies of it


@dataclass(frozen=True)
class SolidCheck:
    """Largest deflection (mm) and disc-averaged stress (MPa) of the solid and of the shell on one mesh.

    Under a hand the shell's stress is that of the certificate, with its margin.

    load   what was done to the part, in words
    bytes  what was reckoned to be needed
    """

    solid_deflection_mm: float
    shell_deflection_mm: float
    solid_stress_mpa: float
    shell_stress_mpa: float
    unknowns: int
    solver: str
    load: str = ""
    bytes: float = 0.0

    @property
    def deflection_ratio(self) -> float:
        """Shell over solid."""
        return self.shell_deflection_mm / self.solid_deflection_mm

    @property
    def stress_ratio(self) -> float:
        """Shell over solid."""
        return self.shell_stress_mpa / self.solid_stress_mpa


def verify_solid(
    pattern: Pattern, placement: Placement, case: Case, edge_mm: float | None = None
) -> SolidCheck:
    """Any design as a solid: the same mesh, load and supports, in three dimensions.

    Of loads of a hand the one that asks most of the part is compared. The mesh is the finest of a few that is
    reckoned to need no more than 2 GB.

    Raises:
        AnalysisError: as `analyse`; or the solid needs too much memory.
    """
    part = Part.of(pattern, placement, roots=False)
    upright = replace(case, flare_mm=0.0)
    edge = edge_mm or EDGE_MODULES * pattern.module_mm
    needed = 0.0
    for nozzles in OUTLINE_NOZZLES:
        size = MeshSize(edge, edge, 0.0, nozzles * case.nozzle_mm)
        model = prepare(part, upright, size)
        needed = memory(model)
        if needed <= MOST_BYTES:
            break
    else:
        raise AnalysisError(
            f"the part in three dimensions needs {needed / 1e9:.1f} GB (limit {MOST_BYTES / 1e9:g})",
            Remedy(verify_solid=None),
            "a lower version",
        )
    shell = prepare(Part.of(pattern, placement), upright, size)
    if not case.handling:
        return replace(check(model, upright, shell=shell), bytes=needed)
    worst = assess(pattern, placement, upright, edge).capacities[0]
    return replace(check(model, upright, worst, shell), load=worst.words, bytes=needed)


def memory(model: Model) -> float:
    """Bytes that the solid of a shell's mesh is reckoned to need."""
    wedges = sum(int(slab.elements.sum()) for slab in _slabs(model))
    unknowns = wedge.DOFS * (2 * len(_slabs(model)) + 1) * len(model.mesh.nodes)
    return BYTES_OF_FACTOR * unknowns ** (4 / 3) + BYTES_OF_WEDGE * wedges


def check(model: Model, case: Case, worst: Capacity | None = None, shell: Model | None = None) -> SolidCheck:
    """The solid on a shell's mesh against that shell or another of the same part, under the loads of the case
    or one of a hand."""
    shell = model if shell is None else shell
    ours = Hand(shell, shell.factorise(case.solver), case)
    hand = Hand(model, ours.factor, case)  # its factor is not asked
    if worst is None:
        pushed = forces_of(shell, case.loads, ours.factor)
        forces = pushed if shell is model else forces_of(model, case.loads, hand.factor)
    else:
        pushed, forces = (worst.asked_n * one.forces(worst.push) for one in (ours, hand))
    shell_answer = ours.factor.solve(np.where(shell.fixed, 0.0, pushed))
    solid = _Solid(model, _slabs(model))
    answer, unknowns, solver = solid.solve(model.translations(forces), case.solver)
    discs = Discs(model.mesh, case.nozzle_mm)
    margin = 1.0 if worst is None else STRESS_MARGIN
    motion = answer[solid.middle]
    if worst is None:
        deflections = [
            np.einsum("nc,nc->n", motion, model.frames[:, 2]),
            np.einsum("nc,nc->n", shell.translations(shell_answer), shell.frames[:, 2]),
        ]
    else:
        along = np.einsum("nc,nc->n", motion, model.frames[:, 2])[:, None] if model.flat else motion
        deflections = [hand.against_hold(worst.push, along), ours.deflection(worst.push, shell_answer)]
    return SolidCheck(
        solid_deflection_mm=float(np.abs(deflections[0]).max()),
        shell_deflection_mm=float(np.abs(deflections[1]).max()),
        solid_stress_mpa=float(discs.most_stressed(solid.stresses(answer))[1][0]),
        shell_stress_mpa=margin * float(ours.discs.most_stressed(shell.corner_stresses(shell_answer))[1][0]),
        unknowns=unknowns,
        solver=solver,
    )


@dataclass(frozen=True)
class _Solid:
    """Slabs of wedges on a shell's mesh. Where they meet, or half-way up a single one, the load acts."""

    model: Model
    slabs: list[_Slab]

    @property
    def middle(self) -> int:
        """The layer of nodes that is loaded."""
        return len(self.slabs)

    def _nodes(self, slab: _Slab) -> tuple[Floats, Floats]:
        """The middle surface (n, 3) of a slab, and from there to its top, (n, 3)."""
        model = self.model
        ends = [
            model.positions + (height - 0.5 * model.wall_mm) * model.frames[:, 2]
            for height in (slab.bottom_mm, slab.top_mm)
        ]
        return 0.5 * (ends[0] + ends[1]), 0.5 * (ends[1] - ends[0])

    def solve(self, loads: Floats, solver: str | None) -> tuple[Floats, int, str]:
        """Displacements (layers, n, 3) under nodal forces (n, 3), how many unknowns, and what solved them."""
        model = self.model
        nodes, layers = len(model.mesh.nodes), 2 * len(self.slabs) + 1
        fixed = np.ones((layers, nodes, wedge.DOFS), bool)  # and so it stays where there is no material
        elements, matrices = [], []
        for level, slab in enumerate(self.slabs):
            triangles = model.mesh.elements[slab.elements]
            elements.append(wedge.layered(triangles, nodes) + 2 * level * nodes)
            middle, half = self._nodes(slab)
            matrices.append(wedge.stiffness(middle, half, triangles, 2.0, model.material))
            fixed[2 * level : 2 * level + wedge.LAYERS, np.unique(triangles)] = False
        held = model.fixed.reshape(nodes, -1)[:, 0]
        if model.support.hold is Hold.FREE:
            fixed[self.middle] |= pins(model.positions, flat=False)[:, : wedge.DOFS]
        elif model.support.hold.pinned:  # held there only, so that the edge may turn
            fixed[self.middle, held] = True
        else:
            fixed[:, held] = True
        system = System(np.concatenate(elements), wedge.DOFS, np.concatenate(matrices), fixed.ravel())
        lower = system.lower()
        del system, matrices, elements  # a third of what the factor needs
        right = np.zeros(fixed.shape)
        right[self.middle] = loads
        factor = factorise(lower, solver)
        answer = factor.solve(np.where(fixed, 0.0, right).ravel())
        return answer.reshape(fixed.shape), int(np.count_nonzero(~fixed)), factor.name

    def stresses(self, answer: Floats) -> Floats:
        """Stress tensors (m, 3, layers, 5) at the element corners, as a shell has them."""
        model = self.model
        out = np.zeros((len(model.mesh.elements), 3, wedge.LAYERS * len(self.slabs), 5))
        for level, slab in enumerate(self.slabs):
            triangles = model.mesh.elements[slab.elements]
            part = answer[2 * level : 2 * level + wedge.LAYERS]
            middle, half = self._nodes(slab)
            found = wedge.stresses((middle, half), model.frames, triangles, 2.0, model.material, part.ravel())
            out[slab.elements, :, wedge.LAYERS * level : wedge.LAYERS * (level + 1)] = found
        return out


@dataclass(frozen=True)
class _Slab:
    """A layer of the wall between two heights above its back, and the elements (m,) that have it."""

    bottom_mm: float
    top_mm: float
    elements: Flags

    @property
    def thickness_mm(self) -> float:
        return self.top_mm - self.bottom_mm


def _slabs(model: Model) -> list[_Slab]:
    """The wall as one slab, or as two where it has thin bars, which fill its back.

    Raises:
        AnalysisError: thin bars of several heights.
    """
    thickness = np.broadcast_to(model.section.thickness_mm, len(model.mesh.elements))
    heights = np.unique(thickness)
    if len(heights) > 2:
        raise AnalysisError(f"the solid check knows bars of one height, not of {heights[:-1].tolist()} mm")
    bounds = [0.0, *heights.tolist()]
    return [_Slab(low, high, thickness >= high) for low, high in pairwise(bounds)]
