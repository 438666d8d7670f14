"""Parts of many kinds to carve a code into: each a build123d solid and where the code is asked for."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from build123d import (
    Axis,
    Box,
    BuildLine,
    BuildPart,
    BuildSketch,
    Circle,
    Cone,
    Cylinder,
    Face,
    Plane,
    Polygon,
    Polyline,
    Pos,
    Rot,
    Solid,
    Sphere,
    Spline,
    Torus,
    Vector,
    extrude,
    fillet,
    loft,
    make_face,
    offset,
    revolve,
)
from OCP.BRepAlgoAPI import BRepAlgoAPI_Fuse
from OCP.BRepBuilderAPI import BRepBuilderAPI_NurbsConvert
from OCP.ShapeUpgrade import ShapeUpgrade_ShapeDivideAngle

from perfqr_cad.solid.kernel import booleans as kernel

FROM_THE_SIDE: dict[str, Any] = {"point": (200.0, 0.0, 0.0), "direction": (-1.0, 0.0, 0.0)}
BEFORE: dict[str, Any] = {"point": (0.0, -200.0, 0.0), "direction": (0.0, 1.0, 0.0)}
ABOVE: dict[str, Any] = {"point": (0.0, 0.0, 200.0), "direction": (0.0, 0.0, -1.0)}


@dataclass(frozen=True)
class Case:
    """A part, the place of a code on it, its size, what a refusal says ('' where none is due), and how deep
    pockets are (None: through-holes)."""

    make: Callable[[], Any]
    place: dict[str, Any] = field(default_factory=dict[str, Any])
    size_mm: float = 24.0
    says: str = ""
    depth_mm: float | None = None


def closed_box() -> Any:
    return Box(60, 50, 45) - Box(57, 47, 42)


def open_box() -> Any:
    whole = Box(60, 50, 45)
    return offset(whole, amount=-1.5, openings=whole.faces().sort_by(Axis.Z)[-1])


def tube() -> Any:
    return Cylinder(35, 60) - Cylinder(33.5, 60)


def split_tube() -> Any:
    """Two halves of a tube as faces of one solid, their joint before the reader."""
    divide = ShapeUpgrade_ShapeDivideAngle(math.pi, tube().wrapped)
    divide.Perform()
    return Rot(0, 0, 90) * Solid(divide.Result())


def spline_tube() -> Any:
    return Solid(BRepBuilderAPI_NurbsConvert(tube().wrapped, True).Shape())


def shell() -> Any:
    return Sphere(40) - Sphere(38.5)


def dome() -> Any:
    return Sphere(40, arc_size1=0) - Sphere(38.4, arc_size1=0)


def bottle() -> Any:
    def body(inset: float) -> Any:
        rings = ((0, 30), (40, 34), (70, 30), (90, 15))
        return loft([Pos(0, 0, z) * Circle(r - inset) for z, r in rings])

    return body(0.0) - body(1.5)


def vase() -> Any:
    def body(inset: float) -> Any:
        rim = [(r - inset, z) for r, z in ((30, 0), (36, 20), (28, 50), (32, 70))]
        with BuildSketch(Plane.XZ) as sketch:
            with BuildLine():
                Spline(*rim)
                Polyline(rim[-1], (0, 70), (0, 0), rim[0])
            make_face()
        return revolve(sketch.sketch, Axis.Z)

    return body(0.0) - body(1.5)


def sheet() -> Any:
    """A wavy B-spline sheet of even thickness."""
    line = np.linspace(-35, 35, 8)
    waves = [[Vector(x, y, 6 * math.sin(x / 25) * math.cos(y / 30)) for y in line] for x in line]
    return Solid.thicken(Face.make_surface_from_array_of_points(waves), 1.5)


def rounded_box() -> Any:
    outer, inner = Box(70, 60, 50), Box(67, 57, 47)
    return fillet(outer.edges(), 6) - fillet(inner.edges(), 4.5)


def profile(*corners: tuple[float, float]) -> Any:
    """A wall of that section in x and z, 60 mm deep."""
    with BuildPart() as part:
        with BuildSketch(Plane.XZ):
            Polygon(*corners, align=None)
        extrude(amount=30, both=True)
    return part.part


def roof(angle_deg: float) -> Any:
    top = 30 * math.tan(math.radians(angle_deg))
    return profile((-30, 0), (0, top), (30, 0), (30, 1.6), (0, top + 1.6), (-30, 1.6))


def joined_plates() -> Any:
    """Two plates side by side, fused, with the joint still in their faces."""
    left, right = Pos(-30, 0, 0) * Box(60, 60, 1.6), Pos(30, 0, 0) * Box(60, 60, 1.6)
    return Solid(kernel.solids(BRepAlgoAPI_Fuse(left.wrapped, right.wrapped).Shape())[0])


def ribbed() -> Any:
    plate = Box(60, 60, 1.6)
    for x in (-15, 0, 15):
        plate += Pos(x, 0, -4) * Box(1.5, 50, 8)
    return plate


CASES: dict[str, Case] = {
    "closed box": Case(closed_box),
    "open box, a numbered face": Case(open_box, {"face": 1}),
    "block with pockets": Case(lambda: Box(60, 50, 40), depth_mm=1.2),
    "tube": Case(tube, BEFORE),
    "tube, wrapped": Case(tube, BEFORE | {"wrap": True}),
    "tube over its seam": Case(tube, FROM_THE_SIDE),
    "tube in two halves, wrapped": Case(split_tube, BEFORE | {"wrap": True}),
    "tube of splines": Case(spline_tube, BEFORE),
    "cone": Case(lambda: Cone(45, 30, 60) - Cone(43.5, 28.5, 60), BEFORE | {"wrap": True}),
    "torus over both seams": Case(
        lambda: Torus(60, 25) - Torus(60, 23.5),
        FROM_THE_SIDE,
        26.0,
    ),
    "ball over its seam": Case(shell, FROM_THE_SIDE),
    "ball over its pole": Case(shell, ABOVE),
    "dome over its pole": Case(dome, ABOVE),
    "bottle": Case(bottle),
    "vase": Case(vase),
    "wavy sheet": Case(sheet),
    "rounded box": Case(rounded_box),
    "wall of uneven thickness": Case(lambda: profile((-30, 0), (30, 0), (30, 2), (-30, 1.2))),
    "two plates in one plane": Case(joined_plates, ABOVE | {"point": (-5.0, 0.0, 200.0)}),
    "shallow roof": Case(lambda: roof(5), ABOVE),
    "turned box": Case(lambda: Rot(21, 37, 58) * closed_box()),
    "far away": Case(lambda: Pos(10000, -10000, 5000) * closed_box()),
    "large box": Case(lambda: Box(2000, 1500, 1000) - Box(1997, 1497, 997)),
    "steep roof": Case(lambda: roof(25), ABOVE, says="bends 50°"),
    "wall three times as thick at one end": Case(
        lambda: profile((-30, 0), (30, 0), (30, 3), (-30, 0.8)), ABOVE, 50.0, "uneven"
    ),
    "ribs behind the face": Case(ribbed, ABOVE, says="set depth"),
    "boss in the middle": Case(
        lambda: Box(60, 60, 1.6) + Pos(0, 0, 3) * Cylinder(4, 6), ABOVE, says="step, opening or rib"
    ),
    "through the hole in the middle": Case(
        lambda: Box(60, 60, 1.6) - Cylinder(4, 10), ABOVE, says="meets no outer face"
    ),
    "over the fillets": Case(rounded_box, ABOVE, 68.0, "use --size 5"),
    "tiny": Case(lambda: Box(3, 3, 0.2), says="hangs over the edge"),
}
