# pyright: reportAttributeAccessIssue=false
# The modeller's stubs are incomplete.
"""Solids of the kernel as STEP boundary representations, in time linear in their edges.

The kernel's own writer runs its shape-healing tools on every face first (`ShapeFix_SplitCommonVertex`
compares
all pairs of wires), which is quadratic in the wires of a perforated face. A solid that was checked needs
none.
"""

from __future__ import annotations

from OCP.BRep import BRep_Tool
from OCP.BRepClass3d import BRepClass3d
from OCP.BRepTools import BRepTools, BRepTools_WireExplorer
from OCP.TopExp import TopExp
from OCP.TopoDS import TopoDS, TopoDS_Edge, TopoDS_Face, TopoDS_Iterator, TopoDS_Shape
from OCP.TopTools import TopTools_IndexedMapOfShape

from .occ import EDGE, FORWARD, REVERSED, VERTEX, distinct
from .step_geometry import Geometry
from .step_text import Part21, flag, refs, text


class Topology:
    """Writes solids into a file; an edge or vertex that several faces share is written once."""

    def __init__(self, part: Part21) -> None:
        self._add = part.add
        self._geometry = Geometry(part)

    def solid(self, solid: TopoDS_Shape, name: str) -> int:
        """The number of the solid's MANIFOLD_SOLID_BREP or, with cavities, BREP_WITH_VOIDS."""
        edges = distinct(solid, EDGE)
        curves = self._edges(solid, edges)
        outer = BRepClass3d.OuterShell_s(TopoDS.Solid_s(solid))
        shell = self._shell(outer, edges, curves)
        voids = [self._shell(s, edges, curves) for s in children(solid) if not s.IsSame(outer)]
        if not voids:
            return self._add(f"MANIFOLD_SOLID_BREP({text(name)},#{shell})")
        cavities = refs([self._add(f"ORIENTED_CLOSED_SHELL('',*,#{v},.T.)") for v in voids])
        return self._add(f"BREP_WITH_VOIDS({text(name)},#{shell},{cavities})")

    def _edges(self, solid: TopoDS_Shape, edges: TopTools_IndexedMapOfShape) -> list[int]:
        """Edge curves in the order of the map; 0 for degenerate ones (poles), which STEP leaves out."""
        corners = distinct(solid, VERTEX)
        point = self._geometry.point
        vertices = [
            self._add(f"VERTEX_POINT('',#{point(BRep_Tool.Pnt_s(TopoDS.Vertex_s(corners.FindKey(i))))})")
            for i in range(1, corners.Extent() + 1)
        ]
        curves: list[int] = []
        for i in range(1, edges.Extent() + 1):
            edge = TopoDS.Edge_s(edges.FindKey(i).Oriented(FORWARD))
            if BRep_Tool.Degenerated_s(edge):
                curves.append(0)
                continue
            start = vertices[corners.FindIndex(TopExp.FirstVertex_s(edge)) - 1]
            end = vertices[corners.FindIndex(TopExp.LastVertex_s(edge)) - 1]
            curve = self._geometry.curve(BRep_Tool.Curve_s(edge, 0.0, 0.0), *BRep_Tool.Range_s(edge))
            curves.append(self._add(f"EDGE_CURVE('',#{start},#{end},#{curve},.T.)"))
        return curves

    def _shell(self, shell: TopoDS_Shape, edges: TopTools_IndexedMapOfShape, curves: list[int]) -> int:
        faces = [self._face(TopoDS.Face_s(face), edges, curves) for face in children(shell)]
        return self._add(f"CLOSED_SHELL('',{refs(faces)})")

    def _face(self, face: TopoDS_Face, edges: TopTools_IndexedMapOfShape, curves: list[int]) -> int:
        forward = face.Orientation() != REVERSED
        surface, mirrored = self._geometry.surface(BRep_Tool.Surface_s(face))
        bounds: list[int] = []
        ahead = TopoDS.Face_s(face.Oriented(FORWARD))
        wires = children(ahead)
        outer = wires[0] if len(wires) == 1 else BRepTools.OuterWire_s(ahead)
        for wire in wires:
            loop = self._loop(in_order(wire, ahead), edges, curves)
            kind = "FACE_OUTER_BOUND" if wire.IsSame(outer) else "FACE_BOUND"
            bounds.append(self._add(f"{kind}('',#{loop},{flag(forward)})"))
        return self._add(f"ADVANCED_FACE('',{refs(bounds)},#{surface},{flag(forward != mirrored)})")

    def _loop(self, uses: list[TopoDS_Edge], edges: TopTools_IndexedMapOfShape, curves: list[int]) -> int:
        oriented: list[int] = []
        for edge in uses:
            curve = curves[edges.FindIndex(edge) - 1]
            if curve:
                ahead = edge.Orientation() != REVERSED
                oriented.append(self._add(f"ORIENTED_EDGE('',*,*,#{curve},{flag(ahead)})"))
        return self._add(f"EDGE_LOOP('',{refs(oriented)})")


def in_order(wire: TopoDS_Shape, face: TopoDS_Face) -> list[TopoDS_Edge]:
    """The edges of a wire head to tail; as stored, where they are so, which spares the kernel's slower
    walk."""
    edges = [TopoDS.Edge_s(e) for e in children(wire)]
    if wire.Orientation() == REVERSED:
        edges.reverse()
    ends = [TopExp.LastVertex_s(e, True) for e in edges]
    if all(
        TopExp.FirstVertex_s(e, True).IsSame(end) for e, end in zip(edges[1:] + edges[:1], ends, strict=True)
    ):
        return edges
    walk = BRepTools_WireExplorer(TopoDS.Wire_s(wire), face)
    walked: list[TopoDS_Edge] = []
    while walk.More():
        walked.append(walk.Current())
        walk.Next()
    return walked


def children(shape: TopoDS_Shape) -> list[TopoDS_Shape]:
    """Sub-shapes one level down, orientations and locations composed."""
    found: list[TopoDS_Shape] = []
    children = TopoDS_Iterator(shape)
    while children.More():
        found.append(children.Value())
        children.Next()
    return found
