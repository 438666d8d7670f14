"""The report: one HTML page a part, with everything inside it and nothing fetched from a network."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from html import escape
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

from . import markup, png, svg
from .design_view import DesignView
from .loss import loss_curve
from .style import STYLE

if TYPE_CHECKING:
    from perfqr_cad.scan import DecoderResult, ScanReport, Sight
    from perfqr_cad.structure import StressField

STAGE_TEXT = {
    "function": "finder and alignment rings (blue)",
    "connectivity": "islands (red)",
    "structural": "strength (green)",
}
MAPS = (("stress", "Von Mises stress"), ("deflection", "Deflection"))
PICTURE_PX = (720, 540)
MAP_INCHES, MAP_DPI = (4.6, 4.0), 110


def write(design: DesignView, path: Path) -> None:
    """Write the page. The same design gives the same bytes: it shows no clock and no timings."""
    certificate = design.certificate()
    body = "\n".join(_sections(design, certificate))
    title = escape(design.solid.name)
    path.write_text(
        f'<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n<title>{title}</title>\n'
        f'<meta name="viewport" content="width=device-width">\n<style>{STYLE}</style>\n</head>\n'
        f"<body>\n{body}\n</body>\n</html>\n",
        "utf-8",
    )


def _sections(design: DesignView, certificate: dict[str, Any]) -> Iterator[str]:
    yield _head(design, certificate)
    yield _views(design)
    yield _readability(design, certificate)
    yield _connectivity(design, certificate)
    yield _strength(design, certificate)
    yield f"<h2>Solid</h2>\n{markup.facts(certificate.get('solid') or {})}"
    yield _scan(design.scan)


def _head(design: DesignView, certificate: dict[str, Any]) -> str:
    symbol, solid = certificate.get("symbol") or {}, design.solid
    chips = [f"version {symbol.get('version')}-{symbol.get('level')}"]
    chips.append(" × ".join(f"{high - low:.4g}" for low, high in zip(*solid.bbox_mm, strict=True)) + " mm")
    if design.stress is not None:
        chips.append(f"{design.stress.material}, {design.stress.mass_g:.3g} g")
        chips.append(f"safety factor {design.stress.safety_factor:.3g}")
    if design.scan is not None:
        chips.append(f"read by {', '.join(design.scan.readers) or 'no decoder'}")
    items = "".join(f"<li>{escape(chip)}</li>" for chip in chips)
    payload = certificate.get("payload")
    text = "" if payload is None else f'<div class="payload">{escape(str(payload))}</div>\n'
    return f'<h1>{escape(solid.name)}</h1>\n{text}<ul class="chips">{items}</ul>'


def _views(design: DesignView) -> str:
    picture = markup.image(png.picture(design, *PICTURE_PX), "the part")
    counts = Counter(bridge.stage for bridge in design.pattern.bridges)
    stages = "; ".join(f"{count} for {STAGE_TEXT[stage]}" for stage, count in sorted(counts.items()))
    caption = f"The pattern. Bridges: {stages or 'none'}"
    plan = svg.drawing(design.pattern, title=design.solid.name, bridges=True)
    inline = plan[plan.index("<svg") :]
    return (
        f'<div class="pair">{markup.figure(picture, "The part")}\n'
        f'<div class="plan">{markup.figure(inline, caption)}</div></div>'
    )


def _readability(design: DesignView, certificate: dict[str, Any]) -> str:
    section = certificate.get("readability") or {}
    blocks = [
        (f"block {number}", f"{block['errors']} of {block['capacity']} codewords that can be corrected")
        for number, block in enumerate(section.get("blocks", []), 1)
    ]
    return (
        f'<h2>Readability</h2>\n<div class="pair"><div>{markup.facts(section)}</div>\n'
        f"<div>{markup.table((), blocks)}</div></div>"
    )


def _connectivity(design: DesignView, certificate: dict[str, Any]) -> str:
    chart = markup.line_chart(loss_curve(design.pattern), x_label="bridges laid", y_label="loss L(Q)")
    caption = (
        "Loss of readability as the bridges are laid: each wrong module counts from the first bridge over it"
    )
    table = markup.facts(certificate.get("connectivity") or {})
    return f'<h2>One piece</h2>\n<div class="pair"><div>{table}</div>{markup.figure(chart, caption)}</div>'


def _strength(design: DesignView, certificate: dict[str, Any]) -> str:
    table = markup.facts(certificate.get("structure") or {})
    if design.stress is None:
        return f"<h2>Strength</h2>\n{table}"
    loop = design.reinforcement
    figures = [_maps(design.stress, "as made")]
    if loop is not None and loop.after is not loop.before:
        figures.insert(0, _maps(loop.before, "before reinforcement"))
    rows = "\n".join(f'<div class="pair">{maps}</div>' for maps in figures)
    return f"<h2>Strength</h2>\n{table}\n{rows}"


def _maps(field: StressField, when: str) -> str:
    """Stress and deflection side by side."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    parts: list[str] = []
    for what, name in MAPS:
        figure = Figure(figsize=MAP_INCHES, dpi=MAP_DPI, layout="constrained")
        FigureCanvasAgg(figure)
        _draw(field, figure.add_subplot(), what)
        data = BytesIO()
        figure.savefig(data, format="png")
        parts.append(markup.figure(markup.png_image(data.getvalue(), name), f"{name}, {when}"))
    return "".join(parts)


def _draw(field: StressField, axes: Any, what: str) -> None:
    values, unit = (field.von_mises_mpa, "MPa") if what == "stress" else (field.deflection_mm, "mm")
    mesh = axes.tripcolor(*field.uv_mm.T, field.triangles, values, shading="gouraud", cmap="turbo")
    axes.set(aspect="equal", xlabel="mm")
    axes.figure.colorbar(mesh, label=unit)


def _scan(report: ScanReport | None) -> str:
    if report is None:
        return "<h2>Scan</h2>\n<p>Not filmed.</p>"
    tilts = next(iter(report.decoders.values())).tilts_deg if report.decoders else ()
    rows = [(name, result.rates, _reach(result)) for name, result in report.decoders.items()]
    heat = markup.heat_map([f"{tilt:g}°" for tilt in tilts], rows)
    backgrounds = markup.table(
        (), [(f"on {name}", f"{rate:.1%}") for name, rate in report.backgrounds.items()]
    )
    sights = [
        _sight(sight, caption)
        for sight, caption in (
            (report.worst_read, "The worst view that is still read"),
            (report.first_missed, "The first view that is missed"),
        )
        if sight is not None
    ]
    said = [*report.warnings, *report.advice]
    advice = f'<ul class="advice">{"".join(f"<li>{escape(line)}</li>" for line in said)}</ul>' if said else ""
    return (
        f'<h2>Scan</h2>\n<div class="pair">{markup.figure(heat, "Views read, by tilt from straight above")}\n'
        f'<div>{backgrounds}</div></div>\n{advice}\n<div class="pair">{"".join(sights)}</div>'
    )


def _reach(result: DecoderResult) -> str:
    """How far every view is read, and how far the flat print of the same code is: the ceiling."""
    reach, ceiling = result.max_tilt_deg, result.flat_max_tilt_deg
    part = "no view from above" if reach is None else f"every view to {reach:g}°"
    return f"{part}; flat print: {'none' if ceiling is None else f'{ceiling:g}°'}"


def _sight(sight: Sight, caption: str) -> str:
    read = ", ".join(sight.read_by) or "none"
    text = f"{caption}: {sight.tilt_deg:g}° from azimuth {sight.azimuth_deg:g}°, read by {read}"
    return markup.figure(markup.image(sight.picture, caption), text)
