"""OpenSCAD source: a module `perforated_qr` with its parameters on top, as values for the customizer.

The outline is a polygon with holes, raised to the thickness. A part that is no plain extrusion (curved,
flared, carved into another body) is a polyhedron. Letters and a backing are in either.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from perfqr_cad.export.cutting import engraving, is_extrusion
from perfqr_cad.export.design_view import DesignView
from perfqr_cad.geometry import Loop

if TYPE_CHECKING:
    from perfqr_cad.solid import Solid

CURVE_TOL_MM = 0.01  # chord error of flattened curves: a fifth of a thin layer
GREATEST_SCALE = 4  # of the customizer's range; never below 1, where webs would be too thin
ROW = 6  # entries on a line
BACKING = "backing"  # name of the one body behind that is an extrusion too

MODULE = "perforated_qr"

PLAIN = """    color({colour}) linear_extrude(height = thickness, convexity = 10) pattern(size);
"""
LETTERED = """    color({colour}) difference() {{
        union() {{
            linear_extrude(height = thickness, convexity = 10) pattern(size);
            if (relief > 0)
                translate([0, 0, thickness]) linear_extrude(height = relief) letters(size);
        }}
        if (relief < 0)
            translate([0, 0, thickness + relief]) linear_extrude(height = 1 - relief) letters(size);
    }}
"""


def write(design: DesignView, path: Path) -> None:
    """Write a source file that OpenSCAD 2015 and later renders and offers in its customizer."""
    title = " ".join(design.solid.name.split())
    extruded = is_extrusion(design) and all(extra.name == BACKING for extra in design.solid.extras)
    body = _extrusion(design) if extruded else _polyhedra(design)
    path.write_text(f"// {title}: a perforated QR code. Units: mm.\n\n{body}", "utf-8")


def _extrusion(design: DesignView) -> str:
    loops = design.pattern.region.loops
    width = float(np.ptp(loops[0].flatten()[:, 0]))
    backing_mm, gap_mm, behind = _backing(design)
    letters = [loop for letter in engraving(design) for loop in letter.loops]
    settings = [
        _width(width),
        _thickness(design.placement.thickness_mm),
        _Setting(
            "backing", backing_mm, "Thickness of a closed plate behind the part, mm; 0 for none", "0:0.1:10"
        ),
        _Setting("gap", gap_mm, "Gap before that plate, mm", "0:0.1:10"),
    ]
    if letters:
        out = "How far the letters stand out of the part, mm; below 0 they are engraved"
        settings.insert(2, _Setting("relief", design.solid.relief_mm, out, "-10:0.1:10"))
    body = (LETTERED if letters else PLAIN).format(colour=_colour(design.solid))
    body += f"""    if (backing > 0)
        color({behind}) translate([0, 0, -gap - backing]) linear_extrude(height = backing) plate(size);
"""
    drawings = [_polygon("pattern", loops, width), _polygon("plate", (loops[0], *_mounts(design)), width)]
    drawings += [_polygon("letters", letters, width)] if letters else []
    return _source(settings, body, drawings)


@dataclass(frozen=True)
class _Setting:
    """A value of the customizer, and parameter of the module."""

    name: str
    value: float | bool
    meaning: str
    range: str = ""

    @property
    def text(self) -> str:
        """The value as OpenSCAD writes it."""
        return str(self.value).lower() if isinstance(self.value, bool) else f"{self.value:.9g}"

    @property
    def line(self) -> str:
        """Its line for the customizer."""
        return f"// {self.meaning}\n{self.name} = {self.text};{f' // [{self.range}]' if self.range else ''}\n"


def _width(width: float) -> _Setting:
    most = f"{width:.9g}:1:{width * GREATEST_SCALE:.9g}"
    return _Setting("size", width, "Width of the part, mm", most)


def _thickness(thickness_mm: float) -> _Setting:
    return _Setting("thickness", thickness_mm, "Thickness of the part, mm", "0.2:0.1:20")


def _source(settings: Sequence[_Setting], body: str, drawings: Sequence[str]) -> str:
    """Values for the customizer, the part made of them, the module that makes it, and what that draws."""
    names = ", ".join(setting.name for setting in settings)
    defaults = ", ".join(f"{setting.name} = {setting.text}" for setting in settings)
    lines = "".join(setting.line for setting in settings)
    return f"""{lines}
{MODULE}({names});

