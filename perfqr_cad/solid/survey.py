# pyright: reportAttributeAccessIssue=false
# The modeller's stubs are incomplete.
"""One walk over a solid: what its edges join, how its wires run, and where edges leave their faces."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from OCP.BRep import BRep_Tool
from OCP.Geom import Geom_Curve, Geom_Line, Geom_Plane, Geom_Surface
from OCP.Geom2d import Geom2d_Line
from OCP.gp import gp_Pnt
from OCP.TopExp import TopExp
from OCP.TopoDS import TopoDS, TopoDS_Face, TopoDS_Shape
from OCP.TopTools import TopTools_IndexedMapOfShape

from . import occ
from .evaluate import evaluator
from .occ import EDGE, FACE, FORWARD, REVERSED, VERTEX, WIRE, Array
from .wires import Use, children, in_order

SAMPLES = 8  # pieces of a curved edge in the polygon of its face
SLACK = 1.5  # between points sampled here and the tolerance that an edge was given from other points
# Samples of a face from which its surface is evaluated at once; before, preparing that costs more.
MANY = 64


class Course(NamedTuple):
    """The curve of an edge between its parameters, and its tolerance, mm."""

    curve: Geom_Curve
    first: float
    last: float
    tolerance_mm: float
    straight: bool

    def parameters(self, pieces: int, ahead: bool) -> list[float]:
        """Ends of equal pieces, in the direction of travel."""
        start, end = (self.first, self.last) if ahead else (self.last, self.first)
        return [start + (end - start) * k / pieces for k in range(pieces + 1)]


@dataclass
class Shell:
    """What one walk over the faces collects; edges and vertices by their index."""

    points: Array  # vertices, mm
    rows: list[tuple[float, float, float]]  # the same
    ends: dict[int, tuple[int, int]] = field(default_factory=dict[int, tuple[int, int]])
    courses: dict[int, Course] = field(default_factory=dict[int, Course])
    uses: list[tuple[int, bool]] = field(default_factory=list[tuple[int, bool]])  # edge, ahead
    corners: list[tuple[int, int]] = field(
        default_factory=list[tuple[int, int]]
    )  # edge ends that meet in a face
    polygons: list[list[Array]] = field(
        default_factory=list[list[Array]]
    )  # of each face, outlines in parameters
    problems: list[str] = field(default_factory=list[str])
    degenerate: bool = False


def survey(shape: TopoDS_Shape) -> Shell:
    """Walk over a solid."""
    vertices, edges = occ.distinct(shape, VERTEX), occ.distinct(shape, EDGE)
    points = [
        BRep_Tool.Pnt_s(TopoDS.Vertex_s(vertices.FindKey(i))).Coord() for i in range(1, vertices.Extent() + 1)
    ]
    shell = Shell(np.array(points).reshape(-1, 3), points)
    for i in range(1, edges.Extent() + 1):
        edge = TopoDS.Edge_s(edges.FindKey(i).Oriented(FORWARD))
        if BRep_Tool.Degenerated_s(edge):
            shell.degenerate = True
            continue
        first, last = TopExp.FirstVertex_s(edge), TopExp.LastVertex_s(edge)
        if first.IsNull() or last.IsNull():
            shell.problems.append("an edge has no vertex at an end")
            continue
        curve = BRep_Tool.Curve_s(edge, 0.0, 0.0)
        if curve is None:
            shell.problems.append("an edge has no curve")
            continue
        shell.ends[i] = vertices.FindIndex(first) - 1, vertices.FindIndex(last) - 1
        start, end = BRep_Tool.Range_s(edge)
        straight = isinstance(curve, Geom_Line)
        shell.courses[i] = Course(curve, start, end, BRep_Tool.Tolerance_s(edge), straight)
        _meets_vertices(shell, i)
    for face in occ.explore(shape, FACE):
        _walk(shell, TopoDS.Face_s(face), edges)
    return shell


def _meets_vertices(shell: Shell, index: int) -> None:
    """Note where the curve of an edge misses its vertices."""
    curve, first, last, tolerance, _ = shell.courses[index]
    if not first < last:
        shell.problems.append("an edge has an empty range")
    for vertex, parameter in zip(shell.ends[index], (first, last), strict=True):
        missed = curve.Value(parameter).Distance(gp_Pnt(*shell.rows[vertex]))
        if missed > SLACK * tolerance:
            place = at(shell.rows[vertex])
            shell.problems.append(f"an edge misses its vertex by {missed:.2g} mm at {place}")


def _walk(shell: Shell, face: TopoDS_Face, edges: TopTools_IndexedMapOfShape) -> None:
    """One face: the uses of its edges, its corners, its outlines, and whether its edges lie on it."""
    forward = TopoDS.Face_s(face.Oriented(FORWARD))
    surface = BRep_Tool.Surface_s(forward)
    flipped = face.Orientation() == REVERSED
    outlines: list[Array] = []
    for wire in children(forward):
        if wire.ShapeType() != WIRE:
            continue
        uses = [use for use in in_order(wire, forward, edges, shell.ends) if use.number in shell.ends]
        for use, following in zip(uses, uses[1:] + uses[:1], strict=True):
            shell.uses.append((use.number, use.ahead != flipped))
            shell.corners.append((2 * use.number + use.ahead, 2 * following.number + (not following.ahead)))
            here = shell.ends[use.number][use.ahead]
            if here != shell.ends[following.number][not following.ahead]:
                shell.problems.append(f"a wire is broken at {at(shell.rows[here])}")
        if isinstance(surface, Geom_Plane):
            outlines.append(_plane_outline(shell, uses, surface, BRep_Tool.Tolerance_s(face)))
        else:
            outlines.append(_curved_outline(shell, uses, surface, forward))
    shell.polygons.append(outlines)


def _plane_outline(shell: Shell, uses: list[Use], plane: Geom_Plane, slack: float) -> Array:
    """The wire in the plane's coordinates; notes where it leaves the plane."""
    samples: list[tuple[float, ...]] = []
    for use in uses:
        course = shell.courses[use.number]
        if course.straight:
            samples.append(shell.rows[shell.ends[use.number][not use.ahead]])
        else:
            samples += [course.curve.Value(t).Coord() for t in course.parameters(SAMPLES, use.ahead)[:-1]]
            slack = max(slack, course.tolerance_mm)
    frame = plane.Position()
    axes = np.array([d.Coord() for d in (frame.XDirection(), frame.YDirection(), frame.Direction())])
    local = (np.array(samples).reshape(-1, 3) - frame.Location().Coord()) @ axes.T
    off = float(np.abs(local[:, 2]).max(initial=0.0))
    if off > SLACK * slack:
        shell.problems.append(
            f"an edge at {at(samples[0])} is {off:.2g} mm off its plane (limit {slack:.2g} mm)"
        )
    return local[:, :2]


