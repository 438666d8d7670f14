"""Fig. 14: success by tilt, the Einstein code printed flat and as a 12 cm part of 2 mm.

The paper scanned each 20 times an angle with one telephone: good to 30° (print) and 20° (part), hardly any
beyond 60° and 30°.
"""

from __future__ import annotations

from pathlib import Path

from perfqr_cad.progress import tell
from perfqr_cad.reproduce.exhibits import exhibit, handheld, rate
from perfqr_cad.scan import Look
from perfqr_cad.scan.decoding.decoders import CORE
from perfqr_cad.table import Table

TILTS_DEG = tuple(range(0, 65, 5))
_COLOURS = ("tab:blue", "tab:orange", "tab:green", "tab:purple")
PAPER_MARKS_DEG = (20, 30)  # good robustness to, difficult beyond


def run(out: Path, views: int = 20) -> Table:
    """Success by tilt for both, per engine and for any of them; the curves as fig14.png."""
    shown = exhibit("Einstein", out)
    part: list[dict[str, float]] = []
    paper: list[dict[str, float]] = []
    for tilt in TILTS_DEG:
        tell(f"tilt {tilt}°")
        seen = handheld(float(tilt), views, seed=14)
        part.append(rate(shown.part, shown.payload, seen, Look()))
        paper.append(rate(shown.print, shown.payload, seen, Look()))
    _plot(out / "fig14.png", part, paper)
    who = (*CORE, "any")
    rows = tuple(
        (tilt, *(p[name] for name in who), *(f[name] for name in who))
        for tilt, p, f in zip(TILTS_DEG, part, paper, strict=True)
    )
    columns = ("tilt °", *(f"part {name}" for name in who), *(f"print {name}" for name in who))
    return Table(
        "Fig. 14: share of scans read by tilt, part and flat print of the Einstein stand-in",
        columns,
        rows,
        (
            f"{views} scans a point, one frame each; "
            f"part {shown.pattern.size_mm:.4g} mm, modules {shown.pattern.module_mm:.3g} mm, upright walls",
            "the paper: part good to 20°, difficult beyond 30°; print good to 30°, none beyond 60°",
        ),
    )


def _plot(path: Path, part: list[dict[str, float]], paper: list[dict[str, float]]) -> None:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8, 4.2), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    for name, colour in zip(CORE, _COLOURS, strict=True):
        for curves, style, label in ((paper, "--", "flat print"), (part, "-", "part")):
            rates = [100 * c[name] for c in curves]
            axes.plot(
                TILTS_DEG, rates, style, color=colour, marker="o", markersize=3, label=f"{name}, {label}"
            )
    for mark in PAPER_MARKS_DEG:
        axes.axvline(mark, color="tab:red", linestyle=":", linewidth=1)
        axes.annotate(f"paper: {mark}°", (mark, 3), rotation=90, color="tab:red", fontsize=8, ha="right")
    axes.set(xlabel="tilt, degrees", ylabel="scans read, %", ylim=(-3, 103))
    axes.legend(frameon=False, fontsize=8, loc="center left", bbox_to_anchor=(1, 0.5))
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=140)
