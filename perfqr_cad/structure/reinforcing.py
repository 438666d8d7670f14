"""Algorithm 1 of the paper, as it stands (`paper`) and as it should be (`optimal`).

Both lay bridges on one factorisation and confirm them on a conforming mesh; what is still too weak goes round
again. `paper` ties the point of largest deformation to the visible point of least cost by Eq. (5). `optimal`
asks which bar lowers the stress most per unit of decoding margin: adjoint sensitivities of all bars are one
solve, the best of them are compared exactly, several are laid at once, and those that do not help are taken
out again.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from shapely.geometry import Point

from perfqr_cad.errors import AnalysisError
from perfqr_cad.structure.analysis import (
    DEFAULT_NOZZLE_MM,
    MESH_SIZE_MODULES,
    analyse,
    bends_only,
    grain_of,
    lattice_of,
    prepare,
)
from perfqr_cad.structure.candidates import Allowance
from perfqr_cad.structure.domain import ThinPart, thin_parts
from perfqr_cad.structure.field import StressField
from perfqr_cad.structure.loads import Load, Loads, Support
from perfqr_cad.structure.materials import MATERIALS, Material
from perfqr_cad.structure.materials import material as material_named
from perfqr_cad.structure.model import forces_of
from perfqr_cad.structure.optimal import ROUND_GAIN, OptimalChoice, worth
from perfqr_cad.structure.paper import PaperChoice
from perfqr_cad.structure.patches import Patches
from perfqr_cad.structure.reanalysis import Reanalysis
from perfqr_cad.structure.reinforcement import STRONG, Reinforcement
from perfqr_cad.surface import Placement

if TYPE_CHECKING:
    from perfqr_cad.pattern import Bridge, Pattern

Method = Literal["optimal", "paper"]
WEAK = "weak: no affordable bridge is left"
LOOP_MESH_MODULES = 1.0  # element edges of the model that bridges are tried on
MOST_FRUITLESS = 2  # conforming meshes in a row that are no better than one before


@dataclass(frozen=True)
class _Job:
    """What stays the same while bridges are laid."""

    placement: Placement
    material: Material
    load: Load | Loads
    support: Support | str
    yield_mpa: float
    nozzle_mm: float
    mesh_size_mm: float | None
    flare_mm: float
    solver: str | None
    patches: Patches

    def check(self, pattern: Pattern) -> StressField:
        """The stress field on a conforming mesh."""
        return analyse(
            pattern,
            self.placement,
            material=self.material,
            load=self.load,
            support=self.support,
            yield_mpa=self.yield_mpa,
            nozzle_mm=self.nozzle_mm,
            mesh_size_mm=self.mesh_size_mm,
            flare_mm=self.flare_mm,
            solver=self.solver,
            patches=self.patches,
        )

    def reanalysis(self, pattern: Pattern) -> Reanalysis:
        """A coarse model of the pattern to try bridges on."""
        size = LOOP_MESH_MODULES * pattern.module_mm
        model = prepare(
            pattern.polygon,
            self.placement,
            self.material,
            self.support,
            nozzle_mm=self.nozzle_mm,
            mesh_size_mm=size,
            corner_size_mm=size,
            layer_size_mm=0.0,
            thin=thin_parts(pattern, self.placement.thickness_mm),
            lattice=lattice_of(pattern),
            bends=bends_only(self.load),
        )
        factor = model.factorise(self.solver)
        return Reanalysis(model, factor, forces_of(model, self.load, factor), self.nozzle_mm)


def reinforce(
    pattern: Pattern,
    placement: Placement,
    *,
    material: Material | str = "PLA",
    load: Load | Loads,
    support: Support | str = "clamped",
    yield_mpa: float | None = None,
    method: Method = "optimal",
    nozzle_mm: float = DEFAULT_NOZZLE_MM,
    mesh_size_mm: float | None = None,
    flare_mm: float = 0.0,
    loss_weight: float = 1.0,
    solver: str | None = None,
) -> Reinforcement:
    """Bridges until the largest stress is within `yield_mpa` (χ; None takes the material's yield stress).

    `flare_mm` is as in `analyse`, `loss_weight` is λ of Eq. (5). "No affordable bridge is left" is a status,
    not an error.

    Raises:
        AnalysisError: the pattern cannot be analysed, or a setting is unknown or out of range.
    """
    if method not in ("optimal", "paper"):
        raise AnalysisError(f"method {method!r} is unknown; choose optimal or paper")
    stuff = material_named(material) if isinstance(material, str) else material
    limit = stuff.yield_mpa if yield_mpa is None else yield_mpa
    if not limit > 0.0:
        raise AnalysisError(f"yield stress is {limit} MPa; it must be a positive number")
    patches = Patches(grain_of(mesh_size_mm or MESH_SIZE_MODULES * pattern.module_mm, nozzle_mm))
    job = _Job(placement, stuff, load, support, limit, nozzle_mm, mesh_size_mm, flare_mm, solver, patches)
    allowance = Allowance.of(pattern)
    chooser = OptimalChoice(allowance) if method == "optimal" else PaperChoice(allowance, loss_weight)
    return _run(pattern, job, chooser, method)


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
        bridged, new, stresses = chooser.lay(start.pattern, analysis, scale * job.yield_mpa)
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
        yield_mpa=job.yield_mpa,
        removed=chooser.removed,
        remedies=() if strong else remedies(best.field, pattern, job.yield_mpa),
    )


@dataclass(frozen=True)
class _Stage:
    """A confirmed pattern with the structural bridges laid so far."""

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
