"""Shapes of the modeller as boundary representations: one walk over all faces."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from OCP.BRep import BRep_Tool
from OCP.BRepClass3d import BRepClass3d
from OCP.BRepTools import BRepTools
from OCP.Geom import (
    Geom_Circle,
    Geom_ConicalSurface,
    Geom_CylindricalSurface,
    Geom_Line,
    Geom_Plane,
    Geom_Surface,
)
from OCP.Geom2d import Geom2d_Line
from OCP.TopExp import TopExp
from OCP.TopoDS import TopoDS, TopoDS_Edge, TopoDS_Face, TopoDS_Shape
from OCP.TopTools import TopTools_IndexedMapOfShape

from perfqr_cad.errors import KernelError
from perfqr_cad.geometry.cycles import starts_of
from perfqr_cad.solid.kernel.modelled import ModelledCurves, ModelledSurfaces, Run
from perfqr_cad.solid.kernel.occ import EDGE, FORWARD, REVERSED, SOLID, VERTEX, WIRE, count, distinct
from perfqr_cad.solid.kernel.wires import children, in_order
from perfqr_cad.solid.tables.batches import Arcs, Cones, Curves, Lines, Planes, Surfaces
from perfqr_cad.solid.tables.brep import Batch, Brep, CurveTable, SurfaceTable


class _Use(NamedTuple):
    edge: int
    ahead: bool
    image: Run | None


class _Side(NamedTuple):
    """A face: its loops as seen from outside."""

    surface: Geom_Surface
    outward: bool
    loops: list[list[_Use]]


def brep_of(shape: TopoDS_Shape) -> Brep:
    """The tables of one solid; what it lacks (a vertex, a curve, an image) is left out there.

    Raises `KernelError` unless the shape is one solid.
    """
    solids = count(shape, SOLID)
    if solids != 1:
        raise KernelError(f"{solids} solids, not one: give them one by one")
    solid = TopoDS.Solid_s(distinct(shape, SOLID).FindKey(1))
    vertices, edges = distinct(solid, VERTEX), distinct(solid, EDGE)
    ends, runs, tolerance = _edges(edges, vertices)
    numbers = {i: number for number, i in enumerate(ends)}
    outer = BRepClass3d.OuterShell_s(solid)
    shells = _led_by(outer, children(solid))
    faces = [[TopoDS.Face_s(face) for face in children(shell)] for shell in shells]
    sides = [_side(face, edges, numbers, ends) for shell in faces for face in shell]
    for face, side in zip((f for shell in faces for f in shell), sides, strict=True):
        slack = BRep_Tool.Tolerance_s(face)
        for use in (use for loop in side.loops for use in loop):
            tolerance[use.edge] = max(tolerance[use.edge], slack)
    loops = [loop for side in sides for loop in side.loops]
    uses = [use for loop in loops for use in loop]
    points = [
        BRep_Tool.Pnt_s(TopoDS.Vertex_s(vertices.FindKey(i + 1))).Coord() for i in range(vertices.Extent())
    ]
    return Brep(
        points=np.array(points).reshape(-1, 3),
        ends=np.array(list(ends.values()), np.int64).reshape(-1, 2),
        curves=_curves(runs),
        tolerance_mm=np.array(tolerance, np.float64),
        edges=np.array([use.edge for use in uses], np.int64),
        ahead=np.array([use.ahead for use in uses], np.bool_),
        images=_curves([use.image for use in uses]),
        loops=starts_of(map(len, loops)),
        bounds=starts_of(len(side.loops) for side in sides),
        surfaces=_surfaces([side.surface for side in sides]),
        outward=np.array([side.outward for side in sides], np.bool_),
        shells=starts_of(map(len, faces)),
    )


def _edges(
    edges: TopTools_IndexedMapOfShape, vertices: TopTools_IndexedMapOfShape
) -> tuple[dict[int, tuple[int, int]], list[Run | None], list[float]]:
    """Vertices, curves and tolerances (those of the vertices included) of the edges that have an extent; the
    vertices by place in the map."""
    ends: dict[int, tuple[int, int]] = {}
    runs: list[Run | None] = []
    tolerance: list[float] = []
    for i in range(1, edges.Extent() + 1):
        edge = TopoDS.Edge_s(edges.FindKey(i).Oriented(FORWARD))
        if BRep_Tool.Degenerated_s(edge):
            continue
        vertex = TopExp.FirstVertex_s(edge), TopExp.LastVertex_s(edge)
        first, last = (-1 if v.IsNull() else vertices.FindIndex(v) - 1 for v in vertex)
        ends[i] = first, last
        curve = BRep_Tool.Curve_s(edge, 0.0, 0.0)
        runs.append(None if curve is None else Run(curve, *BRep_Tool.Range_s(edge)))
        corners = [BRep_Tool.Tolerance_s(v) for v in vertex if not v.IsNull()]
        tolerance.append(max([BRep_Tool.Tolerance_s(edge), *corners]))
    return ends, runs, tolerance


def _side(
    face: TopoDS_Face,
    edges: TopTools_IndexedMapOfShape,
    numbers: dict[int, int],
    ends: dict[int, tuple[int, int]],
) -> _Side:
    forward = TopoDS.Face_s(face.Oriented(FORWARD))
    flipped = face.Orientation() == REVERSED
    surface = BRep_Tool.Surface_s(forward)
    flat = isinstance(surface, Geom_Plane)
    wires = [wire for wire in children(forward) if wire.ShapeType() == WIRE]
    if len(wires) > 1:
        wires = _led_by(BRepTools.OuterWire_s(forward), wires)
    loops: list[list[_Use]] = []
    for wire in wires:
        loop: list[_Use] = []
        for use in in_order(wire, forward, edges, ends):
            if use.number in numbers:
                image = None if flat else _image(TopoDS.Edge_s(use.edge), forward)
                loop.append(_Use(numbers[use.number], use.ahead != flipped, image))
        if loop:  # a wire may be a pole and nothing else
            loops.append(loop[::-1] if flipped else loop)
    return _Side(surface, not flipped, loops)


def _led_by(first: TopoDS_Shape, shapes: Sequence[TopoDS_Shape]) -> list[TopoDS_Shape]:
    """The shapes, one of them first."""
    lead = [shape for shape in shapes if shape.IsSame(first)]
    return [*lead, *(shape for shape in shapes if not shape.IsSame(first))]


def _image(edge: TopoDS_Edge, face: TopoDS_Face) -> Run | None:
    curve = BRep_Tool.CurveOnSurface_s(edge, face, 0.0, 0.0)
    return None if curve is None else Run(curve, *BRep_Tool.Range_s(edge, face))


def _curves(runs: Sequence[Run | None]) -> CurveTable:
    """Curves or images by row: lines and circles as arrays, others as they are."""
    lines, arcs, others = list[int](), list[int](), list[int]()
    for row, run in enumerate(runs):
        match run:
            case None:
                pass
            case Run(Geom_Line() | Geom2d_Line()):
                lines.append(row)
            case Run(Geom_Circle()):
                arcs.append(row)
            case _:
                others.append(row)
    found: list[Batch[Curves]] = []
    for rows, kind in ((lines, _lines), (arcs, _arcs), (others, _modelled)):
        if rows:
            found.append(Batch(np.array(rows), kind([run for i in rows if (run := runs[i]) is not None])))
    return tuple(found)


def _lines(runs: Sequence[Run]) -> Lines:
    start, end = (np.array([run.curve.Value(run[k]).Coord() for run in runs]) for k in (1, 2))
    return Lines(start, end)


def _arcs(runs: Sequence[Run]) -> Arcs:
    centre, x, y = np.array([_frame(run.curve) for run in runs]).swapaxes(0, 1)
    first, last = np.array([run[1:] for run in runs]).T
    cos, sin = np.cos(first)[:, None], np.sin(first)[:, None]
    radius = np.array([_radius(run.curve) for run in runs])
    return Arcs(centre, cos * x + sin * y, cos * y - sin * x, radius, last - first)


def _radius(circle: Any) -> float:
    return circle.Radius()


def _modelled(runs: Sequence[Run]) -> ModelledCurves:
    return ModelledCurves(tuple(runs))


def _surfaces(surfaces: Sequence[Geom_Surface]) -> SurfaceTable:
    """Surfaces by row: planes, and right-handed cylinders and cones, as arrays, others as they are."""
    planes, cones, others = list[int](), list[int](), list[int]()
    for row, surface in enumerate(surfaces):
        match surface:
            case Geom_Plane():
                planes.append(row)
            case Geom_CylindricalSurface() | Geom_ConicalSurface() if surface.Position().Direct():
                cones.append(row)
            case _:
                others.append(row)
    found: list[Batch[Surfaces]] = []
    for rows, kind in ((planes, _planes), (cones, _cones), (others, _as_they_are)):
        if rows:
            found.append(Batch(np.array(rows), kind([surfaces[i] for i in rows])))
    return tuple(found)


def _planes(surfaces: Sequence[Any]) -> Planes:
    frames = np.array([_frame(surface) for surface in surfaces])
    return Planes(frames[:, 0], np.cross(frames[:, 1], frames[:, 2]), frames[:, 1])


def _cones(surfaces: Sequence[Any]) -> Cones:
    frames = np.array([_frame(surface) for surface in surfaces])
    sizes = [
        (s.RefRadius(), s.SemiAngle()) if isinstance(s, Geom_ConicalSurface) else (s.Radius(), 0.0)
        for s in surfaces
    ]
    radius, angle = np.array(sizes).T
    return Cones(frames[:, 0], np.cross(frames[:, 1], frames[:, 2]), frames[:, 1], radius, angle)


def _as_they_are(surfaces: Sequence[Geom_Surface]) -> ModelledSurfaces:
    return ModelledSurfaces(tuple(surfaces))


def _frame(of: Any) -> tuple[Any, Any, Any]:
    """Origin, x and y of an elementary curve or surface."""
    frame = of.Position()
    return frame.Location().Coord(), frame.XDirection().Coord(), frame.YDirection().Coord()
