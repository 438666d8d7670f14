"""Strength of a pattern on a placement: mesh, element matrices, one factorisation, stress."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from shapely.geometry import Polygon

from perfqr_cad.errors import AnalysisError
from perfqr_cad.structure.domain import ThinPart, by_thickness, clean, thin_parts
from perfqr_cad.structure.field import StressField
from perfqr_cad.structure.loads import Load, Loads, Support, Weight
from perfqr_cad.structure.materials import Material
from perfqr_cad.structure.materials import material as material_named
from perfqr_cad.structure.measure import Discs, von_mises
from perfqr_cad.structure.model import Model, build_model, forces_of, unknowns
from perfqr_cad.structure.patches import Patches
from perfqr_cad.structure.quilt import patched
from perfqr_cad.structure.seeding import Grain
from perfqr_cad.structure.t6 import Floats
from perfqr_cad.structure.taper import STRAIGHT, Taper
from perfqr_cad.structure.tiling import Lattice
from perfqr_cad.surface import Placement
from perfqr_cad.units import grams

if TYPE_CHECKING:
    from perfqr_cad.pattern import Pattern

MESH_SIZE_MODULES = 2 / 3  # largest element edge, in modules: see docs/strength.md, refinement
MOST_UNKNOWNS = 1_500_000  # of the mesh that is tried first; a coarser one is 1 to 1.5 % off
CORNER_NOZZLES = 1.0  # element edges at sharp re-entrant corners
LAYER_MESH_SIZES = 0.25  # edges next to free walls, where twisting has its boundary layer
TOLERANCE_NOZZLES = 0.05  # how far the outline may move in the model
TILE_MESH_SIZES = 1.5  # edge of a tile where a region has no modules
DEFAULT_NOZZLE_MM = 0.4
LINEAR_LIMIT_THICKNESSES = 0.5  # deflection above which stretching, which a linear model lacks, carries load
BALANCE_LIMIT = 1e-6  # a solution whose reactions miss the load by more is no solution


def analyse(
    pattern: Pattern,
    placement: Placement,
    *,
    material: Material | str = "PLA",
    load: Load | Loads,
    support: Support | str = "clamped",
    yield_mpa: float | None = None,
    nozzle_mm: float = DEFAULT_NOZZLE_MM,
    mesh_size_mm: float | None = None,
    flare_mm: float = 0.0,
    solver: str | None = None,
    patches: Patches | None = None,
) -> StressField:
    """The stress field of a pattern, recessed bars with their own thickness; see `analyse_region`.

    `flare_mm` is how far holes are wider at the back, to each side; see `Taper`.
    """
    return analyse_region(
        pattern.polygon,
        placement,
        thin=thin_parts(pattern, placement.thickness_mm),
        material=material,
        load=load,
        support=support,
        yield_mpa=yield_mpa,
        nozzle_mm=nozzle_mm,
        mesh_size_mm=mesh_size_mm or MESH_SIZE_MODULES * pattern.module_mm,
        most_unknowns=MOST_UNKNOWNS if mesh_size_mm is None else None,
        lattice=lattice_of(pattern),
        taper=Taper.of(pattern.spec.web_mm, flare_mm),
        solver=solver,
        patches=patches,
    )


def lattice_of(pattern: Pattern) -> Lattice:
    """The lattice of a pattern's modules."""
    half = 0.5 * pattern.symbol.size * pattern.module_mm
    return Lattice(pattern.module_mm, (-half, -half))


def analyse_region(
    polygon: Polygon,
    placement: Placement,
    *,
    material: Material | str = "PLA",
    load: Load | Loads,
    support: Support | str = "clamped",
    yield_mpa: float | None = None,
    nozzle_mm: float = DEFAULT_NOZZLE_MM,
    mesh_size_mm: float,
    most_unknowns: int | None = None,
    thin: Sequence[ThinPart] = (),
    lattice: Lattice | None = None,
    taper: Taper = STRAIGHT,
    solver: str | None = None,
    patches: Patches | None = None,
) -> StressField:
    """The stress field of a light region (mm, in the pattern plane) as a Reissner-Mindlin shell.

    `thin` are parts of it that do not fill the wall. Several loads act together. `yield_mpa` None takes the
    material's. `mesh_size_mm` is the largest element edge; a mesh of more than `most_unknowns` is made
    coarser once. `solver` is "CHOLMOD", "SuperLU" or None for the best one installed. `patches` are meshes of
    tiles to use again, on one lattice and with one mesh size.

    Raises:
        AnalysisError: the region is empty, not finite, in pieces or not held, or a figure is out of range.
    """
    stuff = material_named(material) if isinstance(material, str) else material
    if yield_mpa is not None and not yield_mpa > 0.0:
        raise AnalysisError(f"yield stress is {yield_mpa} MPa; it must be a positive number")
    model = prepare(
        polygon,
        placement,
        stuff,
        support,
        nozzle_mm=nozzle_mm,
        mesh_size_mm=mesh_size_mm,
        most_unknowns=most_unknowns,
        thin=thin,
        lattice=lattice,
        bends=bends_only(load),
        patches=patches,
    )
    factor = model.factorise(solver)
    forces = forces_of(model, load, factor)
    displacement = factor.solve(np.where(model.fixed, 0.0, forces))
    return field_of(
        model,
        displacement,
        forces,
        nozzle_mm=nozzle_mm,
        yield_mpa=yield_mpa,
        taper=taper,
        solver=factor.name,
    )


