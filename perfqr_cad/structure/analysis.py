"""Strength of a part: mesh, element matrices, one factorisation, stress."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from perfqr_cad.errors import AnalysisError
from perfqr_cad.structure.case import Case
from perfqr_cad.structure.measure import Discs, von_mises
from perfqr_cad.structure.mesh.light_region import by_thickness, clean
from perfqr_cad.structure.mesh.seeding import MeshSize
from perfqr_cad.structure.mesh.tile_meshes import TileMeshes
from perfqr_cad.structure.mesh.tiled_mesh import tiled_mesh
from perfqr_cad.structure.mesh.tiling import TileLattice
from perfqr_cad.structure.mesh.triangle import Floats
from perfqr_cad.structure.part import Part
from perfqr_cad.structure.shell_model import Model, build_model, forces_of, unknowns
from perfqr_cad.structure.stress_field import StressField
from perfqr_cad.surface import Placement

if TYPE_CHECKING:
    from perfqr_cad.pattern import Pattern

EDGE_MODULES = 2 / 3  # largest element edge, in modules: see docs/strength.md, refinement
MOST_UNKNOWNS = 1_500_000  # of the mesh that is tried first; a coarser one is 1 to 1.5 % off
TILE_EDGES = 1.5  # edge of a tile, in element edges, where a region has no modules
LINEAR_LIMIT_THICKNESSES = 0.5  # deflection above which stretching, which a linear model lacks, carries load
BALANCE_LIMIT = 1e-6  # a solution whose reactions miss the load by more is no solution


def analyse(
    pattern: Pattern,
    placement: Placement,
    case: Case,
    edge_mm: float | None = None,
    tile_meshes: TileMeshes | None = None,
) -> StressField:
    """The stress field of a pattern, recessed bars with their own thickness.

    `edge_mm` is the largest element edge; None takes 2/3 module, and longer ones where that gives more than
    `MOST_UNKNOWNS`. See `analyse_part` for the rest.
    """
    size = MeshSize.graded(edge_mm or EDGE_MODULES * pattern.module_mm, case.nozzle_mm)
    most = MOST_UNKNOWNS if edge_mm is None else None
    return analyse_part(Part.of(pattern, placement), case, size, tile_meshes, most)


def analyse_part(
    part: Part,
    case: Case,
    size: MeshSize,
    tile_meshes: TileMeshes | None = None,
    most_unknowns: int | None = None,
) -> StressField:
    """The stress field of a part as a Reissner-Mindlin shell; the loads of the case act together.

    A mesh of more than `most_unknowns` is made coarser once. `tile_meshes` are meshes of tiles to use again,
    on one lattice and with one mesh size.

    Raises:
        AnalysisError: the region is empty, not finite, in pieces or not held, or a figure is out of range.
    """
    model = prepare(part, case, size, tile_meshes, most_unknowns)
    factor = model.factorise(case.solver)
    forces = forces_of(model, case.loads, factor)
    displacement = factor.solve(np.where(model.fixed, 0.0, forces))
    return field_of(model, displacement, forces, case, factor.name)


def prepare(
    part: Part,
    case: Case,
    size: MeshSize,
    tile_meshes: TileMeshes | None = None,
    most_unknowns: int | None = None,
) -> Model:
    """Clean the region, mesh it and build its element matrices.

    A flat part is a plate of 3 unknowns a node as long as its load only bends it; else it is a shell.
    """
    wall_mm = part.placement.thickness_mm
    for label, value in (("thickness", wall_mm), ("mesh size", size.edge_mm)):
        if not (math.isfinite(value) and value > 0.0):
            raise AnalysisError(f"{label} is {value} mm; it must be a positive number")
    domain = clean(part.polygon)
    lattice = part.lattice or TileLattice(TILE_EDGES * size.edge_mm)
    classes = by_thickness(domain, part.thin, wall_mm)
    flat = part.placement.is_flat and case.bends_only
    mesh = tiled_mesh(list(classes.values()), lattice, tile_meshes or TileMeshes(size))
    if most_unknowns is not None and unknowns(mesh.mesh, flat) > most_unknowns:
        size = size.coarser()
        mesh = tiled_mesh(list(classes.values()), lattice, TileMeshes(size))
    return build_model(mesh, domain, part.placement, case, size.edge_mm, flat, tuple(classes), part.web_mm)


def field_of(model: Model, displacement: Floats, forces: Floats, case: Case, solver: str) -> StressField:
    """Stress, deflection and reactions of a solved model.

    Raises:
        AnalysisError: the reactions do not balance the load: the part is free to move.
    """
    stress = model.corner_stresses(displacement)
    worst, measure = Discs(model.mesh, case.nozzle_mm).most_stressed(stress)
    motion = model.translations(displacement)
    deflection = np.einsum("nc,nc->n", motion, model.frames[:, 2])
    lowest = int(np.argmax(np.abs(deflection)))
    load, reactions, balance = _balance(model, displacement, forces)
    return StressField(
        mesh=model.mesh,
        nodes_mm=model.positions,
        displacement_mm=motion,
        deflection_mm=deflection,
        stress_mpa=stress,
        max_stress_mpa=float(measure[0]),
        max_stress_at_mm=_pair(model.mesh.nodes[worst[0]]),
        sharp_peak_mpa=float(von_mises(stress).max()),
        disc_width_mm=case.nozzle_mm,
        max_deflection_mm=float(abs(deflection[lowest])),
        max_deflection_at_mm=_pair(model.mesh.nodes[lowest]),
        yield_mpa=case.full_mpa,
        limit_mpa=case.limit_mpa,
        load_n=load,
        reactions_n=reactions,
        balance=balance,
        material=model.material.name,
        support=str(model.support.hold),
        e_mpa=model.material.e_mpa,
        nu=model.material.nu,
        kappa=model.section.kappa,
        thickness_mm=model.wall_mm,
        edge_mm=model.edge_mm,
        unknowns=int(np.count_nonzero(~model.fixed)),
        solver=solver,
        warnings=_warnings(float(abs(deflection[lowest])), model.wall_mm),
    )


def _balance(
    model: Model, displacement: Floats, forces: Floats
) -> tuple[tuple[float, float, float], tuple[float, float, float], float]:
    """Resultants of load and reactions in N, and the unbalanced share of the load."""
    held = model.system.held_forces(displacement) - np.where(model.fixed, forces, 0.0)
    load = model.translations(forces)
    reactions = model.translations(held)
    scale = float(np.abs(load).sum())
    missed = float(np.linalg.norm(load.sum(axis=0) + reactions.sum(axis=0)))
    balance = missed / scale if scale > 0.0 else 0.0
    if not balance < BALANCE_LIMIT:
        raise AnalysisError(
            f"reactions miss the load by {balance:.1e} of it (limit {BALANCE_LIMIT:.0e}):"
            " the part is free to move; hold it on its outer boundary"
        )
    return _triple(load.sum(axis=0)), _triple(reactions.sum(axis=0)), balance


def _warnings(deflection_mm: float, thickness_mm: float) -> tuple[str, ...]:
    limit = LINEAR_LIMIT_THICKNESSES * thickness_mm
    if deflection_mm <= limit:
        return ()
    return (
        f"deflection {deflection_mm:.3g} mm exceeds half the thickness ({limit:.3g} mm):"
        " this answer is linear. A part held all round is stiffer than it says; arms that end freely are not,"
        " and their stress is up to 2 % higher",
    )


def _pair(point: Floats) -> tuple[float, float]:
    return float(point[0]), float(point[1])


def _triple(vector: Floats) -> tuple[float, float, float]:
    return float(vector[0]), float(vector[1]), float(vector[2])
