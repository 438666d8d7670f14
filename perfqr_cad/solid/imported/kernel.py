# pyright: reportAttributeAccessIssue=false
# The modeller's stubs are incomplete.
"""The few kernel calls that carving into an imported solid needs, as plain functions."""

from __future__ import annotations

from collections.abc import Generator, Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from perfqr_cad.errors import KernelError

if TYPE_CHECKING:
    from OCP.TopoDS import TopoDS_Face, TopoDS_Shape, TopoDS_Solid
    from OCP.TopTools import TopTools_IndexedMapOfShape

Kind = Literal["SOLID", "SHELL", "FACE", "WIRE", "EDGE", "VERTEX"]
Array = NDArray[np.float64]

MOST_EDGE_POINTS = 2000


@contextmanager
def quiet() -> Generator[None, None, None]:
    """Keep the kernel's own chatter off the standard output."""
    from OCP.Message import Message, Message_PrinterOStream

    messenger = Message.DefaultMessenger_s()
    messenger.RemovePrinters(Message_PrinterOStream.get_type_descriptor_s())
    yield


def explore(shape: TopoDS_Shape, kind: Kind) -> list[TopoDS_Shape]:
    """Sub-shapes of one kind, each once, in the kernel's order (the order in which CAD programs number
    them).
    """
    from OCP import TopAbs
    from OCP.TopExp import TopExp
    from OCP.TopTools import TopTools_IndexedMapOfShape

    found = TopTools_IndexedMapOfShape()
    TopExp.MapShapes_s(shape, getattr(TopAbs.TopAbs_ShapeEnum, f"TopAbs_{kind}"), found)
    return [found.FindKey(i) for i in range(1, found.Extent() + 1)]


def faces(shape: TopoDS_Shape) -> list[TopoDS_Face]:
    """Faces in the kernel's order; number N of CAD programs is entry N - 1."""
    from OCP.TopoDS import TopoDS

    return [TopoDS.Face_s(f) for f in explore(shape, "FACE")]


def solids(shape: TopoDS_Shape) -> list[TopoDS_Solid]:
    """Solids in the kernel's order."""
    from OCP.TopoDS import TopoDS

    return [TopoDS.Solid_s(s) for s in explore(shape, "SOLID")]


def volume(shape: TopoDS_Shape, precision: float | None = None) -> float:
    """Volume in mm³, signed by orientation. Without a wanted relative `precision` the kernel takes a fixed
    number of points on each face, which on splines with many holes is off by percents.
    """
    from OCP.BRepGProp import BRepGProp
    from OCP.GProp import GProp_GProps

    properties = GProp_GProps()
    if precision is None:
        BRepGProp.VolumeProperties_s(shape, properties)
    else:
        BRepGProp.VolumeProperties_s(shape, properties, precision)
    return float(properties.Mass())


def volume_lost(before: TopoDS_Shape, after: TopoDS_Shape, precision: float | None = None) -> float:
    """Volume in mm³ that `after` lacks of `before`, by the faces in which they differ.

    Imported shells have small gaps; the kernel's volume of such a shell depends on a reference point that
    moves with its vertices, by much more than a hole. Over the changed faces alone the gaps cancel.
    `precision` is a share of what they bound.
    """
    from OCP.BRep import BRep_Builder
    from OCP.TopoDS import TopoDS_Compound

    old, new = explore(before, "FACE"), explore(after, "FACE")
    kept_old, kept_new = _members(before), _members(after)
    builder, changed = BRep_Builder(), TopoDS_Compound()
    builder.MakeCompound(changed)
    for face in old:
        if not kept_new.Contains(face):
            builder.Add(changed, face)
    for face in new:
        if not kept_old.Contains(face):
            builder.Add(changed, face.Reversed())
    return volume(changed, precision)


def area(face: TopoDS_Shape) -> float:
    """Surface area in mm²."""
    from OCP.BRepGProp import BRepGProp
    from OCP.GProp import GProp_GProps

    properties = GProp_GProps()
    BRepGProp.SurfaceProperties_s(face, properties)
    return float(properties.Mass())


def is_valid(shape: TopoDS_Shape) -> bool:
    """The kernel's own validity check."""
    from OCP.BRepCheck import BRepCheck_Analyzer

    return bool(BRepCheck_Analyzer(shape, True, True, False).IsValid())


def healed(solid: TopoDS_Shape) -> TopoDS_Solid | None:
    """The solid after the kernel's repair, or None when that leaves anything but one solid."""
    from OCP.ShapeFix import ShapeFix_Shape

    fixer = ShapeFix_Shape(solid)
    with quiet():
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
                f"the solid {name!r} is invalid and cannot be repaired: check its geometry in the CAD "
                f"system and "
                "export it again"
            )
        solid = repaired
    return outward(grounded(solid))


