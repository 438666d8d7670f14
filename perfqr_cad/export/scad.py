"""OpenSCAD source: the outline as a polygon with holes, raised to the thickness; parameters on top.

A part that is no plain extrusion (curved, flared, carved into another body) is written as a polyhedron.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from pathlib import Path

from perfqr_cad.export.design_view import DesignView

CURVE_TOL_MM = 0.01  # chord error of flattened curves: a fifth of a thin layer
SAME_VOLUME = 1e-6  # relative: a flat part of this volume is the plain extrusion of its outline
GREATEST_SCALE = 4  # of the customizer's range; never below 1, where webs would be too thin
ROW = 6  # entries on a line


def write(design: DesignView, path: Path) -> None:
    """Write a source file that OpenSCAD 2015 and later renders and offers in its customizer."""
    title = " ".join(design.solid.name.split())
    body = _extrusion(design) if is_extrusion(design) else _polyhedron(design)
    path.write_text(f"// {title}: a perforated QR code. Units: mm.\n\n{body}", "utf-8")


def is_extrusion(design: DesignView) -> bool:
    """Whether the outline raised by the thickness is the whole part."""
    plain_mm3 = design.pattern.region.area * design.placement.thickness_mm
    return design.placement.is_flat and math.isclose(plain_mm3, design.solid.volume_mm3, rel_tol=SAME_VOLUME)


def _extrusion(design: DesignView) -> str:
    loops = [loop.flatten(CURVE_TOL_MM).tolist() for loop in design.pattern.region.loops]
    xs = [x for x, _ in loops[0]]
    size = max(xs) - min(xs)
    paths: list[list[int]] = []
    first = 0
    for loop in loops:
        paths.append(list(range(first, first + len(loop))))
        first += len(loop)
    return f"""// Width of the part, mm
size = {size:.9g}; // [{size:.9g}:1:{size * GREATEST_SCALE:.9g}]
// Thickness of the part, mm
thickness = {design.placement.thickness_mm:.9g}; // [0.2:0.1:20]
// Thickness of a closed plate behind the part, mm; 0 for none
backing = 0; // [0:0.1:10]

/* [Hidden] */
drawn_size = {size:.9g};
points = {_rows(_point(p) for loop in loops for p in loop)};
// The outline first, then the holes.
paths = {_rows(str(path).replace(" ", "") for path in paths)};

module pattern() {{
    scale(size / drawn_size) polygon(points, paths, convexity = 10);
}}

module plate() {{
    scale(size / drawn_size) polygon(points, [paths[0]]);
}}

linear_extrude(height = thickness, convexity = 10) pattern();
if (backing > 0) color("black") translate([0, 0, -backing]) linear_extrude(height = backing) plate();
"""


def _polyhedron(design: DesignView) -> str:
    triangles = design.solid.triangles
    faces = triangles.faces[:, ::-1].tolist()  # OpenSCAD sees faces clockwise from outside
    return f"""// Scale of the part
factor = 1; // [1:0.05:{GREATEST_SCALE}]

/* [Hidden] */
points = {_rows(_point(p) for p in triangles.vertices.tolist())};
faces = {_rows(f"[{a},{b},{c}]" for a, b, c in faces)};

scale(factor) polyhedron(points, faces, convexity = 10);
"""


def _point(point: Sequence[float]) -> str:
    return "[" + ",".join(f"{round(value, 7) + 0.0:.9g}" for value in point) + "]"


def _rows(entries: Iterable[str]) -> str:
    each = list(entries)
    lines = (",".join(each[i : i + ROW]) for i in range(0, len(each), ROW))
    return "[\n  " + ",\n  ".join(lines) + "\n]"
