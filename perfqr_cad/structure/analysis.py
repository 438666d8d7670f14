"""Strength of a pattern on a placement: mesh, element matrices, one factorisation, stress."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
import shapely
from shapely.geometry import Polygon

from perfqr_cad.errors import AnalysisError
from perfqr_cad.structure.domain import clean
from perfqr_cad.structure.field import StressField
from perfqr_cad.structure.gmsher import triangulate
from perfqr_cad.structure.loads import Load, Support, Weight
from perfqr_cad.structure.materials import Material
from perfqr_cad.structure.materials import material as material_named
from perfqr_cad.structure.measure import DiscAverage, disc_average, von_mises
from perfqr_cad.structure.model import Model, build_model, forces_of
from perfqr_cad.structure.solvers import factorise
from perfqr_cad.structure.t6 import EDGES, Floats, Ints, Mesh
from perfqr_cad.surface import Placement
from perfqr_cad.units import grams

if TYPE_CHECKING:
    from perfqr_cad.pattern import Pattern

MESH_SIZE_MODULES = 2 / 3  # largest element edge, in modules: see docs/strength.md, refinement
# How far the outline may move in the model, and element edges at re-entrant corners, both in nozzle widths.
# The first pair that keeps the outline within the limit of points is taken: every point costs about 60 to
# 190 unknowns, and beyond some 10⁶ of them the factor does not fit the index range of SuperLU.
DETAIL_NOZZLES = ((0.05, 1.0), (0.25, 1.0), (0.5, 2.0))
MOST_OUTLINE_POINTS = 8000
DEFAULT_NOZZLE_MM = 0.4
LINEAR_LIMIT_THICKNESSES = 0.5  # deflection above which stretching, which a linear model lacks, carries load
BALANCE_LIMIT = 1e-6  # a solution whose reactions miss the load by more is no solution


def analyse(
    pattern: Pattern,
    placement: Placement,
    *,
    material: Material | str = "PLA",
    load: Load,
    support: Support | str = "clamped",
    yield_mpa: float | None = None,
    nozzle_mm: float = DEFAULT_NOZZLE_MM,
    mesh_size_mm: float | None = None,
    solver: str | None = None,
) -> StressField:
    """The stress field of a pattern; see `analyse_region` for the arguments."""
    return analyse_region(
        pattern.polygon,
        placement,
        material=material,
        load=load,
        support=support,
        yield_mpa=yield_mpa,
        nozzle_mm=nozzle_mm,
        mesh_size_mm=mesh_size_mm or MESH_SIZE_MODULES * pattern.module_mm,
        solver=solver,
    )


def analyse_region(
    polygon: Polygon,
    placement: Placement,
    *,
    material: Material | str = "PLA",
    load: Load,
    support: Support | str = "clamped",
    yield_mpa: float | None = None,
    nozzle_mm: float = DEFAULT_NOZZLE_MM,
    mesh_size_mm: float,
    solver: str | None = None,
) -> StressField:
    """The stress field of a light region (mm, in the pattern plane) as a Reissner-Mindlin shell.

    `yield_mpa` None takes the material's. `mesh_size_mm` is the largest element edge. `solver` is "CHOLMOD",
    "SuperLU" or None for the best one installed.

    Raises:
        AnalysisError: the region is empty, not finite, in pieces or not held, or a figure is out of range.
    """
    stuff = material_named(material) if isinstance(material, str) else material
    model = prepare(
        polygon,
        placement,
        stuff,
        support,
        nozzle_mm=nozzle_mm,
        mesh_size_mm=mesh_size_mm,
        bends=bends_only(load),
    )
    factor = factorise(model.lower(), solver)
    forces = forces_of(model, load, factor)
    displacement = factor.solve(np.where(model.fixed, 0.0, forces))
    average = disc_average(model.mesh, nozzle_mm)
    return field_of(model, displacement, forces, average=average, yield_mpa=yield_mpa, solver=factor.name)


def prepare(
    polygon: Polygon,
    placement: Placement,
    material: Material,
    support: Support | str,
    *,
    nozzle_mm: float,
    mesh_size_mm: float,
    corner_size_mm: float | None = None,
    bends: bool = True,
) -> Model:
    """Clean the region, mesh it and build its element matrices.

    `corner_size_mm` None takes the nozzle's width.

    A flat part is a plate of 3 unknowns a node as long as its load only `bends` it; else it is a shell.
    """
    for label, value in (
        ("thickness", placement.thickness_mm),
        ("nozzle", nozzle_mm),
        ("mesh size", mesh_size_mm),
    ):
        if not (math.isfinite(value) and value > 0.0):
            raise AnalysisError(f"{label} is {value} mm; it must be a positive number")
    domain, corner_nozzles = _domain(polygon, nozzle_mm)
    mesh = triangulate(domain, mesh_size_mm, corner_size_mm or corner_nozzles * nozzle_mm)
    held = support if isinstance(support, Support) else Support(support)  # type: ignore[arg-type]
    return build_model(mesh, domain, placement, material, held, mesh_size_mm, placement.is_flat and bends)


def _domain(polygon: Polygon, nozzle_mm: float) -> tuple[Polygon, float]:
    """The cleaned outline in the most detail that can be afforded, and the corner size in nozzle widths."""
    *finer, (coarsest, coarse_corner) = DETAIL_NOZZLES
    for tolerance, corner in finer:
        domain = clean(polygon, tolerance * nozzle_mm)
        if shapely.get_num_coordinates(domain) <= MOST_OUTLINE_POINTS:
            return domain, corner
    return clean(polygon, coarsest * nozzle_mm), coarse_corner


def bends_only(load: Load) -> bool:
    """Whether a load acts along the normal of a flat part."""
    return not (isinstance(load, Weight) and load.direction is not None)


def field_of(
    model: Model,
    displacement: Floats,
    forces: Floats,
    *,
    average: DiscAverage,
    yield_mpa: float | None,
    solver: str,
) -> StressField:
    """Stress, deflection and reactions of a solved model.

    Raises:
        AnalysisError: the reactions do not balance the load: the part is free to move.
    """
    stress = model.corner_stresses(displacement)
    averaged = von_mises(average(stress)).max(axis=1)
    peak = int(np.argmax(averaged))
    deflection = np.einsum("nc,nc->n", model.translations(displacement), model.frames[:, 2])
    lowest = int(np.argmax(np.abs(deflection)))
    load, reactions, balance = _balance(model, displacement, forces)
    thickness = model.section.thickness_mm
    return StressField(
        uv_mm=model.mesh.nodes,
        nodes_mm=model.positions,
        triangles=_quarters(model.mesh),
        displacement_mm=model.translations(displacement),
        deflection_mm=deflection,
        von_mises_mpa=_at_all_nodes(model.mesh, averaged),
        max_stress_mpa=float(averaged[peak]),
        max_stress_at_mm=_pair(model.mesh.nodes[peak]),
        sharp_peak_mpa=float(von_mises(stress).max()),
        disc_width_mm=average.width_mm,
        max_deflection_mm=float(abs(deflection[lowest])),
        max_deflection_at_mm=_pair(model.mesh.nodes[lowest]),
        yield_mpa=model.material.yield_mpa if yield_mpa is None else yield_mpa,
        mass_g=grams(float(model.area_mm2.sum()) * thickness, model.material.density_kg_m3),
        load_n=load,
        reactions_n=reactions,
        balance=balance,
        material=model.material.name,
        support=str(model.support.hold),
        thickness_mm=thickness,
        mesh_size_mm=model.mesh_size_mm,
        unknowns=int(np.count_nonzero(~model.fixed)),
        solver=solver,
        warnings=_warnings(float(abs(deflection[lowest])), thickness),
    )


def _balance(
    model: Model, displacement: Floats, forces: Floats
) -> tuple[tuple[float, float, float], tuple[float, float, float], float]:
    """Resultants of load and reactions in N, and the unbalanced share of the load."""
    held = np.where(model.fixed, model.system.internal_forces(displacement) - forces, 0.0)
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
        " this linear answer overstates both deflection and stress",
    )


def _quarters(mesh: Mesh) -> Ints:
    """Four corner triangles to each six-node one, for drawing: (4m, 3)."""
    return mesh.elements[:, [[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]]].reshape(-1, 3)


def _at_all_nodes(mesh: Mesh, at_corners: Floats) -> Floats:
    """Values at the corner nodes, and their mean at the middles between them."""
    out = np.empty(len(mesh.nodes))
    out[: mesh.corners] = at_corners
    for k, edge in enumerate(EDGES):
        out[mesh.elements[:, 3 + k]] = at_corners[mesh.elements[:, edge]].mean(axis=1)
    return out


def _pair(point: Floats) -> tuple[float, float]:
    return float(point[0]), float(point[1])


def _triple(vector: Floats) -> tuple[float, float, float]:
    return float(vector[0]), float(vector[1]), float(vector[2])
