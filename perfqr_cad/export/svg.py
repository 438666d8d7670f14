"""SVG of the outline: user units are millimetres, arcs stay arcs, holes by the even-odd rule."""

from __future__ import annotations

import math
from collections.abc import Iterable
from pathlib import Path
from xml.sax.saxutils import escape

from perfqr_cad.export.design_view import DesignView
from perfqr_cad.geometry import Arc, Bezier, Circle, Line, Loop
from perfqr_cad.pattern import Bridge, Pattern

DIGITS = 6  # after the point: a nanometre
MATERIAL = "#e9e4d8"
STAGE_COLOURS = {"function": "#3b6fb6", "connectivity": "#d1342f", "structural": "#2c9a4b"}


def write(design: DesignView, path: Path) -> None:
    """Write the reading face of the pattern as one filled path, ready for a cutter."""
    path.write_text(drawing(design.pattern, title=design.solid.name), "utf-8")


def drawing(pattern: Pattern, *, title: str, bridges: bool = False) -> str:
    """The pattern as an SVG document as large as the part; `bridges` lays coloured bars over it by stage."""
    xs, ys = zip(*(p for loop in (pattern.region.outer,) for p in loop.flatten()), strict=True)
    left, top, width, height = min(xs), -max(ys), max(xs) - min(xs), max(ys) - min(ys)
    overlay = "".join(_bar(bridge) for bridge in pattern.bridges) if bridges else ""
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{_n(width)}mm" height="{_n(height)}mm" '
        f'viewBox="{_n(left)} {_n(top)} {_n(width)} {_n(height)}">\n'
        f"<title>{escape(title)}</title>\n"
        f'<path class="part" fill="{MATERIAL}" fill-rule="evenodd" d="{path_data(pattern.region.loops)}"/>\n'
        f"{overlay}</svg>\n"
    )


def path_data(loops: Iterable[Loop]) -> str:
    """Path commands of closed loops, y turned down."""
    return "\n".join(_loop(loop) for loop in loops)


def _loop(loop: Loop) -> str:
    steps = [f"M{_p(loop.segments[0].start)}"]
    for segment in loop.segments:
        match segment:
            case Line(_, end):
                steps.append(f"L{_p(end)}")
            case Arc(_, end, _, ccw):
                steps.append(_arc(segment.radius, abs(segment.sweep_rad) > math.pi, ccw, end))
            case Circle(centre, radius, ccw):  # one command cannot end where it begins
                steps.append(_arc(radius, False, ccw, (centre[0] - radius, centre[1])))
                steps.append(_arc(radius, False, ccw, segment.end))
            case Bezier(_, c1, c2, end):
                steps.append(f"C{_p(c1)} {_p(c2)} {_p(end)}")
    if isinstance(loop.segments[-1], Line):
        steps.pop()  # Z draws it
    return "".join(steps) + "Z"


def _arc(radius: float, large: bool, ccw: bool, end: tuple[float, float]) -> str:
    return f"A{_n(radius)} {_n(radius)} 0 {int(large)} {int(not ccw)} {_p(end)}"


def _bar(bridge: Bridge) -> str:
    (x1, y1), (x2, y2) = bridge.start, bridge.end
    return (
        f'<line class="bridge {bridge.stage}" stroke="{STAGE_COLOURS[bridge.stage]}" '
        f'stroke-width="{_n(bridge.width_mm)}" x1="{_n(x1)}" y1="{_n(-y1)}" x2="{_n(x2)}" y2="{_n(-y2)}"/>\n'
    )


def _p(point: tuple[float, float]) -> str:
    return f"{_n(point[0])} {_n(-point[1])}"


def _n(value: float) -> str:
    text = f"{value:.{DIGITS}f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text
