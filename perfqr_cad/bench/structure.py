"""Speed of the strength layer: one analysis, CalculiX on the same mesh, bridges in the loop, the fallback.

Times are those of the processor, children included: wall-clock times of a shared machine mean little.
"""

from __future__ import annotations

import os
import random
import resource
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from perfqr_cad.pattern import Pattern, PatternSpec, build
from perfqr_cad.pattern.spec import FinderStrategy, Tone
from perfqr_cad.structure import (
    Case,
    Part,
    Pressure,
    analyse,
    calculix,
    handling_loads,
    reinforce,
    verify_solid,
)
from perfqr_cad.structure.analysis import EDGE_MODULES, prepare
from perfqr_cad.structure.elements.solvers import Cholmod, SuperLU, cholmod
from perfqr_cad.structure.mesh.seeding import MeshSize
from perfqr_cad.structure.reinforcement.bar_candidates import Allowance, Candidates
from perfqr_cad.structure.reinforcement.bar_stiffness import bar_tensors, couplings, places_under
from perfqr_cad.structure.reinforcement.lattice_bars import lattice_candidates
from perfqr_cad.structure.reinforcement.reanalysis import Reanalysis
from perfqr_cad.surface import Plane
from perfqr_cad.symbol import encode
from perfqr_cad.table import Table

SIZES_MM, THICKNESS_MM = {8: 140.0, 40: 222.0}, 2.0
PRESSURE = Pressure(13e-6)  # where Algorithm 1 begins to act on this plate at the paper's χ
NOZZLE_MM = 0.4
FINDER = "panel"  # flush rings: with recessed ones their thin bars are weakest, which no bridge relieves
BRIDGES = 20
PLATE_MODES = 3
WEAK_SHARE = 0.4  # yield stress over stress where Algorithm 1 is timed
PAYLOAD = {8: 140, 40: 1900}  # characters of a random text that fill the version
SEED = 1


Rows = list[tuple[Any, ...]]


def run() -> tuple[Table, Table, Table]:
    """Seconds of each piece beside its target, and results beside those of the solid and of CalculiX."""
    pattern = _pattern(8)
    best = Cholmod.name if cholmod() else SuperLU.name
    _analysis(pattern, best)  # imports
    largest_s, unknowns, peak_gb = _largest(best)  # first: the peak is that of the process so far
    times, results, one_s = _shell(pattern, best)
    results += _solid(pattern)
    if calculix.installed():
        beside = _calculix(pattern, best)
        times.append(beside[0])
        results.append(beside[1])
    times.append((f"version 40, {unknowns} unknowns, {best}", largest_s, largest_s / one_s, 10.0))
    times.append(("its peak of memory, GB", peak_gb, None, 4.0))
    notes = (
        "processor seconds, children included",
        "CalculiX is compared with assembling, factorising and solving of the shell on its mesh",
    )
    columns = ("case", "seconds or ratio", "of one analysis", "target")
    return (
        Table("structure: time", columns, tuple(times), notes),
        Table("structure: result", ("model", "deflection mm", "stress MPa", "unknowns"), tuple(results)),
        _beside_solid(),
    )


def _analysis(pattern: Pattern, solver: str) -> Any:
    edge_mm = EDGE_MODULES * pattern.module_mm
    return analyse(pattern, Plane(THICKNESS_MM), Case.of(PRESSURE, solver=solver), edge_mm)


def _shell(pattern: Pattern, best: str) -> tuple[Rows, Rows, float]:
    """Rows of time and of results of our shell, alone and in the loop, and the seconds of one analysis."""
    one_s, answer = _timed(lambda: _analysis(pattern, best))
    fallback_s, fallback = _timed(lambda: _analysis(pattern, SuperLU.name))
    again_s, bridge_s = _loop(pattern, best)
    weak = Case.of(PRESSURE, yield_mpa=WEAK_SHARE * answer.max_stress_mpa, solver=best)
    whole_s, whole = _timed(lambda: reinforce(pattern, Plane(THICKNESS_MM), weak))
    times: Rows = [
        (f"version 8, {answer.unknowns} unknowns, {best}", one_s, 1.0, 1.5),
        (f"the same, {SuperLU.name}", fallback_s, fallback_s / one_s, 4.5),
        ("loop model: mesh, assemble, factorise", again_s, again_s / one_s, None),
        ("one bridge in the loop", bridge_s, bridge_s / one_s, 0.03),
        ("loop model again, over one bridge", again_s / bridge_s, None, None),
        ("conforming mesh and factors again, over one bridge", one_s / bridge_s, None, 40.0),
        (f"Algorithm 1: {whole.iterations} bridges, all meshes", whole_s, whole_s / one_s, 6.0),
    ]
    results: Rows = [
        ("shell", answer.max_deflection_mm, answer.max_stress_mpa, answer.unknowns),
        (f"shell, {SuperLU.name}", fallback.max_deflection_mm, fallback.max_stress_mpa, fallback.unknowns),
    ]
    return times, results, one_s


