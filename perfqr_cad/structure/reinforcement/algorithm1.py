"""Algorithm 1 of the paper, as it stands (`paper`) and as it should be (`optimal`).

Both try bridges on one factorisation and confirm them on a conforming mesh; what is still too weak goes round
again. `paper` ties the point of largest deformation to the visible point of least cost by Eq. (5). `optimal`
asks which bar lowers the stress most per unit of decoding margin: adjoint sensitivities of all bars are one
solve, the best of them are compared exactly, several are added at once, and those that do not help are taken
out again.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Literal

import numpy as np
from shapely.geometry import Point

from perfqr_cad.errors import AnalysisError
from perfqr_cad.structure.analysis import EDGE_MODULES, prepare
from perfqr_cad.structure.assessment import SEARCH_EDGE_MODULES, Assessment, Search, assess
from perfqr_cad.structure.case import Case
from perfqr_cad.structure.handling.capacity import Way
from perfqr_cad.structure.handling.places import breaks_ring, on_ring, presses_ring
from perfqr_cad.structure.material_table import MATERIALS
from perfqr_cad.structure.material_table import material as material_named
from perfqr_cad.structure.mesh.light_region import ThinPart, thin_parts
from perfqr_cad.structure.mesh.seeding import MeshSize
from perfqr_cad.structure.mesh.tile_meshes import TileMeshes
from perfqr_cad.structure.part import Part
from perfqr_cad.structure.reinforcement.bar_candidates import Allowance
from perfqr_cad.structure.reinforcement.optimal_choice import ROUND_GAIN, OptimalChoice, worth
from perfqr_cad.structure.reinforcement.paper_choice import PaperChoice
from perfqr_cad.structure.reinforcement.reanalysis import Reanalysis
from perfqr_cad.structure.reinforcement.reinforced import STRONG, Reinforcement
from perfqr_cad.structure.shell_model import forces_of
from perfqr_cad.structure.stress_field import StressField
from perfqr_cad.surface import Placement

if TYPE_CHECKING:
    from perfqr_cad.pattern import Bridge, Pattern

Method = Literal["optimal", "paper"]
NO_BRIDGE = "no affordable bridge is left"
LEAST_SHARE = 0.6  # of the largest stress: loads that stress a part less are left to the next round
MOST_CONFIRMED, MOST_CONFIRMED_IN_HAND = 40, 6  # conforming meshes in all
MOST_FRUITLESS = 2  # conforming meshes in a row that are no better than one before


@dataclass(frozen=True)
class _Job:
    """What stays the same while bridges are added."""

    placement: Placement
    case: Case
    edge_mm: float | None
    tile_meshes: TileMeshes

    def assess(self, pattern: Pattern) -> Assessment:
        """How the pattern stands up to the case, on a conforming mesh."""
        return assess(pattern, self.placement, self.case, self.edge_mm, self.tile_meshes)

    def reanalysis(self, stage: _Stage) -> Reanalysis:
        """A coarse model of a pattern to try bridges on, its loads scaled to what is allowed of the first."""
        search = stage.assessment.search
        if search is not None:
            return self._in_hand(stage.pattern, search)
        size = MeshSize.even(SEARCH_EDGE_MODULES * stage.pattern.module_mm, self.case.nozzle_mm)
        model = prepare(Part.of(stage.pattern, self.placement), self.case, size)
        factor = model.factorise(self.case.solver)
        return Reanalysis(model, factor, forces_of(model, self.case.loads, factor), self.case.nozzle_mm)

    def _in_hand(self, pattern: Pattern, search: Search) -> Reanalysis:
        """The model of a search, under the ways that bridges may help with."""
        hand = search.hand
        forces, moved = hand.solve(search.ways)
        scale = np.array(
            [
                hand.asked_n(way.load) * self.case.limit_mpa / self.case.limit_under_mpa(way.load)
                for way in search.ways
            ]
        )
        stress = scale * hand.model.largest_at_centres(moved)
        helped = np.array([not _on_ring(pattern, way) for way in search.ways])
        kept = np.flatnonzero(helped & (stress >= LEAST_SHARE * stress[helped].max(initial=0.0)))
        corners = hand.model.mesh.nodes[: hand.model.mesh.corners]
        on_rings = np.flatnonzero([on_ring(pattern, (x, y)) for x, y in corners.tolist()])
        return Reanalysis(
            hand.model, hand.factor, forces[:, kept] * scale[kept], self.case.nozzle_mm, on_rings
        )


def _on_ring(pattern: Pattern, way: Way) -> bool:
    """Whether a load presses a finder ring, whose own bars decide."""
    at_mm = way.push.at_mm
    return way.load.name == "fingertip" and at_mm is not None and presses_ring(pattern, at_mm)


def reinforce(
    pattern: Pattern,
    placement: Placement,
    case: Case,
    *,
    method: Method = "optimal",
    edge_mm: float | None = None,
) -> Reinforcement:
    """Bridges until the largest stress is within the limit of the case (χ of Algorithm 1).

    `edge_mm` is as in `analyse`. "No affordable bridge is left" is a status, not an error.

    Raises:
        AnalysisError: the pattern cannot be analysed, or the method is unknown.
    """
    if method not in ("optimal", "paper"):
        raise AnalysisError(f"method {method!r} is unknown; choose optimal or paper")
    size = MeshSize.graded(edge_mm or EDGE_MODULES * pattern.module_mm, case.nozzle_mm)
    allowance = Allowance.of(pattern)
    job = _Job(placement, case, edge_mm, TileMeshes(size))
    if method == "paper":
        return _run(pattern, job, PaperChoice(allowance), "paper")
    # What a hand may do to a part is no reason to spend what a reader can correct.
    best = _run(pattern, job, OptimalChoice(allowance, spends=not case.handling), "optimal")
    if case.handling or (best.strong and _codewords(best) == _codewords_of(pattern)):
        return best
    other = _run(pattern, job, PaperChoice(allowance), "paper")
    return min((best, other), key=_rank)


def _rank(result: Reinforcement) -> tuple[bool, float, int, int]:
    """Strong ones first, then those that cost least; among weak ones those with the least stress."""
    cost = _codewords(result), len(result.bridges)
    return not result.strong, 0.0 if result.strong else result.after.max_stress_mpa, *cost


def _codewords(result: Reinforcement) -> int:
    """How many codewords are wrong in a reinforced pattern."""
    return _codewords_of(result.pattern)


def _codewords_of(pattern: Pattern) -> int:
    return sum(pattern.readability.errors)


Chooser = OptimalChoice | PaperChoice


def _run(pattern: Pattern, job: _Job, chooser: Chooser, method: Method) -> Reinforcement:
    """Rounds of bridges, each confirmed on a conforming mesh, until the part is strong or they no longer
    help."""
    before = job.assess(pattern)
    limit = job.case.limit_mpa
    best = _Stage(pattern, before, ())
    stages = [best]
    history = [best.use * limit]
    fruitless = 0
    most = MOST_CONFIRMED_IN_HAND if job.case.handling else MOST_CONFIRMED
    stopped = "nothing was asked for: bridges are added for loads that are named"
    while job.case.strengthen and best.use > 1.0:
        if fruitless == MOST_FRUITLESS:
            stopped = f"the last {fruitless} sets of bridges took off less than {ROUND_GAIN:.0%}"
            break
        if len(stages) > most:
            stopped = f"{most} sets of bridges were tried"
            break
        start = best if method == "optimal" else stages[-1]
        analysis = job.reanalysis(start)
        if not analysis.loads:
            stopped = NO_BRIDGE
            break
        # The coarse model understates the peak: what it may show is the limit, understated as much.
        scale = analysis.largest / (start.use * limit)
        bridged, new, stresses = chooser.add_bridges(start.pattern, analysis, scale * limit)
        if not new:
            stopped = NO_BRIDGE
            break
        stages.append(_Stage(bridged, job.assess(bridged), (*start.bridges, *new)))
        history += [*(stress / scale for stress in stresses), stages[-1].use * limit]
        if stages[-1].use < (1.0 - ROUND_GAIN) * best.use:
            best, fruitless = stages[-1], 0
        else:
            chooser.avoid(new, stages[-1].worst_at_mm, pattern.module_mm)
            fruitless += 1
    if best.use > 1.0:  # the first that comes close has the fewest bridges
        best = stages[worth([stage.use for stage in stages], 0.0)]
    strong = best.assessment.strong
    return Reinforcement(
        pattern=best.pattern,
        before=before.field,
        after=best.assessment.field,
        capacities=best.assessment.capacities,
        bridges=best.bridges,
        iterations=len(best.bridges),
        confirmations=len(stages) - 1,
        status=STRONG if strong else f"weak: {_why(best, job.case, stopped)}",
        history=tuple(history),
        method=method,
        limit_mpa=limit,
        removed=chooser.removed,
        remedies=() if strong else remedies(best.assessment.field, pattern, best.assessment.use),
    )


@dataclass(frozen=True)
class _Stage:
    """A confirmed pattern with the structural bridges added so far."""

    pattern: Pattern
    assessment: Assessment
    bridges: tuple[Bridge, ...]

    @cached_property
    def use(self) -> float:
        """Of what it bears where bridges may help, the share that it is asked to."""
        return self.assessment.use_off_rings(self.pattern)

    @property
    def worst_at_mm(self) -> tuple[float, float]:
        """Where that is."""
        answers = [
            one for one in self.assessment.answers if not breaks_ring(self.pattern, one.stressed_at_mm)
        ]
        if not answers:
            return self.assessment.field.max_stress_at_mm
        return max(answers, key=lambda one: one.use).stressed_at_mm


def _why(stage: _Stage, case: Case, stopped: str) -> str:
    """What is too weak, and what stopped the strengthening of it."""
    if not stage.assessment.capacities:
        return stopped
    least = stage.assessment.capacities[0]
    if case.strengthen and stage.use <= 1.0:
        stopped = "rings hang on their own bars, which no bridge may help"
    return f"bears {least.words}, asked {least.asked_n:.2g} N, and breaks {least.breaks}; {stopped}"


def _ends_at(part: ThinPart, field: StressField) -> bool:
    """Whether the largest stress is in or beside a thin part."""
    return part.polygon.distance(Point(field.max_stress_at_mm)) < field.disc_width_mm


def remedies(field: StressField, pattern: Pattern, excess: float) -> tuple[str, ...]:
    """What else would bring the largest stress, that many times too large, within what is allowed:
    estimates."""
    advice: list[str] = []
    bars = [part for part in thin_parts(pattern, field.thickness_mm) if _ends_at(part, field)]
    if bars:
        height = bars[0].thickness_mm
        advice.append(
            f"finder bars {height * excess**0.5:.2f} mm high instead of {height:g} mm: they are weakest"
        )
    advice += [
        # Bending stress falls with the square of the thickness, and grows with the square of the span.
        f"thickness {field.thickness_mm * excess**0.5:.2f} mm instead of {field.thickness_mm:g} mm",
        f"size {pattern.size_mm / excess**0.5:.1f} mm instead of {pattern.size_mm:.1f} mm",
    ]
    today = material_named(field.material) if field.material in MATERIALS else None
    stronger = [m for m in MATERIALS.values() if today and m.yield_mpa >= excess * today.yield_mpa]
    if stronger:
        least = min(stronger, key=lambda m: m.yield_mpa)
        advice.append(f"{least.name} instead of {field.material}")
    if pattern.symbol.level != "H":
        advice.append(f"error correction above level {pattern.symbol.level}, which can afford more bridges")
    return tuple(advice)
