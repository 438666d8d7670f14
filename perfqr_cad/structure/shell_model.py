"""The structure on a mesh: a flat plate (3 unknowns a node) or a curved shell (6), behind one face."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import shapely
from shapely.geometry import Polygon
from shapely.geometry.base import BaseGeometry

from perfqr_cad.errors import AnalysisError
from perfqr_cad.structure.case import Case
from perfqr_cad.structure.elements import mindlin_plate as plate
from perfqr_cad.structure.elements import mindlin_shell as shell
from perfqr_cad.structure.elements.assembly import Flags, Structure, System
from perfqr_cad.structure.elements.condensing import TiledStructure
from perfqr_cad.structure.elements.mindlin_plate import Section
from perfqr_cad.structure.elements.solvers import Factor
from perfqr_cad.structure.loads import STANDARD_GRAVITY_MM_S2, Finger, Hold, Load, Pressure, Support, Weight
from perfqr_cad.structure.material_table import Material
from perfqr_cad.structure.measure import von_mises
from perfqr_cad.structure.mesh.tiled_mesh import TileBlock, TiledMesh
from perfqr_cad.structure.mesh.triangle import SIX_POINTS, SIX_WEIGHTS, Floats, Ints, Mesh
from perfqr_cad.structure.supports import held_nodes, pins
from perfqr_cad.structure.taper import webs
from perfqr_cad.surface import Placement

KAPPA = 1.0  # shear correction: see docs/strength.md; 5/6 misses the solid by 3-7 % on perforated plates
KG_PER_MM3_PER_KG_M3 = 1e-9
N_PER_KG_MM_S2 = 1e-3
FACE, MIDDLE = np.array([1.0, 1, 1, 0, 0]), np.array([0.0, 0, 0, 1, 1])
FINGER_SITES = 8  # a side: where the worst place of a finger is looked for
FINGERS_COMPARED = 12  # by stress, of those that do most work: the worst was among the first 7 on two parts


@dataclass(frozen=True)
class Model:
    """A meshed part with its section, supports and element matrices.

    `positions` (n, 3) and `frames` (n, 3, 3; rows e1, e2, n) are the middle surface at the nodes. `section`
    has the thickness of each element, `wall_mm` that of the wall. Thin bars are taken in the middle of the
    wall: standing aside would only stiffen them.
    """

    mesh: Mesh
    domain: Polygon
    wall_mm: float
    section: Section
    material: Material
    support: Support
    positions: Floats
    frames: Floats
    flat: bool
    system: Structure
    edge_mm: float

    @property
    def fixed(self) -> Flags:
        """Which unknowns are held."""
        return self.system.fixed

    def factorise(self, solver: str | None = None) -> Factor:
        """See `solvers.factorise`."""
        return self.system.factorise(solver)

    @cached_property
    def area_mm2(self) -> Floats:
        """Area of each element on the middle surface."""
        return self.mesh.area_mm2 if self.flat else shell.areas(self.positions, self.mesh.elements)

    def pressure_forces(self, pressure_mpa: Floats | float) -> Floats:
        """Nodal forces of a pressure on the front, inward, one value for all elements or one for each."""
        if self.flat:
            return plate.normal_load(self.mesh, -np.asarray(pressure_mpa))
        return shell.normal_load(self.positions, self.mesh.elements, -np.asarray(pressure_mpa))

    def body_forces(self, per_volume: Floats) -> Floats:
        """Nodal forces of a constant vector load (3,) in N/mm³."""
        thickness = np.broadcast_to(self.section.thickness_mm, len(self.mesh.elements))
        if not self.flat:
            return shell.body_load(self.positions, self.mesh.elements, thickness[:, None] * per_volume)
        along = self.frames[0] @ per_volume
        if np.hypot(along[0], along[1]) > 1e-12 * np.linalg.norm(along):
            raise AnalysisError("a flat plate under a load in its own plane needs the shell model")
        return plate.normal_load(self.mesh, along[2] * thickness)

    def corner_stresses(self, displacement: Floats) -> Floats:
        """Stress tensors (m, 3, layers, 5) at the element corners, layers through the thickness."""
        if self.flat:
            return plate.stresses(self.mesh, displacement, self.section)
        return shell.stresses(self.positions, self.frames, self.mesh.elements, displacement, self.section)

    def largest_at_centres(self, moved: Floats) -> Floats:
        """The largest von Mises stress (k,) at any element's centre under displacements (n·d, k), to compare
        loads by."""
        local = moved.reshape(-1, self.system.dofs, moved.shape[1])[self.mesh.elements]
        local = local.reshape(len(local), -1, moved.shape[1])
        found = np.zeros(moved.shape[1])
        for operator in self._centre_operators:
            stress = np.matmul(operator, local).transpose(0, 2, 1)
            for layer in (stress * FACE, stress * MIDDLE) if self.flat else (stress,):
                found = np.maximum(found, von_mises(layer).max(axis=0))
        return found

    @cached_property
    def _centre_operators(self) -> list[Floats]:
        if self.flat:
            return [plate.centre_operator(self.mesh, self.section)]
        return shell.centre_operator(self.positions, self.frames, self.mesh.elements, self.section)

    def share_inside(self, region: BaseGeometry) -> Floats:
        """Which share (m,) of each element's area lies in a region of the pattern plane."""
        left, low, right, high = region.bounds
        reach = self.mesh.longest_edge_mm
        x, y = self.centres.T
        near = (x > left - reach) & (x < right + reach) & (y > low - reach) & (y < high + reach)
        points = self.mesh.points(SIX_POINTS, near)
        shapely.prepare(region)
        inside = shapely.contains_xy(region, points[..., 0], points[..., 1])
        share = np.zeros(len(near))
        share[near] = (inside @ SIX_WEIGHTS) / SIX_WEIGHTS.sum()
        return share

    @cached_property
    def centres(self) -> Floats:
        """Centres (m, 2) of the elements in the pattern plane."""
        return self.mesh.nodes[self.mesh.elements[:, :3]].mean(axis=1)

    def nodal_areas(self, share: Floats) -> Floats:
        """Area (n,) in mm² that belongs to each node, of elements that count with a share (m,)."""
        if self.flat:
            return plate.normal_load(self.mesh, share)[plate.W :: plate.DOFS]
        upward = share[:, None] * np.array([0.0, 0.0, 1.0])
        return shell.body_load(self.positions, self.mesh.elements, upward).reshape(-1, shell.DOFS)[:, 2]

    @cached_property
    def rigid_motions(self) -> Floats:
        """Translations of the nodes as the part moves as a whole: (n, 3, 6), of a flat plate (n, 1, 3)."""
        offset = self.positions - self.positions.mean(axis=0)
        if self.flat:
            x, y = np.einsum("nc,nac->an", offset, self.frames[:, :2])
            return np.stack([np.ones_like(x), x, y], axis=1)[:, None]
        unit = np.broadcast_to(np.eye(3), (len(offset), 3, 3))
        turns = np.stack([np.cross(axis, offset) for axis in np.eye(3)], axis=2)
        return np.concatenate([unit, turns], axis=2).astype(np.float64)

    def moved(self, vector: Floats) -> Floats:
        """What of a vector of unknowns or forces is translation: (n, 3), of a flat plate (n, 1)."""
        return vector.reshape(-1, self.system.dofs)[:, : 1 if self.flat else 3]

    def alone(self, elements: Ints) -> Model:
        """Some elements cut loose from each other: six nodes to each, and a motion of one moves no other."""
        nodes = self.mesh.elements[elements].ravel()
        mesh = Mesh(self.mesh.nodes[nodes], np.arange(len(nodes)).reshape(-1, 6), len(nodes))
        section = self.section.of(elements)
        positions, frames = self.positions[nodes], self.frames[nodes]
        return replace(self, mesh=mesh, section=section, positions=positions, frames=frames)

    def translations(self, vector: Floats) -> Floats:
        """Space components (n, 3) of the translations or forces in a vector of unknowns."""
        if self.flat:
            return vector[plate.W :: plate.DOFS, None] * self.frames[:, 2]
        return vector.reshape(-1, shell.DOFS)[:, :3]


