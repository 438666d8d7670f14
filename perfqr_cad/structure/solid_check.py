"""The shell put through three-dimensional elasticity: 18-node wedges on the same triangles.

Quadratic in the plane and through the thickness, so the section may warp, which a shell's straight normals
may not. On modules as wide as the wall is thick that is the assumption to doubt.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from perfqr_cad.errors import AnalysisError
from perfqr_cad.structure.analysis import prepare
from perfqr_cad.structure.case import Case
from perfqr_cad.structure.elements import wedge
from perfqr_cad.structure.elements.assembly import Flags, System
from perfqr_cad.structure.measure import Discs
from perfqr_cad.structure.mesh.seeding import MeshSize
from perfqr_cad.structure.mesh.triangle import Floats
from perfqr_cad.structure.part import Part
from perfqr_cad.structure.shell_model import Model, forces_of
from perfqr_cad.surface import Placement

if TYPE_CHECKING:
    from perfqr_cad.pattern import Pattern

EDGE_MODULES = 1.0  # shell and solid are compared on one mesh, which need not be fine


@dataclass(frozen=True)
class SolidCheck:
    """Largest deflection (mm) and disc-averaged stress (MPa) of the solid and of the shell on one mesh."""

    solid_deflection_mm: float
    shell_deflection_mm: float
    solid_stress_mpa: float
    shell_stress_mpa: float
    unknowns: int
    solver: str

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

    Raises:
        AnalysisError: as `analyse`.
    """
    size = MeshSize.graded(edge_mm or EDGE_MODULES * pattern.module_mm, case.nozzle_mm)
    return check(prepare(Part.of(pattern, placement), case, size), case)


def check(model: Model, case: Case) -> SolidCheck:
    """A shell model against the solid on its mesh."""
    shell_factor = model.factorise(case.solver)
    forces = forces_of(model, case.loads, shell_factor)
    shell_answer = shell_factor.solve(np.where(model.fixed, 0.0, forces))

    slabs = _slabs(model)
    nodes, layers = len(model.mesh.nodes), 2 * len(slabs) + 1
    normals = model.frames[:, 2]
    free = ~model.fixed.reshape(nodes, -1)[:, 0]
    fixed = np.ones((layers, nodes), bool)  # and so it stays where there is no material
    elements, matrices = [], []
    for level, slab in enumerate(slabs):
        triangles = model.mesh.elements[slab.elements]
        elements.append(wedge.layered(triangles, nodes) + 2 * level * nodes)
        matrices.append(
            wedge.stiffness(slab.middle(model), normals, triangles, slab.thickness_mm, model.material)
        )
        fixed[2 * level : 2 * level + wedge.LAYERS, np.unique(triangles)] = False
    loaded = layers // 2  # the middle of the wall, or where its slabs meet
    if model.support.hold.pinned:  # held there only, so that the edge may turn
        fixed[loaded] |= ~free
    else:
        fixed |= ~free
    unknowns = np.repeat(fixed.ravel(), wedge.DOFS)
    system = System(np.concatenate(elements), wedge.DOFS, np.concatenate(matrices), unknowns)
    right = np.zeros((layers, nodes, wedge.DOFS))
    right[loaded] = model.translations(forces)
    factor = system.factorise(case.solver)
    answer = factor.solve(np.where(unknowns, 0.0, right.ravel())).reshape(layers, nodes, wedge.DOFS)

    discs = Discs(model.mesh, case.nozzle_mm)
    solid = np.zeros((len(model.mesh.elements), 3, wedge.LAYERS * len(slabs), 5))
    for level, slab in enumerate(slabs):
        triangles, part = model.mesh.elements[slab.elements], answer[2 * level : 2 * level + wedge.LAYERS]
        solid[slab.elements, :, wedge.LAYERS * level : wedge.LAYERS * (level + 1)] = wedge.stresses(
            slab.middle(model), model.frames, triangles, slab.thickness_mm, model.material, part.ravel()
        )
    return SolidCheck(
        solid_deflection_mm=float(np.abs(np.einsum("nc,nc->n", answer[loaded], normals)).max()),
        shell_deflection_mm=float(
            np.abs(np.einsum("nc,nc->n", model.translations(shell_answer), normals)).max()
        ),
        solid_stress_mpa=float(discs.most_stressed(solid)[1][0]),
        shell_stress_mpa=float(discs.most_stressed(model.corner_stresses(shell_answer))[1][0]),
        unknowns=int(np.count_nonzero(~unknowns)),
        solver=factor.name,
    )


@dataclass(frozen=True)
class _Slab:
    """A layer of the wall between two heights above its back, and the elements (m,) that have it."""

    bottom_mm: float
    top_mm: float
    elements: Flags

    @property
    def thickness_mm(self) -> float:
        return self.top_mm - self.bottom_mm

    def middle(self, model: Model) -> Floats:
        """The slab's own middle surface (n, 3)."""
        above = 0.5 * (self.bottom_mm + self.top_mm - model.wall_mm)
        return model.positions + above * model.frames[:, 2]


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
