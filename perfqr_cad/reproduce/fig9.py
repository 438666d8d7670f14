"""Fig. 9: L(Q) along the connectors for λ = 0 and λ = 1 of Eq. (4), and where `optimal` ends."""

from __future__ import annotations

import math
from pathlib import Path

from perfqr_cad.capture import read
from perfqr_cad.pattern import Pattern, PatternSpec, build
from perfqr_cad.pattern.spec import Objective
from perfqr_cad.progress import tell
from perfqr_cad.reproduce.stand_ins import TABLE_1, picture
from perfqr_cad.table import Table

LEAST_LOSS = 1e-3  # above it the axis is logarithmic
CURVES: tuple[tuple[str, Objective], ...] = (("λ = 0", "mst"), ("λ = 1", "paper"), ("optimal", "optimal"))


def run(out: Path) -> Table:
    """One row per method; writes fig9.png and a picture of each pattern with its connectors in red."""
    flower = TABLE_1[0]
    out.mkdir(parents=True, exist_ok=True)
    capture = read(picture(flower, out))
    patterns: dict[str, Pattern] = {}
    for label, objective in CURVES:
        tell(f"fig9: {label}")
        patterns[label] = build(capture.recovery.symbol, PatternSpec(objective=objective), capture.art)
    _plot_losses(patterns, out / "fig9.png")
    for (label, objective), pattern in zip(CURVES, patterns.values(), strict=True):
        plot_pattern(pattern, out / f"fig9_{objective}.png", f"{flower.name}, {label}")
    rows = tuple(
        (name, p.islands_before, len(p.losses) or None, sum(p.readability.errors), p.readability.total)
        for name, p in patterns.items()
    )
    return Table(
        f"Fig. 9: loss of readability along the connectors ({flower.name})",
        ("method", "islands", "connectors weighed", "codewords lost", "L(Q) at the end"),
        rows,
        ("the paper's curve is of another picture: compare its shape, and its end in ∞ for λ = 0",),
    )


def _plot_losses(patterns: dict[str, Pattern], path: Path) -> None:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=(7, 4), dpi=150)
    for label, pattern in patterns.items():
        losses = pattern.losses or (pattern.readability.total,) * 2
        finite = [loss for loss in losses if math.isfinite(loss)]
        steps = (
            range(len(finite)) if pattern.losses else [0, max(len(p.losses) for p in patterns.values()) - 1]
        )
        (line,) = axes.plot(steps, finite, label=label)
        if len(finite) < len(losses):
            axes.plot(
                [len(finite) - 1], finite[-1:], "x", color=line.get_color(), label=f"{label}: ∞ from here"
            )
    axes.set_yscale("symlog", linthresh=LEAST_LOSS)
    axes.set(xlabel="connectors", ylabel="L(Q)", ylim=(0, None))
    axes.legend()
    figure.tight_layout()
    figure.savefig(path, bbox_inches="tight")
    plt.close(figure)


def plot_pattern(pattern: Pattern, path: Path, title: str = "") -> None:
    """A picture of a pattern before black, its connectors in red and ring bars in orange (Fig. 15(b))."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    from matplotlib.collections import LineCollection
    from matplotlib.patches import PathPatch, Rectangle
    from matplotlib.path import Path as Outline

    figure, axes = plt.subplots(figsize=(8, 8), dpi=150)
    half = pattern.size_mm / 2
    axes.add_patch(Rectangle((-half, -half), 2 * half, 2 * half, color="black"))
    loops = [Outline(loop.flatten(), closed=False) for loop in pattern.region.loops]
    axes.add_patch(PathPatch(Outline.make_compound_path(*loops), facecolor="white", linewidth=0))
    colours = {"function": "orange", "connectivity": "red", "structural": "green"}
    axes.add_collection(
        LineCollection(
            [(b.start, b.end) for b in pattern.bridges],
            colors=[colours[b.stage] for b in pattern.bridges],
            linewidths=1.5,
        )
    )
    axes.set(xlim=(-half, half), ylim=(-half, half), aspect="equal", title=title)
    axes.axis("off")
    figure.savefig(path, bbox_inches="tight")
    plt.close(figure)