def unknowns(mesh: Mesh, flat: bool) -> int:
    """How many a model on a mesh has, held ones too."""
    return len(mesh.nodes) * (plate.DOFS if flat else shell.DOFS)


def build_model(
    tiled: TiledMesh,
    domain: Polygon,
    placement: Placement,
    case: Case,
    edge_mm: float,
    flat: bool,
    thicknesses_mm: tuple[float, ...] = (),
    web_mm: float | None = None,
) -> Model:
    """Element matrices and supports of a meshed region on the middle surface of a placement.

    `thicknesses_mm` are those of the classes of material, () for the wall's alone; `web_mm` is the least web,
    None for walls that do not flare.
    """
    mesh, wall = tiled.mesh, placement.thickness_mm
    of_class = np.array(thicknesses_mm or (wall,))
    section = _section(mesh, domain, of_class[tiled.classes], case, web_mm)
    positions = placement.at_depth(mesh.nodes, 0.5 * wall)
    frames = placement.frame(mesh.nodes)
    dofs = plate.DOFS if flat else shell.DOFS
    if case.support.hold is Hold.FREE:
        fixed = pins(positions, flat)
    else:
        fixed = np.repeat(held_nodes(mesh, domain, case.support)[:, None], dofs, axis=1)
        if case.support.hold.pinned:
            fixed[:, plate.BX if flat else shell.ROTATIONS.start :] = False
    system: Structure
    if flat:
        blocks, rows = _alike(tiled, section)
        matrices = tuple(
            plate.stiffness(block.tile_mesh.mesh, section.of(row))
            for block, row in zip(blocks, rows, strict=True)
        )
        system = TiledStructure(tuple(blocks), matrices, dofs, fixed.ravel())
    else:
        matrices = shell.stiffness(positions, frames, mesh.elements, section)
        system = System(mesh.elements, dofs, matrices, fixed.ravel())
    return Model(
        mesh, domain, wall, section, case.material, case.support, positions, frames, flat, system, edge_mm
    )


