"""Questions to shapes of the modeller, their repair, and the one boolean: what carving into a solid needs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Literal

import numpy as np
from OCP.Bnd import Bnd_Box
from OCP.BRep import BRep_Builder, BRep_Tool
from OCP.BRepAdaptor import BRepAdaptor_Curve
from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut
from OCP.BRepBndLib import BRepBndLib
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.BRepLib import BRepLib
from OCP.GCPnts import GCPnts_AbscissaPoint
from OCP.ShapeFix import ShapeFix_Shape
from OCP.ShapeUpgrade import ShapeUpgrade_RemoveLocations
from OCP.TopAbs import TopAbs_ShapeEnum
from OCP.TopoDS import TopoDS, TopoDS_Compound, TopoDS_Face, TopoDS_Shape, TopoDS_Solid
from OCP.TopTools import TopTools_ListOfShape

from perfqr_cad.errors import KernelError
from perfqr_cad.geometry.arrays import Array
from perfqr_cad.geometry.triangles import Corner
from perfqr_cad.solid.kernel import occ
from perfqr_cad.solid.kernel.occ import EDGE, FACE

Kind = Literal["SOLID", "SHELL", "FACE", "WIRE", "EDGE", "VERTEX"]

MOST_EDGE_POINTS = 2000


def explore(shape: TopoDS_Shape, kind: Kind) -> list[TopoDS_Shape]:
    """Sub-shapes of one kind, each once, in the kernel's order (the order in which CAD programs number
    them)."""
    found = occ.distinct(shape, getattr(TopAbs_ShapeEnum, f"TopAbs_{kind}"))
    return [found.FindKey(i) for i in range(1, found.Extent() + 1)]


def faces(shape: TopoDS_Shape) -> list[TopoDS_Face]:
    """Faces in the kernel's order; number N of CAD programs is entry N - 1."""
    return [TopoDS.Face_s(f) for f in explore(shape, "FACE")]


def solids(shape: TopoDS_Shape) -> list[TopoDS_Solid]:
    """Solids in the kernel's order."""
    return [TopoDS.Solid_s(s) for s in explore(shape, "SOLID")]


def volume_lost(before: TopoDS_Shape, after: TopoDS_Shape, precision: float | None = None) -> float:
    """Volume in mm³ that `after` lacks of `before`, by the faces in which they differ.

    Imported shells have small gaps; the kernel's volume of such a shell depends on a reference point that
    moves with its vertices, by much more than a hole. Over the changed faces alone the gaps cancel.
    `precision` is a share of what they bound.
    """
    old, new = explore(before, "FACE"), explore(after, "FACE")
    kept_old, kept_new = occ.distinct(before, FACE), occ.distinct(after, FACE)
    builder, changed = BRep_Builder(), TopoDS_Compound()
    builder.MakeCompound(changed)
    for face in old:
        if not kept_new.Contains(face):
            builder.Add(changed, face)
    for face in new:
        if not kept_old.Contains(face):
            builder.Add(changed, face.Reversed())
    return occ.volume(changed, precision)


def is_valid(shape: TopoDS_Shape) -> bool:
    """The kernel's own validity check."""
    return bool(BRepCheck_Analyzer(shape, True, True, False).IsValid())


def healed(solid: TopoDS_Shape) -> TopoDS_Solid | None:
    """The solid after the kernel's repair, or None when that leaves anything but one solid."""
    fixer = ShapeFix_Shape(solid)
    occ.silence()
    fixer.Perform()
    found = solids(fixer.Shape())
    return found[0] if len(found) == 1 else None


def sound(solid: TopoDS_Solid, name: str) -> TopoDS_Solid:
    """The solid with its outside outside, repaired when the kernel calls it invalid.

    A boolean on an invalid solid returns nonsense without an error, hence no doubtful solid goes on.
    """
    if not is_valid(solid):
        repaired = healed(solid)
        if repaired is None or not is_valid(repaired):
            raise KernelError(
                f"the solid {name!r} is invalid and cannot be repaired: check its geometry in the CAD system "
                "and export it again"
            )
        solid = repaired
    return outward(grounded(solid))


def grounded(solid: TopoDS_Solid) -> TopoDS_Solid:
    """The solid with every face's surface where it lies, not moved there by a location: curves are drawn on
    it."""
    if solid.Location().IsIdentity() and all(face.Location().IsIdentity() for face in explore(solid, "FACE")):
        return solid
    remover = ShapeUpgrade_RemoveLocations()
    remover.Remove(solid)
    return TopoDS.Solid_s(remover.GetResult())


def reconcile(shape: TopoDS_Shape, host: TopoDS_Shape, tolerance_mm: float) -> None:
    """Bring the curves of edges that `host` has not in step with their images on faces, in place.

    A spline edge over many knots of its face may stray between the points at which its error was measured.
    """
    builder, old = BRep_Builder(), occ.distinct(host, EDGE)
    for edge in explore(shape, "EDGE"):
        if not old.Contains(edge):
            builder.SameParameter(TopoDS.Edge_s(edge), False)
    BRepLib.SameParameter_s(shape, tolerance_mm, False)


def outward(solid: TopoDS_Solid) -> TopoDS_Solid:
    """The solid with its outside outside."""
    if occ.volume(solid) > 0:
        return solid
    turned = TopoDS.Solid_s(solid.Reversed())
    if occ.volume(turned) <= 0:
        BRepLib.OrientClosedSolid_s(turned)
    return turned


def cut(solid: TopoDS_Shape, cutters: Sequence[TopoDS_Shape]) -> TopoDS_Solid:
    """`solid` less `cutters` in one boolean. Raises `KernelError` unless one solid is left."""
    arguments, others = TopTools_ListOfShape(), TopTools_ListOfShape()
    arguments.Append(solid)
    for cutter in cutters:
        others.Append(cutter)
    operation = BRepAlgoAPI_Cut()
    operation.SetArguments(arguments)
    operation.SetTools(others)
    operation.SetRunParallel(True)
    operation.SetNonDestructive(True)
    operation.Build()
    if not operation.IsDone():
        raise KernelError(
            f"cutting {len(cutters)} holes failed in the kernel: move the code or change its size a little"
        )
    found = solids(operation.Shape())
    if len(found) != 1:
        raise KernelError(
            f"cutting {len(cutters)} holes left {len(found)} solids instead of 1: move the code"
        )
    return found[0]


def bounding_box(shape: TopoDS_Shape) -> tuple[Corner, Corner]:
    """Least and greatest corner in mm."""
    box = Bnd_Box()
    BRepBndLib.AddOptimal_s(shape, box, False, False)
    x0, y0, z0, x1, y1, z1 = box.Get()
    return (x0, y0, z0), (x1, y1, z1)


def places_of(faces_in: Sequence[TopoDS_Face], shell: TopoDS_Shape) -> list[int]:
    """Which of the faces belong to a shell."""
    members = occ.distinct(shell, FACE)
    return [i for i, face in enumerate(faces_in) if members.Contains(face)]


def edge_points(face: TopoDS_Face, step_mm: float) -> Iterator[Array]:
    """Points (k, 3) along each edge of a face, about `step_mm` apart."""
    for shape in explore(face, "EDGE"):
        edge = TopoDS.Edge_s(shape)
        if BRep_Tool.Degenerated_s(edge):
            continue
        curve = BRepAdaptor_Curve(edge)
        count = min(MOST_EDGE_POINTS, 2 + int(GCPnts_AbscissaPoint.Length_s(curve) / step_mm))
        along = np.linspace(curve.FirstParameter(), curve.LastParameter(), count)
        yield np.array([curve.Value(t).Coord() for t in along.tolist()])
