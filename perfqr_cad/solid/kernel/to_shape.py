"""Boundary representations as shapes of the modeller, for front ends, booleans and its own checks."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from OCP.BRep import BRep_Builder
from OCP.Geom import (
    Geom_Circle,
    Geom_ConicalSurface,
    Geom_CylindricalSurface,
    Geom_Line,
    Geom_Plane,
    Geom_Surface,
)
from OCP.Geom2d import Geom2d_Curve
from OCP.gp import gp_Ax2, gp_Ax3
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import (
    TopoDS,
    TopoDS_Edge,
    TopoDS_Face,
    TopoDS_Iterator,
    TopoDS_Shape,
    TopoDS_Shell,
    TopoDS_Solid,
    TopoDS_Vertex,
    TopoDS_Wire,
)

from perfqr_cad.geometry.arrays import Indices
from perfqr_cad.solid.kernel.modelled import ModelledCurves, ModelledSurfaces, Run
from perfqr_cad.solid.kernel.occ import (
    FORWARD,
    REVERSED,
    Array,
    direction,
    line_2d,
    pnt,
    spline_curve,
    spline_curve_2d,
    spline_surface,
)
from perfqr_cad.solid.tables.batches import (
    Arcs,
    Cones,
    Curves,
    Lines,
    Planes,
    Splines,
    SplineSurfaces,
    Surfaces,
)
from perfqr_cad.solid.tables.brep import TOLERANCE_MM, Brep

BUILDER = BRep_Builder()
NOWHERE = TopLoc_Location()
SAME_SPEED = 1e-9  # share by which an image may be longer than its edge and still be drawn at unit speed


class KernelShape:
    """The edges of a boundary representation, and its faces on demand: some may belong to another shell."""

    def __init__(self, brep: Brep) -> None:
        self._brep = brep
        self._surfaces = _by_row(brep.face_count, ((b.rows, _surfaces(b.of)) for b in brep.surfaces))
        runs = _by_row(len(brep.ends), ((b.rows, _runs(b.of)) for b in brep.curves))
        slack = np.zeros(len(brep.points))
        np.maximum.at(slack, brep.ends.ravel(), np.repeat(brep.tolerance_mm, 2))
        vertices = [_vertex(p, tol) for p, tol in zip(brep.points, slack.tolist(), strict=True)]
        self._edges = [
            _edge(run, tol, vertices[a], vertices[b])
            for run, tol, (a, b) in zip(runs, brep.tolerance_mm.tolist(), brep.ends.tolist(), strict=True)
        ]
        self._draw(runs)

    def wires(self, face: int) -> list[TopoDS_Wire]:
        """The loops of a face, as seen from outside."""
        brep = self._brep
        loops = range(brep.bounds[face], brep.bounds[face + 1])
        return [self._wire(brep.loops[loop], brep.loops[loop + 1]) for loop in loops]

    def face(self, number: int) -> TopoDS_Face:
        """A face, oriented outwards."""
        bare = TopoDS_Face()
        BUILDER.MakeFace(bare, self._surfaces[number], TOLERANCE_MM)
        outward = bool(self._brep.outward[number])
        made = with_wires(bare, self.wires(number), outward)
        return made if outward else TopoDS.Face_s(made.Reversed())

    def solid(self) -> TopoDS_Solid:
        """The solid of all shells."""
        starts = self._brep.shells.tolist()
        return solid_of(*([self.face(i) for i in range(a, b)] for a, b in pairwise(starts)))

    def _wire(self, start: int, end: int) -> TopoDS_Wire:
        wire = TopoDS_Wire()
        BUILDER.MakeWire(wire)
        uses = self._brep.edges[start:end].tolist(), self._brep.ahead[start:end].tolist()
        for edge, ahead in zip(*uses, strict=True):
            BUILDER.Add(wire, self._edges[edge] if ahead else self._edges[edge].Reversed())
        wire.Closed(True)
        return wire

    def _draw(self, runs: Sequence[Run]) -> None:
        """Give the edges their images; an edge that a face meets from both sides, a seam, has two."""
        brep = self._brep
        face_of, edges = brep.face_of_use.tolist(), brep.edges.tolist()
        found: dict[tuple[int, int], list[tuple[int, Geom2d_Curve]]] = defaultdict(list)
        for batch in brep.images:
            rows = batch.rows.tolist()
            for use, image in zip(rows, _images(batch.of, [runs[edges[u]] for u in rows]), strict=True):
                found[edges[use], face_of[use]].append((use, image))
        for (edge, face), images in found.items():
            tolerance = float(brep.tolerance_mm[edge])
            # Of a seam the first image is that of the edge as it runs in the face turned to its surface.
            turned = [bool(brep.ahead[use] != brep.outward[face]) for use, _ in images]
            curves = [images[i][1] for i in np.argsort(turned, kind="stable").tolist()]
            BUILDER.UpdateEdge(self._edges[edge], *curves, self._surfaces[face], NOWHERE, tolerance)
            BUILDER.Range(self._edges[edge], runs[edge].first, runs[edge].last)


def with_wires(face: TopoDS_Face, wires: Iterable[TopoDS_Wire], outward: bool) -> TopoDS_Face:
    """The face with more wires, given as seen from outside; orientation and first wires kept.

    outward  whether the own normal of the face's surface points out of the material
    """
    bare = TopoDS.Face_s(face.EmptyCopied().Oriented(FORWARD))
    known = TopoDS_Iterator(face.Oriented(FORWARD))
    while known.More():
        BUILDER.Add(bare, known.Value())
        known.Next()
    for wire in wires:
        BUILDER.Add(bare, wire if outward else wire.Reversed())
    return TopoDS.Face_s(bare.Oriented(face.Orientation()))


def solid_of(*shells: Sequence[TopoDS_Shape]) -> TopoDS_Solid:
    """The solid of closed shells, each of faces that share their edges."""
    solid = TopoDS_Solid()
    BUILDER.MakeSolid(solid)
    for faces in shells:
        shell = TopoDS_Shell()
        BUILDER.MakeShell(shell)
        for face in faces:
            BUILDER.Add(shell, face)
        shell.Closed(True)
        BUILDER.Add(solid, shell)
    return solid


def _by_row(size: int, parts: Iterable[tuple[Indices, Sequence[Any]]]) -> list[Any]:
    found: dict[int, Any] = {}
    for rows, made in parts:
        found.update(zip(rows.tolist(), made, strict=True))
    return [found[i] for i in range(size)]


def _vertex(p: Array, tolerance_mm: float) -> TopoDS_Vertex:
    vertex = TopoDS_Vertex()
    BUILDER.MakeVertex(vertex, pnt(p), tolerance_mm)
    return vertex


def _edge(run: Run, tolerance_mm: float, start: TopoDS_Vertex, end: TopoDS_Vertex) -> TopoDS_Edge:
    edge = TopoDS_Edge()
    BUILDER.MakeEdge(edge, run.curve, tolerance_mm)
    BUILDER.Add(edge, start.Oriented(FORWARD))
    BUILDER.Add(edge, end.Oriented(REVERSED))
    BUILDER.Range(edge, run.first, run.last)
    return edge


def _runs(curves: Curves) -> list[Run]:
    """Curves in space, and the parameters where edges start and end."""
    match curves:
        case Lines():
            ends = zip(curves.start, curves.end - curves.start, curves.length.tolist(), strict=True)
            return [Run(Geom_Line(pnt(p), direction(d)), 0.0, length) for p, d, length in ends]
        case Arcs():
            frames = zip(curves.centre, curves.axis, curves.x, strict=True)
            sizes = zip(curves.radius.tolist(), curves.sweep.tolist(), strict=True)
            return [
                Run(Geom_Circle(gp_Ax2(pnt(c), direction(z), direction(x)), radius), 0.0, sweep)
                for (c, z, x), (radius, sweep) in zip(frames, sizes, strict=True)
            ]
        case Splines():
            return [Run(spline_curve(poles, curves.knots, curves.degree), 0.0, 1.0) for poles in curves.poles]
        case ModelledCurves():
            return list(curves.runs)
        case _:
            raise TypeError(type(curves).__name__)


def _surfaces(surfaces: Surfaces) -> Sequence[Geom_Surface]:
    match surfaces:
        case Planes():
            frames = zip(surfaces.origin, surfaces.normal, surfaces.x, strict=True)
            return [Geom_Plane(gp_Ax3(pnt(o), direction(z), direction(x))) for o, z, x in frames]
        case Cones():
            frames = zip(surfaces.origin, surfaces.axis, surfaces.x, strict=True)
            sizes = zip(surfaces.radius.tolist(), surfaces.angle.tolist(), strict=True)
            return [
                Geom_ConicalSurface(frame, angle, radius) if angle else Geom_CylindricalSurface(frame, radius)
                for frame, (radius, angle) in zip(
                    (gp_Ax3(pnt(o), direction(z), direction(x)) for o, z, x in frames), sizes, strict=True
                )
            ]
        case SplineSurfaces():
            weights = [None] * len(surfaces) if surfaces.weights is None else surfaces.weights
            return [
                spline_surface(poles, surfaces.u_knots, surfaces.v_knots, surfaces.degrees, w)
                for poles, w in zip(surfaces.poles, weights, strict=True)
            ]
        case ModelledSurfaces():
            return surfaces.handles
        case _:
            raise TypeError(type(surfaces).__name__)


def _images(images: Curves, runs: Sequence[Run]) -> list[Geom2d_Curve]:
    """Images by the parameters of their edges."""
    match images:
        case Lines():
            drops = zip(images.start.tolist(), images.end.tolist(), images.length.tolist(), strict=True)
            return [_line(*drop, run.first, run.last) for drop, run in zip(drops, runs, strict=True)]
        case Splines():
            knots = np.array(images.knots)
            return [
                spline_curve_2d(poles, first + knots * (last - first), images.degree)
                for poles, (_, first, last) in zip(images.poles, runs, strict=True)
            ]
        case ModelledCurves():
            return [run.curve for run in images.runs]
        case _:
            raise TypeError(type(images).__name__)


def _line(
    start: Sequence[float], end: Sequence[float], length: float, first: float, last: float
) -> Geom2d_Curve:
    """A straight image: a line where that goes at unit speed from parameter 0, else a spline of degree 1."""
    if first == 0 and abs(length - last) <= SAME_SPEED * last:
        (u, v), (u1, v1) = start, end
        return line_2d(u, v, u1 - u, v1 - v)
    return spline_curve_2d(np.array([start, end]), (first, first, last, last), 1)