def prepare(
    polygon: Polygon,
    placement: Placement,
    material: Material,
    support: Support | str,
    *,
    nozzle_mm: float,
    mesh_size_mm: float,
    corner_size_mm: float | None = None,
    layer_size_mm: float | None = None,
    most_unknowns: int | None = None,
    thin: Sequence[ThinPart] = (),
    lattice: Lattice | None = None,
    bends: bool = True,
    patches: Patches | None = None,
) -> Model:
    """Clean the region, mesh it and build its element matrices.

    `corner_size_mm` None takes the nozzle's width, `layer_size_mm` None a share of the mesh size.

    A flat part is a plate of 3 unknowns a node as long as its load only `bends` it; else it is a shell.
    """
    for label, value in (
        ("thickness", placement.thickness_mm),
        ("nozzle", nozzle_mm),
        ("mesh size", mesh_size_mm),
    ):
        if not (math.isfinite(value) and value > 0.0):
            raise AnalysisError(f"{label} is {value} mm; it must be a positive number")
    domain = clean(polygon)
    lattice = lattice or Lattice(TILE_MESH_SIZES * mesh_size_mm)
    grain = grain_of(mesh_size_mm, nozzle_mm, corner_size_mm, layer_size_mm)
    classes = by_thickness(domain, thin, placement.thickness_mm)
    flat = placement.is_flat and bends
    quilt = patched(list(classes.values()), lattice, patches or Patches(grain))
    if most_unknowns is not None and unknowns(quilt.mesh, flat) > most_unknowns:
        grain = grain.coarser()
        quilt = patched(list(classes.values()), lattice, Patches(grain))
    held = support if isinstance(support, Support) else Support(support)  # type: ignore[arg-type]
    return build_model(quilt, domain, placement, material, held, grain.size_mm, flat, tuple(classes))


def grain_of(
    mesh_size_mm: float,
    nozzle_mm: float,
    corner_size_mm: float | None = None,
    layer_size_mm: float | None = None,
) -> Grain:
    """The grain of a mesh; see `prepare`."""
    return Grain(
        size_mm=mesh_size_mm,
        corner_mm=corner_size_mm or CORNER_NOZZLES * nozzle_mm,
        layer_mm=LAYER_MESH_SIZES * mesh_size_mm if layer_size_mm is None else layer_size_mm,
        tolerance_mm=TOLERANCE_NOZZLES * nozzle_mm,
    )


def bends_only(load: Load | Loads) -> bool:
    """Whether loads act along the normal of a flat part."""
    loads = load if isinstance(load, tuple) else (load,)
    return not any(isinstance(one, Weight) and one.direction is not None for one in loads)


def field_of(
    model: Model,
    displacement: Floats,
    forces: Floats,
    *,
    nozzle_mm: float,
    yield_mpa: float | None,
    taper: Taper,
    solver: str,
) -> StressField:
    """Stress, deflection and reactions of a solved model.

    Raises:
        AnalysisError: the reactions do not balance the load: the part is free to move.
    """
    stress = taper.stress * model.corner_stresses(displacement)
    hottest, measure = Discs(model.mesh, nozzle_mm).hottest(stress)
    motion = taper.deflection * model.translations(displacement)
    deflection = np.einsum("nc,nc->n", motion, model.frames[:, 2])
    lowest = int(np.argmax(np.abs(deflection)))
    load, reactions, balance = _balance(model, displacement, forces)
    volume = float(model.area_mm2 @ np.broadcast_to(model.section.thickness_mm, len(model.area_mm2)))
    return StressField(
        mesh=model.mesh,
        nodes_mm=model.positions,
        displacement_mm=motion,
        deflection_mm=deflection,
        stress_mpa=stress,
        max_stress_mpa=float(measure[0]),
        max_stress_at_mm=_pair(model.mesh.nodes[hottest[0]]),
        sharp_peak_mpa=float(von_mises(stress).max()),
        disc_width_mm=nozzle_mm,
        max_deflection_mm=float(abs(deflection[lowest])),
        max_deflection_at_mm=_pair(model.mesh.nodes[lowest]),
        yield_mpa=model.material.yield_mpa if yield_mpa is None else yield_mpa,
        mass_g=grams(volume, model.material.density_kg_m3),
        load_n=load,
        reactions_n=reactions,
        balance=balance,
        material=model.material.name,
        support=str(model.support.hold),
        thickness_mm=model.wall_mm,
        mesh_size_mm=model.mesh_size_mm,
        unknowns=int(np.count_nonzero(~model.fixed)),
        solver=solver,
        taper=taper,
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
        " this linear answer overstates both deflection and stress",
    )


def _pair(point: Floats) -> tuple[float, float]:
    return float(point[0]), float(point[1])


def _triple(vector: Floats) -> tuple[float, float, float]:
    return float(vector[0]), float(vector[1]), float(vector[2])