def _solid(pattern: Pattern) -> Rows:
    """Results of the shell and of the solid's wedges on one mesh."""
    solid = verify_solid(pattern, Plane(THICKNESS_MM), Case.of(PRESSURE))
    return [
        ("shell, solid check's mesh", solid.shell_deflection_mm, solid.shell_stress_mpa, None),
        ("18-node wedge, same mesh", solid.solid_deflection_mm, solid.solid_stress_mpa, solid.unknowns),
    ]


def _calculix(pattern: Pattern, best: str) -> tuple[tuple[Any, ...], tuple[Any, ...]]:
    """A row of time and one of results of CalculiX on our mesh."""
    model = _model(pattern)
    shell_s, _ = _timed(lambda: model.factorise(best).solve(model.pressure_forces(1.0)))
    ccx_s, theirs = _timed(lambda: calculix.solve(model, PRESSURE.pressure_mpa))
    deepest = float(np.abs(theirs.displacement[:, 2]).max())
    return (
        ("CalculiX C3D15 on the same mesh", ccx_s, ccx_s / shell_s, 6.0),
        ("CalculiX C3D15, same mesh", deepest, None, theirs.displacement.size),
    )


@dataclass(frozen=True)
class _Part:
    """A part of version 3, 60 mm, whose certificate is put beside the solid's answer."""

    name: str
    load: str
    finder: FinderStrategy = "panel"
    thickness_mm: float = 1.6
    material: str = "PLA"
    tone: Tone = "normal"
    support: str = "free"


BESIDE_SOLID = (
    _Part("panel", "fingertip"),
    _Part("panel", "push"),
    _Part("panel, clamped", "fingertip", support="clamped"),
    _Part("recessed", "fingertip", finder="recessed"),
    _Part("recessed", "push", finder="recessed"),
    _Part("diagonal", "fingertip", finder="diagonal"),
    _Part("inverted", "fingertip", tone="inverted"),
    _Part("sheet of steel, 0.5 mm", "fingertip", thickness_mm=0.5, material="steel"),
    _Part("sheet of steel, 0.5 mm", "push", thickness_mm=0.5, material="steel"),
)


def _beside_solid() -> Table:
    """The certificate over the solid's answer: stress is to be 1 to 1.25, deflection 0.97 to 1.1."""
    rows: list[tuple[Any, ...]] = []
    for part in BESIDE_SOLID:
        spec = PatternSpec(size_mm=60.0, finder=part.finder, tone=part.tone)
        pattern = build(encode("https://example.com/a/7", version=3), spec)
        case = Case.of((), material=part.material, support=part.support)
        case = case.for_hands(handling_loads((part.load,)), upright=False)
        found = verify_solid(pattern, Plane(part.thickness_mm), case)
        rows.append((part.name, found.load, found.deflection_ratio, found.stress_ratio, found.bytes / 1e9))
    columns = ("part", "bears", "deflection over solid", "stress over solid", "GB reckoned")
    return Table("structure: certificate over three dimensions", columns, tuple(rows))


def _largest(solver: str) -> tuple[float, int, float]:
    """Seconds, unknowns and the process's peak of memory in GB for version 40, as large as it must be."""
    pattern = _pattern(40)
    seconds, field = _timed(lambda: analyse(pattern, Plane(THICKNESS_MM), Case.of(PRESSURE, solver=solver)))
    return seconds, field.unknowns, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 / 1e9


def _pattern(version: int) -> Pattern:
    letters = random.Random(SEED)
    text = "".join(letters.choice("abcdefghijkXYZ0123456789") for _ in range(PAYLOAD[version]))
    return build(
        encode(text, version=version),
        PatternSpec(size_mm=SIZES_MM[version], nozzle_mm=NOZZLE_MM, finder=FINDER),
    )


def _model(pattern: Pattern) -> Any:
    size = MeshSize.even(pattern.module_mm, NOZZLE_MM)
    return prepare(Part.of(pattern, Plane(THICKNESS_MM)), Case.of(PRESSURE), size)


def _loop(pattern: Pattern, solver: str) -> tuple[float, float]:
    """Seconds to mesh and factorise the loop's model, and to lay and re-analyse one bridge on it."""

    def begin() -> Reanalysis:
        model = _model(pattern)
        forces = model.pressure_forces(PRESSURE.pressure_mpa)
        return Reanalysis(model, model.factorise(solver), forces, NOZZLE_MM)

    again_s, analysis = _timed(begin)
    bars = lattice_candidates(pattern, Allowance.of(pattern), (pattern.spec.web_mm,))
    rows = np.linspace(0, len(bars) - 1, BRIDGES).astype(int)

    def lay(bar: Candidates) -> None:
        model = analysis.model
        own = bar_tensors(model.section, model.wall_mm, bar, PLATE_MODES)
        analysis.add(analysis.respond(couplings(model, bar)), own, places_under(model.mesh, bar))

    laid_s, _ = _timed(lambda: [lay(bars.take(row[None])) for row in rows])
    return again_s, laid_s / BRIDGES


def _timed(call: Callable[[], Any]) -> tuple[float, Any]:
    start = os.times()
    answer = call()
    return sum(os.times()[:4]) - sum(start[:4]), answer
