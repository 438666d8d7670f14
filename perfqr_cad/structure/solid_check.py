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
from perfqr_cad.structure.analysis import DEFAULT_NOZZLE_MM, bends_only, lattice_of, prepare
from perfqr_cad.structure.assembly import Flags, System
from perfqr_cad.structure.domain import thin_parts
from perfqr_cad.structure.loads import Load, Loads, Support
from perfqr_cad.structure.materials import Material
from perfqr_cad.structure.materials import material as material_named
from perfqr_cad.structure.measure import Discs
from perfqr_cad.structure.model import Model, forces_of
from perfqr_cad.structure.t6 import (
    FROM_GAUSS_TO_CORNERS,
    SIX_POINTS,
    SIX_WEIGHTS,
    THREE_POINTS,
    Floats,
    Ints,
    gradients,
    shapes,
)
from perfqr_cad.surface import Placement

if TYPE_CHECKING:
    from perfqr_cad.pattern import Pattern

DOFS = 3
LAYERS = 3  # of nodes in a slab: back, middle, front
MESH_SIZE_MODULES = 1.0  # shell and solid are compared on one mesh, which need not be fine
_THROUGH_POINTS, _THROUGH_WEIGHTS = np.polynomial.legendre.leggauss(2)
_CHUNK = 4_000  # elements at a time


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
    pattern: Pattern,
    placement: Placement,
    *,
    material: Material | str = "PLA",
    load: Load | Loads,
    support: Support | str = "clamped",
    nozzle_mm: float = DEFAULT_NOZZLE_MM,
    mesh_size_mm: float | None = None,
    solver: str | None = None,
) -> SolidCheck:
    """Any design as a solid: the same mesh, load and supports, in three dimensions.

    Raises:
        AnalysisError: as `analyse`.
    """
    size = mesh_size_mm or MESH_SIZE_MODULES * pattern.module_mm
    stuff = material_named(material) if isinstance(material, str) else material
    model = prepare(
        pattern.polygon,
        placement,
        stuff,
        support,
        nozzle_mm=nozzle_mm,
        mesh_size_mm=size,
        thin=thin_parts(pattern, placement.thickness_mm),
        lattice=lattice_of(pattern),
        bends=bends_only(load),
    )
    return check(model, load, nozzle_mm, solver)


