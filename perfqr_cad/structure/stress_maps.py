"""Stress and deflection maps of a field, as in Fig. 11 of the paper."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from perfqr_cad.structure.stress_field import StressField

if TYPE_CHECKING:
    from perfqr_cad.pattern import Bridge

Quantity = Literal["stress", "deflection"]
DPI = 150
BRIDGE_GREEN = "#35d05b"  # structural bridges, as in Fig. 15; seen on dark and on light
_TITLES = {"stress": "von Mises stress, MPa", "deflection": "deflection, mm"}
_MAPS = {"stress": "inferno", "deflection": "viridis"}


def draw(
    field: StressField,
    path_or_axes: str | Path | Any,
    what: Quantity = "stress",
    *,
    bridges: Sequence[Bridge] = (),
    limit: float | None = None,
) -> None:
    """Draw a map in the pattern plane, as the reader sees it.

    `path_or_axes` is a PNG path or matplotlib axes. `what` is "stress" (the named measure) or "deflection"
    (its size along the normal). `limit` is the top of the scale, None for the field's own largest value, so
    that two maps can share one. `bridges` are outlined in green.
    """
    if isinstance(path_or_axes, str | Path):
        _draw_file(field, Path(path_or_axes), what, bridges, limit)
        return
    axes = path_or_axes
    values = field.von_mises_mpa if what == "stress" else np.abs(field.deflection_mm)
    top = limit if limit is not None else float(values.max())
    drawn = axes.tripcolor(
        field.uv_mm[:, 0],
        field.uv_mm[:, 1],
        field.triangles,
        np.minimum(values, top),
        shading="gouraud",
        cmap=_MAPS[what],
        vmin=0.0,
        vmax=top or 1.0,
        rasterized=True,
    )
    for bridge in bridges:
        axes.fill(*_outline(bridge).T, fill=False, edgecolor=BRIDGE_GREEN, linewidth=1.6)
    at = field.max_stress_at_mm if what == "stress" else field.max_deflection_at_mm
    axes.plot(*at, marker="o", markersize=7, markerfacecolor="none", markeredgecolor="tab:cyan")
    axes.set_aspect("equal")
    axes.set_axis_off()
    axes.set_title(f"{_TITLES[what]} (largest {values.max():.3g})", fontsize=9)
    axes.figure.colorbar(drawn, ax=axes, fraction=0.045, pad=0.02)


def _draw_file(
    field: StressField, path: Path, what: Quantity, bridges: Sequence[Bridge], limit: float | None
) -> None:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(5.0, 4.4), layout="constrained")
    FigureCanvasAgg(figure)
    draw(field, figure.subplots(), what, bridges=bridges, limit=limit)
    # No software version in the file: the same field gives the same bytes.
    figure.savefig(path, dpi=DPI, metadata={"Software": None})


def _outline(bridge: Bridge) -> np.ndarray:
    start, end = np.array(bridge.start), np.array(bridge.end)
    along = (end - start) / np.linalg.norm(end - start)
    across = np.array([-along[1], along[0]]) * bridge.width_mm / 2
    return np.array([start + across, end + across, end - across, start - across])
