"""The report: one HTML page a part, with everything inside it and nothing fetched from a network."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from html import escape
from io import BytesIO
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING, Any

from perfqr_cad.export import svg
from perfqr_cad.export.design_view import DesignView
from perfqr_cad.export.picture import rendered
from perfqr_cad.export.report import markup
from perfqr_cad.export.report.loss import loss_curve
from perfqr_cad.export.report.stylesheet import STYLE

if TYPE_CHECKING:
    from perfqr_cad.pattern import Bridge
    from perfqr_cad.scan import DecoderResult, FilmedView, ScanReport
    from perfqr_cad.structure import StressField
    from perfqr_cad.structure.stress_maps import Quantity

STAGE_TEXT = {
    "function": "finder and alignment rings (blue)",
    "connectivity": "islands (red)",
    "structural": "strength (green)",
}
MAPS: dict[Quantity, str] = {"stress": "Von Mises stress", "deflection": "Deflection"}
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
    yield _readability(certificate)
    yield _connectivity(design, certificate)
    yield _strength(design, certificate)
    yield f"<h2>Solid</h2>\n{markup.facts(certificate.get('solid') or {})}"
    yield _scan(design.scan)


def _head(design: DesignView, certificate: dict[str, Any]) -> str:
    symbol, solid = certificate.get("symbol") or {}, design.solid
    strength = certificate.get("structure") or {}
    chips = [f"version {symbol.get('version')}-{symbol.get('level')}"]
    chips.append(" × ".join(f"{high - low:.4g}" for low, high in zip(*solid.bbox_mm, strict=True)) + " mm")
    if strength:
        chips.append(f"{strength['material']}, {strength['mass_g']:.3g} g")
        chips.append(f"safety factor {strength['safety_factor']:.3g}")
    if design.scan is not None:
        chips.append(f"read by {', '.join(design.scan.readers) or 'no decoder'}")
    items = "".join(f"<li>{escape(chip)}</li>" for chip in chips)
    payload = certificate.get("payload")
    text = "" if payload is None else f'<div class="payload">{escape(str(payload))}</div>\n'
    return f'<h1>{escape(solid.name)}</h1>\n{text}<ul class="chips">{items}</ul>'


def _views(design: DesignView) -> str:
    picture = markup.image(rendered(design, *PICTURE_PX), "the part")
    counts = Counter(bridge.stage for bridge in design.pattern.bridges)
    stages = "; ".join(f"{count} for {STAGE_TEXT[stage]}" for stage, count in sorted(counts.items()))
    caption = f"The pattern. Bridges: {stages or 'none'}"
    plan = svg.drawing(design, bridges=True)
    inline = plan[plan.index("<svg") :]
    return (
        f'<div class="pair">{markup.figure(picture, "The part")}\n'
        f'<div class="plan">{markup.figure(inline, caption)}</div></div>'
    )


def _readability(certificate: dict[str, Any]) -> str:
    section = certificate.get("readability") or {}
    blocks = [(block["errors"], block["capacity"]) for block in section.get("blocks", [])]
    first, rows = 1, list[tuple[str, str]]()
    for (errors, capacity), alike in groupby(blocks):
        last = first + len(list(alike)) - 1
        rows.append(
            (f"block {first}" if first == last else f"blocks {first}–{last}", f"{errors} of {capacity}")
        )
        first = last + 1
    table = markup.table(("", "wrong codewords, of those that can be corrected"), rows)
    facts = markup.facts(section)
    return f'<h2>Readability</h2>\n<div class="pair"><div>{facts}</div>\n<div>{table}</div></div>'


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
    if loop is None or not loop.bridges:
        return f"<h2>Strength</h2>\n{table}\n{_maps(design.stress, 'as made', (), {})}"
    chart = markup.line_chart(loop.history, x_label="steps", y_label="stress, MPa", limit=loop.limit_mpa)
    caption = f"Largest stress as bridges were added ({len(loop.bridges)}); dashed: the yield stress"
    limits: dict[Quantity, float] = {
        "stress": max(loop.before.max_stress_mpa, design.stress.max_stress_mpa),
        "deflection": max(abs(field.max_deflection_mm) for field in (loop.before, design.stress)),
    }
    return (
        f'<h2>Strength</h2>\n<div class="pair"><div>{table}</div>{markup.figure(chart, caption)}</div>\n'
        f"{_maps(loop.before, 'before reinforcement', (), limits)}\n"
        f"{_maps(design.stress, 'as made', loop.bridges, limits)}"
    )


def _maps(field: StressField, when: str, bridges: Sequence[Bridge], limits: Mapping[Quantity, float]) -> str:
    """Stress and deflection side by side, each up to its limit or its own largest value."""
    from matplotlib.figure import Figure

    from perfqr_cad.structure.stress_maps import draw

    parts: list[str] = []
    for what, name in MAPS.items():
        canvas, data = Figure(figsize=MAP_INCHES, dpi=MAP_DPI, layout="constrained"), BytesIO()
        draw(field, canvas.subplots(), what, bridges=bridges, limit=limits.get(what))
        canvas.savefig(data, format="png", metadata={"Software": None})
        parts.append(markup.figure(markup.png_image(data.getvalue(), name), f"{name}, {when}"))
    return f'<div class="pair">{"".join(parts)}</div>'


def _scan(report: ScanReport | None) -> str:
    if report is None:
        return "<h2>Scan</h2>\n<p>Not filmed.</p>"
    backgrounds = markup.table(
        (), [(f"on {name}", f"{rate:.1%}") for name, rate in report.backgrounds.items()]
    )
    sights = [
        _sight(sight, caption)
        for sight, caption in (
            (report.worst_read, "The steepest view that all still read"),
            (report.first_missed, "The first view that one misses"),
        )
        if sight is not None
    ]
    said = [*([report.ground_words] if report.grounds else []), *report.warnings, *report.advice]
    advice = f'<ul class="advice">{"".join(f"<li>{escape(line)}</li>" for line in said)}</ul>' if said else ""
    return (
        f'<h2>Scan</h2>\n<div class="pair">{_heat_maps(list(report.decoders.values()))}</div>\n{advice}\n'
        f'<div class="pair">{"".join(sights)}</div>\n'
        f'<div class="pair">{markup.figure(backgrounds, "Views from above that are read, by ground")}</div>'
        f"{_art(report)}{_grade(report)}"
    )


def _art(report: ScanReport) -> str:
    """The picture that the part was drawn from, beside the part as an eye sees it."""
    if (found := report.likeness) is None:
        return ""
    pair = markup.figure(markup.image(found.art, "the art"), "The art, printed flat")
    pair += markup.figure(markup.image(found.part, "the part"), "The part from straight above")
    return f'\n<p>{escape(found.words(report.readers))}</p>\n<div class="pair">{pair}</div>'


def _grade(report: ScanReport) -> str:
    """The parameters of both standards, before each ground."""
    if report.grade is None:
        return ""
    tables = [
        markup.figure(
            markup.table(
                (f"{grade.written}: {grade.letter}", "grade"),
                [(name, f"{value:.1f}") for name, value in grade.grades.items()],
            ),
            f"{grade.edition}, before {ground}; simulated, not verified",
        )
        for ground, grades in report.grade.grounds.items()
        for grade in grades
    ]
    return f'\n<h2>Grade</h2>\n<div class="pair">{"".join(tables)}</div>'


def _heat_maps(decoders: Sequence[DecoderResult]) -> str:
    """Success by tilt: the part and, where it was filmed too, the flat print of the same code."""
    columns = [f"{tilt:g}°" for tilt in decoders[0].tilts_deg] if decoders else []
    part = [(result.name, result.rates, _reach(result.max_tilt_deg)) for result in decoders]
    print_ = [
        (result.name, result.flat_rates, _reach(result.flat_max_tilt_deg))
        for result in decoders
        if result.flat_rates is not None
    ]
    maps = markup.figure(markup.heat_map(columns, part), "The part: views read, by tilt")
    if print_:
        maps += markup.figure(markup.heat_map(columns, print_), "A flat print of the same code: the ceiling")
    return maps


def _reach(max_tilt_deg: float | None) -> str:
    return "no view" if max_tilt_deg is None else f"all to {max_tilt_deg:g}°"


def _sight(sight: FilmedView, caption: str) -> str:
    read = ", ".join(sight.read_by) or "none"
    text = f"{caption}: {sight.tilt_deg:g}° from azimuth {sight.azimuth_deg:g}°, read by {read}"
    return markup.figure(markup.image(sight.picture, caption), text)
