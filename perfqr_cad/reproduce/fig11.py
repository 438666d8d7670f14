"""Fig. 11: a code of 12 × 12 cm and 5 mm before and after reinforcement, stress and deflection maps.

The paper's 5 Pa leaves this part far below its χ of 10 MPa, so Algorithm 1 would stop at once. It is shown at
5 Pa as it is, and reinforced by both methods at the pressure that takes it over χ. Finder rings hang on the
paper's four diagonal bars (§5.1).
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from perfqr_cad.pattern import Pattern, PatternSpec, build
from perfqr_cad.structure import Case, Pressure, Reinforcement, StressField, analyse, reinforce
from perfqr_cad.structure.stress_maps import draw
from perfqr_cad.surface import Plane
from perfqr_cad.symbol import encode
from perfqr_cad.table import Table
from perfqr_cad.units import mpa_from_pa

TEXT = "3D printed perforated QR codes, Computers & Graphics, CAD/Graphics 2019"
VERSION, SIZE_MM, THICKNESS_MM = 5, 120.0, 5.0
PAPER_PRESSURE_MPA = mpa_from_pa(5.0)
YIELD_MPA = 10.0  # the paper's χ for PLA
OVERLOAD = 1.15  # stress over χ at the pressure where reinforcement is shown


def run(out: Path) -> Table:
    """The figures of each case as a table; writes fig11-5pa.png, -<method>.png and -convergence.png."""
    out.mkdir(parents=True, exist_ok=True)
    pattern = build(encode(TEXT, version=VERSION), PatternSpec(size_mm=SIZE_MM, finder="diagonal"))
    plate = Plane(THICKNESS_MM)
    at_paper = analyse(pattern, plate, Case.of(Pressure(PAPER_PRESSURE_MPA), yield_mpa=YIELD_MPA))
    pressure = PAPER_PRESSURE_MPA * OVERLOAD * YIELD_MPA / at_paper.max_stress_mpa
    rows = [_row("paper's pressure", PAPER_PRESSURE_MPA, at_paper, None)]
    results: list[Reinforcement] = []
    _figure(out / "fig11-5pa.png", [("5 Pa", at_paper, None)])
    case = Case.of(Pressure(pressure), yield_mpa=YIELD_MPA)
    for method in ("optimal", "paper"):
        result = reinforce(pattern, plate, case, method=method)
        results.append(result)
        rows.append(_row("before", pressure, result.before, None))
        rows.append(_row(method, pressure, result.after, result))
        _figure(
            out / f"fig11-{method}.png", [("before", result.before, None), (method, result.after, result)]
        )
    _convergence(out / "fig11-convergence.png", results)
    columns = ("case", "Pa", "stress MPa", "deflection mm", "bridges", "L(Q)", "status")
    notes = (
        f"version {VERSION}, {SIZE_MM:g} mm, {THICKNESS_MM:g} mm thick, PLA, clamped, χ {YIELD_MPA:g} MPa",
    )
    return Table("Fig. 11: stress and deflection before and after reinforcement", columns, tuple(rows), notes)


def _row(case: str, pressure_mpa: float, field: StressField, result: Reinforcement | None) -> tuple[Any, ...]:
    return (
        case,
        pressure_mpa * 1e6,
        field.max_stress_mpa,
        field.max_deflection_mm,
        len(result.bridges) if result else 0,
        _loss(result.pattern) if result else None,
        result.status if result else ("strong" if field.strong else "too weak"),
    )


def _loss(pattern: Pattern) -> float:
    return pattern.readability.total


def _figure(path: Path, cases: list[tuple[str, StressField, Reinforcement | None]]) -> None:
    """Stress above, deflection below, one column for each case, on common scales."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(4.6 * len(cases), 8.4), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(2, len(cases), squeeze=False)
    stress = max(field.max_stress_mpa for _, field, _ in cases)
    deflection = max(field.max_deflection_mm for _, field, _ in cases)
    for column, (name, field, result) in enumerate(cases):
        bridges = result.bridges if result else ()
        draw(field, axes[0, column], "stress", bridges=bridges, limit=stress)
        draw(field, axes[1, column], "deflection", bridges=bridges, limit=deflection)
        axes[0, column].set_title(f"{name}: {axes[0, column].get_title()}", fontsize=9)
    figure.savefig(path, dpi=110, metadata={"Software": None})


def _convergence(path: Path, results: list[Reinforcement]) -> None:
    """The largest stress as each method lays bridges and confirms them, down to the limit."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from matplotlib.ticker import MaxNLocator

    figure = Figure(figsize=(6.0, 3.6), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots()
    for result in results:
        axes.plot(
            result.history, marker="o", markersize=4, label=f"{result.method}: {result.iterations} bridges"
        )
    axes.axhline(YIELD_MPA, color="tab:red", linestyle="--", linewidth=1.0, label=f"χ = {YIELD_MPA:g} MPa")
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.set_xlabel("round or confirming mesh")
    axes.set_ylabel("largest stress, MPa")
    axes.set_ylim(bottom=0.0)
    axes.grid(alpha=0.3)
    axes.legend(fontsize=8)
    figure.savefig(path, dpi=110, metadata={"Software": None})
