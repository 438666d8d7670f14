"""What a part bears in the hand: for each load the newtons at which it reaches what it is allowed, and where.

Everything is linear: each way of acting is solved once for one newton, all of them on one factor. A part in
the hand is free; a force on one region is balanced by a traction on the region that the hand holds, spread
like a rigid motion (as in inertia relief), so that three pins keep the part in place and carry nothing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from shapely.geometry import Polygon
from shapely.geometry.base import BaseGeometry

from perfqr_cad.errors import AnalysisError
from perfqr_cad.structure.case import Case
from perfqr_cad.structure.elements.solvers import Factor
from perfqr_cad.structure.handling.named_loads import HandlingLoad
from perfqr_cad.structure.handling.places import breaking, pressed
from perfqr_cad.structure.handling.pushes import Push, pushes, rim
from perfqr_cad.structure.loads import STANDARD_GRAVITY_MM_S2, Hold
from perfqr_cad.structure.measure import Discs
from perfqr_cad.structure.mesh.triangle import Floats
from perfqr_cad.structure.shell_model import KG_PER_MM3_PER_KG_M3, N_PER_KG_MM_S2, Model

if TYPE_CHECKING:
    from perfqr_cad.pattern import Pattern


# Solids of wedges show up to 12 % more than the shell: docs/strength.md, certificate beside three dimensions.
STRESS_MARGIN = 1.15


@dataclass(frozen=True)
class Way:
    """A load and one way in which it can act."""

    load: HandlingLoad
    push: Push


def ways_of(load: HandlingLoad, domain: Polygon) -> list[Way]:
    """The ways in which a load that is no fingertip can act on a part."""
    return [Way(load, push) for push in pushes(load, domain)]


@dataclass(frozen=True)
class Capacity:
    """What a part bears of one load.

    bears_n            the force at which the averaged stress reaches `limit_mpa`
    asked_n            the force that it is asked to bear; `stress_mpa` and `deflection_mm` are at that force
    loaded_at_mm       where it is pressed; None: everywhere
    stressed_at_mm     where the stress is largest
    push               the way of the load that is worst
    where, breaks      in words: how it is pressed, and where it gives way first
    """

    load: HandlingLoad
    asked_n: float
    bears_n: float
    stress_mpa: float
    limit_mpa: float
    deflection_mm: float
    loaded_at_mm: tuple[float, float] | None
    stressed_at_mm: tuple[float, float]
    push: Push
    where: str = ""
    breaks: str = ""

    @property
    def enough(self) -> bool:
        """Whether the part bears what it is asked to."""
        return self.bears_n >= self.asked_n

    @property
    def use(self) -> float:
        """Share of what it bears that the part is asked to."""
        return self.asked_n / self.bears_n

    @property
    def words(self) -> str:
        """What the part bears, as a buyer would say it: "9 N by a fingertip (on the lower left finder
        ring)"."""
        return f"{self.bears_n:.2g} N by {self.load.words}" + (f" ({self.where})" if self.where else "")

    def located(self, pattern: Pattern) -> Capacity:
        """The same with its places in words."""
        where = self.push.words
        if not where and self.loaded_at_mm is not None:
            where = pressed(pattern, self.loaded_at_mm, self.stressed_at_mm)
        return replace(self, where=where, breaks=breaking(pattern, self.stressed_at_mm))