def grounded(solid: TopoDS_Solid) -> TopoDS_Solid:
    """The solid with every face's surface where it lies, not moved there by a location: curves are drawn on
    it.
    """
    from OCP.ShapeUpgrade import ShapeUpgrade_RemoveLocations
    from OCP.TopoDS import TopoDS

    if solid.Location().IsIdentity() and all(face.Location().IsIdentity() for face in explore(solid, "FACE")):
        return solid
    remover = ShapeUpgrade_RemoveLocations()
    remover.Remove(solid)
    return TopoDS.Solid_s(remover.GetResult())


def reconcile(shape: TopoDS_Shape, host: TopoDS_Shape, tolerance_mm: float) -> None:
    """Bring the curves of edges that `host` has not in step with their images on faces, in place.

    A spline edge over many knots of its face may stray between the points at which its error was measured.
    """
    from OCP.BRep import BRep_Builder
    from OCP.BRepLib import BRepLib
    from OCP.TopAbs import TopAbs_ShapeEnum
    from OCP.TopExp import TopExp
    from OCP.TopoDS import TopoDS
    from OCP.TopTools import TopTools_IndexedMapOfShape

    builder, old = BRep_Builder(), TopTools_IndexedMapOfShape()
    TopExp.MapShapes_s(host, TopAbs_ShapeEnum.TopAbs_EDGE, old)
    for edge in explore(shape, "EDGE"):
        if not old.Contains(edge):
            builder.SameParameter(TopoDS.Edge_s(edge), False)
    BRepLib.SameParameter_s(shape, tolerance_mm, False)


def outward(solid: TopoDS_Solid) -> TopoDS_Solid:
    """The solid with its outside outside."""
    from OCP.BRepLib import BRepLib
    from OCP.TopoDS import TopoDS

    if volume(solid) > 0:
        return solid
    turned = TopoDS.Solid_s(solid.Reversed())
    if volume(turned) <= 0:
        BRepLib.OrientClosedSolid_s(turned)
    return turned


def cut(solid: TopoDS_Shape, tools: Sequence[TopoDS_Shape]) -> TopoDS_Solid:
    """`solid` less `tools` in one boolean. Raises `KernelError` unless one solid is left."""
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut
    from OCP.TopTools import TopTools_ListOfShape

    arguments, others = TopTools_ListOfShape(), TopTools_ListOfShape()
    arguments.Append(solid)
    for tool in tools:
        others.Append(tool)
    operation = BRepAlgoAPI_Cut()
    operation.SetArguments(arguments)
    operation.SetTools(others)
    operation.SetRunParallel(True)
    operation.SetNonDestructive(True)
    operation.Build()
    if not operation.IsDone():
        raise KernelError(
            f"cutting {len(tools)} holes failed in the kernel: move the code or change its size a little"
        )
    found = solids(operation.Shape())
    if len(found) != 1:
        raise KernelError(f"cutting {len(tools)} holes left {len(found)} solids instead of 1: move the code")
    return found[0]


def bounding_box(shape: TopoDS_Shape) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    """Least and greatest corner in mm."""
    from OCP.Bnd import Bnd_Box
    from OCP.BRepBndLib import BRepBndLib

    box = Bnd_Box()
    BRepBndLib.AddOptimal_s(shape, box, False, False)
    x0, y0, z0, x1, y1, z1 = box.Get()
    return (x0, y0, z0), (x1, y1, z1)


def places_of(faces_in: Sequence[TopoDS_Face], shell: TopoDS_Shape) -> list[int]:
    """Which of the faces belong to a shell."""
    members = _members(shell)
    return [i for i, face in enumerate(faces_in) if members.Contains(face)]


def _members(shape: TopoDS_Shape) -> TopTools_IndexedMapOfShape:
    """The faces of a shape as a set."""
    from OCP.TopAbs import TopAbs_ShapeEnum
    from OCP.TopExp import TopExp
    from OCP.TopTools import TopTools_IndexedMapOfShape

    found = TopTools_IndexedMapOfShape()
    TopExp.MapShapes_s(shape, TopAbs_ShapeEnum.TopAbs_FACE, found)
    return found


def edge_points(face: TopoDS_Face, step_mm: float) -> Iterator[Array]:
    """Points (k, 3) along each edge of a face, about `step_mm` apart."""
    from OCP.BRep import BRep_Tool
    from OCP.BRepAdaptor import BRepAdaptor_Curve
    from OCP.GCPnts import GCPnts_AbscissaPoint
    from OCP.TopoDS import TopoDS

    for shape in explore(face, "EDGE"):
        edge = TopoDS.Edge_s(shape)
        if BRep_Tool.Degenerated_s(edge):
            continue
        curve = BRepAdaptor_Curve(edge)
        count = min(MOST_EDGE_POINTS, 2 + int(GCPnts_AbscissaPoint.Length_s(curve) / step_mm))
        along = np.linspace(curve.FirstParameter(), curve.LastParameter(), count)
        yield np.array([curve.Value(t).Coord() for t in along.tolist()])