def _section(mesh: Mesh, domain: Polygon, thickness_mm: Floats, case: Case, web_mm: float | None) -> Section:
    """Thickness and what flaring walls leave of each element, by the width of its web in front."""
    bending, area, stress = np.ones((3, len(thickness_mm)))
    if case.flare_mm and web_mm is not None:
        centres = mesh.nodes[mesh.elements[:, :3]].mean(axis=1)
        for one in webs(domain, centres, web_mm, case.flare_mm):
            bending[one.elements] = 1.0 / one.taper.deflection
            area[one.elements] = one.taper.area
            stress[one.elements] = one.taper.stress / one.taper.deflection
        recessed = thickness_mm < thickness_mm.max()  # bars there do not flare
        bending[recessed], area[recessed], stress[recessed] = 1.0, 1.0, 1.0
    material = case.material
    return Section(thickness_mm, material.e_mpa, material.nu, KAPPA, bending, area, stress)


def _alike(tiled: TiledMesh, section: Section) -> tuple[list[TileBlock], list[Ints]]:
    """Blocks of tiles whose elements have the same sections too, and the elements of one tile of each."""
    blocks: list[TileBlock] = []
    rows: list[Ints] = []
    start = 0
    for block in tiled.blocks:
        tiles, each = len(block.nodes), len(block.tile_mesh.elements)
        number = start + np.arange(tiles * each).reshape(tiles, each)
        shares = np.asarray(section.bending_share)[number]
        _, group = np.unique(shares, axis=0, return_inverse=True)
        for one in range(int(group.max()) + 1):
            alike = np.flatnonzero(group.reshape(-1) == one)
            blocks.append(TileBlock(block.tile_mesh, block.nodes[alike]))
            rows.append(number[alike[0]])
        start += tiles * each
    return blocks, rows