@dataclass(frozen=True)
class Hand:
    """A model and its factor, under pushes of a hand."""

    model: Model
    factor: Factor
    case: Case

    @property
    def weight_n(self) -> float:
        """The part's own weight."""
        thickness = np.broadcast_to(self.model.section.thickness_mm, len(self.model.area_mm2))
        mass_kg = (
            self.model.material.density_kg_m3 * KG_PER_MM3_PER_KG_M3 * float(self.model.area_mm2 @ thickness)
        )
        return mass_kg * STANDARD_GRAVITY_MM_S2 * N_PER_KG_MM_S2

    def asked_n(self, load: HandlingLoad) -> float:
        """The force of a load on this part."""
        if load.newtons is not None:
            return load.newtons
        if load.pressure_mpa is not None:
            return load.pressure_mpa * float(self.model.area_mm2.sum())
        return self.weight_n

    def forces(self, push: Push) -> Floats:
        """Nodal forces (n·d,) of one newton, inward along the normal, and of what holds against it.

        Raises:
            AnalysisError: there is no material to press or to hold.
        """
        model = self.model
        whole = np.ones(len(model.area_mm2))
        share = whole if push.loaded is None else model.share_inside(push.loaded)
        loaded = float(share @ model.area_mm2)
        if loaded <= 0.0:
            x, y = push.at_mm or (0.0, 0.0)
            raise AnalysisError(f"no material to press at ({x:.1f}, {y:.1f}) mm: give the part a wider frame")
        forces = model.pressure_forces(share / loaded)
        if model.support.hold is not Hold.FREE:
            return np.where(model.fixed, 0.0, forces)
        return forces + self._reaction(forces, push)

    def _reaction(self, forces: Floats, push: Push) -> Floats:
        """The traction on what is held, spread like a rigid motion, that balances some forces."""
        motions, (areas, gram) = self.model.rigid_motions, self._grip(push)
        resultant = np.einsum("nci,nc->i", motions, self.model.moved(forces))
        spread = -np.linalg.solve(gram, resultant)
        reaction = np.zeros_like(forces).reshape(-1, self.model.system.dofs)
        reaction[:, : motions.shape[1]] = areas[:, None] * (motions @ spread)
        return reaction.ravel()

    def _grip(self, push: Push) -> tuple[Floats, Floats]:
        """Area (n,) of what is held by nodes, and the scalar products of rigid motions over it."""
        key = push.held.wkb
        if key not in self._grips:
            areas = self.model.nodal_areas(self.model.share_inside(push.held))
            if not np.count_nonzero(areas) > 3:
                raise AnalysisError(f"no material to hold {push.words}: give the part a wider frame")
            motions = self.model.rigid_motions
            self._grips[key] = areas, np.einsum("nci,n,ncj->ij", motions, areas, motions, optimize=True)
        return self._grips[key]

    @cached_property
    def _grips(self) -> dict[bytes, tuple[Floats, Floats]]:
        return {}

    @cached_property
    def rim(self) -> BaseGeometry:
        """What a hand holds while a finger of another presses."""
        return rim(self.model.domain)

    def deflection(self, push: Push, displacement: Floats) -> Floats:
        """Motion (n,) along the normal against the region held, under the part's own supports if it has
        some."""
        return self.against_hold(push, self.model.moved(displacement))

    def against_hold(self, push: Push, moved: Floats) -> Floats:
        """Translations (n, 3), of a flat plate (n, 1), as motion (n,) along the normal against the hold."""
        model = self.model
        if model.support.hold is Hold.FREE:
            motions, (areas, gram) = model.rigid_motions, self._grip(push)
            carried = np.linalg.solve(gram, np.einsum("nci,nc->i", motions, areas[:, None] * moved))
            moved = moved - motions @ carried
        return moved[:, 0] if model.flat else np.einsum("nc,nc->n", moved, model.frames[:, 2])

    @cached_property
    def discs(self) -> Discs:
        """Where stress is averaged."""
        return Discs(self.model.mesh, self.case.nozzle_mm)

    @property
    def loads(self) -> list[HandlingLoad]:
        """The loads of the case that can act on the part as it is held."""
        mounted = self.model.support.hold is not Hold.FREE
        return [load for load in self.case.handling if not (mounted and load.needs_no_support)]

    def solve(self, ways: Sequence[Way]) -> tuple[Floats, Floats]:
        """Forces and displacements (n·d, k) of one newton of each way."""
        forces = np.stack([self.forces(way.push) for way in ways], axis=1)
        return forces, self.factor.solve(np.where(self.model.fixed[:, None], 0.0, forces))

    def answer(self, way: Way, displacement: Floats) -> Capacity:
        """What the part bears of a load, of which one newton moves it so."""
        load, push = way.load, way.push
        places, measure = self.discs.most_stressed(self.model.corner_stresses(displacement))
        x, y = self.model.mesh.nodes[places[0]].tolist()
        asked, limit = self.asked_n(load), self.case.limit_under_mpa(load)
        per_newton = STRESS_MARGIN * float(measure[0])
        return Capacity(
            load=load,
            asked_n=asked,
            bears_n=limit / per_newton,
            stress_mpa=asked * per_newton,
            limit_mpa=limit,
            deflection_mm=asked * float(np.abs(self.deflection(push, displacement)).max()),
            loaded_at_mm=push.at_mm,
            stressed_at_mm=(x, y),
            push=push,
        )
