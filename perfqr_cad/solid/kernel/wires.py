"""The edges of wires, head to tail, by their place in a map of all edges."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from OCP.BRepTools import BRepTools_WireExplorer
from OCP.TopoDS import TopoDS, TopoDS_Face, TopoDS_Iterator, TopoDS_Shape
from OCP.TopTools import TopTools_IndexedMapOfShape

from perfqr_cad.solid.kernel.occ import REVERSED


class Use(NamedTuple):
    """An edge of a wire, and whether the wire runs along it or against it."""

    number: int
    ahead: bool
    edge: TopoDS_Shape


def in_order(
    wire: TopoDS_Shape,
    face: TopoDS_Face,
    edges: TopTools_IndexedMapOfShape,
    ends: Mapping[int, tuple[int, int]],
) -> list[Use]:
    """The edges of a wire head to tail: as stored, where they are so, which spares the kernel's slower walk.

    edges  all edges of the solid; ends  the numbers of the vertices at each edge's start and end; edges
    without any (a pole's) have no place in the order and are left out
    """
    uses = [Use(edges.FindIndex(edge), edge.Orientation() != REVERSED, edge) for edge in children(wire)]
    if wire.Orientation() == REVERSED:
        uses.reverse()
    linked = [use for use in uses if use.number in ends]
    # Seams that meet in one vertex leave the order open.
    if len({use.number for use in linked}) < len(linked):
        return _walked(wire, face, edges)
    before = linked[-1] if linked else None
    for use in linked:
        if before is None or ends[before.number][before.ahead] != ends[use.number][not use.ahead]:
            return _walked(wire, face, edges)
        before = use
    return linked


def _walked(wire: TopoDS_Shape, face: TopoDS_Face, edges: TopTools_IndexedMapOfShape) -> list[Use]:
    walk = BRepTools_WireExplorer(TopoDS.Wire_s(wire), face)
    walked: list[Use] = []
    while walk.More():
        edge = walk.Current()
        walked.append(Use(edges.FindIndex(edge), edge.Orientation() != REVERSED, edge))
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