def _curved_outline(shell: Shell, uses: list[Use], surface: Geom_Surface, face: TopoDS_Face) -> Array:
    """The wire in the surface's parameters; notes where curve and image are apart."""
    outline: list[tuple[float, float]] = []
    drawn: list[tuple[float, float]] = []
    curved: list[tuple[float, float, float]] = []
    limits: list[float] = []
    slack = BRep_Tool.Tolerance_s(face)
    for use in uses:
        course = shell.courses[use.number]
        image = BRep_Tool.CurveOnSurface_s(TopoDS.Edge_s(use.edge), face, 0.0, 0.0)
        if image is None:
            shell.problems.append("an edge has no image on its curved face")
            continue
        # A straight image needs no samples to be a side of the polygon, and but its middle to be compared.
        straight = isinstance(image, Geom2d_Line)
        parameters = course.parameters(2 if straight else SAMPLES, use.ahead)
        images = [image.Value(t).Coord() for t in parameters]
        outline += images[:1] if straight else images[:-1]
        drawn += images
        curved += [course.curve.Value(t).Coord() for t in parameters]
        limits += [SLACK * max(slack, course.tolerance_mm)] * len(parameters)
    if drawn:
        off = np.linalg.norm(_evaluated(surface, drawn) - curved, axis=1)
        if (wrong := off > limits).any():
            worst = int(np.argmax(np.where(wrong, off, 0.0)))
            shell.problems.append(
                f"an edge at {at(curved[worst])} is {off[worst]:.2g} mm off its face "
                f"(limit {limits[worst]:.2g} mm)"
            )
    return np.array(outline).reshape(-1, 2)


def _evaluated(surface: Geom_Surface, uv: list[tuple[float, float]]) -> Array:
    """Points (k, 3) of a surface."""
    if len(uv) < MANY:
        return np.array([surface.Value(u, v).Coord() for u, v in uv])
    return evaluator(surface)(np.array(uv), 1)[0]


def at(p: Iterable[float]) -> str:
    """A point for people."""
    return "({:.3f}, {:.3f}, {:.3f})".format(*p)
