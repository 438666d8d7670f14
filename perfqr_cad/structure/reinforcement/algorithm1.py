"""Algorithm 1 of the paper, as it stands (`paper`) and as it should be (`optimal`).

Both try bridges on one factorisation and confirm them on a conforming mesh; what is still too weak goes round
again. `paper` ties the point of largest deformation to the visible point of least cost by Eq. (5). `optimal`
asks which bar lowers the stress most per unit of decoding margin: adjoint sensitivities of all bars are one
solve, the best of them are compared exactly, several are added at once, and those that do not help are taken
out again.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from shapely.geometry import Point

from perfqr_cad.errors import AnalysisError
from perfqr_cad.structure.analysis import EDGE_MODULES, analyse, prepare
from perfqr_cad.structure.case import Case
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
WEAK = "weak: no affordable bridge is left"
LOOP_EDGE_MODULES = 1.0  # element edges of the model that bridges are tried on
MOST_FRUITLESS = 2  # conforming meshes in a row that are no better than one before


@dataclass(frozen=True)
class _Job:
    """What stays the same while bridges are added."""

    placement: Placement
    case: Case
    edge_mm: float | None
    tile_meshes: TileMeshes

    def check(self, pattern: Pattern) -> StressField:
        """The stress field on a conforming mesh."""
        return analyse(pattern, self.placement, self.case, self.edge_mm, self.tile_meshes)

    def reanalysis(self, pattern: Pattern) -> Reanalysis:
        """A coarse model of the pattern to try bridges on."""
        size = MeshSize.even(LOOP_EDGE_MODULES * pattern.module_mm, self.case.nozzle_mm)
        model = prepare(Part.of(pattern, self.placement), self.case, size)
        factor = model.factorise(self.case.solver)
        return Reanalysis(model, factor, forces_of(model, self.case.loads, factor), self.case.nozzle_mm)


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
    chooser = OptimalChoice(allowance) if method == "optimal" else PaperChoice(allowance)
    return _run(pattern, _Job(placement, case, edge_mm, TileMeshes(size)), chooser, method)


Chooser = OptimalChoice | PaperChoice


def _run(pattern: Pattern, job: _Job, chooser: Chooser, method: Method) -> Reinforcement:
    before = job.check(pattern)
    best = _Stage(pattern, before, ())
    stages = [best]
    history = [before.max_stress_mpa]
    fruitless = 0
    while not best.field.strong and fruitless < MOST_FRUITLESS:
        start = best if method == "optimal" else stages[-1]
        analysis = job.reanalysis(start.pattern)
        # The coarse model understates the peak: what it may show is the limit, understated as much.
        scale = analysis.largest / start.field.max_stress_mpa
        bridged, new, stresses = chooser.add_bridges(start.pattern, analysis, scale * job.case.limit_mpa)
        if not new:
            break
        stages.append(_Stage(bridged, job.check(bridged), (*start.bridges, *new)))
        field = stages[-1].field
        history += [*(stress / scale for stress in stresses), field.max_stress_mpa]
        if field.max_stress_mpa < (1.0 - ROUND_GAIN) * best.field.max_stress_mpa:
            best, fruitless = stages[-1], 0
        else:
            chooser.avoid(new, field.max_stress_at_mm, pattern.module_mm)
            fruitless += 1
    if not best.field.strong:  # the first that comes close has the fewest bridges
        best = stages[worth([stage.field.max_stress_mpa for stage in stages], 0.0)]
    strong = best.field.strong
    return Reinforcement(
        pattern=best.pattern,
        before=before,
        after=best.field,
        bridges=best.bridges,
        iterations=len(best.bridges),
        confirmations=len(stages) - 1,
        status=STRONG if strong else WEAK,
        history=tuple(history),
        method=method,
        yield_mpa=job.case.limit_mpa,
        removed=chooser.removed,
        remedies=() if strong else remedies(best.field, pattern, job.case.limit_mpa),
    )


@dataclass(frozen=True)
class _Stage:
    """A confirmed pattern with the structural bridges added so far."""

    pattern: Pattern
    field: StressField
    bridges: tuple[Bridge, ...]


def _ends_at(part: ThinPart, field: StressField) -> bool:
    """Whether the largest stress is in or beside a thin part."""
    return part.polygon.distance(Point(field.max_stress_at_mm)) < field.disc_width_mm


def remedies(field: StressField, pattern: Pattern, yield_mpa: float) -> tuple[str, ...]:
    """What else would bring the largest stress within the yield stress, first estimates."""
    excess = field.max_stress_mpa / yield_mpa
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
