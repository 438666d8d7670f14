"""OpenSCAD source: the outline as a polygon with holes, raised to the thickness; parameters on top.

A part that is no plain extrusion (curved, flared, carved into another body) is written as a polyhedron.
Letters and a backing are in either.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
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

PLAIN = """linear_extrude(height = thickness, convexity = 10) pattern();
"""
LETTERED = """difference() {
    union() {
        linear_extrude(height = thickness, convexity = 10) pattern();
        if (relief > 0) translate([0, 0, thickness]) linear_extrude(height = relief) letters();
    }
    if (relief < 0) translate([0, 0, thickness + relief]) linear_extrude(height = 1 - relief) letters();
}
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
    backing_mm, gap_mm, colour = _backing(design)
    letters = [loop for letter in engraving(design) for loop in letter.loops]
    relief = ""
    if letters:
        relief = f"""// How far the letters stand out of the part, mm; below 0 they are engraved
relief = {design.solid.relief_mm:.9g}; // [-10:0.1:10]
"""
    return f"""// Width of the part, mm
size = {width:.9g}; // [{width:.9g}:1:{width * GREATEST_SCALE:.9g}]
// Thickness of the part, mm
thickness = {design.placement.thickness_mm:.9g}; // [0.2:0.1:20]
{relief}// Thickness of a closed plate behind the part, mm; 0 for none
backing = {backing_mm:.9g}; // [0:0.1:10]
// Gap before that plate, mm
gap = {gap_mm:.9g}; // [0:0.1:10]

/* [Hidden] */
drawn_size = {width:.9g};
{_polygon("pattern", loops)}
{_polygon("plate", (loops[0], *_mounts(design)))}
{_polygon("letters", letters) if letters else ""}
color({_colour(design.solid)}) {LETTERED if letters else PLAIN}
if (backing > 0) color({colour}) translate([0, 0, -gap - backing]) linear_extrude(height = backing) plate();
"""


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


def _polygon(name: str, loops: Iterable[Loop]) -> str:
    """A module that draws loops, the outline first, then what is open."""
    flat = [loop.flatten(CURVE_TOL_MM).tolist() for loop in loops]
    ends = np.cumsum([0, *map(len, flat)]).tolist()
    paths = (str(list(range(*span))).replace(" ", "") for span in pairwise(ends))
    return f"""{name}_points = {_rows(_point(p) for loop in flat for p in loop)};
{name}_paths = {_rows(paths)};

module {name}() {{
    scale(size / drawn_size) polygon({name}_points, {name}_paths, convexity = 10);
}}
"""


def _polyhedra(design: DesignView) -> str:
    extras = {f"behind_{k}": extra for k, extra in enumerate(design.solid.extras)}
    bodies = "\n".join(_polyhedron(name, body) for name, body in {"part": design.solid, **extras}.items())
    shown = "// Whether the plate behind the part is there\nbacking = true;\n" if extras else ""
    behind = "".join(
        f"if (backing) color({_colour(body)}) scale(factor) {name}();\n" for name, body in extras.items()
    )
    return f"""// Scale of the part
factor = 1; // [1:0.05:{GREATEST_SCALE}]
{shown}
/* [Hidden] */
{bodies}
color({_colour(design.solid)}) scale(factor) part();
{behind}"""


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
