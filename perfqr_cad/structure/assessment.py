"""How a part stands up to its case: one stress field for loads that act together, or what it bears of each
load of a hand, with the field of the one that asks most of it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from dataclasses import field as entry
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from perfqr_cad.structure.analysis import EDGE_MODULES, MOST_UNKNOWNS, analyse, field_of, prepare
from perfqr_cad.structure.case import Case
from perfqr_cad.structure.handling.capacity import Capacity, Hand, Way, ways_of
from perfqr_cad.structure.handling.fingertips import worst_fingertips
from perfqr_cad.structure.handling.places import breaks_ring, presses_ring
from perfqr_cad.structure.mesh.seeding import MeshSize
from perfqr_cad.structure.mesh.tile_meshes import TileMeshes
from perfqr_cad.structure.mesh.triangle import Floats
from perfqr_cad.structure.part import Part
from perfqr_cad.structure.stress_field import StressField
from perfqr_cad.surface import Placement

if TYPE_CHECKING:
    from perfqr_cad.pattern import Pattern

SEARCH_EDGE_MODULES = 1.0  # element edges of the model on which the worst way of each load is sought
FINGERTIPS_SOUGHT = 8  # worst places of a fingertip, on rings and elsewhere, kept for the loop
ON_RINGS, OFF_RINGS = (
    1,
    2,
)  # worst places of a fingertip on rings and elsewhere: compared on the fine mesh


@dataclass(frozen=True)
class Search:
    """A coarse model under a hand, and the ways of its loads that stress it most."""

    hand: Hand
    ways: tuple[Way, ...]


@dataclass(frozen=True)
class Assessment:
    """The field that decides, and what the part bears of each load, least first; () where loads act together.

    answers  of all ways that were compared on the fine mesh
    search   where they were sought
    """

    field: StressField
    capacities: tuple[Capacity, ...] = ()
    answers: tuple[Capacity, ...] = ()
    search: Search | None = entry(default=None, repr=False, compare=False)

    @property
    def use(self) -> float:
        """The largest share of what the part bears that it is asked to; above 1 it is too weak."""
        return max((one.use for one in self.answers), default=self.field.use)

    def use_off_rings(self, pattern: Pattern) -> float:
        """The same where bridges may help: they keep clear of rings."""
        if not self.answers:
            return self.field.use
        return max(
            (one.use for one in self.answers if not breaks_ring(pattern, one.stressed_at_mm)), default=0.0
        )

    @property
    def strong(self) -> bool:
        """Whether the part bears all that it is asked to."""
        return self.use <= 1.0


def assess(
    pattern: Pattern,
    placement: Placement,
    case: Case,
    edge_mm: float | None = None,
    tile_meshes: TileMeshes | None = None,
) -> Assessment:
    """How a pattern stands up to a case; the mesh as in `analyse`.

    The worst way of each load is sought on a coarse mesh; the answers are those of the fine one.

    Raises:
        AnalysisError: the pattern cannot be analysed.
    """
    if not case.handling:
        return Assessment(analyse(pattern, placement, case, edge_mm, tile_meshes))
    part = Part.of(pattern, placement)
    search = _search(pattern, part, case)
    ways = _compared(pattern, search)
    size = MeshSize.graded(edge_mm or EDGE_MODULES * pattern.module_mm, case.nozzle_mm)
    model = prepare(part, case, size, tile_meshes, MOST_UNKNOWNS if edge_mm is None else None)
    hand = Hand(model, model.factorise(case.solver), case)
    forces, moved = hand.solve(ways)
    answers = [hand.answer(way, moved[:, k]).located(pattern) for k, way in enumerate(ways)]
    worst = int(np.argmax([one.use for one in answers]))
    least = [
        max((one for one in answers if one.load is load), key=lambda one: one.use)
        for load in dict.fromkeys(way.load for way in ways)
    ]
    least.sort(key=lambda one: -one.use)
    decisive = _field(hand, ways[worst], answers[worst], forces[:, worst], moved[:, worst])
    return Assessment(decisive, tuple(least), tuple(answers), search)


def _field(hand: Hand, way: Way, answer: Capacity, forces: Floats, moved: Floats) -> StressField:
    """The stress field under what is asked of a way, deflections against what the hand holds."""
    asked = answer.asked_n
    found = field_of(hand.model, asked * moved, asked * forces, hand.case, hand.factor.name)
    return replace(
        found,
        limit_mpa=answer.limit_mpa,
        max_stress_mpa=answer.stress_mpa,
        deflection_mm=asked * hand.deflection(way.push, moved),
        max_deflection_mm=answer.deflection_mm,
    )


def _search(pattern: Pattern, part: Part, case: Case) -> Search:
    """The worst ways of each load on a coarse model."""
    size = MeshSize.even(SEARCH_EDGE_MODULES * pattern.module_mm, case.nozzle_mm)
    model = prepare(part, case, size)
    hand = Hand(model, model.factorise(case.solver), case)
    found: list[Way] = []
    for load in hand.loads:
        if load.name == "fingertip":
            kinds = (partial(presses_ring, pattern), partial(_clear_of_rings, pattern))
            found += [
                Way(load, push) for kind in worst_fingertips(hand, kinds, FINGERTIPS_SOUGHT) for push in kind
            ]
            continue
        ways = ways_of(load, model.domain)
        stresses = model.largest_at_centres(hand.solve(ways)[1])
        found.append(ways[int(np.argmax(stresses))])
    return Search(hand, tuple(found))


def _clear_of_rings(pattern: Pattern, at_mm: tuple[float, float]) -> bool:
    return not presses_ring(pattern, at_mm)


def _compared(pattern: Pattern, search: Search) -> list[Way]:
    """The ways to compare on the fine mesh: one of each load, a few of a fingertip."""
    kept: list[Way] = []
    on_rings, off_rings = 0, 0
    for way in search.ways:
        if way.load.name == "fingertip":
            at_mm = way.push.at_mm
            if at_mm is not None and presses_ring(pattern, at_mm):
                on_rings += 1
                if on_rings > ON_RINGS:
                    continue
            else:
                off_rings += 1
                if off_rings > OFF_RINGS:
                    continue
        kept.append(way)
    return kept
