# pyright: reportAttributeAccessIssue=false
# The modeller's stubs are incomplete.
"""Solids of the kernel as STEP boundary representations, in time linear in their edges.

The kernel's own writer runs its shape-healing tools on every face first (`ShapeFix_SplitCommonVertex`
compares
all pairs of wires), which is quadratic in the wires of a perforated face. A solid that was checked needs
none.
"""

from __future__ import annotations

from typing import NamedTuple

from OCP.BRep import BRep_Tool
from OCP.BRepClass3d import BRepClass3d
from OCP.BRepTools import BRepTools
from OCP.TopExp import TopExp
from OCP.TopoDS import TopoDS, TopoDS_Face, TopoDS_Shape
from OCP.TopTools import TopTools_IndexedMapOfShape

from .occ import EDGE, FORWARD, REVERSED, VERTEX, distinct
from .step_geometry import Geometry
from .step_text import Part21, flag, refs, text
from .wires import Use, children, in_order


class _Edges(NamedTuple):
    """By an edge's place in the map: its entity, and the numbers of its vertices."""

    curves: dict[int, int]
    ends: dict[int, tuple[int, int]]


class Topology:
    """Writes solids into a file; an edge or vertex that several faces share is written once."""

    def __init__(self, part: Part21) -> None:
        self._add = part.add
        self._geometry = Geometry(part)

    def solid(self, solid: TopoDS_Shape, name: str) -> int:
        """The number of the solid's MANIFOLD_SOLID_BREP or, with cavities, BREP_WITH_VOIDS."""
        edges = distinct(solid, EDGE)
        written = self._edges(solid, edges)
        outer = BRepClass3d.OuterShell_s(TopoDS.Solid_s(solid))
        shell = self._shell(outer, edges, written)
        voids = [self._shell(s, edges, written) for s in children(solid) if not s.IsSame(outer)]
        if not voids:
            return self._add(f"MANIFOLD_SOLID_BREP({text(name)},#{shell})")
        cavities = refs([self._add(f"ORIENTED_CLOSED_SHELL('',*,#{v},.T.)") for v in voids])
        return self._add(f"BREP_WITH_VOIDS({text(name)},#{shell},{cavities})")

    def _edges(self, solid: TopoDS_Shape, edges: TopTools_IndexedMapOfShape) -> _Edges:
        """Edge curves by their place in the map; degenerate ones (poles) are left out, as STEP does."""
        corners = distinct(solid, VERTEX)
        point = self._geometry.point
        vertices = [
            self._add(f"VERTEX_POINT('',#{point(BRep_Tool.Pnt_s(TopoDS.Vertex_s(corners.FindKey(i))))})")
            for i in range(1, corners.Extent() + 1)
        ]
        found = _Edges({}, {})
        for i in range(1, edges.Extent() + 1):
            edge = TopoDS.Edge_s(edges.FindKey(i).Oriented(FORWARD))
            if BRep_Tool.Degenerated_s(edge):
                continue
            start = corners.FindIndex(TopExp.FirstVertex_s(edge)) - 1
            end = corners.FindIndex(TopExp.LastVertex_s(edge)) - 1
            curve = self._geometry.curve(BRep_Tool.Curve_s(edge, 0.0, 0.0), *BRep_Tool.Range_s(edge))
            found.ends[i] = start, end
            found.curves[i] = self._add(f"EDGE_CURVE('',#{vertices[start]},#{vertices[end]},#{curve},.T.)")
        return found

    def _shell(self, shell: TopoDS_Shape, edges: TopTools_IndexedMapOfShape, written: _Edges) -> int:
        faces = [self._face(TopoDS.Face_s(face), edges, written) for face in children(shell)]
        return self._add(f"CLOSED_SHELL('',{refs(faces)})")

    def _face(self, face: TopoDS_Face, edges: TopTools_IndexedMapOfShape, written: _Edges) -> int:
        forward = face.Orientation() != REVERSED
        surface, mirrored = self._geometry.surface(BRep_Tool.Surface_s(face))
        bounds: list[int] = []
        ahead = TopoDS.Face_s(face.Oriented(FORWARD))
        wires = children(ahead)
        outer = wires[0] if len(wires) == 1 else BRepTools.OuterWire_s(ahead)
        for wire in wires:
            loop = self._loop(in_order(wire, ahead, edges, written.ends), written)
            kind = "FACE_OUTER_BOUND" if wire.IsSame(outer) else "FACE_BOUND"
            bounds.append(self._add(f"{kind}('',#{loop},{flag(forward)})"))
        return self._add(f"ADVANCED_FACE('',{refs(bounds)},#{surface},{flag(forward != mirrored)})")

    def _loop(self, uses: list[Use], written: _Edges) -> int:
        oriented = [
            self._add(f"ORIENTED_EDGE('',*,*,#{written.curves[use.number]},{flag(use.ahead)})")
            for use in uses
            if use.number in written.curves
        ]
        return self._add(f"EDGE_LOOP('',{refs(oriented)})")