def forces_of(model: Model, loads: tuple[Load, ...], factor: Factor) -> Floats:
    """Nodal forces (n·d,) of loads that act together.

    The factor is used to find the worst place for a finger, given all other loads.
    """
    roaming = [load for load in loads if isinstance(load, Finger) and load.at_mm is None]
    forces = np.zeros(len(model.fixed))
    for one in loads:
        if one not in roaming:
            forces += _forces_of(model, one)
    for finger in roaming:
        forces = _worst_finger(model, finger, factor, forces)
    return forces


def _forces_of(model: Model, load: Load) -> Floats:
    match load:
        case Pressure(pressure_mpa):
            return model.pressure_forces(pressure_mpa)
        case Weight(direction, gravities):
            per_kg = gravities * STANDARD_GRAVITY_MM_S2 * N_PER_KG_MM_S2
            per_volume = model.material.density_kg_m3 * KG_PER_MM3_PER_KG_M3 * per_kg
            way = -model.frames[:, 2].mean(axis=0) if direction is None else np.asarray(direction)
            return model.body_forces(per_volume * way / np.linalg.norm(way))
        case Finger():
            return _finger_forces(model, load)


def _finger_forces(model: Model, finger: Finger) -> Floats:
    """Forces of a finger at its place.

    Raises:
        AnalysisError: no material lies under it.
    """
    assert finger.at_mm is not None
    centres = model.mesh.nodes[model.mesh.elements[:, :3]].mean(axis=1)
    near = np.linalg.norm(centres - finger.at_mm, axis=1) <= finger.radius_mm + model.mesh.longest_edge_mm
    points = model.mesh.points(SIX_POINTS, near)
    inside = np.linalg.norm(points - np.asarray(finger.at_mm), axis=2) <= finger.radius_mm
    share = np.zeros(len(near))
    share[near] = (inside @ SIX_WEIGHTS) / SIX_WEIGHTS.sum()
    loaded = float(share @ model.area_mm2)
    if loaded <= 0.0:
        x, y = finger.at_mm
        raise AnalysisError(
            f"no material under a finger of radius {finger.radius_mm:g} mm at ({x:g}, {y:g}) mm:"
            " move it onto the part"
        )
    return model.pressure_forces(finger.force_n / loaded * share)


def _worst_finger(model: Model, finger: Finger, factor: Factor, others: Floats) -> Floats:
    """Forces of the finger and others, it where it strains the part most, out of a grid of places.

    The places of most work are compared by the stress there.
    """
    left, bottom, right, top = model.domain.bounds
    steps = (np.arange(FINGER_SITES) + 0.5) / FINGER_SITES
    free = ~model.fixed
    cases: list[Floats] = []
    work: list[float] = []
    for x in left + steps * (right - left):
        row: list[Floats] = []
        for y in bottom + steps * (top - bottom):
            try:
                row.append(others + _finger_forces(model, replace(finger, at_mm=(float(x), float(y)))))
            except AnalysisError:  # a hole larger than a finger
                continue
        if row:
            cases += row
            work += factor.work(np.stack(row, axis=1) * free[:, None]).tolist()
    if not cases:
        raise AnalysisError(
            f"no material under a finger of radius {finger.radius_mm:g} mm anywhere: use a larger one"
        )
    most = [cases[k] for k in np.argsort(-np.array(work))[:FINGERS_COMPARED]]
    peaks = [float(von_mises(model.corner_stresses(factor.solve(f * free))).max()) for f in most]
    return most[int(np.argmax(peaks))]
