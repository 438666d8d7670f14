# pyright: reportAttributeAccessIssue=false
# The modeller's stubs are incomplete.
"""Perforating without booleans: loops become wires of the front and back faces, walls are stitched
between."""

from __future__ import annotations

from collections.abc import Sequence

from OCP.TopoDS import (
    TopoDS,
    TopoDS_Face,
    TopoDS_Iterator,
    TopoDS_Shape,
    TopoDS_Shell,
    TopoDS_Solid,
    TopoDS_Wire,
)

from .chart import Chart
from .occ import FACE, FORWARD, explore
from .sections import Well
from .tube import BUILDER, Tube, cap, tubes


def panel(wells: Sequence[Well], chart: Chart) -> TopoDS_Solid:
    """A wall of its own: the first well is its rim, the others are its holes."""
    made = tubes(tuple(wells), chart)
    front = cap(chart, 0.0, [t.mouth for t in made], outwards=True)
    feet = [t.foot for t in made if t.foot is not None]
    back = cap(chart, chart.thickness_mm, feet, outwards=False)
    return solid_of([front, back, *(face for t in made for face in t.faces)])


def punch(
    solid: TopoDS_Shape, front: TopoDS_Face, back: TopoDS_Face | None, wells: Sequence[Well], chart: Chart
) -> TopoDS_Solid:
    """The solid with wells sunk from a face of it, to another face of it or to floors of their own.

    `front` and `back` are faces as the solid holds them (`back` None when every well is a pocket);
    `chart.surface(0)` and `chart.surface(chart.thickness_mm)` must be their surfaces, as
    `BRep_Tool.Surface_s`
    gives them. Loops must lie strictly inside both faces and apart: see `proof.check`, which the caller runs.
    """
    made = tubes(tuple(wells), chart)
    faces = [
        f for f in explore(solid, FACE) if not f.IsSame(front) and not (back is not None and f.IsSame(back))
    ]
    faces.append(perforated(front, [t.mouth for t in made], chart.towards_reader(0.0)))
    if back is not None:
        feet = [t.foot for t in made if t.foot is not None]
        faces.append(perforated(back, feet, chart.towards_reader(chart.thickness_mm)))
    return solid_of([*faces, *(face for t in made for face in t.faces)])


def perforated(face: TopoDS_Face, wires: Sequence[TopoDS_Wire], towards_reader: bool) -> TopoDS_Face:
    """The face with more wires, given as the reader sees them; orientation and first wires kept."""
    bare = TopoDS.Face_s(face.EmptyCopied().Oriented(FORWARD))
    outlines = TopoDS_Iterator(face.Oriented(FORWARD))
    while outlines.More():
        BUILDER.Add(bare, outlines.Value())
        outlines.Next()
    for wire in wires:
        BUILDER.Add(bare, wire if towards_reader else wire.Reversed())
    return TopoDS.Face_s(bare.Oriented(face.Orientation()))


def solid_of(faces: Sequence[TopoDS_Shape]) -> TopoDS_Solid:
    """One closed shell of faces that share their edges, as a solid."""
    shell = TopoDS_Shell()
    BUILDER.MakeShell(shell)
    for face in faces:
        BUILDER.Add(shell, face)
    shell.Closed(True)
    solid = TopoDS_Solid()
    BUILDER.MakeSolid(solid)
    BUILDER.Add(solid, shell)
    return solid


__all__ = ["Tube", "panel", "perforated", "punch", "solid_of"]
