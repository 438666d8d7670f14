# pyright: reportAttributeAccessIssue=false
# The modeller's stubs are incomplete.
"""The walls of one hole (or of the rim): shared edges, exact images, material to the left of travel.

Seen from the reader, the outer loop runs counter-clockwise and holes run clockwise. Out of the material is
then
always to the right of travel, for the rim and for every hole alike.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from OCP.BRep import BRep_Builder
from OCP.Geom import Geom_Curve, Geom_Line, Geom_Surface
from OCP.gp import gp_Dir
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS, TopoDS_Edge, TopoDS_Face, TopoDS_Vertex, TopoDS_Wire

from perfqr_cad.pattern.outline import Point

from .chart import Chart, Column, Trace, Wall, Well
from .occ import FORWARD, REVERSED, TOLERANCE_MM, Array, pnt
from .recess import Top
from .sections import Sections

BUILDER = BRep_Builder()
NOWHERE = TopLoc_Location()


@dataclass(frozen=True)
class Tube:
    """What a well adds to a shell.

    well   whose walls they are
    mouth  its wire in the front face, in the direction of travel; None where it begins elsewhere
    foot   its wire in the back face, in the direction of travel; None where it ends elsewhere
    base   its wire in the front face below a crest, against the direction of travel
    faces  walls and, with the first well of each, floors and crests; oriented outward
    """

    well: Well
    mouth: TopoDS_Wire | None
    foot: TopoDS_Wire | None
    base: TopoDS_Wire | None
    faces: tuple[TopoDS_Face, ...]


@dataclass(frozen=True)
class Seam:
    """Corners and edges at the level of bar tops, where the walls above and below meet; by their pattern
    points."""

    depth_mm: float
    vertices: dict[Point, TopoDS_Vertex] = field(default_factory=dict[Point, TopoDS_Vertex])
    edges: dict[tuple[Point, Point], tuple[TopoDS_Edge, Trace]] = field(
        default_factory=dict[tuple[Point, Point], tuple[TopoDS_Edge, Trace]]
    )

    def vertex(self, at: Point, p: Array, tolerance_mm: float) -> TopoDS_Vertex:
        if at not in self.vertices:
            self.vertices[at] = _vertex(p, tolerance_mm)
        BUILDER.UpdateVertex(self.vertices[at], tolerance_mm)  # never lowers it
        return self.vertices[at]

    def edge(self, start: Point, end: Point, trace: Trace) -> TopoDS_Edge:
        if (start, end) not in self.edges:
            self.edges[start, end] = _edge(trace, self.vertices[start], self.vertices[end]), trace
        return self.edges[start, end][0]

    def top(self, top: Top, chart: Chart) -> TopoDS_Face:
        """The face of a bar, on edges of the walls around it."""
        edges: list[TopoDS_Edge] = []
        for segment in top.loop.segments:
            ahead = (segment.start, segment.end) in self.edges
            edge, trace = self.edges[(segment.start, segment.end) if ahead else (segment.end, segment.start)]
            _draw(chart.surface(top.depth_mm), [edge], [trace])
            edges.append(edge if ahead else TopoDS.Edge_s(edge.Reversed()))
        return cap(chart, top.depth_mm, [_wire(edges)], outwards=True)


def shell_faces(sections: Sections, chart: Chart) -> tuple[list[Tube], list[TopoDS_Face]]:
    """The walls of all wells, and the tops of the bars between them."""
    if not sections.tops:
        return tubes(sections.wells, chart), []
    seam = Seam(sections.tops[0].depth_mm)
    made = tubes(sections.wells, chart, seam)
    return made, [seam.top(top, chart) for top in sections.tops]


def tubes(wells: tuple[Well, ...], chart: Chart, seam: Seam | None = None) -> list[Tube]:
    """The walls of many wells. Wells of equal levels are laid together: a chart works on arrays."""
    columns: dict[int, list[Column]] = {}
    by_levels: dict[tuple[object, ...], list[int]] = {}
    for i, well in enumerate(wells):
        by_levels.setdefault(_whole(well).levels, []).append(i)
    for levels, members in by_levels.items():
        stacks = [stack for i in members for stack in _whole(wells[i]).stacks()]
        laid = iter(chart.lay(stacks, _whole(wells[members[0]]).levels))
        for i in members:
            first, count = levels.index(wells[i].levels[0]), len(wells[i].levels)
            columns[i] = [next(laid).storey(first, count) for _ in wells[i].loops[0].segments]
    stands = [_stand(well, chart, columns[i], seam) for i, well in enumerate(wells)]
    return [_tube(stand, ends, chart) for stand, ends in zip(stands, _shared_faces(stands), strict=True)]


def _whole(well: Well) -> Well:
    return well.part_of or well


@dataclass(frozen=True)
class _Stand:
    """The walls of a well, with its first and last wires in the direction of travel."""

    well: Well
    first: TopoDS_Wire
    last: TopoDS_Wire
    walls: list[TopoDS_Face]
    on_seam: tuple[bool, bool]


def _shared_faces(stands: Sequence[_Stand]) -> list[list[tuple[float, list[TopoDS_Wire]]]]:
    """For each stand, the crests and floors that it is the first to bound: depth, and wires as seen."""
    found: list[list[tuple[float, list[TopoDS_Wire]]]] = [[] for _ in stands]
    floors: dict[int, list[TopoDS_Wire]] = {}
    crests: dict[int, list[TopoDS_Wire]] = {}
    for stand, own in zip(stands, found, strict=True):
        well = stand.well
        if well.crest:
            if well.crest not in crests:
                own.append((well.levels[0].depth_mm, crests.setdefault(well.crest, [])))
            crests[well.crest].append(stand.first)
        if well.floor:
            if well.floor not in floors:
                own.append((well.levels[-1].depth_mm, floors.setdefault(well.floor, [])))
            floors[well.floor].append(_reversed(stand.last))
    return found


def _tube(stand: _Stand, ends: list[tuple[float, list[TopoDS_Wire]]], chart: Chart) -> Tube:
    well = stand.well
    faces = [cap(chart, depth, wires, outwards=True) for depth, wires in ends]
    return Tube(
        well,
        mouth=None if well.crest or stand.on_seam[0] else stand.first,
        foot=None if well.floor or well.crest or stand.on_seam[1] else stand.last,
        base=_reversed(stand.last) if well.crest else None,
        faces=(*stand.walls, *faces),
    )


def _stand(well: Well, chart: Chart, columns: list[Column], seam: Seam | None) -> _Stand:
    n = len(columns)
    corners = [
        chart.points(np.array([s.start for s in loop.segments]), level.depth_mm)
        for loop, level in zip(well.loops, well.levels, strict=True)
    ]
    slack = max(trace.tolerance_mm for column in columns for trace in column.traces)
    vertices: list[list[TopoDS_Vertex]] = []
    rings: list[list[TopoDS_Edge]] = []
    for k, (loop, level) in enumerate(zip(well.loops, well.levels, strict=True)):
        traces = [column.traces[k] for column in columns]
        if seam is not None and level.depth_mm == seam.depth_mm:
            starts = [s.start for s in loop.segments]
            row = [seam.vertex(start, p, slack) for start, p in zip(starts, corners[k], strict=True)]
            ring = [
                seam.edge(a, b, t) for a, b, t in zip(starts, starts[1:] + starts[:1], traces, strict=True)
            ]
        else:
            row = [_vertex(p, slack) for p in corners[k]]
            ring = [_edge(trace, row[i], row[(i + 1) % n]) for i, trace in enumerate(traces)]
            if level.on_face:
                _draw(chart.surface(level.depth_mm), ring, traces)
        vertices.append(row)
        rings.append(ring)
    faces: list[TopoDS_Face] = []
    for k, (upper, lower) in enumerate(pairwise(range(len(rings)))):
        sides = [
            _drop(a, b, p, q)
            for a, b, p, q in zip(
                vertices[upper], vertices[lower], corners[upper], corners[lower], strict=True
            )
        ]
        for i in range(n):
            j = (i + 1) % n
            faces.append(_wall(columns[i].walls[k], rings[upper][i], rings[lower][i], sides[i], sides[j]))

    on_seam = tuple(seam is not None and well.levels[k].depth_mm == seam.depth_mm for k in (0, -1))
    return _Stand(well, _wire(rings[0]), _wire(rings[-1]), faces, (on_seam[0], on_seam[1]))


def _vertex(p: Array, tolerance_mm: float) -> TopoDS_Vertex:
    vertex = TopoDS_Vertex()
    BUILDER.MakeVertex(vertex, pnt(p), tolerance_mm)
    return vertex


def _edge(trace: Trace, start: TopoDS_Vertex, end: TopoDS_Vertex) -> TopoDS_Edge:
    return _bounded(trace.curve, trace.first, trace.last, trace.tolerance_mm, start, end)


def _drop(start: TopoDS_Vertex, end: TopoDS_Vertex, p: Array, q: Array) -> TopoDS_Edge:
    """The straight edge from one level down to the next, by arc length."""
    fall = q - p
    length = float(np.sqrt(fall @ fall))
    line = Geom_Line(pnt(p), gp_Dir(float(fall[0]), float(fall[1]), float(fall[2])))
    return _bounded(line, 0.0, length, TOLERANCE_MM, start, end)


def _bounded(
    curve: Geom_Curve,
    first: float,
    last: float,
    tolerance_mm: float,
    start: TopoDS_Vertex,
    end: TopoDS_Vertex,
) -> TopoDS_Edge:
    edge = TopoDS_Edge()
    BUILDER.MakeEdge(edge, curve, tolerance_mm)
    BUILDER.Add(edge, start.Oriented(FORWARD))
    BUILDER.Add(edge, end.Oriented(REVERSED))
    BUILDER.Range(edge, first, last)
    return edge


def _draw(surface: Geom_Surface, edges: list[TopoDS_Edge], traces: list[Trace]) -> None:
    """Give the edges of a loop their images on the surface of the face they bound."""
    for edge, trace in zip(edges, traces, strict=True):
        if trace.image is not None:
            BUILDER.UpdateEdge(edge, trace.image, surface, NOWHERE, trace.tolerance_mm)
            BUILDER.Range(edge, trace.first, trace.last)


def _wall(
    wall: Wall, upper: TopoDS_Edge, lower: TopoDS_Edge, left: TopoDS_Edge, right: TopoDS_Edge
) -> TopoDS_Face:
    """The face between two levels; `left` drops at the start of the segment, `right` at its end.

    Seen from outside, its boundary runs along the lower edge, up, back along the upper edge, down.
    """
    if wall.images is not None:
        over, under, start, end = wall.images
        for edge, image in ((upper, over), (lower, under)):
            BUILDER.UpdateEdge(edge, image, wall.surface, NOWHERE, TOLERANCE_MM)
        if left.IsSame(right):  # a whole circle: the seam is seen from both its sides
            images = (start, end) if wall.outward else (end, start)
            BUILDER.UpdateEdge(left, *images, wall.surface, NOWHERE, TOLERANCE_MM)
        else:
            BUILDER.UpdateEdge(left, start, wall.surface, NOWHERE, TOLERANCE_MM)
            BUILDER.UpdateEdge(right, end, wall.surface, NOWHERE, TOLERANCE_MM)
    wire = TopoDS_Wire()
    BUILDER.MakeWire(wire)
    BUILDER.Add(wire, lower)
    BUILDER.Add(wire, right.Reversed())
    BUILDER.Add(wire, upper.Reversed())
    BUILDER.Add(wire, left)
    wire.Closed(True)
    face = TopoDS_Face()
    BUILDER.MakeFace(face, wall.surface, TOLERANCE_MM)
    BUILDER.Add(face, wire if wall.outward else wire.Reversed())
    return face if wall.outward else TopoDS.Face_s(face.Reversed())


def _wire(edges: list[TopoDS_Edge]) -> TopoDS_Wire:
    wire = TopoDS_Wire()
    BUILDER.MakeWire(wire)
    for edge in edges:
        BUILDER.Add(wire, edge)
    wire.Closed(True)
    return wire


def _reversed(wire: TopoDS_Wire) -> TopoDS_Wire:
    return TopoDS.Wire_s(wire.Reversed())


def cap(chart: Chart, depth_mm: float, wires: list[TopoDS_Wire], *, outwards: bool) -> TopoDS_Face:
    """A face at a level, its wires given as seen by the reader; `outwards`: its outside is the reader's
    side."""
    face = TopoDS_Face()
    BUILDER.MakeFace(face, chart.surface(depth_mm), TOLERANCE_MM)
    seen = chart.towards_reader(depth_mm)
    for wire in wires:
        BUILDER.Add(face, wire if seen else wire.Reversed())
    return face if outwards == seen else TopoDS.Face_s(face.Reversed())
