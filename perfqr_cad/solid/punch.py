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
from .occ import FORWARD
from .sections import Sections
from .tube import BUILDER, Tube, cap, shell_faces


def panel(sections: Sections, chart: Chart) -> TopoDS_Solid:
    """A wall of its own, whose first well is its rim: a front face for each piece, one back."""
    front_mm, back_mm = sections.between_mm
    made, tops = shell_faces(sections, chart)
    fronts = [cap(chart, front_mm, wires, outwards=True) for wires in mouths(made)]
    back = cap(chart, back_mm, [t.foot for t in made if t.foot is not None], outwards=False)
    return solid_of([*fronts, back, *(face for t in made for face in t.faces), *tops])


def mouths(tubes: Sequence[Tube]) -> list[list[TopoDS_Wire]]:
    """The wires of each piece of the front face."""
    pieces: dict[int, list[TopoDS_Wire]] = {}
    for tube in tubes:
        wire = tube.mouth or tube.base
        if wire is not None:
            pieces.setdefault(tube.well.piece, []).append(wire)
    return [wires for _, wires in sorted(pieces.items())]


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


__all__ = ["Tube", "panel", "perforated", "solid_of"]