// The part about the middle of the code, its back at z = 0. In other files: use <this file>, then
// {MODULE}(size = ...);
module {MODULE}({defaults}) {{
{body}}}

/* [Hidden] */
""" + "\n".join(drawings)


def _backing(design: DesignView) -> tuple[float, float, str]:
    """Thickness and gap, mm, and colour of the plate behind a flat part; without one those of a touching
    dark one, 0 mm thick."""
    if not design.solid.extras:
        return 0.0, 0.0, '"black"'
    (plate,) = design.solid.extras
    (_, _, low), (_, _, high) = plate.bbox_mm
    return high - low, -high, _colour(plate)


def _mounts(design: DesignView) -> list[Loop]:
    """Mounting holes, which go through the backing too."""
    pattern = design.pattern
    return [Loop((hole.circle,)) for hole in pattern.spec.surround.all_holes(pattern.size_mm)]


def _polygon(name: str, loops: Iterable[Loop], width: float) -> str:
    """A module that draws loops of a part so wide, the outline first, then what is open, in another size."""
    flat = [loop.flatten(CURVE_TOL_MM).tolist() for loop in loops]
    ends = np.cumsum([0, *map(len, flat)]).tolist()
    paths = (str(list(range(*span))).replace(" ", "") for span in pairwise(ends))
    return f"""{name}_points = {_rows(_point(p) for loop in flat for p in loop)};
{name}_paths = {_rows(paths)};

module {name}(size = {width:.9g}) {{
    scale(size / {width:.9g}) polygon({name}_points, {name}_paths, convexity = 10);
}}
"""


def _polyhedra(design: DesignView) -> str:
    """A flat part in any size and thickness, another in any size."""
    extras = {f"behind_{k}": extra for k, extra in enumerate(design.solid.extras)}
    (left, _, _), (right, _, _) = design.solid.bbox_mm
    width, thickness_mm = right - left, design.placement.thickness_mm
    settings, factor = [_width(width)], f"size / {width:.9g}"
    if design.placement.is_flat and not design.solid.is_carved:
        settings.append(_thickness(thickness_mm))
        factor = f"[{factor}, {factor}, thickness / {thickness_mm:.9g}]"
    if extras:
        settings.append(_Setting("backing", True, "Whether the plate behind the part is there"))
    body = f"    color({_colour(design.solid)}) scale({factor}) part();\n"
    for name, extra in extras.items():
        body += f"    if (backing) color({_colour(extra)}) scale({factor}) {name}();\n"
    bodies = {"part": design.solid, **extras}
    return _source(settings, body, [_polyhedron(name, body) for name, body in bodies.items()])


def _polyhedron(name: str, body: Solid) -> str:
    """A module that draws the triangles of a body."""
    points, corners = body.triangles.vertices.tolist(), body.triangles.faces.tolist()
    faces = (f"[{a},{c},{b}]" for a, b, c in corners)  # OpenSCAD sees faces clockwise from outside
    return f"""{name}_points = {_rows(map(_point, points))};
{name}_faces = {_rows(faces)};

module {name}() {{
    polyhedron({name}_points, {name}_faces, convexity = 10);
}}
"""


def _colour(body: Solid) -> str:
    return _point(body.colour)


def _point(point: Sequence[float]) -> str:
    return "[" + ",".join(f"{round(value, 7) + 0.0:.9g}" for value in point) + "]"


def _rows(entries: Iterable[str]) -> str:
    each = list(entries)
    lines = (",".join(each[i : i + ROW]) for i in range(0, len(each), ROW))
    return "[\n  " + ",\n  ".join(lines) + "\n]"
