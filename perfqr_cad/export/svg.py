"""SVG of the outline: user units are millimetres, arcs and Béziers stay what they are."""

from __future__ import annotations

import math
from collections.abc import Iterable
from pathlib import Path
from typing import Literal
from xml.sax.saxutils import escape

from perfqr_cad.export.cutting import cut, engraving
from perfqr_cad.export.design_view import DesignView, face
from perfqr_cad.geometry import Arc, Bezier, Circle, Line, Loop
from perfqr_cad.pattern import Bridge

SvgVariant = Literal["filled", "cut"]

DIGITS = 6  # after the point: a nanometre
MATERIAL, LETTERS = "#e9e4d8", "#8d8674"
STAGE_COLOURS = {"function": "#3b6fb6", "connectivity": "#d1342f", "structural": "#2c9a4b"}
# What drivers of laser cutters take for a line to follow, and colours that tell them what to do there.
HAIRLINE_MM = 0.01
CUT_COLOUR, ENGRAVE_COLOUR = "#ff0000", "#0000ff"


def write(design: DesignView, path: Path, *, variant: SvgVariant = "filled", kerf_mm: float = 0.0) -> None:
    """Write the reading face: as a filled shape, or as hairlines that a cutter follows, half a kerf beside
    it."""
    path.write_text(hairlines(design, kerf_mm) if variant == "cut" else drawing(design), "utf-8")


def drawing(design: DesignView, *, bridges: bool = False) -> str:
    """The material as one filled path, letters on it; `bridges` lays coloured bars over it by stage."""
    letters = "".join(_path(letter.loops) for letter in engraving(design))
    bars = "".join(_bar(bridge) for bridge in face(design).bridges) if bridges else ""
    return _page(
        design,
        design.pattern.region.outer,
        f'<path class="part" fill="{MATERIAL}" fill-rule="evenodd" '
        f'd="{path_data(face(design).region.loops)}"/>\n'
        + _group("engrave", f'fill="{LETTERS}" fill-rule="evenodd"', letters)
        + bars,
    )


def hairlines(design: DesignView, kerf_mm: float = 0.0) -> str:
    """A path for every loop, what is inside first: letters to engrave, holes, and last the outline."""
    work = cut(design, kerf_mm)
    letters, through = ("".join(_path([loop]) for loop in loops) for loops in (work.engrave, work.through))
    line = f'fill="none" stroke-width="{HAIRLINE_MM:g}"'
    return _page(
        design,
        work.outline,
        _group("engrave", f'{line} stroke="{ENGRAVE_COLOUR}"', letters)
        + _group("cut", f'{line} stroke="{CUT_COLOUR}"', through),
    )


def _page(design: DesignView, outline: Loop, content: str) -> str:
    """A document as large as the part, or as the path around it."""
    corners = outline.flatten()
    (left, low), (right, high) = corners.min(axis=0).tolist(), corners.max(axis=0).tolist()
    width, height = _n(right - left), _n(high - low)
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}mm" height="{height}mm" '
        f'viewBox="{_n(left)} {_n(-high)} {width} {height}">\n'
        f"<title>{escape(design.solid.name)}</title>\n{content}</svg>\n"
    )


def _group(name: str, attributes: str, content: str) -> str:
    return f'<g id="{name}" {attributes}>\n{content}</g>\n' if content else ""


def _path(loops: Iterable[Loop]) -> str:
    return f'<path d="{path_data(loops)}"/>\n'


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