def check(model: Model, load: Load | Loads, nozzle_mm: float, solver: str | None = None) -> SolidCheck:
    """A shell model against the solid on its mesh."""
    shell_factor = model.factorise(solver)
    forces = forces_of(model, load, shell_factor)
    shell_answer = shell_factor.solve(np.where(model.fixed, 0.0, forces))

    slabs = _slabs(model)
    nodes, layers = len(model.mesh.nodes), 2 * len(slabs) + 1
    normals = model.frames[:, 2]
    free = ~model.fixed.reshape(nodes, -1)[:, 0]
    fixed = np.ones((layers, nodes), bool)  # and so it stays where there is no material
    elements, matrices = [], []
    for level, slab in enumerate(slabs):
        triangles = model.mesh.elements[slab.elements]
        elements.append(layered(triangles, nodes) + 2 * level * nodes)
        matrices.append(stiffness(slab.middle(model), normals, triangles, slab.thickness_mm, model.material))
        fixed[2 * level : 2 * level + LAYERS, np.unique(triangles)] = False
    loaded = layers // 2  # the middle of the wall, or where its slabs meet
    if model.support.hold.pinned:  # held there only, so that the edge may turn
        fixed[loaded] |= ~free
    else:
        fixed |= ~free
    unknowns = np.repeat(fixed.ravel(), DOFS)
    system = System(np.concatenate(elements), DOFS, np.concatenate(matrices), unknowns)
    right = np.zeros((layers, nodes, DOFS))
    right[loaded] = model.translations(forces)
    factor = system.factorise(solver)
    answer = factor.solve(np.where(unknowns, 0.0, right.ravel())).reshape(layers, nodes, DOFS)

    discs = Discs(model.mesh, nozzle_mm)
    solid = np.zeros((len(model.mesh.elements), 3, LAYERS * len(slabs), 5))
    for level, slab in enumerate(slabs):
        triangles, part = model.mesh.elements[slab.elements], answer[2 * level : 2 * level + LAYERS]
        solid[slab.elements, :, LAYERS * level : LAYERS * (level + 1)] = stresses(
            slab.middle(model), model.frames, triangles, slab.thickness_mm, model.material, part.ravel()
        )
    return SolidCheck(
        solid_deflection_mm=float(np.abs(np.einsum("nc,nc->n", answer[loaded], normals)).max()),
        shell_deflection_mm=float(
            np.abs(np.einsum("nc,nc->n", model.translations(shell_answer), normals)).max()
        ),
        solid_stress_mpa=float(discs.hottest(solid)[1][0]),
        shell_stress_mpa=float(discs.hottest(model.corner_stresses(shell_answer))[1][0]),
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


def layered(elements: Ints, nodes: int) -> Ints:
    """Wedge connectivity (m, 18): the triangle's six nodes on the back, the middle and the front layer."""
    return np.concatenate([elements + layer * nodes for layer in range(LAYERS)], axis=1)


def elasticity(material: Material) -> Floats:
    """The elasticity matrix (6, 6) in MPa for (xx, yy, zz, xy, yz, zx)."""
    lame = material.e_mpa * material.nu / ((1 + material.nu) * (1 - 2 * material.nu))
    c = np.zeros((6, 6))
    c[:3, :3] = lame
    c[range(3), range(3)] += 2 * material.shear_mpa
    c[range(3, 6), range(3, 6)] = material.shear_mpa
    return c


def stiffness(
    positions: Floats, normals: Floats, triangles: Ints, thickness_mm: float, material: Material
) -> Floats:
    """Element stiffness matrices (m, 54, 54), unknowns node by node, layer by layer."""
    root = np.linalg.cholesky(elasticity(material)).T
    out = np.empty((len(triangles), 54, 54))
    for start in range(0, len(triangles), _CHUNK):
        part = slice(start, start + _CHUNK)
        x, n = positions[triangles[part]], normals[triangles[part]]
        rows = []
        for point, weight in zip(SIX_POINTS, SIX_WEIGHTS, strict=True):
            for zeta, through in zip(_THROUGH_POINTS, _THROUGH_WEIGHTS, strict=True):
                strain, volume = _strains(x, n, point, float(zeta), thickness_mm)
                rows.append(root @ strain * np.sqrt(weight * through * volume)[:, None, None])
        stacked = np.concatenate(rows, axis=1)
        np.matmul(stacked.transpose(0, 2, 1), stacked, out=out[part])
    return out


def _strains(x: Floats, n: Floats, point: Floats, zeta: float, thickness_mm: float) -> tuple[Floats, Floats]:
    """Strains (m, 6, 54) in space axes and the volume Jacobian (m,) at a point of each wedge."""
    value, slope = shapes(point[None])[0], gradients(point[None])[0]
    through = np.array([zeta * (zeta - 1) / 2, 1 - zeta**2, zeta * (zeta + 1) / 2])
    through_slope = np.array([zeta - 0.5, -2 * zeta, zeta + 0.5])
    half = 0.5 * thickness_mm
    layer = x + zeta * half * n
    jacobian = np.stack([slope[0] @ layer, slope[1] @ layer, value @ n * half], axis=1)
    local = np.stack(
        [np.outer(through, slope[0]), np.outer(through, slope[1]), np.outer(through_slope, value)]
    ).reshape(3, -1)
    d = np.linalg.inv(jacobian) @ local
    b = np.zeros((len(x), 6, 18, DOFS))
    for row, (p, q) in enumerate(((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0))):
        b[:, row, :, q] = d[:, p]
        b[:, row, :, p] = d[:, q]
    return b.reshape(len(x), 6, 54), np.linalg.det(jacobian)


def stresses(
    positions: Floats,
    frames: Floats,
    triangles: Ints,
    thickness_mm: float,
    material: Material,
    displacement: Floats,
) -> Floats:
    """(σ11, σ22, τ12, τ13, τ23) in surface axes at the element corners: (m, 3, 3, 5), back, middle, front."""
    c = elasticity(material)
    u = displacement.reshape(-1, DOFS)[layered(triangles, len(positions))].reshape(len(triangles), -1)
    axes = frames[triangles[:, 0]]
    at_gauss = np.empty((len(triangles), 3, LAYERS, 5))
    for start in range(0, len(triangles), _CHUNK):
        part = slice(start, start + _CHUNK)
        x, n = positions[triangles[part]], frames[triangles[part], 2]
        for g, point in enumerate(THREE_POINTS):
            for layer, zeta in enumerate((-1.0, 0.0, 1.0)):
                strain, _ = _strains(x, n, point, zeta, thickness_mm)
                xx, yy, zz, xy, yz, zx = np.einsum("ab,mbi,mi->am", c, strain, u[part], optimize=True)
                tensor = np.stack([xx, xy, zx, xy, yy, yz, zx, yz, zz], axis=1).reshape(-1, 3, 3)
                local = axes[part] @ tensor @ axes[part].transpose(0, 2, 1)
                at_gauss[part, g, layer] = np.stack(
                    [local[:, 0, 0], local[:, 1, 1], local[:, 0, 1], local[:, 0, 2], local[:, 1, 2]], axis=1
                )
    return np.einsum("ng,mgla->mnla", FROM_GAUSS_TO_CORNERS, at_gauss)
